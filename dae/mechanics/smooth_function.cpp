#include "dae/mechanics/smooth_function.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <mfs/error.hpp>

#include "dae/mechanics/fast_changes.hpp"

namespace mfs::dae {
namespace {

class Linear final : public SmoothFunction {
 public:
  Linear(double value, double slope) : value_(value), slope_(slope) {}
  Jet at(double x) const override { return {value_ + slope_ * x, slope_, 0.0}; }
  std::vector<int> changing_operations() const override { return {}; }
  void enclose(const Interval& x, std::vector<Interval>& results) const override {
    results = {value_ + slope_ * x};
  }

 private:
  double value_, slope_;
};

class Harmonic final : public SmoothFunction {
 public:
  Harmonic(double offset, double amplitude, double frequency, double phase)
      : offset_(offset), amplitude_(amplitude), angular_(2 * std::acos(-1.0) * frequency), phase_(phase) {}
  Jet at(double x) const override {
    const double s = amplitude_ * std::sin(angular_ * x + phase_);
    const double c = amplitude_ * std::cos(angular_ * x + phase_);
    return {offset_ + s, angular_ * c, -angular_ * angular_ * s};
  }
  void enclose(const Interval& x, std::vector<Interval>& results) const override {
    results = {offset_ + amplitude_ * sin(angular_ * x + phase_)};
  }

 private:
  double offset_, amplitude_, angular_, phase_;
};

class SmoothStep final : public SmoothFunction {
 public:
  SmoothStep(double begin, double end, double before, double after)
      : begin_(begin), length_(end - begin), before_(before), rise_(after - before) {}
  Jet at(double x) const override {
    const double s = (x - begin_) / length_;
    if (s <= 0) return {before_, 0.0, 0.0};
    if (s >= 1) return {before_ + rise_, 0.0, 0.0};
    return {before_ + rise_ * s * s * s * (10 + s * (6 * s - 15)),
            rise_ / length_ * 30 * s * s * (1 - s) * (1 - s),
            rise_ / (length_ * length_) * 60 * s * (1 - s) * (1 - 2 * s)};
  }
  void add_marks(const TimeSpan& span, std::vector<double>& marks) const override {
    if (length_ * kFaster < span.end - span.begin) marks.insert(marks.end(), {begin_, begin_ + length_});
  }
  void enclose(const Interval& x, std::vector<Interval>& results) const override {
    const auto [least, most] = std::minmax({value(x.low), value(x.high)});
    results = {{least, most}};
  }

 private:
  double begin_, length_, before_, rise_;
};

/// What changes by less, in parts of a table's range, is no event in it.
constexpr double kNoise = 0.01;
/// The smallest event that is looked for.
constexpr double kSmallest = 1.0 / 64;
/// As kFaster, at the first level. Stretches end at points here, which are further apart than parts of an
/// expression.
constexpr double kFasterTable = 6.0;

/// Between two points, with their second derivatives m (moments, as of an elastic spline).
class Spline final : public SmoothFunction {
 public:
  Spline(std::vector<double> x, std::vector<double> y) : x_(std::move(x)), y_(std::move(y)), m_(x_.size()) {
    find_moments();
  }
  Jet at(double x) const override {
    const std::size_t last = x_.size() - 1;
    if (x <= x_.front()) return line(x, 0, chord(0) - (x_[1] - x_[0]) / 6 * m_[1]);
    if (x >= x_.back()) return line(x, last, chord(last - 1) + (x_[last] - x_[last - 1]) / 6 * m_[last - 1]);
    const auto i = static_cast<std::size_t>(std::upper_bound(x_.begin(), x_.end(), x) - x_.begin()) - 1;
    const double h = x_[i + 1] - x_[i], left = (x_[i + 1] - x) / h, right = (x - x_[i]) / h;
    return {left * y_[i] + right * y_[i + 1] +
                h * h / 6 * ((left * left - 1) * left * m_[i] + (right * right - 1) * right * m_[i + 1]),
            (y_[i + 1] - y_[i]) / h +
                h / 6 * ((3 * right * right - 1) * m_[i + 1] - (3 * left * left - 1) * m_[i]),
            left * m_[i] + right * m_[i + 1]};
  }

