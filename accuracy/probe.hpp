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
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "accuracy/null_vectors.hpp"

namespace mfs {

struct NullDirection {
  bool regular = false;
  bool null = false;     // proved
  double smallness = 1;  // |A d| / | |A||d| |, the least that was seen of a large d
  Vertex unknown = -1;   // the largest scaled entry of the last d
};

/// Entries of size 1/2 to 1 with random signs in scaled rows; the same in every run.
template <class Scalar>
void probing_vector(Vertex n, const double* scale, Scalar* b) {
  std::uint64_t state = 0x9E3779B97F4A7C15u;
  for (Vertex i = 0; i < n; ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;  // Knuth, MMIX
    const double size = 0.5 + 0.5 * static_cast<double>(state >> 40) * 0x1p-24;
    const double sign = (state >> 33) % 2 == 0 ? 1 : -1;
    b[i] = Scalar(static_cast<RealOf<Scalar>>(sign * size / scale[i]));
  }
}

/// The residual of a probing vector that proves A regular: |l^T b| is about |l|_2, so some scaled entry of
/// b - A x is at least |l|_2 / |l|_1 >= 1 / sqrt(n).
inline double small_residual(Vertex n) {
  return 1e-3 / std::sqrt(static_cast<double>(n));
}

/// One use. `inverse(x)` puts about A^-1 x in the place of x; `residual(b, x, low, r)` r = b - A (x + low),
/// `add(d, x, low)` x + low += d, both in twice the precision.
template <class Exec, class Scalar, class Inverse, class Residual, class Add>
class Probe {
 public:
  Probe(const Exec& exec, const ScaledRows<Scalar>& a, Vertex n, const Inverse& inverse,
        const Residual& residual, const Add& add)
      : exec_(exec), a_(a), inverse_(inverse), residual_(residual), add_(add) {
    for (std::vector<Scalar>* vector : {&b_, &x_, &low_, &d_, &r_})
      vector->assign(static_cast<std::size_t>(n), Scalar(0));
  }

  NullDirection run() {
    constexpr int kSteps = 30;
    constexpr double kStall = 0.9;
    const Vertex n = static_cast<Vertex>(b_.size());
    probing_vector(n, a_.row_scale, b_.data());
    r_ = b_;
    double last = std::numeric_limits<double>::infinity();
    for (int step = 0; step < kSteps; ++step) {
      d_ = r_;
      inverse_(d_.data());
      add_(d_.data(), x_.data(), low_.data());
      residual_(b_.data(), x_.data(), low_.data(), r_.data());
      found_.regular = largest_of(r_) <= small_residual(n);
      const double length = scale_correction();
      if (!std::isfinite(length)) break;
      measure(length);
      if (found_.null || found_.regular || !(length < kStall * last)) break;
      last = length;
    }
    found_.null = found_.null || (!found_.regular && found_.smallness <= singular_below<Scalar>());
    found_.regular = found_.regular && !found_.null;
    return found_;
  }

 private:
  static constexpr double kEpsilon = std::numeric_limits<RealOf<Scalar>>::epsilon();
  static constexpr double kRounding = 2 * kEpsilon;  // double: 4e-16

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

  // What is not longer than the root of 1 / epsilon has not grown along a null vector.
  void measure(double length) {
    if (!(length * std::sqrt(kEpsilon) > 1)) return;
    std::vector<Scalar> product(d_.size());
    const double smallness = null_measure(exec_, a_, singular_below<Scalar>(), d_, product);
    if (smallness < found_.smallness) found_.smallness = smallness;
    found_.null = smallness <= kRounding;
  }

  Exec exec_;
  ScaledRows<Scalar> a_;
  const Inverse& inverse_;
  const Residual& residual_;
  const Add& add_;
  std::vector<Scalar> b_, x_, low_, d_, r_;
  NullDirection found_;
};

template <class Exec, class Scalar, class Inverse, class Residual, class Add>
NullDirection null_direction(const Exec& exec, const ScaledRows<Scalar>& a, Vertex n, const Inverse& inverse,
                             const Residual& residual, const Add& add) {
  return Probe<Exec, Scalar, Inverse, Residual, Add>(exec, a, n, inverse, residual, add).run();
}

}  // namespace mfs
