// The first rungs of the ladder where the factors lie: a substitution, and iterative refinement while that
// halves the error. One wait for the device a step.
#pragma once

#include <limits>

#include "accuracy/solve_controls.hpp"
#include "kernels/factors.hpp"
#include "ordering/stopwatch.hpp"

namespace mfs {

/// Of the block that `factors` were started with. `improved`: whether the last step made the solution better,
/// so that it is worth going on from.
template <class Value>
SolveOutcome refine_resident(ResidentFactors<Value>& factors, const SolveControls& controls, bool& improved) {
  SolveOutcome outcome;
  outcome.backward_error = factors.backward_error(controls.tolerance);
  const Stopwatch refining;
  double before = std::numeric_limits<double>::max();  // a first step for every finite error
  while (outcome.backward_error > controls.tolerance && outcome.backward_error <= before / 2 &&
         outcome.refinement_steps < controls.max_steps) {
    factors.correct();
    before = outcome.backward_error;
    outcome.backward_error = factors.backward_error(controls.tolerance);
    ++outcome.refinement_steps;
  }
  if (outcome.refinement_steps > 0) outcome.time_ladder = refining.seconds();
  improved = outcome.backward_error < before;
  return outcome;
}

}  // namespace mfs
