// Backward differentiation formulas of order 1 to 5 with variable step, in the fixed-leading-coefficient form
// of DASSL and IDA, for a vector y of which each new value and derivative are tied by y' = y'_p + c (y -
// y_p).
//
// The past is held as modified divided differences phi_0 ... phi_k+1 (Krogh 1974): phi_0 = y at the last
// time, phi_1 a scaled backward difference, and so on; a constant step leaves them alone, a change of step
// multiplies phi_j by beta_j. The prediction is the polynomial through the last k + 1 values, and
// y - y_p = e is, times a known constant, the local error. The estimates of order k - 2 ... k + 1 come from
// phi and e alone; order and step are chosen from them.
//
// What was done at another step or order leaves a stiff body's velocities off by far more than a local error:
// at order 1 those of a point at r of a body that turns with w by h w^2 r / 2 inwards, whatever the body's
// stiffness, and at the first step of order 2 by nothing, at once. This difference is in the correction, does
// not become smaller with the step, and has no consequence. So where an error is too large, what the step's
// own matrix leaves of it is looked at instead (Shampine and Baca, Numer. Math. 1984; RADAU5 of Hairer and
// Wanner, Solving ODEs II, IV.8): a velocity counts (M + h' D + h'^2 K)^-1 M times. Then order and step are
// chosen by that alone; errors of other orders are not known so.
//
// Sources: Brenan, Campbell, Petzold, "Numerical Solution of Initial-Value Problems in DAEs", SIAM 1996, ch.
// 5; Hindmarsh et al., SUNDIALS, ACM TOMS 31 (2005) 363-396, section 2.3 (whose factors of 2, 0.9, 0.5 and
// 0.25 these are). Five things differ: the first step, of which no more is known than y', is far too short
// for its error, and doubled again and again it leaves differences that are rounding and decide the orders,
// so the next ones become long at once, as CVODE's does; after the third rejection in one step the integrator
// starts the formula anew, as its past is then no guide (IDA goes on at order 1 with it, and order and step
// come up only after many equal steps), and after many steps of order 1 order 2 has to be no more than
// better; steps grow by 1.2 ... 2 after as many equal ones as CVODE asks for, and after a rejection by 2 not
// before then either (IDA's only double, so that errors for tolerances a hundred apart differ by anything
// from 15 to 200, and a step may double and be rejected by turns for ever); and orders above 2 are left where
// they are not stable (stability_watch.hpp).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "dae/integrator/stability_watch.hpp"
#include "dae/vectors/executor.hpp"

namespace mfs::dae {

/// A step becomes longer only by a factor worth its new matrix, and a little less than the estimate lets it.
constexpr double kLeastGrowth = 1.2, kSafety = 0.9;

class Bdf {
 public:
  static constexpr int kMostOrder = 5;

  /// `fixed`: the order rises to `max_order` and stays, whatever the error; steps may grow slowly. All
  /// vectors are those of `executor`, which has to live as long. `max_step`: the longest that is going to be
  /// tried; 0: not bounded.
  Bdf(int max_order, bool fixed, const Executor& executor, double max_step = 0.0)
      : max_order_(max_order), fixed_(fixed), max_step_(max_step), executor_(executor) {}

  /// Forgets the past, takes y and `dy` = y'; `h`: the step that is going to be tried. Where its error is far
  /// below what is allowed, the next ones become long at once, up to `longest`.
  void start(Array<double> y, Array<double> dy, double h, double longest);

  /// Predicts y and y' at t + h by the present order. Nothing changes until `accept`.
  void predict(double h, Array<double>& y, Array<double>& dy);
  double rate() const { return rate_; }  ///< c = 1/h' of the last prediction
  int order() const { return order_; }

