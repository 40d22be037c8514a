// The state between the ends of a step.
//
// Positions are on the polynomial of degree 5 that has q, v and a of both ends, velocities on that of degree
// 3 that has v and a: errors of h^6 q''''''/46080 and h^4 v''''/384 at most. (The polynomial of BDF itself,
// as IDAGetSolution has it, comes to 0.02 h^6 at order 5. The derivative of the first would have the local
// error of q divided by h as an error of velocities, the second that divided by h^2.) Accelerations and
// multipliers are on straight lines, where CondensedNewton::make_consistent begins.
#pragma once

#include "dae/integrator/step_state.hpp"

namespace mfs::dae {

/// At t, between `before` and `after`, whose vectors are on the host. `lambda`: multipliers of `before`; of
/// another length: unknown.
State state_between(double t, const StepState& before, const Array<double>& lambda, const StepState& after);

}  // namespace mfs::dae
