#include "dae/statics/instability.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <mfs/error.hpp>

#include "dae/statics/block_vectors.hpp"

namespace mfs::dae {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// s over the kappa of the stiffest part: at first, in the end, and from one to the next.
constexpr double kFirst = 1e-4, kLeast = 1e-15, kRatio = 1e-4;
/// s over the smallest kappa in the space before, where all are positive, and what s falls by at least.
constexpr double kBelow = 1e-2, kSlower = 10.0;
/// Vectors of a Krylov space at most, and of those after the first one what they grow by between two looks.
constexpr Index kMostVectors = 40, kPart = 20;
/// The slowest motion is in a space of k vectors where its kappa is this part of s / k^2: errors fall by
/// exp(-4 k sqrt(kappa / s)).
constexpr double kResolved = 4.0;
/// What is left of a vector beside the others, in parts of it, that is rounding.
constexpr double kDependent = 1e-10;
/// What constraints allow of a vector, in parts of it, beyond which it is made of the rounding of those
/// before: of equal kappas a Krylov space has one vector alone, and inertia tells nothing of what violates
/// p.p = 1.
constexpr double kViolated = 1e-6;
/// A negative x^T K x that is less than this part of its terms is rounding.
constexpr double kRounding = 1e-14;
/// K is symmetric where the rest is this part of kappa, and an eigenvector has a residual of this part.
constexpr double kSymmetric = 1e-3, kEigenvector = 1e-3;

/// K has a part that is not symmetric where it is more than this of what two motions have of it; dampers feed
/// one where it is more than this of what they take.
constexpr double kWithoutPotential = 1e-5, kFed = 1e-8;
/// Rounding of a kappa, in parts of its terms: that of many entries.
constexpr double kRoundings = 1e-12;

class UnstableMotionSearch {
 public:
  UnstableMotionSearch(const RestingSystem& rest, ConstrainedMatrix& matrix)
      : system_(rest.system),
        matrix_(matrix),
        tangent_(rest.tangent),
        force_(rest.force),
        slow_(rest.rounding),
        n_(system_.coordinates()),
        m_(system_.constraints()) {}

  Stability run(const std::function<bool()>& go_on) {
    Stability stability{find(go_on)};
    if (stability.growing || space_.cols() == 0) return stability;
    double terms = 0.0;
    for (Index j = 0; j < space_.cols(); ++j) terms = std::max(terms, terms_of(space_.col(j)));
    stability.rounding = std::max(slow_, kRoundings * terms);
    stability.may_swing = !has_potential(stability.rounding) || !is_damped();
    return stability;
  }

 private:
  std::optional<UnstableMotion> find(const std::function<bool()>& go_on) {
    const double stiffest = stiffest_kappa();
    if (!(stiffest > slow_) || !std::isfinite(stiffest)) return std::nullopt;
    const double least = std::max(kLeast * stiffest, slow_);
    for (double s = kFirst * stiffest; s > least; s = next_after(s)) {
      if (go_on && !go_on()) return std::nullopt;
      try {
        std::optional<UnstableMotion> found = look_from(s, s == kFirst * stiffest);
        if (found || is_slowest_found_) return found;
      } catch (const SingularMatrix&) {
      } catch (const AccuracyNotReached&) {
      }
    }
    return std::nullopt;
  }

  /// Of the motions in the space, each with its own kappa.
  bool has_potential(double rounding) const {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> own(0.5 * (stiffness_ + stiffness_.transpose()));
    const MatrixXd k = own.eigenvectors().transpose() * stiffness_ * own.eigenvectors();
    const VectorXd size = own.eigenvalues().cwiseAbs().cwiseSqrt();
    const MatrixXd least = (kWithoutPotential * size * size.transpose()).array() + rounding;
    return ((k - k.transpose()).array().abs() <= least.array()).all();
  }
  bool is_damped() const {
    MatrixXd d(space_.cols(), space_.cols());
    for (Index j = 0; j < d.cols(); ++j) d.col(j) = space_.transpose() * times(Block::force_v, space_.col(j));
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(0.5 * (d + d.transpose()), Eigen::EigenvaluesOnly);
    const VectorXd& taken = solver.eigenvalues();
    return taken.minCoeff() >= -kFed * taken.cwiseAbs().maxCoeff();
  }

