#include "dae/mechanics/fast_changes.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

namespace mfs::dae {
namespace {

/// Parts that are no longer, in parts of the span, are not halved: the function jumps there.
constexpr double kJump = 1e-12;
/// Ends of stretches that are no longer are one mark.
constexpr double kOneMark = 1e-9;
/// What is rounding beside the values.
constexpr double kRounding = 1e-12;

/// A part of time, with bounds on the values in it.
struct Part {
  double begin, end;
  double width;  // of the bounds

  bool operator<(const Part& other) const {
    return width != other.width ? width < other.width : end - begin < other.end - other.begin;
  }
};

}  // namespace

std::vector<Sample> resolved(const std::function<Interval(const Interval&)>& function, const TimeSpan& span,
                             int most_halvings) {
  std::vector<Sample> samples;
  double least = HUGE_VAL, most = -HUGE_VAL;
  const auto sample = [&](double t) {
    const double value = function(t).low;
    samples.push_back({t, value});
    if (!std::isfinite(value)) return;
    least = std::min(least, value);
    most = std::max(most, value);
  };
  const auto part = [&](double begin, double end) {
    return Part{begin, end, function({begin, end}).width()};
  };
  sample(span.begin);
  sample(span.end);
  std::priority_queue<Part> parts;
  parts.push(part(span.begin, span.end));
  for (int halvings = 0; halvings < most_halvings && !parts.empty(); ++halvings) {
    const Part widest = parts.top();
    const double size = std::max(std::abs(least), std::abs(most));
    if (widest.width <= std::max(0.5 * kQuarter * (most - least), kRounding * size)) break;
    parts.pop();
    if (widest.end - widest.begin <= kJump * (span.end - span.begin)) continue;
    const double middle = 0.5 * (widest.begin + widest.end);
    sample(middle);
    parts.push(part(widest.begin, middle));
    parts.push(part(middle, widest.end));
  }
  std::sort(samples.begin(), samples.end(), [](const Sample& x, const Sample& y) { return x.t < y.t; });
  return samples;
}

void mark_fast_changes(const std::vector<Sample>& samples, double level, double ratio,
                       std::vector<double>& marks) {
  if (samples.empty()) return;
  double least = HUGE_VAL, most = -HUGE_VAL;
  for (const Sample& sample : samples) {
    if (!std::isfinite(sample.value)) continue;
    least = std::min(least, sample.value);
    most = std::max(most, sample.value);
  }
  const double begin = samples.front().t, end = samples.back().t;
  std::vector<double> ends = {begin};  // of stretches
  Interval stretch = samples.front().value;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    stretch = hull(stretch, samples[i].value);
    if (stretch.width() <= level * (most - least)) continue;
    if (samples[i - 1].t > ends.back()) ends.push_back(samples[i - 1].t);
    if (hull(samples[i - 1].value, samples[i].value).width() > level * (most - least))
      ends.push_back(samples[i].t);
    stretch = hull(ends.back() == samples[i].t ? samples[i].value : samples[i - 1].value, samples[i].value);
  }
  // The last stretch goes on behind the end.
  for (std::size_t i = 1; i + 1 < ends.size(); ++i) {
    const double before = ends[i] - ends[i - 1], after = ends[i + 1] - ends[i];
    if (before <= ratio * after) continue;
    marks.push_back(ends[i]);
    if (after > kOneMark * (end - begin)) marks.push_back(ends[i + 1]);
  }
}

}  // namespace mfs::dae
