// Which rows of a matrix follow from those before them, against singular values (Eigen's Jacobi SVD).
#include "dae/integrator/dependencies.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>

namespace mfs::dae::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::ElementsAre;

Pattern dense_pattern(Eigen::Index rows, Eigen::Index columns) {
  Pattern pattern{static_cast<int>(rows), static_cast<int>(columns), {0}, {}};
  for (Eigen::Index i = 0; i < rows; ++i) {
    for (Eigen::Index j = 0; j < columns; ++j) pattern.column.push_back(static_cast<int>(j));
    pattern.row_start.push_back(static_cast<int>(pattern.column.size()));
  }
  return pattern;
}

Dependencies find(const MatrixXd& rows, const std::vector<char>& normalizes, const VectorXd& scale,
                  const std::vector<char>& nonholonomic = {}) {
  std::vector<double> values;
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    for (Eigen::Index j = 0; j < rows.cols(); ++j) values.push_back(rows(i, j));
  return {dense_pattern(rows.rows(), rows.cols()),
          values,
          {scale.data(), scale.data() + scale.size()},
          normalizes,
          nonholonomic};
}

/// All combinations, a row each.
MatrixXd combinations(const Dependencies& found, Eigen::Index rows) {
  MatrixXd all = MatrixXd::Zero(static_cast<Eigen::Index>(found.redundant().size()), rows);
  for (Eigen::Index k = 0; k < all.rows(); ++k)
    for (const auto& [row, share] : found.combination(static_cast<std::size_t>(k))) all(k, row) = share;
  return all;
}

Eigen::Index rank(const MatrixXd& matrix) {
  if (matrix.rows() == 0) return 0;
  const VectorXd sizes = matrix.jacobiSvd().singularValues();
  return (sizes.array() > 1e-10 * sizes[0]).count();
}

class RandomMatrix {
 public:
  explicit RandomMatrix(unsigned seed) : engine_(seed) {}
  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(engine_); }
  MatrixXd make(Eigen::Index rows, Eigen::Index columns) {
    std::uniform_real_distribution<double> entry(-1.0, 1.0);
    return MatrixXd::NullaryExpr(rows, columns, [&] { return entry(engine_); });
  }

 private:
  std::mt19937 engine_;
};

TEST(Dependencies, AreTheLastRowsThatFollow) {
  MatrixXd rows(5, 4);
  rows << 1, 0, 0, 0,  //
      0, 2, 0, 0,      //
      1, 2, 0, 0,      // follows
      0, 0, 0, 3,      //
      5, 0, 0, 3;      // follows
  const Dependencies found = find(rows, std::vector<char>(5, 0), VectorXd::Ones(4));
  EXPECT_THAT(found.redundant(), ElementsAre(2, 4));
  MatrixXd expected(2, 5);
  expected << -1, -1, 1, 0, 0,  //
      -5, 0, 0, -1, 1;
  EXPECT_LT((combinations(found, 5) - expected).norm(), 1e-14);
}

TEST(Dependencies, RankAndNamesAreThoseOfSingularValues) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RandomMatrix random(seed);
    const Eigen::Index n = 3 + random.below(12), m = 1 + random.below(20);
    const Eigen::Index r = 1 + random.below(static_cast<int>(std::min(n, m)));
    MatrixXd rows = random.make(m, r) * random.make(r, n);
    for (Eigen::Index i = 0; i < m; ++i) rows.row(i) *= std::pow(10.0, random.below(7) - 3);  // units
    if (random.below(2) == 0) rows.row(random.below(static_cast<int>(m))).setZero();
    VectorXd scale = VectorXd::Ones(n);
    scale[0] = 1e-3;
    const Dependencies found = find(rows, std::vector<char>(static_cast<std::size_t>(m), 0), scale);
    const MatrixXd in_scale = rows * scale.asDiagonal();
    MatrixXd alike = in_scale;
    for (Eigen::Index i = 0; i < m; ++i) alike.row(i) /= std::max(alike.row(i).cwiseAbs().maxCoeff(), 1e-300);
    const auto count = static_cast<Eigen::Index>(found.redundant().size());
    ASSERT_EQ(count, m - rank(alike));
    const MatrixXd all = combinations(found, m);
    for (Eigen::Index k = 0; k < count; ++k) {
      const double size = (all.row(k).cwiseAbs() * in_scale.cwiseAbs()).maxCoeff();
      EXPECT_LE((all.row(k) * in_scale).cwiseAbs().maxCoeff(), 1e-9 * size);
      EXPECT_EQ(all(k, found.redundant()[static_cast<std::size_t>(k)]), 1.0);
    }
    // What is left without the redundant rows has the whole rank.
    std::vector<Eigen::Index> kept;
    for (Eigen::Index i = 0; i < m; ++i)
      if (std::find(found.redundant().begin(), found.redundant().end(), i) == found.redundant().end())
        kept.push_back(i);
    MatrixXd basis(static_cast<Eigen::Index>(kept.size()), n);
    for (std::size_t i = 0; i < kept.size(); ++i)
      basis.row(static_cast<Eigen::Index>(i)) = alike.row(kept[i]);
    EXPECT_EQ(rank(basis), m - count);
  }
}

