#include "dae/statics/polished_modes.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

namespace mfs::dae {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;

constexpr int kMostSteps = 6;
/// Of s: a smaller step is the last, as the next has its square.
constexpr double kLast = 1e-7;
/// What s may change in all, in parts of it, and the cosine between a motion and what becomes of it.
constexpr double kMostChange = 0.1, kSameMotion = 0.9;
/// Of z^H Q'(s) x, in parts of what it is the sum of: less has no quotient, as that of motions that are two
/// in one.
constexpr double kLeastSlope = 1e-10;

struct Pair {
  Complex s;
  VectorXcd x, z;  // reduced
};

/// One step, nothing where there is none.
std::optional<Pair> step(const MotionMatrices& matrices, const ReducedMotion& reduced, const Pair& pair) {
  const Complex s = pair.s;
  const MatrixXcd slope = 2.0 * s * reduced.mass + reduced.damping.cast<Complex>();
  const MatrixXcd q = s * s * reduced.mass + s * reduced.damping + reduced.stiffness.cast<Complex>();
  const Eigen::PartialPivLU<MatrixXcd> lu(q);
  Pair next{s, lu.solve(slope * pair.x), lu.adjoint().solve(slope.adjoint() * pair.z)};
  if (!next.x.allFinite() || !next.z.allFinite()) return std::nullopt;
  next.x.normalize();
  next.z.normalize();
  const Complex along = next.z.dot(slope * next.x);
  const double terms = next.z.cwiseAbs().dot(slope.cwiseAbs() * next.x.cwiseAbs());
  if (!(std::abs(along) > kLeastSlope * terms)) return std::nullopt;
  const VectorXcd x = reduced.basis * next.x;
  const VectorXcd image = s * s * matrices.complex_times(Block::force_a, x) +
                          s * matrices.complex_times(Block::force_v, x) +
                          matrices.complex_times(Block::force_q, x);
  next.s -= (reduced.basis * next.z).dot(image) / along;
  return next;
}

/// Nothing where it comes to no end, or to another motion.
std::optional<Pair> polished(const MotionMatrices& matrices, const ReducedMotion& reduced,
                             const Pair& begin) {
  std::optional<Pair> pair = begin;
  for (int i = 0; i < kMostSteps; ++i) {
    const Complex before = pair->s;
    pair = step(matrices, reduced, *pair);
    if (!pair || !(std::abs(pair->s - begin.s) <= kMostChange * std::abs(begin.s))) return std::nullopt;
    if (!(std::abs(pair->x.dot(begin.x)) >= kSameMotion)) return std::nullopt;
    if (std::abs(pair->s - before) <= kLast * std::abs(pair->s)) return pair;
  }
  return std::nullopt;
}

/// y of N y = x, of size 1.
VectorXcd reduced_of(const Eigen::HouseholderQR<MatrixXd>& basis, const VectorXcd& x) {
  VectorXcd y(basis.cols());
  y.real() = basis.solve(Eigen::VectorXd(x.real()));
  y.imag() = basis.solve(Eigen::VectorXd(x.imag()));
  return y.normalized();
}

}  // namespace

void polish(const MotionMatrices& matrices, const ReducedMotion& reduced, Eigenpairs& pairs, Index count) {
  const Eigen::HouseholderQR<MatrixXd> basis(reduced.basis);
  for (Index i = 0; i < std::min(count, pairs.s.size()); ++i) {
    if (pairs.s[i].imag() < 0 || may_be_free(matrices, pairs.s[i], pairs.x.col(i))) continue;
    const VectorXcd y = reduced_of(basis, pairs.x.col(i));
    const auto pair = polished(matrices, reduced, {pairs.s[i], y, y});
    if (!pair) continue;
    // A real one stays real.
    pairs.s[i] = pairs.s[i].imag() == 0 ? Complex(pair->s.real(), 0.0) : pair->s;
    pairs.x.col(i) = reduced.basis * pair->x;
  }
}

}  // namespace mfs::dae
