#include "dae/integrator/formula.hpp"

#include "dae/integrator/bdf.hpp"
#include "dae/integrator/vector_loops.hpp"

namespace mfs::dae {
namespace {

/// BDF for y = [q, v].
class BdfFormula : public Formula {
 public:
  explicit BdfFormula(const IntegratorOptions& options)
      : bdf_(options.max_order, options.fixed_step > 0.0, options.threads), threads_(options.threads) {}

  void start(const State& state, double h) override {
    bdf_.start(joined(state.q, state.v), joined(state.v, state.a), h);
  }
  void predict(double h, StepRelation& relation) override {
    bdf_.predict(h, y_, dy_);
    const double rate = bdf_.rate();
    relation.v_by_a = relation.q_by_v = 1.0 / rate;
    const std::size_t n = y_.size() / 2;
    for (auto* part : {&relation.q, &relation.v, &relation.a}) part->resize(n);
    parallel_for(n, threads_, [&](std::size_t i) {
      relation.q[i] = y_[i];
      relation.v[i] = dy_[i];
      // v_p' + c (v - v_p), where v starts as q_p', not as v_p.
      relation.a[i] = dy_[n + i] + rate * (dy_[i] - y_[n + i]);
    });
  }
  int order() const override { return bdf_.order(); }
  double local_error(const State& state, const std::vector<double>& weights) override {
    const std::size_t n = state.q.size();
    correction_.resize(2 * n);
    parallel_for(2 * n, threads_,
                 [&](std::size_t i) { correction_[i] = (i < n ? state.q[i] : state.v[i - n]) - y_[i]; });
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
  int threads_;
  std::vector<double> y_, dy_;  ///< predicted
  std::vector<double> correction_;
};

class GeneralizedAlpha : public Formula {
 public:
  GeneralizedAlpha(double rho, int threads)
      : alpha_m_((2.0 * rho - 1.0) / (rho + 1.0)), alpha_f_(rho / (rho + 1.0)), threads_(threads) {}

  void start(const State& state, double h) override {
    last_ = state;
    w_ = state.a;
    step_ = h;
  }
  void predict(double h, StepRelation& relation) override {
    step_ = h;
    const double weight = (1.0 - alpha_f_) / (1.0 - alpha_m_);  // of a in w
    const std::size_t n = w_.size();
    relation.v_by_a = gamma() * weight * h;
    relation.q_by_v = beta() * h / gamma();
    relation.q.resize(n);
    relation.v.resize(n);
    relation.a.resize(n);
    parallel_for(n, threads_, [&](std::size_t i) {
      const double w = next_w(i, last_.a[i]);
      relation.q[i] = last_.q[i] + h * last_.v[i] + h * h * ((0.5 - beta()) * w_[i] + beta() * w);
      relation.v[i] = last_.v[i] + h * ((1.0 - gamma()) * w_[i] + gamma() * w);
      relation.a[i] = last_.a[i];
    });
  }
  int order() const override { return 2; }
  double local_error(const State&, const std::vector<double>&) override { return 0.0; }
  double reject(int) override { return 0.5 * step_; }
  double accept(const State& state, const std::vector<double>&) override {
    parallel_for(w_.size(), threads_, [&](std::size_t i) { w_[i] = next_w(i, state.a[i]); });
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
  int threads_;
  State last_;
  std::vector<double> w_;
};

}  // namespace

std::unique_ptr<Formula> make_formula(const IntegratorOptions& options) {
  if (options.method == Method::bdf) return std::make_unique<BdfFormula>(options);
  return std::make_unique<GeneralizedAlpha>(options.rho_inf, options.threads);
}

}  // namespace mfs::dae
