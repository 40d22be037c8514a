// Whether A is singular, by one solution for a right-hand side that is as good as random: where tiny pivots
// were divided by, or more of them perturbed than the exact correction (accuracy/correction.hpp) takes.
//
// If l^T A = 0, then l^T (b - A x) = l^T b for every x: no x makes the residual small beside b, unless b
// happens to be orthogonal to l. So a residual that is small beside b itself proves A regular. The factors
// are those of A + E, and steps of refinement d := (A+E)^-1 (b - A x), x := x + d leave the part of d alone
// that is a null vector of A, as (A+E)^-1 E z = z for it, and make all else smaller. So d is measured as a
// null vector: |A d| <= 45 epsilon | |A||d| |, in balanced rows as well, proves A singular to working
// precision, unless the residual becomes small all the same; with 2 epsilon, which is the rounding of A's own
// entries, that would be chance. Neither proof rests on what the factors are. x and the residual have twice
// the precision (accuracy/refinement.hpp): in plain precision a residual could not become small beside b for
// condition numbers from 1e12 on.
//
// Where E is large beside what A makes of a few vectors, as in a regular A whose condition is near 1 /
// epsilon, steps make the residual larger along these, though A is regular. So steps that do not get shorter
// go on as those of GCR (Eisenstat, Elman and Schultz 1983): each leaves the least residual that it and the
// steps before it can.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <optional>
#include <vector>

#include "accuracy/null_vectors.hpp"
#include "kernels/stages/doubled_rows.hpp"
#include "kernels/stages/probe_step.hpp"

namespace mfs {

struct NullDirection {
  bool regular = false;
  bool null = false;     // proved
  double smallness = 1;  // |A d| / | |A||d| | of the d that proves it
  Vertex unknown = -1;   // the largest scaled entry of the last d
};

/// The residual of a probing vector that proves A regular: |l^T b| is about |l|_2, so some scaled entry of
/// b - A x is at least |l|_2 / |l|_1 >= 1 / sqrt(n).
inline double small_residual(Vertex n) {
  return 1e-3 / std::sqrt(static_cast<double>(n));
}

/// Steps of a probe, at most, and by what each must become shorter.
constexpr int kProbeSteps = 30;
constexpr double kProbeStall = 0.9;
/// A correction of this smallness is never taken for that of a regular matrix: the rounding of A's own
/// entries.
template <class Scalar>
constexpr double kRoundingOfEntries = 2 * std::numeric_limits<RealOf<Scalar>>::epsilon();
/// What is not longer than the root of 1 / epsilon has not grown along a null vector.
template <class Scalar>
bool may_be_null(double length) {
  return length * std::sqrt(std::numeric_limits<RealOf<Scalar>>::epsilon()) > 1;
}

/// Steps together go on for so many that do not make the residual less.
constexpr int kStepsWithoutGain = 5;

/// Whether a probe where the factors lie proves A regular. Anything else is left to one on the host, which
/// also measures in balanced rows.
template <class Value>
class ResidentProbe {
 public:
  ResidentProbe(ResidentFactors<Value>& factors, Vertex n) : factors_(factors), enough_(small_residual(n)) {}

  bool proves_regular() {
    step_alone();
    if (state_ == State::open) step_together();
    return state_ == State::regular;
  }

 private:
  enum class State { open, regular, left_to_host };

  void step_alone() {
    double last = std::numeric_limits<double>::infinity();
    for (int step = 0; step < kProbeSteps; ++step) {
      const ProbeStep found = factors_.probe(step == 0);
      judge(found, may_be_null<Value>(found.length));
      if (state_ != State::open || !(found.length < kProbeStall * last)) return;
      last = found.length;
    }
  }
  // From nothing, as steps that got longer have lost digits.
  void step_together() {
    double least = std::numeric_limits<double>::infinity();
    int in_vain = 0;
    for (int step = 0; in_vain < kStepsWithoutGain && state_ == State::open; ++step) {
      const std::optional<ProbeStep> found = factors_.probe_together(step == 0);
      if (!found || !std::isfinite(found->left)) return;
      judge(*found, true);
      in_vain = found->left < kProbeStall * least ? 0 : in_vain + 1;
      least = std::min(least, found->left);
    }
  }
  void judge(const ProbeStep& found, bool large) {
    if (large && !(found.product > kRoundingOfEntries<Value> * found.size)) {
      state_ = State::left_to_host;
    } else if (found.left <= enough_) {
      state_ = State::regular;
    }
  }

