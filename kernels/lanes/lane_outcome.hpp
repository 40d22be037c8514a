// What is asked of lanes and what became of them, on the host, whoever executes the program.
#pragma once

#include "ordering/types.hpp"

namespace mfs::lanes {

/// Systems in arrays, as Batch of mfs/batch_solver.hpp has them.
template <class Scalar>
struct LaneSystems {
  Offset count;
  const Scalar* values;
  Offset values_stride;
  const Scalar* b;
  Scalar* x;
  Offset nrhs, ldb, ldx, b_stride, x_stride;
};

/// Sizes relative to the largest scaled entry: up to `tiny` a pivot is noise, below `bound` it must be at
/// least `border_part` of what it divides.
struct PivotSizes {
  double bound, tiny, border_part;
};

/// What a solution must reach, and what it may take.
struct LaneRules {
  PivotSizes pivots;
  double tolerance;
  int max_steps;
};

/// What became of a lane.
struct LaneOutcome {
  bool solved = false;  // its solution is written
  double backward_error = 0;
  int steps = 0;  // of refinement
};

}  // namespace mfs::lanes
