// Stress at nodes where it is known, and loads on surfaces.
#include <gmock/gmock.h>

#include <mfs/error.hpp>
#include <numeric>

#include "dae/fem/nodal_stress.hpp"
#include "dae/fem/surface_load.hpp"
#include "test/dae/fem/element_fixtures.hpp"

namespace mfs::dae::testing {
namespace {

class NodalStressOf : public ::testing::TestWithParam<ElementKind> {};

TEST_P(NodalStressOf, UniaxialTensionIsExactInAnyOrientation) {
  const Mesh mesh = distorted_box(GetParam(), {1.0, 0.8, 0.6}, {2, 2, 2}, 4);
  const SolidGroup body = make_body(mesh, {});
  std::mt19937 random(3);
  const Eigen::Matrix3d r = random_rotation(random);
  const double strain = 1e-3;
  // Without lateral stress: E22 = E33 = -nu E11, and S11 = E E11.
  const Eigen::Vector3d green(strain, -0.3 * strain, -0.3 * strain);
  const Eigen::Matrix3d stretch = (2 * green.array() + 1).sqrt().matrix().asDiagonal();
  const Eigen::VectorXd q =
      map_nodes(mesh, [&](const Eigen::Vector3d& x) { return Eigen::Vector3d(r * stretch * x); });
  const NodalStress stress = nodal_stress(body, q.data());
  const double expected = 2.1e11 * strain * stretch(0, 0) * stretch(0, 0) / stretch.determinant();
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    EXPECT_NEAR(stress.von_mises[i], expected, 1e-9 * expected);
    EXPECT_NEAR(stress.cauchy[i][0], expected * r(0, 0) * r(0, 0), 1e-9 * expected);
    EXPECT_NEAR(stress.cauchy[i][4], expected * r(1, 0) * r(2, 0), 1e-9 * expected);
  }
  EXPECT_NEAR(stress.largest, expected, 1e-9 * expected);
}

// Linear strain over the height: the largest stress is at the outer fibre, not at an integration point.
TEST_P(NodalStressOf, BendingIsLargestAtTheOuterFibre) {
  const double radius = 100, height = 0.2;
  const Mesh mesh = box_mesh({1, 0.1, height}, {4, 1, 2}, GetParam());
  const SolidGroup body = make_body(mesh, {MaterialLaw::st_venant_kirchhoff, 2.1e11, 0.0, 7850});
  const Eigen::VectorXd q = map_nodes(mesh, [&](const Eigen::Vector3d& x) {
    const double z = x(2) - height / 2, angle = x(0) / radius;
    return Eigen::Vector3d((radius + z) * std::sin(angle), x(1), (radius + z) * std::cos(angle) - radius);
  });
  const NodalStress stress = nodal_stress(body, q.data());
  const double expected = 2.1e11 * height / 2 / radius;
  EXPECT_NEAR(stress.largest, expected, 0.01 * expected);
  const double z = mesh.nodes[static_cast<std::size_t>(stress.largest_node)][2];
  EXPECT_TRUE(z == 0 || z == height) << z;
}

TEST(VonMises, HasItsKnownValues) {
  EXPECT_NEAR(von_mises({5, 5, 5, 0, 0, 0}), 0, 1e-15);
  EXPECT_NEAR(von_mises({0, -7, 0, 0, 0, 0}), 7, 1e-14);
  EXPECT_NEAR(von_mises({0, 0, 0, 2, 0, 0}), 2 * std::sqrt(3.0), 1e-14);
  EXPECT_NEAR(von_mises({0, 0, 0, 0, 2, 0}), 2 * std::sqrt(3.0), 1e-14);
  EXPECT_NEAR(von_mises({0, 0, 0, 0, 0, 2}), 2 * std::sqrt(3.0), 1e-14);
}

// Shares of a face: they sum to one, and their centre is the face's. A stretched half is counted by its area.
TEST_P(NodalStressOf, SurfaceSharesCarryAnEvenPressure) {
  Mesh mesh = box_mesh({2, 1, 1}, {4, 3, 2}, GetParam());
  for (Point3& x : mesh.nodes) x[1] = x[1] * (1 + x[1]) / 2;
  if (GetParam() == ElementKind::tet10) straighten(mesh);
  const std::vector<int>& face = mesh.node_sets.at("x1");
  const std::vector<double> shares = surface_shares(mesh, face);
  Point3 center{};
  for (std::size_t i = 0; i < face.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      center[k] += shares[i] * mesh.nodes[static_cast<std::size_t>(face[i])][k];
  EXPECT_NEAR(std::accumulate(shares.begin(), shares.end(), 0.0), 1, 1e-14);
  EXPECT_THAT(center,
              ::testing::ElementsAre(::testing::DoubleNear(2, 1e-13), ::testing::DoubleNear(0.5, 1e-13),
                                     ::testing::DoubleNear(0.5, 1e-13)));
}

TEST_P(NodalStressOf, SurfaceSharesAreEqualWhereNoFaceIsSpanned) {
  const Mesh mesh = box_mesh({2, 1, 1}, {2, 1, 1}, GetParam());
  EXPECT_THAT(surface_shares(mesh, {0, 1, 2}), ::testing::Each(::testing::DoubleNear(1.0 / 3, 1e-15)));
  EXPECT_THROW(surface_shares(mesh, {}), InvalidInput);
}

// All nodes: faces between elements carry no load.
TEST_P(NodalStressOf, SurfaceSharesLeaveInnerFacesOut) {
  const Mesh mesh = box_mesh({1, 1, 1}, {2, 2, 2}, GetParam());
  std::vector<int> all(mesh.nodes.size());
  std::iota(all.begin(), all.end(), 0);
  const std::vector<double> shares = surface_shares(mesh, all);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Point3& x = mesh.nodes[i];
    const bool inside = std::all_of(x.begin(), x.end(), [](double c) { return c > 1e-9 && c < 1 - 1e-9; });
    if (inside) {
      EXPECT_EQ(shares[i], 0);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Elements, NodalStressOf, ::testing::ValuesIn(kKinds),
                         [](const auto& info) { return kind_name(info.param); });

}  // namespace
}  // namespace mfs::dae::testing