// The rows of joints may contain a normalization: it is they that are redundant, wherever it stands.
TEST(Dependencies, NormalizationsAreNeverRedundant) {
  MatrixXd rows(4, 4);
  rows << 1, 0, 0, 0,  //
      0, 1, 2, 0,      //
      0, 2, 4, 0,      // the same, and this one normalizes
      1, 1, 2, 0;      // follows, whichever is taken
  const Dependencies found = find(rows, {0, 0, 1, 0}, VectorXd::Ones(4));
  EXPECT_THAT(found.redundant(), ElementsAre(1, 3));
  EXPECT_LT((combinations(found, 4) * rows).norm(), 1e-14);
}

TEST(Dependencies, MultipliersOfLeastSquares) {
  RandomMatrix random(7);
  MatrixXd rows = random.make(7, 4) * random.make(4, 9);
  const Dependencies found = find(rows, std::vector<char>(7, 0), VectorXd::Ones(9));
  ASSERT_EQ(found.redundant().size(), 3U);
  const VectorXd given = random.make(7, 1);
  std::vector<double> least(given.data(), given.data() + 7), basic = least;
  found.make_least(least, std::vector<double>(7, 1.0));
  const VectorXd forces = rows.transpose() * given;
  const VectorXd expected =
      MatrixXd(rows.transpose()).completeOrthogonalDecomposition().solve(forces);  // of least norm
  EXPECT_LT((Eigen::Map<const VectorXd>(least.data(), 7) - expected).norm(), 1e-12);
  found.make_basic(basic);
  EXPECT_LT((rows.transpose() * Eigen::Map<const VectorXd>(basic.data(), 7) - forces).norm(), 1e-12);
  for (const int row : found.redundant()) EXPECT_EQ(basic[static_cast<std::size_t>(row)], 0.0);
}

TEST(Dependencies, LeastSquaresAreThoseOfOtherUnits) {
  MatrixXd rows(2, 1);
  rows << 1, 1;
  const Dependencies found = find(rows, {0, 0}, VectorXd::Ones(1));
  ASSERT_EQ(found.redundant().size(), 1U);
  std::vector<double> lambda{5.0, 0.0};
  found.make_least(lambda, {1.0, 2.0});
  EXPECT_NEAR(lambda[0], 4.0, 1e-13);  // x^2 + 4 (5 - x)^2 is least
  EXPECT_NEAR(lambda[1], 1.0, 1e-13);
}

// A normalization's multiplier costs nothing.
TEST(Dependencies, LeastSquaresLeaveNormalizationsOut) {
  MatrixXd rows(3, 2);
  rows << 1, 0,  // normalizes
      3, 1,      //
      0, 2;
  const Dependencies found = find(rows, {1, 0, 0}, VectorXd::Ones(2));
  ASSERT_EQ(found.redundant().size(), 1U);
  std::vector<double> lambda{0.0, 5.0, 0.0};
  found.make_least(lambda, {0, 1, 1});
  EXPECT_NEAR(lambda[0], 12.0, 1e-13);  // 15 - 3
  EXPECT_NEAR(lambda[1], 1.0, 1e-13);   // of the shares (1, 2) of 5 in the second coordinate
  EXPECT_NEAR(lambda[2], 2.0, 1e-13);
}

// What follows is left out: of constraints on velocities nothing drifts then, of others positions would.
TEST(Dependencies, OnVelocitiesAreRedundantBeforeOthers) {
  MatrixXd rows(3, 3);
  rows << 1, 1, 0,  // on velocities
      1, 0, 0, 0, 1, 0;
  const VectorXd scale = VectorXd::Ones(3);
  EXPECT_THAT(find(rows, {0, 0, 0}, scale).redundant(), ElementsAre(2));
  EXPECT_THAT(find(rows, {0, 0, 0}, scale, {1, 0, 0}).redundant(), ElementsAre(0));
}

}  // namespace
}  // namespace mfs::dae::test
