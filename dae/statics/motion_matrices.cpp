#include "dae/statics/motion_matrices.hpp"

#include <algorithm>
#include <cmath>

#include "dae/statics/block_vectors.hpp"

namespace mfs::dae {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

/// Of B, 1/s: less is at rest.
constexpr double kAtRest = 1e-9;
/// Of the largest stiffness.
constexpr double kRounding = 1e-14;

}  // namespace

MotionMatrices::MotionMatrices(const ConstrainedSystem& system, const State& state, Damping damping)
    : pattern_(system.tangent_pattern()), tangent_(make_tangent(system)) {
  system.evaluate(StateView{state.t, state.q.data(), state.v.data(), state.a.data(), state.lambda.data()},
                  tangent_,
                  {Block::force_a, Block::force_v, Block::force_q, Block::position_q, Block::velocity_q});
  if (damping == Damping::left_out)
    std::fill(tangent_[Block::force_v].begin(), tangent_[Block::force_v].end(), 0.0);
  for (int j = 0; j < system.constraints(); ++j) (system.is_nonholonomic(j) ? rolling_ : held_).push_back(j);
}

int MotionMatrices::first_moving() const {
  const Pattern& p = pattern_[Block::velocity_q];
  for (const int j : rolling_)
    for (int k = p.row_start[j]; k < p.row_start[j + 1]; ++k)
      if (std::abs(tangent_[Block::velocity_q][k]) > kAtRest) return j;
  return -1;
}

VectorXd MotionMatrices::times(Block block, const VectorXd& x) const {
  return product(pattern_[block], tangent_[block], x);
}

VectorXcd MotionMatrices::complex_times(Block block, const VectorXcd& x) const {
  VectorXcd image(pattern_[block].rows);
  image.real() = times(block, x.real());
  image.imag() = times(block, x.imag());
  return image;
}

VectorXd MotionMatrices::terms(Block block, const VectorXcd& x) const {
  const Pattern& p = pattern_[block];
  VectorXd sums = VectorXd::Zero(p.rows);
  for (int i = 0; i < p.rows; ++i)
    for (int k = p.row_start[i]; k < p.row_start[i + 1]; ++k)
      sums[i] += std::abs(tangent_[block][k]) * std::abs(x[p.column[k]]);
  return sums;
}

MatrixXd MotionMatrices::dense(Block block) const {
  const Pattern& p = pattern_[block];
  MatrixXd matrix = MatrixXd::Zero(p.rows, p.columns);
  for (int i = 0; i < p.rows; ++i)
    for (int k = p.row_start[i]; k < p.row_start[i + 1]; ++k) matrix(i, p.column[k]) = tangent_[block][k];
  return matrix;
}

double MotionMatrices::typical_frequency() const {
  const VectorXd m = diagonal(Block::force_a), k = diagonal(Block::force_q);
  const double least = m.size() > 0 ? kRounding * k.maxCoeff() : 0.0;
  std::vector<double> all;
  for (Index i = 0; i < m.size(); ++i)
    if (m[i] > 0 && k[i] > least) all.push_back(std::sqrt(k[i] / m[i]));
  if (all.empty()) {
    const double stiffest = k.maxCoeff(), heaviest = m.maxCoeff();
    return stiffest > 0 && heaviest > 0 ? std::sqrt(stiffest / heaviest) : 1.0;
  }
  return median(std::move(all));
}

VectorXd MotionMatrices::diagonal(Block block) const {
  return diagonal_sizes(pattern_[block], tangent_[block]);
}

MatrixXd MotionMatrices::dense(Block block, const std::vector<int>& rows) const {
  const MatrixXd whole = dense(block);
  MatrixXd part(static_cast<Index>(rows.size()), whole.cols());
  for (std::size_t i = 0; i < rows.size(); ++i) part.row(static_cast<Index>(i)) = whole.row(rows[i]);
  return part;
}

}  // namespace mfs::dae
