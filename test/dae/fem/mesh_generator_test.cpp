// Meshes of the generators: every element has its right side out, holes are round, refinement does what it
// says.
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <map>
#include <mfs/error.hpp>

#include "test/dae/fem/element_fixtures.hpp"

namespace mfs::dae::testing {
namespace {

struct Hole {
  const char* set;
  double x, y, radius;
};

struct Generator {
  const char* name;
  std::function<Mesh(int, ElementKind)> mesh;
  std::vector<Hole> holes;
  double thickness;
};

std::vector<Generator> generators() {
  return {{"bell_crank",
           [](int refine, ElementKind kind) { return bell_crank_mesh(refine, kind); },
           {{"center_hole", 0, 0, 0.03}, {"arm1_hole", 0.24, 0, 0.018}, {"arm2_hole", 0, 0.18, 0.018}},
           0.03},
          {"connecting_rod",
           [](int refine, ElementKind kind) { return connecting_rod_mesh(refine, kind); },
           {{"big_hole", 0, 0, 0.024}, {"small_hole", 0.2, 0, 0.013}},
           0.022},
          {"control_arm",
           [](int refine, ElementKind kind) { return control_arm_mesh(refine, kind); },
           {{"front_hole", 0, 0.2, 0.024},
            {"rear_hole", 0, -0.2, 0.024},
            {"shock_hole", 0.25, 0, 0.02},
            {"ball_hole", 0.38, 0, 0.018}},
           0.03}};
}

class Generated : public ::testing::TestWithParam<std::tuple<std::size_t, ElementKind>> {
 protected:
  Generator generator() const { return generators()[std::get<0>(GetParam())]; }
  ElementKind kind() const { return std::get<1>(GetParam()); }
};

// The constructor of a body refuses Jacobians that are not positive at integration points; here also at
// nodes.
TEST_P(Generated, ElementsAreSound) {
  for (const int refine : {1, 2, 3}) {
    const SolidGroup body = make_body(generator().mesh(refine, kind()), {});
    double nodes[60], smallest = 1, largest = 0;
    for (int e = 0; e < body.size(); ++e) {
      body.gather_nodes(e, nodes);
      for (const Point3& at : reference_nodes(kind())) {
        const double det = determinant(jacobian(kind(), at, nodes));
        smallest = std::min(smallest, det);
        largest = std::max(largest, det);
      }
    }
    EXPECT_GT(smallest, 0.02 * largest) << "refine " << refine;
  }
}

TEST_P(Generated, HolesAreRoundAndGoThrough) {
  const Generator g = generator();
  const Mesh mesh = g.mesh(2, kind());
  ASSERT_EQ(mesh.node_sets.size(), g.holes.size());
  for (const Hole& hole : g.holes) {
    const std::vector<int>& set = mesh.node_sets.at(hole.set);
    double lowest = 1, highest = -1;
    std::size_t near = 0;
    for (const int node : set) {
      const Point3& x = mesh.nodes[static_cast<std::size_t>(node)];
      EXPECT_NEAR(std::hypot(x[0] - hole.x, x[1] - hole.y), hole.radius, 1e-12);
      lowest = std::min(lowest, x[2]);
      highest = std::max(highest, x[2]);
    }
    for (const Point3& x : mesh.nodes)
      near += std::hypot(x[0] - hole.x, x[1] - hole.y) < 1.0001 * hole.radius ? 1 : 0;
    EXPECT_EQ(set.size(), near);
    EXPECT_NEAR(lowest, 0, 1e-15);
    EXPECT_NEAR(highest, g.thickness, 1e-12);
  }
}

// No node is there twice, none is left over: the surface closes, so its volume by the divergence theorem is
// that of the elements. Curved elements have the same volume in the limit, and faster than straight ones.
TEST_P(Generated, VolumesConverge) {
  const auto volume = [&](int refine) {
    return make_body(generator().mesh(refine, kind()), {}).mass() / 7850;
  };
  const double coarse = volume(1), middle = volume(2), fine = volume(4);
  const double rate = std::log2(std::abs(middle - coarse) / std::abs(fine - middle));
  EXPECT_GT(rate, kind() == ElementKind::hex8 ? 1.8 : 3.5);
  EXPECT_NEAR(middle, fine, 0.01 * fine);
}

TEST_P(Generated, EachNodeIsThereOnce) {
  const Mesh mesh = generator().mesh(2, kind());
  std::map<std::array<long, 3>, int> at;
  for (const Point3& x : mesh.nodes)
    ++at[{std::lround(x[0] * 1e7), std::lround(x[1] * 1e7), std::lround(x[2] * 1e7)}];
  EXPECT_EQ(at.size(), mesh.nodes.size());
  std::vector<int> used(mesh.nodes.size());
  for (const int node : mesh.elements) ++used[static_cast<std::size_t>(node)];
  EXPECT_THAT(used, ::testing::Each(::testing::Gt(0)));
}

INSTANTIATE_TEST_SUITE_P(All, Generated,
                         ::testing::Combine(::testing::Values(0u, 1u, 2u), ::testing::ValuesIn(kKinds)),
                         [](const auto& info) {
                           return std::string(generators()[std::get<0>(info.param)].name) + "_" +
                                  kind_name(std::get<1>(info.param));
                         });

// The paper's unknowns: positions, velocities, accelerations.
TEST(Generators, ReachFromTwoThousandToAMillionUnknowns) {
  const auto unknowns = [](int refine) {
    return 9 * bell_crank_mesh(refine, ElementKind::hex8).nodes.size();
  };
  EXPECT_LT(unknowns(1), 2500u);
  EXPECT_GT(unknowns(11), 1000000u);
}

TEST(Generators, RefuseWhatLeavesNoMesh) {
  EXPECT_THROW(bell_crank_mesh(0, ElementKind::hex8), InvalidInput);
  EXPECT_THROW(box_mesh({1, 1, 1}, {1, 0, 1}, ElementKind::hex8), InvalidInput);
  EXPECT_THROW(box_mesh({1, -1, 1}, {1, 1, 1}, ElementKind::hex8), InvalidInput);
  BellCrankShape acute, thin, hollow, close;
  acute.angle = 0.5;
  EXPECT_THROW(bell_crank_mesh(1, ElementKind::hex8, acute), InvalidInput);
  thin.thickness = 0;
  EXPECT_THROW(bell_crank_mesh(1, ElementKind::hex8, thin), InvalidInput);
  hollow.end_hole = 0.04;
  EXPECT_THROW(bell_crank_mesh(1, ElementKind::hex8, hollow), InvalidInput);
  close.arm2 = 0.09;
  EXPECT_THROW(bell_crank_mesh(1, ElementKind::hex8, close), InvalidInput);
}

TEST(Generators, BoxHasItsFaces) {
  const Mesh mesh = box_mesh({2, 3, 4}, {2, 1, 3}, ElementKind::hex20);
  EXPECT_EQ(mesh.element_count(), 6);
  EXPECT_EQ(mesh.node_sets.at("x1").size(), 18u);  // 8 corners and 10 middles of edges of 1 x 3 faces
  for (const int node : mesh.node_sets.at("z1")) EXPECT_EQ(mesh.nodes[static_cast<std::size_t>(node)][2], 4);
  EXPECT_NEAR(make_body(mesh, {MaterialLaw::neo_hookean, 1, 0, 2}).mass(), 48, 1e-12);
}

}  // namespace
}  // namespace mfs::dae::testing
