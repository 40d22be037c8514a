// Integrates a ConstrainedSystem from t0 to t_end as Jung and Bae do (Multibody System Dynamics 2017, Eq.
// (6)).
//
// At every step the unknowns x = [lambda, a, v, q] of the new time solve H(x) = 0, which is made of the
// equations of motion, the constraints at all three levels (so nothing drifts) and the relations of a BDF
// formula between a, v and q. Constraints already tie some coordinates to the others, so these relations are
// asked for along the directions that are free: U1^T (h' a - v - zeta1) = 0, U2^T (h' v - q - zeta2) = 0,
// where [Phi_q; U_i^T] is invertible. Here U1 = U2 is, but for tied nodes, the null space of Phi_q at the
// prediction (projection.hpp). h' = h / b0.
//
// Steps and orders 1 ... 5 follow an estimate of the local error. Newton's method is that of NOX, its linear
// systems are solved by MFS; a factorization is kept as long as it lets Newton's method converge.
//
//   Integrator integrator(system);
//   Recorder recorder;                       // a class of yours, derived from Observer
//   integrator.run(0.0, q0, v0, 1.0, {0.01, 0.02, ...}, recorder);
//   integrator.report();                     // what it took
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <mfs/options.hpp>

#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae {

enum class Method {
  bdf,                ///< order 1 ... 5
  generalized_alpha,  ///< order 2, with little damping where the motion is slow beside the step
};

/// Which unknowns Newton's method sees. The trajectory is the same.
enum class Unknowns {
  full,     ///< the paper's [lambda, a, v, q], and what the constraints take of the formula (projection.hpp)
  reduced,  ///< q and v of coordinates that are in no joint are expressed by a
};

struct IntegratorOptions {
  Method method = Method::bdf;
  Unknowns unknowns = Unknowns::reduced;

  /// The local error of a coordinate q_i, a velocity v_i stays below rtol |q_i| + atol_position s_i,
  /// rtol |v_i| + atol_velocity s_i in the mean square, with s_i = coordinate_scale(i).
  /// Where rtol alone is given and less than 1e-4, these are made smaller, so that errors of the whole motion
  /// fall as rtol does (tolerances.hpp).
  double rtol = 1e-4;
  double atol_position = 0.0;  ///< 0: rtol / 100
  double atol_velocity = 0.0;  ///< 0: rtol
  /// Largest |Phi|, |d/dt Phi|, |d^2/dt^2 Phi| that a step may leave (each in its own unit), and not more
  /// than a tenth of the local error that atol_position and atol_velocity allow.
  double constraint_position = 1e-8;
  double constraint_velocity = 1e-6;
  double constraint_acceleration = 1e-4;

  int max_order = 5;          ///< of BDF, 1 ... 5
  double initial_step = 0.0;  ///< s; 0: chosen
  double max_step = 0.0;      ///< s; 0: no bound
  double min_step = 0.0;      ///< s, the step at which the integrator gives up; 0: as small as t resolves
  /// s; not 0: no error control. BDF starts with initial_step and comes up to this slowly, generalized-alpha
  /// starts with it. Steps are shortened evenly to meet outputs that end steps, and t_end.
  double fixed_step = 0.0;
  double rho_inf = 0.8;  ///< spectral radius of generalized-alpha at infinity, 0 ... 1

  int newton_iterations = 8;  ///< most of one attempt at a step
  /// Keep a factorization while Newton's method converges with it.
  bool keep_factors = true;
  /// Most steps of FGMRES with kept factors as preconditioner, before a matrix is factored anew; 0: none.
  int krylov_steps = 8;

  Backend backend = Backend::openmp;  ///< of the linear solver
  int threads = 0;                    ///< of the linear solver and of the assembly; 0: all
  int analysis_threads = 0;           ///< of the linear solver's analysis; 0: as many
};

/// What the system is in at a time. Multipliers of constraints of which some follow from the others are those
/// with the least sum of squares, normalizations left out.
struct State {
  double t = 0.0;
  std::vector<double> q, v, a, lambda;
};