  /// The largest |k_ij| / sqrt(m_i m_j); where what is stiff has no inertia, as the travel of a joint, that
  /// of a typical body takes its place. Of a K that is positive it is on the diagonal, but a force that
  /// depends on a measured quantity may have no entry there.
  double stiffest_kappa() const {
    VectorXd m = inertias();
    std::vector<double> positive;
    std::copy_if(m.begin(), m.end(), std::back_inserter(positive),
                 [](double inertia) { return inertia > 0; });
    if (positive.empty()) return 0.0;
    const double typical = median(std::move(positive));
    for (double& inertia : m) inertia = inertia > 0 ? inertia : typical;
    const Pattern& p = system_.tangent_pattern()[Block::force_q];
    double most = 0.0;
    for (int i = 0; i < p.rows; ++i)
      for (int k = p.row_start[i]; k < p.row_start[i + 1]; ++k)
        most = std::max(most, std::abs(tangent_[Block::force_q][k]) / std::sqrt(m[i] * m[p.column[k]]));
    return most;
  }

  /// Of coordinates. Of Euler parameters the one that is 1 has as little as the others are, perhaps 1e-90,
  /// and gets that of another.
  VectorXd inertias() const {
    VectorXd m = diagonal_sizes(system_.tangent_pattern()[Block::force_a], tangent_[Block::force_a]);
    const Pattern& pattern = system_.tangent_pattern()[Block::position_q];
    for (int row = 0; row < m_; ++row) {
      if (!system_.is_normalization(row)) continue;
      const auto begin = pattern.column.begin() + pattern.row_start[row],
                 end = pattern.column.begin() + pattern.row_start[row + 1];
      const int most = *std::max_element(begin, end, [&](int i, int j) { return m[i] < m[j]; });
      std::for_each(begin, end, [&](int i) { m[i] = std::max(m[i], m[most]); });
    }
    return m;
  }

  /// Where the space has only positive kappas, it has shown negative ones down to that size.
  double next_after(double s) const {
    return least_kappa_ > kRatio * s ? std::min(kBelow * least_kappa_, s / kSlower) : kRatio * s;
  }

  VectorXd times(Block block, const VectorXd& x, bool transposed = false) const {
    return product(system_.tangent_pattern()[block], tangent_[block], x, transposed);
  }

  /// z of the force M x.
  VectorXd response(const VectorXd& force) {
    std::vector<double> right_side(static_cast<std::size_t>(n_ + m_), 0.0);
    std::copy(force.begin(), force.end(), right_side.begin());
    const std::vector<double> solution = matrix_.solve(std::move(right_side));
    return Eigen::Map<const VectorXd>(solution.data(), n_);
  }
  VectorXd by_inertia(const VectorXd& x) const { return times(Block::force_a, x); }

  /// sqrt(x^T M x).
  static double size_of(const VectorXd& x, const VectorXd& by_inertia) {
    return std::sqrt(std::max(0.0, x.dot(by_inertia)));
  }
  double size_of(const VectorXd& x) const { return size_of(x, by_inertia(x)); }

  /// Makes a Krylov space, a part at a time, until it shows a motion that grows, or that none is slower than
  /// the slowest one in it.
  std::optional<UnstableMotion> look_from(double s, bool is_first) {
    least_kappa_ = 0.0;
    matrix_.factor(tangent_, {s, 0.0, 1.0});
    space_.resize(n_, 0);
    forces_.resize(n_, 0);
    is_complete_ = false;
    for (Index most = is_first ? kMostVectors : kPart; !is_complete_; most += kPart) {
      extend_space(std::min<Index>({most, kMostVectors, n_ - m_}));
      const Index count = space_.cols();
      is_complete_ = is_complete_ || count == kMostVectors || count == n_ - m_;
      if (count == 0) return std::nullopt;
      if (std::optional<UnstableMotion> found = motion_in_space(s)) return found;
      is_slowest_found_ = least_kappa_ * static_cast<double>(count * count) >= kResolved * s;
      if (is_slowest_found_) return std::nullopt;
    }
    return std::nullopt;
  }

  /// To so many vectors, orthonormal by M (Arnoldi's method), or to all that are not dependent.
  void extend_space(Index most) {
    Index count = space_.cols();
    space_.conservativeResize(n_, most);
    forces_.conservativeResize(n_, most);
    for (; count < most; ++count) {
      VectorXd next = response(count == 0 ? by_inertia(irregular(n_)) : VectorXd(forces_.col(count - 1)));
      VectorXd force = by_inertia(next);
      const double size = size_of(next, force);
      for (int pass = 0; pass < 2 && count > 0; ++pass) {
        const VectorXd shares = space_.leftCols(count).transpose() * force;
        next -= space_.leftCols(count) * shares;
        force -= forces_.leftCols(count) * shares;
      }
      const double left = size_of(next, force);
      is_complete_ = !(left > kDependent * size) || !std::isfinite(left) || !is_allowed(next);
      if (is_complete_) break;
      space_.col(count) = next / left;
      forces_.col(count) = force / left;
    }
    space_.conservativeResize(n_, count);
    forces_.conservativeResize(n_, count);
    stiffness_.resize(count, count);
    for (Index j = 0; j < count; ++j)
      stiffness_.col(j) = space_.transpose() * times(Block::force_q, space_.col(j));
  }

