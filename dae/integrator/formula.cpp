#include "dae/integrator/formula.hpp"

#include <cmath>

#include "dae/integrator/bdf.hpp"

namespace mfs::dae {
namespace {

/// BDF for y = [q, v].
class BdfFormula : public Formula {
 public:
  explicit BdfFormula(const IntegratorOptions& options) : bdf_(options.max_order, options.fixed_step > 0.0) {}

  void start(const State& state, double h) override {
    bdf_.start(joined(state.q, state.v), joined(state.v, state.a), h);
  }
  void predict(double h, StepRelation& relation) override {
    bdf_.predict(h, y_, dy_);
    const double rate = bdf_.rate();
    relation.rate_v = rate;
    relation.rate_a = rate * rate;
    const std::size_t n = y_.size() / 2;
    relation.q.assign(y_.begin(), y_.begin() + static_cast<std::ptrdiff_t>(n));
    relation.v.assign(dy_.begin(), dy_.begin() + static_cast<std::ptrdiff_t>(n));
    relation.a.resize(n);
    // a = v_p' + c (v - v_p), where v starts as q_p', not as v_p.
    for (std::size_t i = 0; i < n; ++i) relation.a[i] = dy_[n + i] + rate * (dy_[i] - y_[n + i]);
  }
  int order() const override { return bdf_.order(); }
  double local_error(const State& state, const std::vector<double>& weights) override {
    correction_ = joined(state.q, state.v);
    for (std::size_t i = 0; i < correction_.size(); ++i) correction_[i] -= y_[i];
    return bdf_.local_error(correction_, weights);
  }
  double reject(int times) override { return bdf_.reject(times); }
  double accept(const State&, const std::vector<double>& weights) override {
    return bdf_.accept(correction_, weights);
  }

 private:
  static std::vector<double> joined(std::vector<double> first, const std::vector<double>& second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
  }

  Bdf bdf_;
  std::vector<double> y_, dy_;  ///< predicted
  std::vector<double> correction_;
};

class GeneralizedAlpha : public Formula {
 public:
  explicit GeneralizedAlpha(double rho)
      : alpha_m_((2.0 * rho - 1.0) / (rho + 1.0)), alpha_f_(rho / (rho + 1.0)) {}

  void start(const State& state, double h) override {
    last_ = state;
    w_ = state.a;
    step_ = h;
  }
  void predict(double h, StepRelation& relation) override {
    step_ = h;
    const double weight = (1.0 - alpha_f_) / (1.0 - alpha_m_);  // of a in w
    const std::size_t n = w_.size();
    relation.rate_v = gamma() / (beta() * h);
    relation.rate_a = 1.0 / (beta() * weight * h * h);
    relation.q.resize(n);
    relation.v.resize(n);
    relation.a = last_.a;
    for (std::size_t i = 0; i < n; ++i) {
      const double w = next_w(i, last_.a[i]);
      relation.q[i] = last_.q[i] + h * last_.v[i] + h * h * ((0.5 - beta()) * w_[i] + beta() * w);
      relation.v[i] = last_.v[i] + h * ((1.0 - gamma()) * w_[i] + gamma() * w);
    }
  }
  int order() const override { return 2; }
  double local_error(const State&, const std::vector<double>&) override { return 0.0; }
  double reject(int) override { return 0.5 * step_; }
  double accept(const State& state, const std::vector<double>&) override {
    for (std::size_t i = 0; i < w_.size(); ++i) w_[i] = next_w(i, state.a[i]);
    last_ = state;
    return step_;
  }

 private:
  double gamma() const { return 0.5 - alpha_m_ + alpha_f_; }
  double beta() const { return 0.25 * (gamma() + 0.5) * (gamma() + 0.5); }
  /// w of coordinate i at the new time, where its acceleration is `a`.
  double next_w(std::size_t i, double a) const {
    return ((1.0 - alpha_f_) * a + alpha_f_ * last_.a[i] - alpha_m_ * w_[i]) / (1.0 - alpha_m_);
  }

  double alpha_m_, alpha_f_, step_ = 0.0;
  State last_;
  std::vector<double> w_;
};

}  // namespace

double weighted_rms(const std::vector<double>& e, const std::vector<double>& weights) {
  double sum = 0.0;
  for (std::size_t i = 0; i < e.size(); ++i) sum += (e[i] / weights[i]) * (e[i] / weights[i]);
  return e.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(e.size()));
}

std::unique_ptr<Formula> make_formula(const IntegratorOptions& options) {
  if (options.method == Method::bdf) return std::make_unique<BdfFormula>(options);
  return std::make_unique<GeneralizedAlpha>(options.rho_inf);
}

}  // namespace mfs::dae
