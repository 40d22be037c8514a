#include "dae/integrator/formula.hpp"

#include <cstddef>
#include <utility>

#include "dae/integrator/bdf.hpp"
#include "dae/vectors/loops.hpp"

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
      : bdf_(options.max_order, options.fixed_step > 0.0, executor), executor_(executor) {}

  void start(const StepState& state, double h) override {
    const std::size_t n = state.q.size();
    Array<double> y, dy;
    y.resize(executor_, 2 * n);
    dy.resize(executor_, 2 * n);
    for_each(executor_, n, Join{state.q.data(), state.v.data(), state.a.data(), y.data(), dy.data(), n});
    bdf_.start(std::move(y), std::move(dy), h);
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
  double local_error(const StepState& state, const Array<double>& weights) override {
    const std::size_t n = state.q.size();
    correction_.resize(executor_, 2 * n);
    for_each(executor_, n, Correction{state.q.data(), state.v.data(), y_.data(), correction_.data(), n});
    return bdf_.local_error(correction_, weights);
  }
  double reject(int times) override { return bdf_.reject(times); }
  double accept(const StepState&, const Array<double>& weights) override {
    return bdf_.accept(correction_, weights);
  }

 private:
  Bdf bdf_;
  const Executor& executor_;
  Array<double> y_, dy_;  ///< predicted
  Array<double> correction_;
};

/// What generalized-alpha makes of one coordinate: w at the new time from a there and from a and w before.
struct NextW {
  double alpha_m, alpha_f;
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
    const double next = next_w(last_a[i], last_a[i], w[i]);
    q[i] = last_q[i] + h * last_v[i] + h * h * ((0.5 - beta) * w[i] + beta * next);
    v[i] = last_v[i] + h * ((1.0 - gamma) * w[i] + gamma * next);
    a[i] = last_a[i];
  }
};

/// Goes on to q, v and a.
struct GoOn {
  const double *q, *v, *a;
  double *last_q, *last_v, *last_a, *w;
  NextW next_w;
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    w[i] = next_w(a[i], last_a[i], w[i]);
    last_q[i] = q[i];
    last_v[i] = v[i];
    last_a[i] = a[i];
  }
};

/// The same with w = a, to begin with.
struct Begin {
  const double *q, *v, *a;
  double *last_q, *last_v, *last_a, *w;
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    last_q[i] = q[i];
    last_v[i] = v[i];
    w[i] = last_a[i] = a[i];
  }
};

class GeneralizedAlpha : public Formula {
 public:
  GeneralizedAlpha(double rho, const Executor& executor)
      : next_w_{(2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)}, executor_(executor) {}

  void start(const StepState& state, double h) override {
    for (auto* part : {&q_, &v_, &a_, &w_}) part->resize(executor_, state.q.size());
    for_each(
        executor_, w_.size(),
        Begin{state.q.data(), state.v.data(), state.a.data(), q_.data(), v_.data(), a_.data(), w_.data()});
    step_ = h;
  }
  void predict(double h, StepRelation& relation) override {
    step_ = h;
    const double weight = (1.0 - next_w_.alpha_f) / (1.0 - next_w_.alpha_m);  // of a in w
    relation.v_by_a = gamma() * weight * h;
    relation.q_by_v = beta() * h / gamma();
    for (auto* part : {&relation.q, &relation.v, &relation.a}) part->resize(executor_, w_.size());
    for_each(executor_, w_.size(),
             Newmark{q_.data(), v_.data(), a_.data(), w_.data(), relation.q.data(), relation.v.data(),
                     relation.a.data(), next_w_, h, beta(), gamma()});
  }
  int order() const override { return 2; }
  double local_error(const StepState&, const Array<double>&) override { return 0.0; }
  double reject(int) override { return 0.5 * step_; }
  double accept(const StepState& state, const Array<double>&) override {
    for_each(executor_, w_.size(),
             GoOn{state.q.data(), state.v.data(), state.a.data(), q_.data(), v_.data(), a_.data(), w_.data(),
                  next_w_});
    return step_;
  }

 private:
  double gamma() const { return 0.5 - next_w_.alpha_m + next_w_.alpha_f; }
  double beta() const { return 0.25 * (gamma() + 0.5) * (gamma() + 0.5); }

  NextW next_w_;
  const Executor& executor_;
  double step_ = 0.0;
  Array<double> q_, v_, a_, w_;  ///< of the last time
};

}  // namespace

std::unique_ptr<Formula> make_formula(const IntegratorOptions& options, const Executor& executor) {
  if (options.method == Method::bdf) return std::make_unique<BdfFormula>(options, executor);
  return std::make_unique<GeneralizedAlpha>(options.rho_inf, executor);
}

}  // namespace mfs::dae
