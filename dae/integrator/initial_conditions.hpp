// Initial positions and velocities that fulfil the constraints: q0 moves to Phi = 0 (Gauss-Newton) and v0 to
// d/dt Phi = 0, as little as possible in the scales of the coordinates, each by linear systems
//
//   [ K      Phi_q^T ] [ change ]   [ ... ]        K: 1 / scale^2 on the diagonal, 0 of measures
//   [ Phi_q     0    ] [   mu   ] = [ ... ]
//
// solved by mfs::Solver. Where positions are moved, constraints on velocities are left out: their rows are mu
// = 0. Newton then finds a0 and lambda0 by the equations of motion.
#pragma once

#include <mfs/error.hpp>

#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae {

/// Throws InvalidInput with the name of a constraint that is no number at the given t, q and v.
void check_constraints(const ConstrainedSystem& system, const State& given);

/// `given`: t, q, v. Returns the state with a and lambda zero. Constraints have to be independent.
/// Throws InvalidInput where no q near the given one fulfils the constraints, with the name of the one that
/// the given q violates most.
State consistent_motion(const ConstrainedSystem& system, const IntegratorOptions& options, State given);

/// The largest |x_i|; infinite where one is not a number.
double largest_size(const std::vector<double>& x);

/// Does `work` with a matrix of the start; what is singular or no number there is named by `name(column)`.
template <class Name, class Work>
void naming_start(const Name& name, const Work& work) {
  const auto append = [&](auto& error) {
    if (error.column() >= 0)
      error.append(" (initial conditions: " + name(static_cast<int>(error.column())) + ")");
  };
  try {
    work();
  } catch (SingularMatrix& e) {
    append(e);
    throw;
  } catch (InvalidInput& e) {
    append(e);
    throw;
  }
}

/// Values of Phi_q at t and q.
std::vector<double> constraint_gradient(const ConstrainedSystem& system, double t,
                                        const std::vector<double>& q);
/// The largest size in each row of these, in coordinates of these scales.
std::vector<double> constraint_sizes(const ConstrainedSystem& system, double t, const std::vector<double>& q,
                                     const std::vector<double>& scale);

}  // namespace mfs::dae
