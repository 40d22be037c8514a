// How long the next step is to be tried.
#pragma once

#include <algorithm>
#include <cmath>

#include "dae/integrator/error_weights.hpp"
#include "dae/integrator/integrator.hpp"

namespace mfs::dae {

/// Steps of which at most so many are left before what ends one are evened out to meet it.
constexpr double kEvenedOut = 8.0;
/// By how much the last of them may be longer than the error control asks for.
constexpr double kStretch = 1.05;
/// How much longer than the last one a step may be that comes back to the fixed one after a rejection.
constexpr double kBackToFixed = 1.1;

/// Where nothing but rates is known: that in which they change [q, v] by half of what is allowed, not more
/// than `typical`.
inline double first_step(const Executor& executor, const StepState& state, const Array<double>& weights,
                         const IntegratorOptions& options, double typical) {
  if (options.initial_step > 0.0) return options.initial_step;
  if (options.fixed_step > 0.0) return options.fixed_step;
  const Rates rates{state.v.data(), state.a.data(), state.v.size()};
  return 1.0 / std::max(1.0 / typical, 2.0 * weighted_rms<1>(executor, rates, weights).of[0]);
}

/// The step wanted, or a shorter one by which a whole number of steps is as long as what is `left`.
inline double planned_step(const IntegratorOptions& options, double wanted, double left) {
  if (options.max_step > 0.0) wanted = std::min(wanted, options.max_step);
  if (options.fixed_step > 0.0) wanted = std::min(wanted, options.fixed_step);
  const double steps = left / wanted;
  if (options.fixed_step > 0.0) {
    const double count = std::max(1.0, std::ceil(steps * (1.0 - 1e-9)));
    // One that is coming back to the step asked for is as long as it may be, until it would pass the end.
    return wanted < options.fixed_step && count > 2.0 ? wanted : left / count;
  }
  return steps > kEvenedOut ? wanted : left / std::max(1.0, std::ceil(steps / kStretch));
}

/// The step to want after one that was wanted and taken, also where it was shortened to meet an output.
inline double back_to_fixed(const IntegratorOptions& options, double suited, double wanted) {
  return std::min(options.fixed_step, std::max(suited, kBackToFixed * wanted));
}

}  // namespace mfs::dae