  /// Where its points begin to change faster, at three levels, so that a blow is found in noise.
  void add_marks(const TimeSpan& span, std::vector<double>& marks) const override {
    std::vector<Sample> samples = {{span.begin, value(span.begin)}};
    for (std::size_t i = 0; i < x_.size(); ++i)
      if (x_[i] > span.begin && x_[i] < span.end) samples.push_back({x_[i], y_[i]});
    samples.push_back({span.end, value(span.end)});
    double ratio = kFasterTable;
    for (double level = kQuarter; level > kNoise; level /= 4, ratio *= 2)
      mark_fast_changes(samples, level, ratio, marks);
  }

  /// A table has no parts that tell small bumps from large ones.
  double range(int) const override {
    const auto [least, most] = std::minmax_element(y_.begin(), y_.end());
    return kSmallest / kQuarter * (*most - *least);
  }
  /// On a part of length h between two points it is no farther from its chord than h^2 / 8 of the larger of
  /// their second derivatives.
  void enclose(const Interval& x, std::vector<Interval>& results) const override {
    double at = x.low, here = value(at);
    Interval bounds = here;
    for (auto i = static_cast<std::size_t>(std::upper_bound(x_.begin(), x_.end(), at) - x_.begin());
         at < x.high; ++i) {
      const bool whole = i < x_.size() && x_[i] < x.high;
      const double next = whole ? x_[i] : x.high, there = whole ? y_[i] : value(next);
      const double bend = i == 0 || i >= x_.size() ? 0.0 : std::max(std::abs(m_[i - 1]), std::abs(m_[i]));
      bounds = hull(bounds, widened(hull(here, there), (next - at) * (next - at) / 8 * bend));
      at = next;
      here = there;
    }
    results = {bounds};
  }

 private:
  Jet line(double x, std::size_t through, double slope) const {
    return {y_[through] + slope * (x - x_[through]), slope, 0.0};
  }
  double chord(std::size_t i) const { return (y_[i + 1] - y_[i]) / (x_[i + 1] - x_[i]); }
  /// The tridiagonal system of equal slopes at inner points, by elimination from the first to the last.
  void find_moments() {
    const std::size_t n = x_.size();
    std::vector<double> diagonal(n, 1.0);
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const double before = x_[i] - x_[i - 1], after = x_[i + 1] - x_[i];
      diagonal[i] = 2 * (before + after);
      m_[i] = 6 * (chord(i) - chord(i - 1));
      if (i == 1) continue;
      diagonal[i] -= before * before / diagonal[i - 1];
      m_[i] -= before * m_[i - 1] / diagonal[i - 1];
    }
    for (std::size_t i = n - 1; i-- > 1;) m_[i] = (m_[i] - (x_[i + 1] - x_[i]) * m_[i + 1]) / diagonal[i];
  }

  std::vector<double> x_, y_, m_;
};

}  // namespace

Function constant_function(double value) {
  return std::make_shared<Linear>(value, 0.0);
}

Function linear_function(double value, double slope) {
  return std::make_shared<Linear>(value, slope);
}

Function harmonic_function(double offset, double amplitude, double frequency, double phase) {
  if (!(frequency > 0)) throw InvalidInput("frequency", "not positive");
  return std::make_shared<Harmonic>(offset, amplitude, frequency, phase);
}

Function smooth_step(double begin, double end, double before, double after) {
  if (!(begin < end)) throw InvalidInput("end", "not after begin");
  return std::make_shared<SmoothStep>(begin, end, before, after);
}

Function spline_function(std::vector<double> x, std::vector<double> y) {
  if (x.size() < 2) throw InvalidInput("x", "a spline needs two points or more");
  if (y.size() != x.size())
    throw InvalidInput("y",
                       std::to_string(x.size()) + " points, but " + std::to_string(y.size()) + " values");
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i])) throw InvalidInput("x", "not finite", static_cast<std::int64_t>(i));
    if (!std::isfinite(y[i])) throw InvalidInput("y", "not finite", static_cast<std::int64_t>(i));
    if (i > 0 && !(x[i - 1] < x[i])) throw InvalidInput("x", "does not ascend", static_cast<std::int64_t>(i));
  }
  return std::make_shared<Spline>(std::move(x), std::move(y));
}

}  // namespace mfs::dae
