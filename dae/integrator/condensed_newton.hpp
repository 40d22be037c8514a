// Newton's method for the steps of mechanisms of rigid bodies, of which constraints hold most coordinates.
//
// With the relations of the formula solved for v and q, and q_by_v kappa + mu for mu (projection.hpp),
//
//   v = v0 + v_by_a (a - a0) + B kappa,     q = q0 + q_by_a (a - a0) + B mu,
//
// the unknowns are a, lambda, kappa, mu, for F and the constraints on three levels. Those on positions and
// velocities determine kappa and mu alone, once a is known (constraint_directions.hpp). What kappa
// and mu change in F and in the constraints on accelerations is left out of the matrix,
//
//   [ (dF/da + v_by_a dF/dv + q_by_a dF/dq) / s + Phi_q^T Phi_q            Phi_q^T ] [ s a                ]
//   [ Phi_q + v_by_a (Phi'')_v + q_by_a (Phi'')_q                             0    ] [ lambda - s Phi_q a ]
//
// (scaled and augmented as in step_equations.hpp), a third as large as that of all unknowns and in a chain a
// twentieth of the work. It costs a rate at which corrections shrink: kappa and mu answer a correction of a
// by h w h a and h^2 w h a, as far as the motion turns (w) the directions of the constraints, and change the
// accelerations of the constraints by (w h)^2 a. Where stiff springs pull across constraints that rate may be
// bad; who calls then turns to newton.hpp, whose matrix is whole.
//
// One thread makes the passes over vectors: there are no more than a few thousand coordinates.
#pragma once

#include <memory>
#include <vector>

#include "dae/integrator/newton.hpp"
#include "dae/integrator/projection.hpp"

namespace mfs::dae {

class CondensedNewton {
 public:
  /// Whether a system is one for it: one of joints without constraints on velocities alone.
  static bool suits(const ConstrainedSystem& system);
  /// Whether it is one for make_consistent(): most coordinates are in constraints, none in very many.
  static bool is_of_joints(const ConstrainedSystem& system);

  /// All have to live as long; `executor` is the host. The counters and times of `report` grow.
  CondensedNewton(const ConstrainedSystem& system, const Projection& projection,
                  const IntegratorOptions& options, const Executor& executor, IntegrationReport& report);
  ~CondensedNewton();

  /// As those of Newton.
  void find_accelerations(StepState& state, double h);
  NewtonOutcome solve(const StepRelation& relation, const Array<double>& lambda, const Array<double>& weights,
                      StepState& state);

  /// As that of Newton. Where the matrix leaves most of `e`, forces are not stiff, and `e` is as it was:
  /// false.
  bool filter_error(Array<double>& e);

  /// Brings a state that is nearly there to the constraints on positions and velocities, along their
  /// directions, and sets a and lambda. Throws what the system and the solver throw; the state is of no use
  /// then.
  void make_consistent(StepState& state);

  /// Of the matrix.
  int size() const;
  std::size_t entries() const;
  /// Phi_q of the last Jacobian.
  const std::vector<double>& constraint_gradient() const;
  /// In how many steps corrections by a new Jacobian have shrunk slowly.
  int slow_steps() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mfs::dae
