// The vectors of a solve in the memory of a device, as iterative refinement sees them
// (accuracy/iterative_refinement.hpp): one part, and one wait for the device a step. What the host does where
// a step has stalled is left to it.
#pragma once

#include <cmath>

#include "accuracy/iterative_refinement.hpp"
#include "kernels/factors.hpp"

namespace mfs {

/// Of the block that `factors` were started with.
template <class Value>
class ResidentVectors {
 public:
  ResidentVectors(ResidentFactors<Value>& factors, double tolerance)
      : factors_(factors), tolerance_(tolerance) {}

  Vertex parts() const { return 1; }
  void measure(double* errors) { errors[0] = factors_.backward_error(tolerance_); }
  void correct(const Vertex*, Vertex) { factors_.correct(); }
  // correct() has added it.
  double add_correction(Vertex, Vertex) { return factors_.backward_error(tolerance_); }
  double drop_remainders(Vertex, Vertex, double error) const { return error; }
  // No other solution is held.
  void take_back(Vertex) { lost_ = true; }

  /// Whether the last step made the solution worse.
  bool lost() const { return lost_; }

 private:
  ResidentFactors<Value>& factors_;
  double tolerance_;
  bool lost_ = false;
};

/// Of the block that `factors` were started with. `improved`: whether the solution is worth going on from.
template <class Value>
SolveOutcome refine_resident(ResidentFactors<Value>& factors, const SolveControls& controls, bool& improved) {
  ResidentVectors<Value> vectors(factors, controls.tolerance);
  IterativeRefinement<ResidentVectors<Value>> refinement(vectors, controls);
  refinement.measure();
  // A right-hand side that is not finite has not been refused yet.
  const bool finite = std::isfinite(refinement.worst_error());
  if (finite) refinement.run();
  improved = finite && !vectors.lost();
  SolveOutcome outcome;
  outcome.backward_error = refinement.worst_error();
  outcome.refinement_steps = refinement.steps();
  if (refinement.steps() > 0) outcome.time_ladder = refinement.seconds();
  return outcome;
}

}  // namespace mfs
