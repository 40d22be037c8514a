// The matrices of small motions about a state,
//
//   M x'' + D x' + K x + Phi_q^T mu = f,   Phi_q x = 0,
//
// and, where something rolls, Phi_q x' + V_q x = 0 in its place for rows of constraints on velocities, V_q =
// d(Phi_q v)/dq, as Matrix Market files, for whoever wants to design a controller or to check modes with
// other tools.
#pragma once

#include <string>
#include <vector>

#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae {

/// Writes M.mtx, D.mtx, K.mtx (n x n), Phi_q.mtx (m x n), V_q.mtx (the same, where something rolls), F.mtx (F
/// and Phi, n + m) in `state`, which has t, q, v, a and lambda, and rows.csv: a line for each coordinate and
/// each constraint with its name, and q or lambda. Makes the folder. All constraints are there, also those
/// that follow from others. Throws InvalidInput where files cannot be written. Returns the names of the
/// matrices.
std::vector<std::string> write_linearization(const ConstrainedSystem& system, const State& state,
                                             const std::string& folder);

}  // namespace mfs::dae