  ResidentFactors<Value>& factors_;
  double enough_;
  State state_ = State::open;
};

/// One use. `inverse(x)` puts about A^-1 x in the place of x.
template <class Exec, class Scalar, class Inverse>
class Probe {
 public:
  Probe(const Exec& exec, const ScaledRows<Scalar>& a, Vertex n, const Inverse& inverse)
      : exec_(exec), a_(a), inverse_(inverse) {
    for (std::vector<Scalar>* vector : {&b_, &x_, &low_, &d_, &r_, &product_, &nothing_})
      vector->assign(static_cast<std::size_t>(n), Scalar(0));
  }

  NullDirection run() {
    step_alone();
    if (!found_.regular && !found_.null) step_together();
    if (!found_.regular && !found_.null) prove_null(smallest_, singular_below<Scalar>());
    return found_;
  }

 private:
  // Steps that know nothing of each other, as long as they get shorter.
  void step_alone() {
    for (std::size_t i = 0; i < b_.size(); ++i)
      take_probing_entry(static_cast<Offset>(i), a_.row_scale, b_[i]);
    r_ = b_;
    double last = std::numeric_limits<double>::infinity();
    for (int step = 0; step < kProbeSteps; ++step) {
      d_ = r_;
      inverse_(d_.data());
      take_correction();
      const double length = scale_correction();
      if (!std::isfinite(length)) return;
      if (may_be_null<Scalar>(length)) measure();
      if (found_.null || found_.regular || !(length < kProbeStall * last)) return;
      last = length;
    }
  }

  // As long as the residual becomes less: that of a singular A ends at its part along the left null vector.
  // From nothing, as steps that got longer have lost digits.
  void step_together() {
    std::fill(x_.begin(), x_.end(), Scalar(0));
    std::fill(low_.begin(), low_.end(), Scalar(0));
    r_ = b_;
    double least = length_of_residual();
    int in_vain = 0;
    for (int step = 0; step < most_steps() && in_vain < kStepsWithoutGain && std::isfinite(least); ++step) {
      if (!find_direction()) return;
      d_ = directions_.back().d;
      scale_correction();
      measure();
      if (found_.null) return;
      take_direction();
      if (found_.regular) return;
      const double length = length_of_residual();
      in_vain = length < kProbeStall * least ? 0 : in_vain + 1;
      least = std::min(least, length);
    }
  }
  // A^-1 r without what A makes the same of as of the directions before. Twice the precision keeps d and A d
  // together, as d is as long as the condition of A.
  bool find_direction() {
    Direction next{r_, nothing_, nothing_, 0};
    inverse_(next.d.data());
    multiply(next);
    for (const Direction& before : directions_) {
      const Scalar part = along(before, next.product);
      add_vector(exec_, size(), -part, before.product.data(), next.product.data());
      add_doubled_multiple(exec_, size(), -part, before.d.data(), before.low.data(), next.d.data(),
                           next.low.data());
    }
    next.square = std::abs(dot_product(exec_, size(), next.product.data(), next.product.data()));
    if (!(next.square > 0) || !std::isfinite(next.square)) return false;
    directions_.push_back(std::move(next));
    return true;
  }
  // As far as leaves the least residual.
  void take_direction() {
    const Direction& last = directions_.back();
    for (std::size_t i = 0; i < product_.size(); ++i) product_[i] = r_[i] * row_factor(i);
    add_doubled_multiple(exec_, size(), along(last, product_), last.d.data(), last.low.data(), x_.data(),
                         low_.data());
    find_residual();
  }
  struct Direction {
    std::vector<Scalar> d, low, product;  // A (d + low) in scaled rows
    double square;                        // of the product's length
  };
  void multiply(Direction& of) {
    subtract_product(nothing_, of.d, of.low, of.product);
    for (std::size_t i = 0; i < of.product.size(); ++i) of.product[i] *= -row_factor(i);
  }
  Scalar along(const Direction& direction, const std::vector<Scalar>& vector) const {
    return dot_product(exec_, size(), direction.product.data(), vector.data()) /
           static_cast<RealOf<Scalar>>(direction.square);
  }
  int most_steps() const {
    constexpr std::size_t kMost = 60, kBytes = std::size_t(1) << 29;
    return static_cast<int>(std::min(kMost, kBytes / (3 * sizeof(Scalar) * b_.size())));
  }

