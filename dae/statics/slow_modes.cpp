#include "dae/statics/slow_modes.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace mfs::dae {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

/// A mode slower than that part of c is looked for again.
constexpr double kSlow = 0.1;
/// What rounding may leave of s, in parts of it: more, and it may be nothing else.
constexpr double kFree = 0.1;
/// Of the columns of X, in parts of the first: less is rounding.
constexpr double kNoColumn = 1e-6;
constexpr int kMostLooks = 12;

/// An orthonormal real basis of the space of the first `count` motions.
MatrixXd space_of(const Eigenpairs& pairs, Index count) {
  MatrixXd columns(pairs.x.rows(), 2 * count);
  for (Index i = 0; i < count; ++i) {
    const VectorXcd x = pairs.x.col(i).normalized();
    columns.col(2 * i) = x.real();
    columns.col(2 * i + 1) = x.imag();
  }
  Eigen::ColPivHouseholderQR<MatrixXd> qr(columns);
  qr.setThreshold(kNoColumn);
  return MatrixXd(qr.householderQ() * MatrixXd::Identity(columns.rows(), qr.rank()));
}

/// 1/s, of the fastest motion in the space; 0 where all of them may be free.
double rate_of_fastest(const MotionMatrices& matrices, const MatrixXd& basis) {
  const Index f = basis.cols();
  const auto reduced = [&](Block block) {
    MatrixXd image(basis.rows(), f);
    for (Index i = 0; i < f; ++i) image.col(i) = matrices.times(block, basis.col(i));
    return MatrixXd(basis.transpose() * image);
  };
  const Eigen::FullPivLU<MatrixXd> mass(reduced(Block::force_a));
  if (!mass.isInvertible()) return 0.0;
  MatrixXd next = MatrixXd::Zero(2 * f, 2 * f);
  next.topRightCorner(f, f).setIdentity();
  next.bottomLeftCorner(f, f) = -mass.solve(reduced(Block::force_q));
  next.bottomRightCorner(f, f) = -mass.solve(reduced(Block::force_v));
  const Eigen::EigenSolver<MatrixXd> solver(next);
  double fastest = 0.0;
  for (Index i = 0; i < 2 * f; ++i) {
    const Complex s = solver.eigenvalues()[i];
    if (!may_be_free(matrices, s, basis * solver.eigenvectors().col(i).head(f)))
      fastest = std::max(fastest, std::abs(s));
  }
  return fastest;
}

}  // namespace

double rounding_of(const MotionMatrices& matrices, Complex s, const VectorXcd& x) {
  const VectorXd size = x.cwiseAbs();
  const double inertia = std::abs(x.dot(matrices.complex_times(Block::force_a, x)));
  const double terms =
      size.dot(matrices.terms(Block::force_q, x)) + std::abs(s) * size.dot(matrices.terms(Block::force_v, x));
  const double forces = 2 * std::norm(s) * inertia;
  return forces > 0 ? std::numeric_limits<double>::epsilon() * terms / forces : HUGE_VAL;
}

bool may_be_free(const MotionMatrices& matrices, Complex s, const VectorXcd& x) {
  return !(rounding_of(matrices, s, x) < kFree);
}

void sort_by_size(Eigenpairs& pairs) {
  std::vector<Index> order(static_cast<std::size_t>(pairs.s.size()));
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](Index i, Index j) { return std::abs(pairs.s[i]) < std::abs(pairs.s[j]); });
  const Eigenpairs before = pairs;
  for (std::size_t k = 0; k < order.size(); ++k) {
    pairs.s[static_cast<Index>(k)] = before.s[order[k]];
    pairs.x.col(static_cast<Index>(k)) = before.x.col(order[k]);
  }
}

Eigenpairs with_slow_ones(const MotionMatrices& matrices, Eigenpairs pairs, double c, const AboutRate& find) {
  sort_by_size(pairs);
  for (int look = 0; look < kMostLooks; ++look) {
    const Index slow = (pairs.s.cwiseAbs().array() < kSlow * c).count();
    if (slow == 0) break;
    const MatrixXd space = space_of(pairs, slow);
    const double rate = std::min(rate_of_fastest(matrices, space), kSlow * c);
    if (!(rate > 0)) break;
    Eigenpairs found = find(rate, space);
    if (found.s.size() < slow) break;
    sort_by_size(found);
    pairs.s.head(slow) = found.s.head(slow);
    pairs.x.leftCols(slow) = found.x.leftCols(slow);
    c = rate;
  }
  return pairs;
}

}  // namespace mfs::dae
