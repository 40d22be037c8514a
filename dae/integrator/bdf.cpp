#include "dae/integrator/bdf.hpp"

#include <algorithm>
#include <cmath>

#include "dae/integrator/formula.hpp"
#include "dae/integrator/vector_loops.hpp"

namespace mfs::dae {
namespace {

/// By which steps may grow again and again at any order, with nothing that sees their error.
constexpr double kSafeGrowth = 1.1;

/// Factor for the step by which an error of `error` at `order` becomes half of what is allowed.
double step_factor(double error, int order) {
  return std::pow(2.0 * error + 1e-4, -1.0 / (order + 1));
}

}  // namespace

void Bdf::start(const std::vector<double>& y, const std::vector<double>& dy, double h) {
  phi_.assign(static_cast<std::size_t>(max_order_) + 2, std::vector<double>(y.size(), 0.0));
  phi_[0] = y;
  phi_[1] = dy;  // y', until restart_with multiplies it by the first step
  order_ = 1;
  rising_ = true;
  steps_ = last_order_ = unchanged_ = 0;
  step_ = last_step_ = 0.0;
  psi_ = {};
  restart_with(h);
}

// Nothing but y and y' is known: the first difference is that of the step about to be tried.
void Bdf::restart_with(double h) {
  const double factor = step_ > 0.0 ? h / step_ : h;
  parallel_for(phi_[1].size(), threads_, [&](std::size_t i) { phi_[1][i] *= factor; });
  step_ = psi_[0] = h;
}

void Bdf::set_coefficients(double h) {
  const auto k = static_cast<std::size_t>(order_);
  // Steps that are evened out to meet a time differ by rounding.
  const bool same = std::abs(h - last_step_) <= 1e-9 * h && order_ == last_order_;
  next_unchanged_ = std::min((same ? unchanged_ : 0) + 1, last_order_ + 2);
  next_psi_ = psi_;
  alpha_[0] = beta_[0] = sigma_[0] = 1.0;
  gamma_[0] = 0.0;
  double span = h;  // from the new value to the i-th before it
  for (std::size_t i = 1; i <= k; ++i) {
    const double old = psi_[i - 1];
    next_psi_[i - 1] = span;
    beta_[i] = beta_[i - 1] * span / old;
    gamma_[i] = gamma_[i - 1] + alpha_[i - 1] / h;
    span = old + h;
    alpha_[i] = h / span;
    sigma_[i] = static_cast<double>(i) * sigma_[i - 1] * alpha_[i];
  }
  next_psi_[k] = span;

  double leading = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < k; ++i) {
    leading -= 1.0 / (static_cast<double>(i) + 1.0);
    sum -= alpha_[i];
  }
  rate_ = -leading / h;
  error_factor_ = std::max(std::abs(alpha_[k] + leading - sum), alpha_[k]);
}

void Bdf::predict(double h, std::vector<double>& y, std::vector<double>& dy) {
  if (steps_ == 0 && h != step_) restart_with(h);
  step_ = h;
  set_coefficients(h);
  const auto k = static_cast<std::size_t>(order_);
  y.resize(phi_[0].size());
  dy.resize(y.size());
  parallel_for_parts(y.size(), threads_, [&](std::size_t begin, std::size_t end) {
    double *const value = y.data(), *const rate = dy.data();
    std::copy(phi_[0].begin() + begin, phi_[0].begin() + end, value + begin);
    std::fill(rate + begin, rate + end, 0.0);
    for (std::size_t j = 1; j <= k; ++j) {
      const double* const phi = phi_[j].data();
      const double beta = beta_[j], gamma = gamma_[j];
      for (std::size_t i = begin; i < end; ++i) {
        const double difference = beta * phi[i];
        value[i] += difference;
        rate[i] += gamma * difference;
      }
    }
  });
}

// Of e and what it would be at one and two orders less.
Bdf::Sizes Bdf::sizes(const std::vector<double>& e, const std::vector<double>& weights) const {
  const auto k = static_cast<std::size_t>(order_);
  const double *const last = phi_[k].data(), *const before = phi_[k - 1].data();
  const double beta_last = beta_[k], beta_before = beta_[k - 1];
  return weighted_rms_of<3>(
      [&](std::size_t i) {
        const double below = e[i] + beta_last * last[i];
        return Sizes{e[i], below, below + beta_before * before[i]};
      },
      weights, threads_);
}

