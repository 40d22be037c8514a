// Rigid bodies against the plain laws of Newton and Euler, and energy against the mass matrix.
#include "dae/mechanics/rigid_body.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "test/dae/mechanics/two_bodies.hpp"

namespace mfs::dae {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using test::Random;

/// The 3 x 4 matrix with w' = 2 G p', from the product of quaternions: (0, w') = 2 conj(p) p'.
Eigen::Matrix<double, 3, 4> g_matrix(const Vector4d& p) {
  Eigen::Matrix<double, 3, 4> g;
  for (int k = 0; k < 4; ++k) {
    const Vector4d unit = Vector4d::Unit(k);
    g.col(k) = (Eigen::Quaterniond(p[0], p[1], p[2], p[3]).conjugate() *
                Eigen::Quaterniond(unit[0], unit[1], unit[2], unit[3]))
                   .vec();
  }
  return g;
}

struct Single {
  RigidBody body;
  Vector3d gravity{0.3, -9.81, 2.0};
  MultibodyBuilder builder;
  std::unique_ptr<ConstrainedSystem> system;

  explicit Single(std::uint64_t seed) {
    Random random(seed);
    body = test::random_body(random, "top");
    add_rigid_body(builder, body, gravity);
    system = builder.build(1);
  }
  Vector4d p() const { return Eigen::Map<const Vector4d>(builder.initial_q().data() + 3); }
  Vector4d rate() const { return Eigen::Map<const Vector4d>(builder.initial_v().data() + 3); }
};

TEST(RigidBody, MovesByTheLawsOfNewtonAndEuler) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Single single(seed);
    Random random(100 + seed);
    const Vector3d acceleration = test::random_vector(random), spin_up = test::random_vector(random);
    const Matrix3d& inertia = single.body.inertia;
    const Vector3d spin = single.body.placement.rotation.transpose() * single.body.placement.angular_velocity;
    // w' = 2 G p' and p.p = 1, by time once more: G p'' = w''/2, p.p'' = -p'.p'.
    const Vector4d second =
        0.5 * g_matrix(single.p()).transpose() * spin_up - single.rate().squaredNorm() * single.p();
    test::State state{
        0.0, single.builder.initial_q(), single.builder.initial_v(), std::vector<double>(7), {0.0}};
    Eigen::Map<Vector3d>(state.a.data()) = acceleration;
    Eigen::Map<Vector4d>(state.a.data() + 3) = second;
    Residual residual = make_residual(*single.system);
    single.system->evaluate(state.view(), residual);
    EXPECT_NEAR(residual.position[0], 0.0, 1e-14);
    EXPECT_NEAR(residual.velocity[0], 0.0, 1e-14);
    EXPECT_NEAR(residual.acceleration[0], 0.0, 1e-13);
    const Eigen::Map<const Vector3d> force(residual.force.data());
    EXPECT_LT((force - single.body.mass * (acceleration - single.gravity)).norm(), 1e-13);
    const Vector3d moment =
        0.5 * g_matrix(single.p()) * Eigen::Map<const Vector4d>(residual.force.data() + 3);
    EXPECT_LT((moment - (inertia * spin_up + spin.cross(inertia * spin))).norm(), 1e-13);
  }
}

TEST(RigidBody, MassMatrixGivesTheKineticEnergy) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Single single(seed);
    const std::vector<double> none(7), multiplier(1);
    const StateView state{0.0, single.builder.initial_q().data(), none.data(), none.data(),
                          multiplier.data()};
    Tangent tangent = make_tangent(*single.system);
    single.system->evaluate(state, tangent, BlockSet::all());
    ASSERT_EQ(tangent[Block::force_a].size(), 49U);
    const Eigen::Map<const Eigen::Matrix<double, 7, 7>> mass(tangent[Block::force_a].data());
    EXPECT_LT((mass - mass.transpose()).cwiseAbs().maxCoeff(), 1e-14);
    const Eigen::Map<const Eigen::Matrix<double, 7, 1>> v(single.builder.initial_v().data());
    const Placement& placement = single.body.placement;
    const Vector3d spin = placement.rotation.transpose() * placement.angular_velocity;
    const double energy = 0.5 * single.body.mass * placement.velocity.squaredNorm() +
                          0.5 * spin.dot(single.body.inertia * spin);
    EXPECT_NEAR(0.5 * v.dot(mass * v), energy, 1e-13);
  }
}

TEST(RigidBody, FrameRemembersItsPlacement) {
  Random random(3);
  MultibodyBuilder builder;
  const RigidBody body = test::random_body(random, "top");
  const Frame frame = add_rigid_body(builder, body, Vector3d::Zero());
  const Placement placement = initial_placement(builder, frame);
  EXPECT_TRUE(placement.position.isApprox(body.placement.position, 1e-14));
  EXPECT_TRUE(placement.rotation.isApprox(body.placement.rotation, 1e-14));
  EXPECT_TRUE(placement.velocity.isApprox(body.placement.velocity, 1e-14));
  EXPECT_TRUE(placement.angular_velocity.isApprox(body.placement.angular_velocity, 1e-14));
  EXPECT_EQ(builder.build(1)->coordinate_name(5), "top.e2");
  EXPECT_EQ(builder.build(1)->constraint_name(0), "body top, Euler parameters, equation 1 of 1");

  const Attachment attachment = attach(builder, frame, {1, 2, 3}, axes_along({0, 0, 2}, {1, 1, 1}));
  EXPECT_TRUE(
      (placement.position + placement.rotation * attachment.point).isApprox(Vector3d(1, 2, 3), 1e-13));
  const Matrix3d axes = placement.rotation * attachment.axes;
  EXPECT_TRUE(axes.col(2).isApprox(Vector3d(0, 0, 1), 1e-13));
  EXPECT_TRUE(axes.col(0).isApprox(Vector3d(1, 1, 0).normalized(), 1e-13));
  EXPECT_NEAR(axes.determinant(), 1.0, 1e-13);
}

}  // namespace
}  // namespace mfs::dae
