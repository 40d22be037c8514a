#include "dae/mechanics/integral.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace mfs::dae {
namespace {

constexpr double kAccuracy = 1e-12;
/// By how much of the range of all values those of a part may leave the ones that are met in it, and, times
/// its length, by how much of the integral.
constexpr double kLeaves = 0.25, kMissed = 1e-5;
/// Parts that are no longer, in parts of the whole, are not halved; nor are more than so many parts.
constexpr double kJump = 1e-12;
constexpr int kMostParts = 100'000;

/// Gauss' rule of five points.
constexpr std::array<std::array<double, 2>, 5> kRule{{{-0.906179845938663993, 0.236926885056189088},
                                                      {-0.538469310105683091, 0.478628670499366468},
                                                      {0.0, 128.0 / 225},
                                                      {0.538469310105683091, 0.478628670499366468},
                                                      {0.906179845938663993, 0.236926885056189088}}};

class Integral {
 public:
  Integral(const SmoothFunction& function, double from, double to)
      : function_(function), length_(to - from), operations_(function.changing_operations()) {
    parts_ = {part(from, to)};
    met_ = std::abs(parts_.front().integral);
  }

  double sum() {
    double sum = 0.0;
    for (int parts = 1; !parts_.empty();) {
      const Part whole = parts_.back();
      parts_.pop_back();
      const double middle = 0.5 * (whole.from + whole.to);
      const Part first = part(whole.from, middle), second = part(middle, whole.to);
      const double halves = first.integral + second.integral;
      met_ += std::abs(first.integral) + std::abs(second.integral) - std::abs(whole.integral);
      const bool good = std::abs(halves - whole.integral) <= kAccuracy * size() * std::abs(length_) &&
                        keeps_to(hull(first.values, second.values), whole);
      if (good || std::abs(whole.to - whole.from) <= kJump * std::abs(length_)) {
        sum += halves;
      } else if (++parts > kMostParts) {
        return std::numeric_limits<double>::quiet_NaN();
      } else {
        parts_.push_back(first);
        parts_.push_back(second);
      }
    }
    return sum;
  }

 private:
  struct Part {
    double from, to;
    double integral;
    Interval values;
  };
  Part part(double from, double to) {
    Part part{from, to, 0.0, {HUGE_VAL, -HUGE_VAL}};
    for (const auto& [x, weight] : kRule) {
      const double value = function_.value(0.5 * (from + to + x * (to - from)));
      part.integral += 0.5 * (to - from) * weight * value;
      part.values = hull(part.values, value);
    }
    all_ = hull(all_, part.values);
    return part;
  }
  double size() const { return std::max(std::abs(all_.low), std::abs(all_.high)); }
  /// Whether the function has nothing between the points at which it was evaluated.
  bool keeps_to(const Interval& values, const Part& part) {
    if (operations_.empty()) return true;
    function_.enclose({std::min(part.from, part.to), std::max(part.from, part.to)}, results_);
    const Interval& bounds = results_.back();
    const double off = std::max(values.low - bounds.low, bounds.high - values.high);
    return off <= kLeaves * all_.width() + kAccuracy * size() &&
           off * std::abs(part.to - part.from) <= kMissed * met_ + kAccuracy * size() * std::abs(length_);
  }

  const SmoothFunction& function_;
  double length_;
  std::vector<int> operations_;
  Interval all_{HUGE_VAL, -HUGE_VAL};
  double met_ = 0.0;  // of the integral of the absolute value
  std::vector<Part> parts_;
  std::vector<Interval> results_;
};

}  // namespace

double integral(const SmoothFunction& function, double from, double to) {
  return from == to ? 0.0 : Integral(function, from, to).sum();
}

}  // namespace mfs::dae
