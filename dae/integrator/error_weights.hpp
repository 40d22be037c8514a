// Passes over vectors, for the host and for devices: what local errors and rates are measured by, and what is
// expected of multipliers.
#pragma once

#include <cmath>
#include <cstddef>

#include "dae/integrator/integrator.hpp"
#include "dae/integrator/step_state.hpp"
#include "dae/vectors/loops.hpp"
#include "dae/vectors/operations.hpp"

namespace mfs::dae {

/// Error weights of [q, v].
struct SetWeights {
  const double *q, *v, *scale;
  double* weights;
  std::size_t n;
  double rtol, atol_position, atol_velocity;
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    weights[i] = rtol * std::abs(q[i]) + atol_position * scale[i];
    weights[n + i] = rtol * std::abs(v[i]) + atol_velocity * scale[i];
  }
};

/// [v, a], the derivatives of [q, v].
struct Rates {
  const double *v, *a;
  std::size_t n;
  MFS_HOST_DEVICE Numbers<1> operator()(std::size_t i) const { return {{i < n ? v[i] : a[i - n]}}; }
};

/// Of [q, v], by accelerations that jump from a to b.
struct Jump {
  const double *a, *b;
  std::size_t n;
  MFS_HOST_DEVICE Numbers<1> operator()(std::size_t i) const { return {{i < n ? 0.0 : b[i - n] - a[i - n]}}; }
};

/// On the line through two values at the ends of the last step, `ratio` steps after it.
struct Extrapolate {
  const double *now, *before;
  double* then;
  double ratio;
  MFS_HOST_DEVICE void operator()(std::size_t i) const { then[i] = now[i] + (now[i] - before[i]) * ratio; }
};

/// Of `state`; `scale`: of the coordinates.
inline void weigh(const Executor& executor, const StepState& state, const Array<double>& scale,
                  const IntegratorOptions& options, Array<double>& weights) {
  const std::size_t n = scale.size();
  weights.resize(executor, 2 * n);
  for_each(executor, n,
           SetWeights{state.q.data(), state.v.data(), scale.data(), weights.data(), n, options.rtol,
                      options.atol_position, options.atol_velocity});
}

/// By which rates of [q, v] change between two states, in units of what is allowed per time.
inline double jump(const Executor& executor, const StepState& before, const StepState& after,
                   const Array<double>& weights) {
  return weighted_rms<1>(executor, Jump{before.a.data(), after.a.data(), before.a.size()}, weights).of[0];
}

inline void extrapolate(const Executor& executor, const Array<double>& now, const Array<double>& before,
                        double ratio, Array<double>& then) {
  then.resize(executor, now.size());
  for_each(executor, now.size(), Extrapolate{now.data(), before.data(), then.data(), ratio});
}

}  // namespace mfs::dae
