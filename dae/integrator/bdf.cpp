#include "dae/integrator/bdf.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dae/vectors/loops.hpp"
#include "dae/vectors/operations.hpp"

namespace mfs::dae {
namespace {

/// By which steps may grow again and again at any order, with nothing that sees their error.
constexpr double kSafeGrowth = 1.1;

/// A local error, in units of what is allowed, with which steps would become longer at any order.
constexpr double kFarFromLimit = 1e-3;
/// What the error of order 1 comes to before the order rises for the first time (with 1e-2 of what is allowed
/// a block that falls was off by 3e-6 m at the default tolerances, instead of 6e-8), and by how much at most
/// a step may become longer until then.
constexpr double kErrorOfStart = 1e-4, kGrowthOfStart = 100.0;

/// Factor for the step by which an error of `error` at `order` becomes half of what is allowed.
double step_factor(double error, int order) {
  return std::pow(2.0 * error + 1e-4, -1.0 / (order + 1));
}

/// Of all differences, and what each is multiplied by.
constexpr int kMost = Bdf::kMostOrder + 2;

/// y = phi_0 + sum beta_j phi_j, y' = sum gamma_j beta_j phi_j.
struct Predict {
  double *value, *rate;
  const double* phi[kMost];
  double beta[kMost], gamma[kMost];
  int order;
  MFS_HOST_DEVICE void operator()(std::size_t begin, std::size_t end) const {
    for (std::size_t i = begin; i < end; ++i) value[i] = phi[0][i];
    for (std::size_t i = begin; i < end; ++i) rate[i] = 0.0;
    for (int j = 1; j <= order; ++j)
      for (std::size_t i = begin; i < end; ++i) {
        const double difference = beta[j] * phi[j][i];
        value[i] += difference;
        rate[i] += gamma[j] * difference;
      }
  }
};

/// The differences of the new time from those of the old one and the correction.
struct Shift {
  const double* e;
  double* above;  ///< phi of order + 1; null: not kept
  double* phi[kMost];
  double beta[kMost];
  int order;
  MFS_HOST_DEVICE void operator()(std::size_t begin, std::size_t end) const {
    if (above != nullptr)
      for (std::size_t i = begin; i < end; ++i) above[i] = e[i];
    const double* sum = e;
    for (int j = order; j >= 0; --j) {
      for (std::size_t i = begin; i < end; ++i) phi[j][i] = sum[i] + beta[j] * phi[j][i];
      sum = phi[j];
    }
  }
};

/// e, what it would be at one and two orders less, and the sum of the first and the last.
struct FourErrors {
  const double *e, *last, *before;
  double beta_last, beta_before;
  MFS_HOST_DEVICE Numbers<4> operator()(std::size_t i) const {
    const double below = e[i] + beta_last * last[i], two_below = below + beta_before * before[i];
    return {{e[i], below, two_below, e[i] + two_below}};
  }
};

struct OneError {
  const double* e;
  MFS_HOST_DEVICE Numbers<1> operator()(std::size_t i) const { return {{e[i]}}; }
};

struct ErrorAbove {
  const double *e, *above;
  MFS_HOST_DEVICE Numbers<1> operator()(std::size_t i) const { return {{e[i] - above[i]}}; }
};

struct Subtract {
  const double *e, *above;
  double* difference;
  MFS_HOST_DEVICE void operator()(std::size_t i) const { difference[i] = e[i] - above[i]; }
};

}  // namespace

void Bdf::start(Array<double> y, Array<double> dy, double h, double longest) {
  const std::size_t n = y.size();
  phi_[0] = std::move(y);
  phi_[1] = std::move(dy);  // y', until restart_with multiplies it by the first step
  for (int j = 2; j <= max_order_ + 1; ++j) {
    phi_[j].resize(executor_, n);
    fill(executor_, n, 0.0, phi_[j].data());
  }
  order_ = 1;
  rising_ = true;
  rejected_ = false;
  steps_ = last_order_ = unchanged_ = steps_at_one_ = 0;
  step_ = last_step_ = 0.0;
  longest_at_start_ = longest;
  psi_ = {};
  restart_with(h);
}

// Nothing but y and y' is known: the first difference is that of the step about to be tried.
void Bdf::restart_with(double h) {
  scale(executor_, phi_[1].size(), step_ > 0.0 ? h / step_ : h, phi_[1].data());
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
  if (distrusted_ == 0) return;
  error_factor_ = std::max(error_factor_, 1.0 / (order_ + 1));
  for (std::size_t i = 1; i <= k; ++i) sigma_[i] = std::max(sigma_[i], 1.0 / static_cast<double>(i + 1));
}

void Bdf::predict(double h, Array<double>& y, Array<double>& dy) {
  if (steps_ == 0 && h != step_) restart_with(h);
  step_ = h;
  set_coefficients(h);
  y.resize(executor_, phi_[0].size());
  dy.resize(executor_, y.size());
  Predict predict{y.data(), dy.data(), {}, {}, {}, order_};
  for (int j = 0; j <= order_; ++j) {
    predict.phi[j] = phi_[j].data();
    predict.beta[j] = beta_[j];
    predict.gamma[j] = gamma_[j];
  }
  for_parts(executor_, y.size(), predict);
}

Bdf::Sizes Bdf::sizes(const Array<double>& e, const Array<double>& weights) const {
  if (order_ == 1 || fixed_) return {weighted_rms<1>(executor_, OneError{e.data()}, weights).of[0]};
  const FourErrors errors{e.data(), phi_[order_].data(), phi_[order_ - 1].data(), beta_[order_],
                          beta_[order_ - 1]};
  const Numbers<4> sizes = weighted_rms<4>(executor_, errors, weights);
  return {sizes.of[0], sizes.of[1], sizes.of[2], sizes.of[3]};
}

double Bdf::local_error(const Array<double>& e, const Array<double>& weights) {
  const auto k = static_cast<std::size_t>(order_);
  filtered_ = above_filtered_ = false;
  sizes_ = sizes(e, weights);
  const Sizes& size = sizes_;
  error_here_ = sigma_[k] * size[0];
  suited_order_ = order_;
  suited_error_ = error_here_;
  const bool held = hold_.holds() && order_ == kStableOrder;  // its differences are now large, now small
  if (order_ > 1 && !fixed_ && !held) {
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

double Bdf::filtered_error(const Array<double>& e, const Array<double>& weights) {
  filtered_ = true;
  const double size = weighted_rms<1>(executor_, OneError{e.data()}, weights).of[0];
  suited_order_ = order_;
  suited_error_ = error_here_ = sigma_[static_cast<std::size_t>(order_)] * size;
  return error_factor_ * size;
}

void Bdf::correction_above(const Array<double>& e, Array<double>& above) const {
  above.resize(executor_, e.size());
  for_each(executor_, e.size(), Subtract{e.data(), phi_[order_ + 1].data(), above.data()});
}

void Bdf::filtered_error_above(const Array<double>& above, const Array<double>& weights) {
  above_filtered_ = true;
  filtered_above_ = weighted_rms<1>(executor_, OneError{above.data()}, weights).of[0] / (order_ + 2);
}

double Bdf::reject(int times) {
  rising_ = false;
  rejected_ = true;
  order_ = suited_order_;
  return step_ * (times == 1 ? std::clamp(0.9 * step_factor(suited_error_, order_), 0.25, 0.9) : 0.25);
}

void Bdf::shift(const Array<double>& e) {
  Shift shift{e.data(), order_ < max_order_ ? phi_[order_ + 1].data() : nullptr, {}, {}, order_};
  for (int j = 0; j <= order_; ++j) {
    shift.phi[j] = phi_[j].data();
    shift.beta[j] = beta_[j];
  }
  for_parts(executor_, e.size(), shift);
}

double Bdf::accept(const Array<double>& e, const Array<double>& weights) {
  ++steps_;
  distrusted_ = std::max(0, distrusted_ - 1);
  steps_at_one_ = order_ == 1 ? steps_at_one_ + 1 : 0;
  if (!fixed_ && (suited_order_ < order_ || order_ == most_order())) rising_ = false;
  Choice next{order_, step_};
  if (leave_unstable_orders())
    next.order = kStableOrder;
  else if (!fixed_ && !rising_)
    next = choose(e, weights);
  else if (const double growth = growth_of_start(); growth > 1.0)
    next.step = growth * step_;
  else if (steps_ > 1)
    next = {std::min(order_ + 1, most_order()), (fixed_ ? kSafeGrowth : 2.0) * step_};
  shift(e);
  psi_ = next_psi_;
  unchanged_ = next_unchanged_;
  last_order_ = order_;
  last_step_ = step_;
  order_ = next.order;
  return next.step;
}

double Bdf::growth_of_start() const {
  const double error = error_factor_ * sizes_[0];
  if (fixed_ || !rising_ || order_ > 1 || step_ <= last_step_ || error > kErrorOfStart / 4.0) return 1.0;
  return std::min({std::sqrt(kErrorOfStart / error), kGrowthOfStart, longest_at_start_ / step_});
}

bool Bdf::leave_unstable_orders() {
  hold_.add(step_);
  // Where the step is not limited by its error, differences are rounding, which is an oscillation as well.
  if (fixed_ || filtered_ || hold_.ignores_alarms() || order_ <= kStableOrder ||
      error_factor_ * sizes_[0] < kFarFromLimit) {
    watch_.forget();
    return false;
  }
  watch_.add(sizes_[0], sizes_[1], sizes_[2], sizes_[3]);
  // Nor is it where it may not be longer anyway: what grows there will make it shorter first.
  const bool bounded = max_step_ > 0.0 && step_ >= (1.0 - 1e-9) * max_step_;
  if (bounded || !watch_.unstable()) return false;
  watch_.forget();
  hold_.begin(step_, order_ == kMostOrder);
  return true;
}

double Bdf::error_of_order_above(const Array<double>& e, const Array<double>& weights) const {
  if (above_filtered_) return filtered_above_;
  const ErrorAbove above{e.data(), phi_[order_ + 1].data()};
  return weighted_rms<1>(executor_, above, weights).of[0] / (order_ + 2);
}

Bdf::Choice Bdf::choose(const Array<double>& e, const Array<double>& weights) {
  int order = suited_order_;
  double error = suited_error_;
  // The order above is judged only after order + 1 equal steps, and not just after a raise.
  const bool long_at_one = steps_at_one_ > kLongAtOne;
  if ((!filtered_ || above_filtered_) && order == order_ && order_ < most_order() &&
      (order_ + 1 < next_unchanged_ || long_at_one) && order_ - last_order_ != 1) {
    const double error_above = error_of_order_above(e, weights);
    const double rated_here = (order_ + 1) * error_here_, rated_above = (order_ + 2) * error_above;
    if (order_ > 1 && order_ * error_below_ <= std::min(rated_here, rated_above)) {
      order = order_ - 1;
      error = error_below_;
    } else if (rated_above < (order_ > 1 || long_at_one ? 1.0 : 0.5) * rated_here) {
      order = order_ + 1;
      error = error_above;
    }
  }
  const double factor = step_factor(error, order);
  const bool settled = next_unchanged_ > order_ + 1;
  if (settled) rejected_ = false;
  if (factor >= 2.0 && !rejected_) return {order, 2.0 * step_};
  if (kSafety * factor >= kLeastGrowth && settled) return {order, std::min(kSafety * factor, 2.0) * step_};
  return {order, factor <= 1.0 ? step_ * std::clamp(factor, 0.5, 0.9) : step_};
}

}  // namespace mfs::dae
