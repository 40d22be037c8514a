#include "dae/integrator/formula.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "dae/integrator/bdf.hpp"
#include "dae/vectors/loops.hpp"
#include "dae/vectors/operations.hpp"

namespace mfs::dae {
namespace {

/// [q, v] and [v, a].
struct Join {
  const double *q, *v, *a;
  double *y, *dy;
  std::size_t n;
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    y[i] = q[i];
    y[n + i] = dy[i] = v[i];
    dy[n + i] = a[i];
  }
};

struct Relate {
  const double *y, *dy;
  double *q, *v, *a;
  std::size_t n;
  double rate;
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    q[i] = y[i];
    v[i] = dy[i];
    // v_p' + c (v - v_p), where v starts as q_p', not as v_p.
    a[i] = dy[n + i] + rate * (dy[i] - y[n + i]);
  }
};

struct Correction {
  const double *q, *v, *y;
  double* e;
  std::size_t n;
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    e[i] = q[i] - y[i];
    e[n + i] = v[i] - y[n + i];
  }
};

/// BDF for y = [q, v].
class BdfFormula : public Formula {
 public:
  BdfFormula(const IntegratorOptions& options, const Executor& executor)
      : bdf_(options.max_order, options.fixed_step > 0.0, executor, options.max_step), executor_(executor) {}

  void start(const StepState& state, double h, double longest) override {
    const std::size_t n = state.q.size();
    Array<double> y, dy;
    y.resize(executor_, 2 * n);
    dy.resize(executor_, 2 * n);
    for_each(executor_, n, Join{state.q.data(), state.v.data(), state.a.data(), y.data(), dy.data(), n});
    bdf_.start(std::move(y), std::move(dy), h, longest);
  }
  void predict(double h, StepRelation& relation) override {
    bdf_.predict(h, y_, dy_);
    const double rate = bdf_.rate();
    relation.v_by_a = relation.q_by_v = 1.0 / rate;
    const std::size_t n = y_.size() / 2;
    for (auto* part : {&relation.q, &relation.v, &relation.a}) part->resize(executor_, n);
    for_each(executor_, n,
             Relate{y_.data(), dy_.data(), relation.q.data(), relation.v.data(), relation.a.data(), n, rate});
  }
  int order() const override { return bdf_.order(); }
  double local_error(const StepState& state, const Array<double>& weights,
                     const ErrorFilter& filter) override {
    const std::size_t n = state.q.size();
    correction_.resize(executor_, 2 * n);
    for_each(executor_, n, Correction{state.q.data(), state.v.data(), y_.data(), correction_.data(), n});
    const double error = bdf_.local_error(correction_, weights);
    if (!bdf_.may_be_stiff(error)) return error;
    filtered_.resize(executor_, 2 * n);
    copy(executor_, 2 * n, correction_.data(), filtered_.data());
    if (!filter_velocities(filter)) return error;
    const double filtered = bdf_.filtered_error(filtered_, weights);
    if (filtered <= 1.0 && bdf_.asks_for_error_above()) {
      bdf_.correction_above(correction_, filtered_);
      if (filter_velocities(filter)) bdf_.filtered_error_above(filtered_, weights);
    }
    return filtered;
  }
  double reject(int times) override { return bdf_.reject(times); }
  void distrust_past() override { bdf_.distrust_past(); }
  double accept(const StepState&, const Array<double>& weights) override {
    return bdf_.accept(correction_, weights);
  }

 private:
  /// Of filtered_.
  bool filter_velocities(const ErrorFilter& filter) {
    const std::size_t n = filtered_.size() / 2;
    velocities_.resize(executor_, n);
    copy(executor_, n, filtered_.data() + n, velocities_.data());
    if (!filter(velocities_)) return false;
    copy(executor_, n, velocities_.data(), filtered_.data() + n);
    return true;
  }

  Bdf bdf_;
  const Executor& executor_;
  Array<double> y_, dy_;  ///< predicted
  Array<double> correction_, filtered_;
  Array<double> velocities_;  ///< filtered
};