  /// Local error of the step with correction `e` = y - y_p, in units of what `weights` allow: at most 1 is
  /// good. Says also what `reject` and `accept` are going to do.
  double local_error(const Array<double>& e, const Array<double>& weights);
  /// Whether a local error of `error` is too large, and not so much too large that it is known to be no
  /// matter of stiffness.
  bool may_be_stiff(double error) const {
    return !fixed_ && error > 1.0 && error <= (rising_ ? kLargeAtStart : kLargest);
  }
  /// The same as local_error, after it, where `e` is what stiff forces leave of the correction.
  double filtered_error(const Array<double>& e, const Array<double>& weights);
  /// Whether filtered_error is to know what stiff forces leave of the error of order 2, too: after many steps
  /// of order 1, in which nothing else might tell that it is better.
  bool asks_for_error_above() const { return order_ == 1 && most_order() > 1 && steps_at_one_ >= kLongAtOne; }
  /// The correction as it would be at the next higher order.
  void correction_above(const Array<double>& e, Array<double>& above) const;
  /// After filtered_error; `above`: what stiff forces leave of correction_above.
  void filtered_error_above(const Array<double>& above, const Array<double>& weights);
  /// The step to try next, after the error was too large for the `times`-th time (1, 2, ...) in one step.
  /// From the third time on, what is known of the past is to be forgotten by start().
  double reject(int times);
  /// Goes on to the new time with correction `e`; returns the step that suits it. After local_error(e).
  double accept(const Array<double>& e, const Array<double>& weights);
  /// Until so many steps are taken that they know what is next: estimates of the error are not less than
  /// those of equal steps. After long steps those of a short one are less, as it is of the same smooth
  /// function.
  void distrust_past() { distrusted_ = order_ + 1; }

 private:
  using Coefficients = std::array<double, kMostOrder + 2>;
  using Differences = std::array<Array<double>, kMostOrder + 2>;
  /// Of e, of what it would be at one and two orders less, as far as these are known, and of the sum of the
  /// first and the last.
  using Sizes = std::array<double, 4>;
  Sizes sizes(const Array<double>& e, const Array<double>& weights) const;
  void restart_with(double h);
  void set_coefficients(double h);
  void shift(const Array<double>& e);
  struct Choice {
    int order;
    double step;
  };
  /// The order and the step after this one.
  Choice choose(const Array<double>& e, const Array<double>& weights);
  double error_of_order_above(const Array<double>& e, const Array<double>& weights) const;
  /// The highest order that may be taken now.
  int most_order() const { return hold_.holds() ? std::min(kStableOrder, max_order_) : max_order_; }
  /// By how much the next step may be longer while nothing is known of the error but that it is small, or 1.
  double growth_of_start() const;
  /// Whether orders above 2 are to be left now.
  bool leave_unstable_orders();

  /// Errors that only vibrations which the start excites, or the like, have in the first steps. Passed over,
  /// they left accelerations of bell_crank at rtol 1e-3 off by 4.6 times their size, instead of 0.75.
  static constexpr double kLargeAtStart = 30.0;
  /// Errors that stiffness which is met within a step has, as that of a stop: 740 to 830 where a body of 10
  /// m/s stuck to one of 1e9 N/m. Those of stiff bodies, springs and frictions that steps pass over are up
  /// to 66.
  static constexpr double kLargest = 100.0;
  /// Steps of order 1 in a row after which order 2 is taken where it is better, if only a little or, as far
  /// as steps of different length tell, for now: where they are never alike, order 1 stayed for up to 147
  /// steps.
  static constexpr int kLongAtOne = 30;

  int max_order_;
  bool fixed_;
  double max_step_;
  const Executor& executor_;
  int order_ = 1;
  bool rising_ = true;     ///< the first steps: order and step grow at each
  bool rejected_ = false;  ///< by the error, and since then not so many equal steps that they may grow
  int steps_ = 0, steps_at_one_ = 0;  ///< steps_at_one_: the last ones
  int last_order_ = 0;                ///< of the last accepted step
  int distrusted_ = 0;                ///< steps for which the past still is no guide
  double step_ = 0.0, last_step_ = 0.0, longest_at_start_ = 0.0;
  int unchanged_ = 0, next_unchanged_ = 0;  ///< steps taken with one step and order
  double rate_ = 0.0, error_factor_ = 0.0;
  Coefficients psi_{}, next_psi_{};  ///< times between the new value and earlier ones
  Coefficients alpha_{}, beta_{}, gamma_{}, sigma_{};
  Differences phi_;                              ///< up to max_order + 1
  double error_here_ = 0.0, error_below_ = 0.0;  ///< |error| of orders k, k - 1
  int suited_order_ = 1;
  double suited_error_ = 0.0;
  Sizes sizes_{};
  bool filtered_ = false;        ///< the error of the present step is
  bool above_filtered_ = false;  ///< and that of the order above, which is filtered_above_
  double filtered_above_ = 0.0;
  static constexpr int kStableOrder = 2;
  StabilityWatch watch_;
  OrderHold hold_;
};

}  // namespace mfs::dae
