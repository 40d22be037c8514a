// Where a function begins to change much faster than before: pulses and smooth steps that are short beside
// what is quiet before them. Steps of an integrator grow while nothing changes and would pass over them.
//
//   value      _____________/\________     _ : so long the function stays within a quarter of its range;
//   stretches  |           |||       |         || are shorter by far, and are marked
#pragma once

#include <functional>
#include <vector>

#include "dae/mechanics/interval.hpp"
#include "dae/mechanics/time_span.hpp"

namespace mfs::dae {

/// A function's value at a time.
struct Sample {
  double t = 0.0, value = 0.0;
};

/// Times, ascending, with values between each two neighbours of which `function` goes no farther than an
/// eighth of its range. `function`: encloses its values in an interval of time. Halves the part whose bounds
/// are farthest apart, so that no pulse is too narrow to be found; what jumps is halved until it is 1e-12 of
/// the span. Where `most_halvings` are not enough, as with very many turns of a sine, parts are all about as
/// long.
std::vector<Sample> resolved(const std::function<Interval(const Interval&)>& function, const TimeSpan& span,
                             int most_halvings);

/// Adds where `samples` begin to change faster: where a stretch, within which values stay in `level` of their
/// range, is followed by one that is shorter by `ratio`, and the end of that.
void mark_fast_changes(const std::vector<Sample>& samples, double level, double ratio,
                       std::vector<double>& marks);

/// Of a harmonic, lengths of stretches of a quarter of the range differ by a factor of 4.2 at most.
constexpr double kQuarter = 0.25, kFaster = 12.0;

}  // namespace mfs::dae
