// An integration formula, as the step's equations and the loop over steps see it. Whichever it is, at the new
// time v and q of a coordinate are linear functions of a,
//
//   v = v0 + v_by_a (a - a0),    q = q0 + q_by_v (v - v0),
//
// with (q0, v0, a0) a prediction from earlier steps, from which Newton's method starts. BDF has both factors
// h' (h' = h / b0, the paper's Eq. (6)).
//
// Generalized-alpha is that of Arnold and Bruls (Multibody System Dynamics 18 (2007) 185-202): an
// acceleration-like w with (1 - am) w_1 + am w_0 = (1 - af) a_1 + af a_0 takes a's place in Newmark's
// formulas; order 2, damping of high frequencies chosen by rho_inf. With the relations asked for along the
// directions that constraints leave free (projection.hpp), which hold on all levels, it is the method for the
// ordinary differential equations of the free directions: nothing is lost where the step changes, and no
// accelerations oscillate. Steps follow the leading terms of its local errors.
#pragma once

#include <functional>
#include <memory>

#include "dae/integrator/step_state.hpp"

namespace mfs::dae {

struct StepRelation {
  double t = 0.0;                     ///< the new time
  double v_by_a = 0.0, q_by_v = 0.0;  ///< s
  Array<double> q, v, a;              ///< q0, v0, a0
  double q_by_a() const { return q_by_v * v_by_a; }
};

/// Takes from an error of velocities what forces take of it within the step (Newton::filter_error). False: it
/// cannot.
using ErrorFilter = std::function<bool(Array<double>& velocities)>;

class Formula {
 public:
  virtual ~Formula() = default;
  /// Forgets the past; `h` is the step that is going to be tried, `longest` what the first steps may come to
  /// where they become longer at once.
  virtual void start(const StepState& state, double h, double longest) = 0;
  /// The relation at the last accepted time + h.
  virtual void predict(double h, StepRelation& relation) = 0;
  virtual int order() const = 0;
  /// Local error of a step that ends in `state`, in units of what is allowed. `weights` belong to [q, v].
  /// `filter` may be used where it is too large.
  virtual double local_error(const StepState& state, const Array<double>& weights,
                             const ErrorFilter& filter) = 0;
  /// The step to try next, after the local error was too large for the `times`-th time in one step.
  virtual double reject(int times) = 0;
  /// Goes on to `state`; returns the step that suits next. After local_error(state).
  virtual double accept(const StepState& state, const Array<double>& weights) = 0;
  /// After a step, or before one that is going to be tried: what moves the system changes at its end in a way
  /// that earlier steps do not tell.
  virtual void distrust_past() {}
};

/// All vectors are those of `executor`, which has to live as long.
std::unique_ptr<Formula> make_formula(const IntegratorOptions& options, const Executor& executor);

}  // namespace mfs::dae