/// w belongs to the time alpha_m - alpha_f steps from a's: where the step has changed, it is moved there
/// along the line through both (Jay and Negrut 2009).
struct NextW {
  double alpha_m, alpha_f;
  double ratio = 1.0;  ///< of this step and the one that w is of
  MFS_HOST_DEVICE double moved(double a, double w) const { return a + ratio * (w - a); }
  /// Of the new time, from a there and from a and w, moved, before.
  MFS_HOST_DEVICE double operator()(double a, double last_a, double w) const {
    return ((1.0 - alpha_f) * a + alpha_f * last_a - alpha_m * w) / (1.0 - alpha_m);
  }
};

struct Newmark {
  const double *last_q, *last_v, *last_a, *w;
  double *q, *v, *a;
  NextW next_w;
  double h, beta, gamma;
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    const double now = next_w.moved(last_a[i], w[i]), next = next_w(last_a[i], last_a[i], now);
    q[i] = last_q[i] + h * last_v[i] + h * h * ((0.5 - beta) * now + beta * next);
    v[i] = last_v[i] + h * ((1.0 - gamma) * now + gamma * next);
    a[i] = last_a[i];
  }
};

/// Divided differences of a velocity at the last times.
struct Differences {
  double step, two_steps, three_steps;  ///< the new one, it with the one before, ...
  MFS_HOST_DEVICE double first(double v, double last_v) const { return (v - last_v) / step; }
  MFS_HOST_DEVICE double second(double first, double last_first) const {
    return (first - last_first) / two_steps;
  }
  MFS_HOST_DEVICE double third(double second, double last_second) const {
    return (second - last_second) / three_steps;
  }
};

/// The leading terms of the local errors of [q, v]: h^3 times the second and the third derivative of v and
/// constants of the method. The derivatives are taken from velocities: by accelerations, vibrations that are
/// far too fast for the step would count for (w h)^2 times what they are.
struct LeadingError {
  const double *v, *last_v, *first, *second;
  std::size_t n;
  Differences differences;
  double of_q, of_v;
  MFS_HOST_DEVICE Numbers<1> operator()(std::size_t i) const {
    const std::size_t k = i < n ? i : i - n;
    const double now = differences.second(differences.first(v[k], last_v[k]), first[k]);
    return {{i < n ? of_q * now : of_v * differences.third(now, second[k])}};
  }
};

/// The error of v where forces change in a way that earlier steps do not tell, in parts of the v that they
/// make in the step: the leading term takes it for a smooth function and has 0.09 of it, but what a step
/// takes a force at its end for that is not there before is all wrong.
constexpr double kUnforeseen = 0.5;

/// Goes on to q, v and a.
struct GoOn {
  const double *q, *v, *a;
  double *last_q, *last_v, *last_a, *w, *first, *second;
  NextW next_w;
  Differences differences;
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    w[i] = next_w(a[i], last_a[i], next_w.moved(last_a[i], w[i]));
    const double now = differences.first(v[i], last_v[i]);
    second[i] = differences.second(now, first[i]);
    first[i] = now;
    last_q[i] = q[i];
    last_v[i] = v[i];
    last_a[i] = a[i];
  }
};

/// The same with w = a, to begin with, and as if there had been a step of no time.
struct Begin {
  const double *q, *v, *a;
  double *last_q, *last_v, *last_a, *w, *first, *second;
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    last_q[i] = q[i];
    last_v[i] = v[i];
    w[i] = last_a[i] = first[i] = a[i];
    second[i] = 0.0;
  }
};

class GeneralizedAlpha : public Formula {
 public:
  GeneralizedAlpha(const IntegratorOptions& options, const Executor& executor)
      : next_w_{(2.0 * options.rho_inf - 1.0) / (options.rho_inf + 1.0),
                options.rho_inf / (options.rho_inf + 1.0)},
        fixed_step_(options.fixed_step),
        executor_(executor) {}