/// One accepted step.
struct StepReport {
  std::int64_t number = 0;  ///< 1, 2, ...
  double t = 0.0;           ///< s, at its end
  double h = 0.0;           ///< s
  int order = 0;
  int newton_iterations = 0;  ///< rejected attempts included, as all below
  int factorizations = 0;
  int rejections = 0;        ///< attempts that failed before
  double residual = 0.0;     ///< largest |H_i(x)| in the end
  double violation[3] = {};  ///< largest |Phi|, |d/dt Phi|, |d^2/dt^2 Phi|
  double wall = 0.0;         ///< s of computing
};

/// The sum of all steps.
struct IntegrationReport {
  std::int64_t coordinates = 0, constraints = 0;
  std::int64_t unknowns = 0, entries = 0;  ///< of H_x
  std::vector<std::string> redundant;      ///< constraints that follow from those before and are left out

  std::int64_t steps = 0;
  std::int64_t error_rejections = 0;   ///< the local error was too large
  std::int64_t newton_rejections = 0;  ///< Newton's method did not converge
  std::int64_t solver_rejections = 0;  ///< the linear solver or the system threw
  std::int64_t newton_iterations = 0;
  std::int64_t jacobians = 0, factorizations = 0, analyses = 0;
  std::int64_t krylov_solves = 0;  ///< linear systems solved on kept factors of another matrix
  double violation[3] = {};        ///< largest |Phi|, |d/dt Phi|, |d^2/dt^2 Phi| of all accepted steps

  std::int64_t bytes_solver = 0;  ///< taken by the linear solver
  double time_analysis = 0;       ///< s: reordering and symbolic factorization
  double time_factor = 0;         ///< s: numeric factorization
  double time_solve = 0;          ///< s: solution of factored systems
  double time_assembly = 0;       ///< s: residuals and Jacobians
  double time_total = 0;          ///< s, initial conditions included, observers not
};

/// Is told of what happens. What it throws ends the run.
class Observer {
 public:
  virtual ~Observer() = default;
  /// After each accepted step; `state()` fetches where the system is then.
  virtual void step(const StepReport&, const std::function<const State&()>& /*state*/) {}
  /// At t0, if it is among the outputs, and at each later output time, after the step in or with which it
  /// comes.
  virtual void output(const State&) {}
};

class ScaledSystem;

class Integrator {
 public:
  /// `system` has to live as long. Throws InvalidInput for options out of range.
  explicit Integrator(const ConstrainedSystem& system, IntegratorOptions options = {});
  ~Integrator();
  Integrator(Integrator&&) noexcept;

  /// Integrates from `t0` to `t_end` and calls `observer`; returns the state at `t_end`. `q0` and `v0` (n
  /// each) are first moved, as little as possible, to where the constraints hold. `outputs` ascend within t0
  /// ... t_end. Mechanisms pass over them, and states there come from the ends of steps (dense_output.hpp):
  /// of rigid bodies they fulfil all equations, with flexible ones constraints hold as well as positions do.
  /// What is neither has them at ends of steps. Throws InvalidInput (sizes, times, NaN; constraints that the
  /// start cannot be moved to, or that contradict each other: names them), mfs::Error where the step became
  /// too small (time, order and what failed), and what the linear solver throws that no shorter step can cure
  /// (OutOfMemory, BackendError).
  State run(double t0, std::vector<double> q0, std::vector<double> v0, double t_end,
            const std::vector<double>& outputs, Observer& observer);

  /// Of the run in progress, or the last one.
  const IntegrationReport& report() const;

 private:
  class Impl;
  const ConstrainedSystem* system_;
  IntegratorOptions options_;
  std::unique_ptr<ScaledSystem> scaled_;  ///< where the system has scales other than 1, of the last run
  std::unique_ptr<Impl> impl_;
};

}  // namespace mfs::dae
