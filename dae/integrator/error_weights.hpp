// Passes over vectors, for the host and for devices: what local errors and rates are measured by, and what is
// expected of multipliers.
#pragma once

#include <cmath>
#include <cstddef>

#include "dae/vectors/loops.hpp"

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

}  // namespace mfs::dae