  void start(const StepState& state, double h, double) override {
    for (auto* part : {&q_, &v_, &a_, &w_, &first_, &second_}) part->resize(executor_, state.q.size());
    for_each(executor_, w_.size(),
             Begin{state.q.data(), state.v.data(), state.a.data(), q_.data(), v_.data(), a_.data(), w_.data(),
                   first_.data(), second_.data()});
    step_ = h;
    last_step_ = before_ = 0.0;
    alike_ = 0;
  }
  void distrust_past() override { distrusted_ = order() + 1; }
  void predict(double h, StepRelation& relation) override {
    step_ = h;
    next_w_.ratio = last_step_ > 0.0 ? h / last_step_ : 1.0;
    const double weight = (1.0 - next_w_.alpha_f) / (1.0 - next_w_.alpha_m);  // of a in w
    relation.v_by_a = gamma() * weight * h;
    relation.q_by_v = beta() * h / gamma();
    for (auto* part : {&relation.q, &relation.v, &relation.a}) part->resize(executor_, w_.size());
    for_each(executor_, w_.size(),
             Newmark{q_.data(), v_.data(), a_.data(), w_.data(), relation.q.data(), relation.v.data(),
                     relation.a.data(), next_w_, h, beta(), gamma()});
  }
  int order() const override { return 2; }
  double local_error(const StepState& state, const Array<double>& weights, const ErrorFilter&) override {
    // In parts of a step: where w is, what w itself has of h^2 a''.
    const double d = next_w_.alpha_m - next_w_.alpha_f, after = (1.0 + d) * (1.0 + d);
    const double in_w =
        0.5 * (1.0 - next_w_.alpha_f - (1.0 - next_w_.alpha_m) * after - next_w_.alpha_m * d * d);
    const double of_q = beta() + 0.5 * d - 1.0 / 6.0;
    const double leading = 0.5 * d * d * (1.0 - gamma()) + 0.5 * gamma() * after - 1.0 / 6.0 + in_w;
    const double of_v = distrusted_ > 0 ? std::max(leading, kUnforeseen) : leading;
    const double cube = step_ * step_ * step_;
    const bool known = last_step_ > 0.0;  // in the first step there is no third difference
    const LeadingError error{
        state.v.data(), v_.data(),     first_.data(),     second_.data(),
        w_.size(),      differences(), 2.0 * of_q * cube, known ? 6.0 * of_v * cube : 0.0};
    return error_ = weighted_rms<1>(executor_, error, weights).of[0];
  }
  double reject(int times) override {
    alike_ = 0;
    return step_ * (times == 1 ? std::clamp(kSafety * factor(), 0.25, 0.9) : 0.25);
  }
  double accept(const StepState& state, const Array<double>&) override {
    for_each(executor_, w_.size(),
             GoOn{state.q.data(), state.v.data(), state.a.data(), q_.data(), v_.data(), a_.data(), w_.data(),
                  first_.data(), second_.data(), next_w_, differences()});
    alike_ = last_step_ > 0.0 && std::abs(step_ - last_step_) <= 1e-9 * step_ ? alike_ + 1 : 1;
    before_ = std::exchange(last_step_, step_);
    distrusted_ = std::max(0, distrusted_ - 1);
    if (fixed_step_ > 0.0) return fixed_step_;
    if (factor() <= 1.0) return step_ * std::clamp(factor(), 0.5, 0.9);
    const double longer = std::min(kSafety * factor(), 2.0);
    return longer >= kLeastGrowth && alike_ > order() ? longer * step_ : step_;
  }

 private:
  double gamma() const { return 0.5 - next_w_.alpha_m + next_w_.alpha_f; }
  double beta() const { return 0.25 * (gamma() + 0.5) * (gamma() + 0.5); }
  Differences differences() const {
    const double most = distrusted_ > 0 ? step_ : HUGE_VAL;  // as if no step of the past had been longer
    const double last = std::min(last_step_, most), before = std::min(before_, most);
    return {step_, step_ + last, step_ + last + before};
  }
  /// For the step, by which the error becomes half of what is allowed.
  double factor() const { return std::cbrt(1.0 / (2.0 * error_ + 1e-4)); }

  NextW next_w_;
  const double fixed_step_;
  const Executor& executor_;
  double step_ = 0.0, last_step_ = 0.0, before_ = 0.0, error_ = 0.0;
  int alike_ = 0;                 ///< steps of one length
  int distrusted_ = 0;            ///< steps for which the past still is no guide
  Array<double> q_, v_, a_, w_;   ///< of the last time
  Array<double> first_, second_;  ///< differences of v there
};

}  // namespace

std::unique_ptr<Formula> make_formula(const IntegratorOptions& options, const Executor& executor) {
  if (options.method == Method::bdf) return std::make_unique<BdfFormula>(options, executor);
  return std::make_unique<GeneralizedAlpha>(options, executor);
}

}  // namespace mfs::dae
