// Initial conditions that fulfil the constraints, found in three steps, each a linear system
//
//   [ K      Phi_q^T ] [ change ]   [ ... ]        K: 1 / scale^2 on the diagonal, or the mass matrix
//   [ Phi_q     0    ] [   mu   ] = [ ... ]
//
// solved by mfs::Solver: q0 moves to Phi = 0 and v0 to d/dt Phi = 0, as little as possible in the scales of
// the coordinates (Gauss-Newton); then a0 and lambda0 follow from the equations of motion.
#pragma once

#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae {

/// `given`: t, q, v. Returns all of the state. Constraints have to be independent.
/// Throws InvalidInput where no q near the given one fulfils the constraints (names one), SingularMatrix
/// where the mass matrix leaves accelerations undetermined (names a coordinate or constraint).
State consistent_state(const ConstrainedSystem& system, const IntegratorOptions& options, State given);

/// Values of Phi_q at t and q.
std::vector<double> constraint_gradient(const ConstrainedSystem& system, double t,
                                        const std::vector<double>& q);

}  // namespace mfs::dae