double Bdf::local_error(const std::vector<double>& e, const std::vector<double>& weights) {
  const auto k = static_cast<std::size_t>(order_);
  const bool lower_known = order_ > 1 && !fixed_;
  const Sizes size = lower_known
                         ? sizes(e, weights)
                         : Sizes{weighted_rms([&](std::size_t i) { return e[i]; }, weights, threads_)};
  error_here_ = sigma_[k] * size[0];
  suited_order_ = order_;
  suited_error_ = error_here_;
  if (lower_known) {
    error_below_ = sigma_[k - 1] * size[1];
    const double here = (order_ + 1) * error_here_, below = order_ * error_below_;
    bool lower = below <= 0.5 * here;
    if (order_ > 2) {
      const double two_below = (order_ - 1) * sigma_[k - 2] * size[2];
      lower = std::max(below, two_below) <= here;
    }
    if (lower) {
      suited_order_ = order_ - 1;
      suited_error_ = error_below_;
    }
  }
  return error_factor_ * size[0];
}

double Bdf::reject(int times) {
  rising_ = false;
  if (times >= 3) {
    order_ = 1;
    return 0.25 * step_;
  }
  order_ = suited_order_;
  return step_ * (times == 1 ? std::clamp(0.9 * step_factor(suited_error_, order_), 0.25, 0.9) : 0.25);
}

// The differences of the new time from those of the old one and the correction.
void Bdf::shift(const std::vector<double>& e) {
  const auto k = static_cast<std::size_t>(order_);
  parallel_for_parts(e.size(), threads_, [&](std::size_t begin, std::size_t end) {
    if (order_ < max_order_) std::copy(e.begin() + begin, e.begin() + end, phi_[k + 1].begin() + begin);
    const double* sum = e.data();
    for (std::size_t j = k + 1; j-- > 0;) {
      double* const phi = phi_[j].data();
      const double beta = beta_[j];
      for (std::size_t i = begin; i < end; ++i) phi[i] = sum[i] + beta * phi[i];
      sum = phi;
    }
  });
}

double Bdf::accept(const std::vector<double>& e, const std::vector<double>& weights) {
  ++steps_;
  if (!fixed_ && (suited_order_ < order_ || order_ == max_order_)) rising_ = false;
  Choice next{order_, step_};
  if (!fixed_ && !rising_)
    next = choose(e, weights);
  else if (steps_ > 1)
    next = {std::min(order_ + 1, max_order_), (fixed_ ? kSafeGrowth : 2.0) * step_};
  shift(e);
  psi_ = next_psi_;
  unchanged_ = next_unchanged_;
  last_order_ = order_;
  last_step_ = step_;
  order_ = next.order;
  return next.step;
}

Bdf::Choice Bdf::choose(const std::vector<double>& e, const std::vector<double>& weights) {
  int order = suited_order_;
  double error = suited_error_;
  // The order above is judged only after order + 1 equal steps, and not just after a raise.
  if (order == order_ && order_ < max_order_ && order_ + 1 < next_unchanged_ && order_ - last_order_ != 1) {
    const auto& above = phi_[static_cast<std::size_t>(order_) + 1];
    const double error_above =
        weighted_rms([&](std::size_t i) { return e[i] - above[i]; }, weights, threads_) / (order_ + 2);
    const double rated_here = (order_ + 1) * error_here_, rated_above = (order_ + 2) * error_above;
    if (order_ > 1 && order_ * error_below_ <= std::min(rated_here, rated_above)) {
      order = order_ - 1;
      error = error_below_;
    } else if (rated_above < (order_ > 1 ? 1.0 : 0.5) * rated_here) {
      order = order_ + 1;
      error = error_above;
    }
  }
  const double factor = step_factor(error, order);
  if (factor >= 2.0) return {order, 2.0 * step_};
  return {order, factor <= 1.0 ? step_ * std::clamp(factor, 0.5, 0.9) : step_};
}

}  // namespace mfs::dae