  // x + low += d
  void take_correction() {
    add_doubled(exec_, size(), d_.data(), x_.data(), low_.data());
    find_residual();
  }
  void find_residual() {
    subtract_product(b_, x_, low_, r_);
    found_.regular = largest_of(r_) <= small_residual(size());
  }
  // r := b - A (x + low)
  void subtract_product(const std::vector<Scalar>& b, const std::vector<Scalar>& x,
                        const std::vector<Scalar>& low, std::vector<Scalar>& r) {
    doubled_residual(exec_, size(), a_.rows, b.data(), x.data(), low.data(), r.data());
  }
  Vertex size() const { return static_cast<Vertex>(b_.size()); }
  RealOf<Scalar> row_factor(std::size_t i) const { return static_cast<RealOf<Scalar>>(a_.row_scale[i]); }
  double length_of_residual() const {
    double sum = 0;
    for (std::size_t i = 0; i < r_.size(); ++i)
      sum += std::norm(std::complex<double>(r_[i]) * a_.row_scale[i]);
    return std::sqrt(sum);
  }
  double largest_of(const std::vector<Scalar>& r) const {
    double most = 0;
    for (std::size_t i = 0; i < r.size(); ++i) {
      const double size = std::abs(r[i]) * a_.row_scale[i];
      if (!(size <= most)) most = size;  // NaN stays
    }
    return most;
  }

  // d between scaled unknowns; its largest entry.
  double scale_correction() {
    double most = 0;
    for (std::size_t u = 0; u < d_.size(); ++u) {
      d_[u] /= static_cast<RealOf<Scalar>>(a_.scale[u]);
      const double size = std::abs(d_[u]);
      if (!(size <= most)) {
        most = size;
        found_.unknown = static_cast<Vertex>(u);
      }
    }
    return most;
  }

  // Balanced rows take as long as some solves to make, and are asked for where the scaled ones say null.
  void measure() {
    const double smallness = scaled_residual(exec_, a_, {}, d_, product_);
    if (smallness <= kRoundingOfEntries<Scalar>) prove_null(d_, kRoundingOfEntries<Scalar>);
    if (!(smallness < least_)) return;
    least_ = smallness;
    smallest_ = d_;
  }
  void prove_null(const std::vector<Scalar>& d, double bound) {
    if (d.empty()) return;
    const double smallness = null_measure(exec_, a_, bound, d, product_);
    found_.null = smallness <= bound;
    if (!found_.null) return;
    found_.regular = false;
    found_.smallness = smallness;
  }

  Exec exec_;
  ScaledRows<Scalar> a_;
  const Inverse& inverse_;
  std::vector<Scalar> b_, x_, low_, d_, r_, product_, nothing_;
  std::vector<Direction> directions_;  // of GCR
  std::vector<Scalar> smallest_;       // large d with the least |A d| / | |A||d| |
  double least_ = 1;
  NullDirection found_;
};

template <class Exec, class Scalar, class Inverse>
NullDirection null_direction(const Exec& exec, const ScaledRows<Scalar>& a, Vertex n,
                             const Inverse& inverse) {
  return Probe<Exec, Scalar, Inverse>(exec, a, n, inverse).run();
}

}  // namespace mfs
