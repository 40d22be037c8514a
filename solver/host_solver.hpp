// The last resort of a backend on a device: a solver on the host, with a ladder of its own, for values whose
// factors on the device do not reach the tolerance. It is made when it is first needed.
#pragma once

#include <cstdint>
#include <memory>

#include <mfs/solver.hpp>

#include "kernels/fallback.hpp"
#include "solver/matrix_factors.hpp"

namespace mfs {

template <class Scalar>
class HostSolver {
 public:
  /// Of a solver on a device with these options and factors, both of which must outlive it.
  HostSolver(const Options& options, const MatrixFactors<Scalar>& factors)
      : options_(options), factors_(factors) {}

  /// Whether the present values are solved for here. After values that were, others with the same analysis
  /// are so from the start; now and then the device is tried again. A solver that has refused serves nothing.
  bool serves();
  /// The solver for the present values, after serves(). Throws what BasicSolver::factor throws.
  BasicSolver<Scalar>& solver();
  /// It has solved: the present values are solved for here from now on.
  void note_solved() { fallback_.activate(); }

 private:
  const Options& options_;
  const MatrixFactors<Scalar>& factors_;
  std::unique_ptr<BasicSolver<Scalar>> solver_;
  Fallback fallback_;
  std::int64_t analysis_ = 0;  // that solver_ and fallback_ belong to
  std::int64_t seen_ = 0;      // set of values that fallback_ was told of
  std::int64_t factored_ = 0;  // set of values that solver_ has factored
};

}  // namespace mfs
