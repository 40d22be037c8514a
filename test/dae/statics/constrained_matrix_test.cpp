// The augmented system against a dense solution of the one that it stands for.
#include "dae/statics/constrained_matrix.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "test/dae/mechanics/dense.hpp"
#include "test/dae/statics/models.hpp"

namespace mfs::dae {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// What is added to A times what the constraints ask for belongs to the multipliers.
TEST(ConstrainedMatrix, GivesMultipliersAlsoWhereConstraintsAskForAChange) {
  const MultibodyModel model = make_model(test::pendulum(-0.4), "", 1);
  const ConstrainedSystem& system = *model.system;
  const int n = system.coordinates(), m = system.constraints();
  std::vector<double> lambda(static_cast<std::size_t>(m));
  for (int j = 0; j < m; ++j) lambda[j] = std::cos(1.0 + j);
  const std::vector<double> rest(static_cast<std::size_t>(n), 0.0);
  Tangent tangent = make_tangent(system);
  system.evaluate({0.0, model.q0.data(), rest.data(), rest.data(), lambda.data()}, tangent, BlockSet::all());

  const ByAVQ factors{3.0, 0.5, 2.0};
  const auto block = [&](Block b) { return test::dense(system.tangent_pattern()[b], tangent[b]); };
  MatrixXd whole = MatrixXd::Zero(n + m, n + m);
  whole.topLeftCorner(n, n) = factors[0] * block(Block::force_a) + factors[1] * block(Block::force_v) +
                              factors[2] * block(Block::force_q);
  whole.bottomLeftCorner(m, n) = block(Block::position_q);
  whole.topRightCorner(n, m) = block(Block::position_q).transpose();

  ConstrainedMatrix matrix(system, 1);
  matrix.factor(tangent, factors);
  std::vector<double> right_side(static_cast<std::size_t>(n + m));
  for (int i = 0; i < n + m; ++i) right_side[i] = std::sin(1.0 + 3.0 * i);
  const VectorXd expected = whole.fullPivLu().solve(Eigen::Map<const VectorXd>(right_side.data(), n + m));
  const std::vector<double> found = matrix.solve(right_side);
  for (int i = 0; i < n + m; ++i) EXPECT_NEAR(found[i], expected[i], 1e-10 * expected.norm()) << i;
}

}  // namespace
}  // namespace mfs::dae
