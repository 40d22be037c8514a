// Whether A is singular, by one solution for a right-hand side that is as good as random: where the exact
// correction (accuracy/correction.hpp) would be too large.
//
// If l^T A = 0, then l^T (b - A x) = l^T b for every x: no x makes the residual small beside b, unless b
// happens to be orthogonal to l. Refinement and FGMRES then let x grow along a null vector of A until the
// residual is small beside |A| |x|, which is what backward errors are measured by. So a residual that is
// small beside b itself proves A regular; if it is not, x / |x| is a null vector as far as x has grown.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "accuracy/solve_controls.hpp"
#include "kernels/runtime/scalars.hpp"

namespace mfs {

struct NullDirection {
  bool regular = false;
  bool null = false;    // the solution has grown into a null vector,
  Vertex unknown = -1;  // and this is its largest scaled entry
};

/// As far as refinement gets: the residual beside b then says whether the solution is good enough.
template <class Scalar>
SolveControls probing_controls() {
  return {2.0 * std::numeric_limits<RealOf<Scalar>>::epsilon(), 10};
}

/// Entries of size 1/2 to 1 with random signs in scaled rows; the same in every run.
template <class Scalar>
void probing_vector(Vertex n, const double* scale, Scalar* b) {
  std::uint64_t state = 0x9E3779B97F4A7C15u;
  for (Vertex i = 0; i < n; ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;  // Knuth, MMIX
    const double size = 0.5 + 0.5 * static_cast<double>(state >> 40) * 0x1p-24;
    const double sign = (state >> 33) % 2 == 0 ? 1 : -1;
    b[i] = Scalar(static_cast<RealOf<Scalar>>(sign * size / scale[i]));
  }
}

/// From the residual r of the solution x for a probing vector; `largest` is the largest scaled entry of A.
template <class Scalar>
NullDirection null_direction(Vertex n, const double* row_scale, const Scalar* r, const double* column_scale,
                             const Scalar* x, double largest) {
  // |l^T b| is about |l|_2, so some entry of the residual is at least |l|_2 / |l|_1 >= 1 / sqrt(n).
  const double small = 1e-3 / std::sqrt(static_cast<double>(n));
  constexpr double kNull = 1e4 * std::numeric_limits<RealOf<Scalar>>::epsilon();
  double residual = 0, size = 0;
  NullDirection direction;
  for (Vertex i = 0; i < n; ++i) {
    const double rest = std::abs(r[i]) * row_scale[i], entry = std::abs(x[i]) / column_scale[i];
    if (!(rest <= residual)) residual = rest;  // NaN stays
    if (!(entry <= size)) {
      size = entry;
      direction.unknown = i;
    }
  }
  direction.regular = residual <= small;
  direction.null = std::isfinite(size) && size * largest * kNull > 1;
  return direction;
}

}  // namespace mfs
