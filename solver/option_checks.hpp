// What the options mean where they leave the choice to the solver, and which of them are refused.
#pragma once

#include <cmath>
#include <limits>

#include <mfs/options.hpp>

#include "kernels/runtime/scalars.hpp"

namespace mfs {

/// Throws InvalidInput with the name of the first option that makes no sense or that the backend cannot obey,
/// BackendError for a backend that is not there.
void check_options(const Options& options);

/// Number of threads of every phase but the analysis.
int threads_of(const Options& options);
int analysis_threads_of(const Options& options);

template <class Scalar>
double tolerance_of(const SolveOptions& options) {
  if (options.tolerance > 0) return options.tolerance;
  return std::is_same_v<RealOf<Scalar>, double> ? 1e-12 : 1e-6;
}

/// `Scalar` of the matrix, whose factors have single precision or that of the matrix.
template <class Scalar>
double pivot_tolerance_of(const FactorOptions& options, bool single_precision) {
  if (options.pivot_tolerance > 0) return options.pivot_tolerance;
  return std::sqrt(single_precision ? double{std::numeric_limits<RealOf<Narrow<Scalar>>>::epsilon()}
                                    : double{std::numeric_limits<RealOf<Scalar>>::epsilon()});
}

/// Precision::automatic on a device that computes `single_to_double` times as fast in single precision.
inline Precision automatic_precision(int single_to_double) {
  return single_to_double > kSlowDouble ? Precision::single : Precision::full;
}
/// Whether factors are to have single precision where the matrix has more; `automatic` is that of the
/// backend.
template <class Scalar>
bool mixed_precision(const FactorOptions& options, Precision automatic) {
  const Precision asked = options.precision == Precision::automatic ? automatic : options.precision;
  return asked == Precision::single && !std::is_same_v<Scalar, Narrow<Scalar>>;
}

}  // namespace mfs