  bool is_allowed(const VectorXd& x) const {
    return times(Block::position_q, x).lpNorm<Eigen::Infinity>() <= kViolated * x.lpNorm<Eigen::Infinity>();
  }

  std::optional<UnstableMotion> motion_in_space(double s) {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> symmetric(0.5 * (stiffness_ + stiffness_.transpose()));
    least_kappa_ = symmetric.eigenvalues()[0];
    const VectorXd x = space_ * symmetric.eigenvectors().col(0);
    if (!is_negative_along(x)) return std::nullopt;
    const VectorXd rest = times(Block::force_q, x) - times(Block::force_q, x, true);
    const bool is_symmetric = (space_.transpose() * rest).norm() <= kSymmetric * std::abs(least_kappa_);
    return is_symmetric ? motion_along(x) : eigenvector_in_space(s);
  }

  /// What is real, negative and fulfils K x = kappa M x.
  std::optional<UnstableMotion> eigenvector_in_space(double s) {
    const Eigen::EigenSolver<MatrixXd> solver(stiffness_);
    if (solver.info() != Eigen::Success) return std::nullopt;
    std::optional<UnstableMotion> fastest;
    for (Index j = 0; j < stiffness_.cols(); ++j) {
      const std::complex<double> kappa = solver.eigenvalues()[j];
      if (kappa.imag() != 0 || !(kappa.real() < 0)) continue;
      VectorXd x = space_ * solver.eigenvectors().col(j).real();
      x /= size_of(x);
      const VectorXd residual = (s + kappa.real()) * response(by_inertia(x)) - x;
      if (!is_negative_along(x) || !(size_of(residual) <= kEigenvector)) continue;
      UnstableMotion found = motion_along(x);
      if (!fastest || found.rate > fastest->rate) fastest = std::move(found);
    }
    return fastest;
  }

  /// |x|^T |K| |x|.
  double terms_of(const VectorXd& x) const {
    const Pattern& p = system_.tangent_pattern()[Block::force_q];
    const std::vector<double>& values = tangent_[Block::force_q];
    double sum = 0.0;
    for (int i = 0; i < p.rows; ++i)
      for (int k = p.row_start[i]; k < p.row_start[i + 1]; ++k)
        sum += std::abs(x[i] * values[k] * x[p.column[k]]);
    return sum;
  }

  /// Beyond rounding, and beyond what forces that are left can do with directions that change, and
  /// constraints with what violates them.
  bool is_negative_along(const VectorXd& x) const {
    const VectorXd stiff = times(Block::force_q, x);
    double left = stiff.norm() * times(Block::position_q, x).norm();
    for (Index i = 0; i < n_; ++i) left += std::abs(force_[i]) * x[i] * x[i];
    const double inertia = x.dot(by_inertia(x));
    return x.dot(stiff) < -(kRounding * terms_of(x) + slow_ * inertia + left);
  }

  UnstableMotion motion_along(const VectorXd& x) const {
    const double size = size_of(x), kappa = x.dot(times(Block::force_q, x)) / (size * size);
    const VectorXd unit = x / size;
    return {std::vector<double>(unit.begin(), unit.end()), std::sqrt(-kappa)};
  }

  const ConstrainedSystem& system_;
  ConstrainedMatrix& matrix_;
  const Tangent& tangent_;
  const std::vector<double>& force_;
  const double slow_;
  const Index n_, m_;
  MatrixXd space_, forces_, stiffness_;  // a basis, M times it, and K in it
  bool is_complete_ = false, is_slowest_found_ = false;
  double least_kappa_ = 0.0;  // in the space
};

}  // namespace

Stability examine_rest(const RestingSystem& rest, ConstrainedMatrix& matrix,
                       const std::function<bool()>& go_on) {
  for (int row = 0; row < rest.system.constraints(); ++row)
    if (rest.system.is_nonholonomic(row)) return {};
  if (rest.system.coordinates() == rest.system.constraints()) return {};
  return UnstableMotionSearch(rest, matrix).run(go_on);
}

}  // namespace mfs::dae
