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
  /// Of a solver with these options on a device.
  explicit HostSolver(const Options& options);

  /// Whether the present values are solved for here. After values that were, others are so from the start;
  /// now and then the device is tried again. A solver that has refused serves nothing.
  bool serves(const MatrixFactors<Scalar>& factors);
  /// The solver for the present values. Throws what BasicSolver::factor throws.
  BasicSolver<Scalar>& solver_for(const MatrixFactors<Scalar>& factors);
  /// It has solved: the present values are solved for here from now on.
  void note_solved() { fallback_.activate(); }

 private:
  Options options_;
  std::unique_ptr<BasicSolver<Scalar>> solver_;
  Fallback fallback_;
  std::int64_t analysis_ = 0, values_ = 0;  // of the matrix that solver_ has factored
  std::int64_t seen_ = 0;                   // set of values that fallback_ was told of
};

}  // namespace mfs
