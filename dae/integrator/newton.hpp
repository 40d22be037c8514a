// Newton's method for the equations of a step: NOX, with MFS for its linear systems.
//
// When a search ends is said by newton_progress.hpp. It begins with the factors at hand, unless the step has
// changed too much or, as where flexible bodies turn, corrections by so old a Jacobian are expected to shrink
// so slowly that they would be made in vain until it is renewed. When corrections do not shrink, or anything
// throws, it starts again from the prediction with a fresh factorization; if that was one already, it has
// failed and the step has to be shorter.
#pragma once

#include <array>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "dae/integrator/formula.hpp"
#include "dae/integrator/integrator.hpp"
#include "dae/integrator/step_equations.hpp"

namespace mfs::dae {

/// Of a search for the new time.
struct NewtonOutcome {
  bool converged = false;
  std::exception_ptr thrown;          ///< by the system or the linear solver, in the last search
  int iterations = 0;                 ///< of all searches
  double residual = 0.0;              ///< largest |H_i|
  std::array<double, 3> violation{};  ///< largest constraint residuals, by level

  /// Why it has not converged.
  std::string failure() const;
  /// Adds what an accepted step leaves to its line and to the report of the run.
  void tell(StepReport& line, IntegrationReport& report) const;
};

class Newton {
 public:
  /// `equations`, `executor`, whose vectors all are, and `report`, whose counters and times grow, have to
  /// live as long.
  Newton(const StepEquations& equations, const IntegratorOptions& options, const Executor& executor,
         IntegrationReport& report);
  ~Newton();

  /// Sets a and lambda of `state` to what the equations of motion and the constraints on accelerations ask
  /// for. Steps are expected to take some `h` seconds. Throws SingularMatrix where accelerations are left
  /// undetermined (names a coordinate or constraint).
  void find_accelerations(StepState& state, double h);

  /// Solves for the new time. `lambda` is where multipliers start, `weights` belong to [q, v]. Where it does
  /// not converge, `state` stays as it was; otherwise its arrays are used again.
  NewtonOutcome solve(const StepRelation& relation, const Array<double>& lambda, const Array<double>& weights,
                      StepState& state);

  /// Makes of an error `e` of velocities (n) in the last step that was solved for, which ended in `state`,
  /// what the step's own matrix leaves of it:
  ///
  ///   (M + v_by_a D + q_by_a K) x + Phi_q^T mu = M e,   Phi_q x = Phi_q e.
  ///
  /// False: there is no such matrix, or something threw; `e` is as it was.
  bool filter_error(const StepState& state, Array<double>& e);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mfs::dae
