// Accelerations and multipliers of small mechanisms, from the equations of motion and the constraints on
// accelerations together, against the plain laws: all signs at once.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "dae/mechanics/joints.hpp"
#include "dae/mechanics/motions.hpp"
#include "test/dae/mechanics/dense.hpp"
#include "test/dae/mechanics/two_bodies.hpp"

namespace mfs::dae {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::Random;

struct Motion {
  VectorXd a, lambda;
};

/// Of the initial state: M a + Phi_q^T lambda = -F(0, 0), Phi_q a = -(d^2/dt^2 Phi)(0).
Motion accelerations_and_multipliers(MultibodyBuilder& builder) {
  const auto system = builder.build(1);
  const int n = system->coordinates(), m = system->constraints();
  const std::vector<double> zero(n);
  const StateView state{0.0, builder.initial_q().data(), builder.initial_v().data(), zero.data(),
                        zero.data()};
  Residual residual = make_residual(*system);
  Tangent tangent = make_tangent(*system);
  system->evaluate(state, residual);
  system->evaluate(state, tangent, BlockSet::all());
  for (int i = 0; i < m; ++i) {
    EXPECT_NEAR(residual.position[i], 0.0, 1e-13) << system->constraint_name(i);
    EXPECT_NEAR(residual.velocity[i], 0.0, 1e-13) << system->constraint_name(i);
  }
  const auto block = [&](Block b) { return test::dense(system->tangent_pattern()[b], tangent[b]); };
  const MatrixXd jacobian = block(Block::position_q);
  MatrixXd matrix = MatrixXd::Zero(n + m, n + m);
  matrix.topLeftCorner(n, n) = block(Block::force_a);
  matrix.bottomLeftCorner(m, n) = jacobian;
  matrix.topRightCorner(n, m) = jacobian.transpose();
  VectorXd right(n + m);
  right << -Eigen::Map<VectorXd>(residual.force.data(), n),
      -Eigen::Map<VectorXd>(residual.acceleration.data(), m);
  const VectorXd x = matrix.fullPivLu().solve(right);
  return {x.head(n), x.tail(m)};
}

/// A body that turns about an axis fixed in the ground, hinged on side a or b of the joint.
struct Pendulum {
  RigidBody body;
  Vector3d hinge, axis, gravity{0.4, -9.81, 1.0};
  double spin = 2.5;
  MultibodyBuilder builder;
  Frame frame;
  Matrix3d axes;

  explicit Pendulum(std::uint64_t seed) {
    Random random(seed);
    hinge = test::random_vector(random);
    axis = test::random_vector(random).normalized();
    axes = axes_along(axis, test::random_vector(random));
    body = test::random_body(random, "bob");
    body.placement.angular_velocity = spin * axis;
    body.placement.velocity = spin * axis.cross(arm());
    frame = add_rigid_body(builder, body, gravity);
  }
  Vector3d arm() const { return body.placement.position - hinge; }
  Matrix3d inertia() const {  // in ground axes
    return body.placement.rotation * body.inertia * body.placement.rotation.transpose();
  }
  Attachment on_ground() const { return attach(builder, {}, hinge, axes); }
  Attachment on_body() const { return attach(builder, frame, hinge, axes); }

  /// Newton and Euler for the angular acceleration `spin_up`: acceleration of the centre of mass, and what
  /// the hinge gives.
  Vector3d acceleration(double spin_up) const {
    return spin_up * axis.cross(arm()) + spin * spin * axis.cross(axis.cross(arm()));
  }
  Vector3d force(double spin_up) const { return body.mass * (acceleration(spin_up) - gravity); }
  Vector3d moment(double spin_up) const {
    const Matrix3d j = inertia();
    return spin_up * j * axis + spin * spin * axis.cross(j * axis) + arm().cross(force(spin_up));
  }
};

TEST(Balance, PendulumOnARevoluteJoint) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Pendulum pendulum(seed);
    add_joint(pendulum.builder, {"hinge", JointKind::revolute, pendulum.on_ground(), pendulum.on_body()});
    const Motion x = accelerations_and_multipliers(pendulum.builder);
    // The hinge gives no moment about its axis: moment(s) . axis = 0 is linear in s.
    const double at_rest = pendulum.moment(0).dot(pendulum.axis);
    const double spin_up = -at_rest / (pendulum.moment(1).dot(pendulum.axis) - at_rest);
    EXPECT_LT((x.a.head<3>() - pendulum.acceleration(spin_up)).norm(), 1e-11);
    const Vector3d force = pendulum.force(spin_up),
                   moment = pendulum.axes.transpose() * pendulum.moment(spin_up);
    EXPECT_LT((x.lambda.segment<3>(1) + force).norm(), 1e-10);  // after the one of p.p = 1
    EXPECT_NEAR(x.lambda[4], -moment[1], 1e-10);
    EXPECT_NEAR(x.lambda[5], moment[0], 1e-10);
  }
}

TEST(Balance, DriveOfARotation) {
  const double spin_up = 3.5;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Pendulum pendulum(seed);
    add_joint(pendulum.builder, {"hinge", JointKind::revolute, pendulum.on_ground(), pendulum.on_body()});
    const double f =
        10.0;  // amplitude sin(2 pi f t + phase): its first derivative is spin, its second spin_up
    const double angular = 2 * std::acos(-1.0) * f, sine = -spin_up / (angular * angular),
                 cosine = pendulum.spin / angular;
    const Function angle = harmonic_function(-sine, std::hypot(sine, cosine), f, std::atan2(sine, cosine));
    add_rotation(pendulum.builder, "drive", pendulum.on_ground(), pendulum.on_body(), angle);
    const Motion x = accelerations_and_multipliers(pendulum.builder);
    EXPECT_LT((x.a.head<3>() - pendulum.acceleration(spin_up)).norm(), 1e-11);
    EXPECT_NEAR(x.lambda[6], -pendulum.moment(spin_up).dot(pendulum.axis), 1e-10);
  }
}

TEST(Balance, DriveOfATranslation) {
  Random random(8);
  MultibodyBuilder builder;
  RigidBody body = test::random_body(random, "piston");
  body.placement.angular_velocity.setZero();
  const Vector3d gravity(0.4, -9.81, 1.0), along = test::random_vector(random).normalized();
  body.placement.velocity = 4.0 * along;
  const Frame frame = add_rigid_body(builder, body, gravity);
  const Matrix3d axes = axes_along(along);
  const Attachment ground = attach(builder, {}, body.placement.position, axes);
  const Attachment piston = attach(builder, frame, body.placement.position, axes);
  add_joint(builder, {"guide", JointKind::translational, ground, piston});
  add_translation(builder, "drive", ground, piston, linear_function(0.0, 4.0));
  const Motion x = accelerations_and_multipliers(builder);
  const Vector3d weight = body.mass * axes.transpose() * gravity;
  EXPECT_LT(x.a.head<7>().norm(), 1e-11);
  EXPECT_NEAR(x.lambda[1], weight[0], 1e-11);  // the guide holds with -lambda what pulls
  EXPECT_NEAR(x.lambda[2], weight[1], 1e-11);
  EXPECT_LT(x.lambda.segment<3>(3).norm(), 1e-11);
  EXPECT_NEAR(x.lambda[6], weight[2], 1e-11);
}

}  // namespace
}  // namespace mfs::dae
