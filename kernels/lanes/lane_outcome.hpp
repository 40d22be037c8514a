// What is asked of lanes, what became of them, and when a lane is refined no further; on the host, whoever
// executes the program.
#pragma once

#include <limits>

#include "kernels/lanes/lane_steps.hpp"

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

constexpr double kNotMeasured = std::numeric_limits<double>::infinity();

/// Notes the error `now` of one column of a lane after so many steps of refinement. `error` is what it was,
/// from kNotMeasured on. Whether the column is to be refined: each step must halve the error.
MFS_LANES bool stays_open(const LaneRules& rules, int step, double now, double& error, LaneOutcome& lane) {
  if (!lane.solved || error <= rules.tolerance) return false;
  const double before = error;
  error = now;
  if (now <= rules.tolerance) {
    lane.backward_error = larger(now, lane.backward_error);
    lane.steps = lane.steps < step ? step : lane.steps;
    return false;
  }
  const bool improved = step == 0 ? now < before : now < 0.5 * before;
  lane.solved = improved && step < rules.max_steps;
  return lane.solved;
}

}  // namespace mfs::lanes
