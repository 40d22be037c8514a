// The state between the ends of a step.
//
// Of mechanisms of rigid bodies: positions are on the polynomial of degree 5 that has q, v and a of both
// ends, velocities on that of degree 3 that has v and a: errors of h^6 q''''''/46080 and h^4 v''''/384 at
// most. (The polynomial of BDF itself, as IDAGetSolution has it, comes to 0.02 h^6 at order 5. The derivative
// of the first would have the local error of q divided by h as an error of velocities, the second that
// divided by h^2.) Accelerations and multipliers are on straight lines, where
// CondensedNewton::make_consistent begins.
//
// With flexible bodies nothing may be asked of F there: what is left of the local error in positions would be
// multiplied by their stiffness. v, a and multipliers are on the polynomials through the ends of the last
// steps, as many as the order of the formula and one, which is BDF's own: in v 0.09 to 0.3 of a local error
// (orders 5 to 1), in a and multipliers as small a part of them. q has one end more, because where motions
// are prescribed positions at the ends are far better than what the formula would leave of them. Vibrations
// that steps pass over do not become larger, as they would by rates. Meshes are turned back before
// (body_turns.hpp). Constraints hold as well as positions do.
#pragma once

#include <vector>

#include "dae/integrator/step_state.hpp"
#include "dae/mechanics/turning_bodies.hpp"

namespace mfs::dae {

/// At t, between `before` and `after`, whose vectors are on the host.
State state_between(double t, const StepState& before, const StepState& after);

/// States at the ends of steps before the present one.
class PastStates {
 public:
  explicit PastStates(int most = 1) : most_(static_cast<std::size_t>(most)) {}

  /// `state` becomes number 0, the others move on by one. It gets arrays that may be used again.
  void add(StepState& state);
  /// None of them is known any more: they are of other constraints.
  void forget_multipliers();
  bool knows_multipliers() const { return known_multipliers_ > 0; }
  std::size_t size() const { return states_.size(); }
  const StepState& operator[](std::size_t k) const { return states_[k]; }

 private:
  std::size_t most_, known_multipliers_ = 0;
  std::vector<StepState> states_;  ///< the last one first
};

/// Of `degree` = 1 ... 5, positions need so many states before the present one.
constexpr int kMostPast = 6;

/// The state at t, not after `now`, on polynomials of `degree`, of positions one more, or less where less of
/// the past is known.
void interpolate(const Executor& executor, const std::vector<PointRange>& bodies, double t,
                 const StepState& now, const PastStates& past, int degree, StepState& there);

}  // namespace mfs::dae
