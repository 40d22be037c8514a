// Two rigid bodies somewhere in space, and attachments on them.
#pragma once

#include <Eigen/Geometry>

#include "dae/mechanics/rigid_body.hpp"
#include "test/dae/mechanics/system_derivatives.hpp"
#include "test/reference/random.hpp"

namespace mfs::test {

inline Eigen::Vector3d random_vector(Random& random) {
  const double x = random.entry(), y = random.entry();
  return {x, y, random.entry()};
}

inline Eigen::Matrix3d random_rotation(Random& random) {
  const Eigen::Vector3d axis = random_vector(random).normalized();
  return Eigen::AngleAxisd(3 * random.entry(), axis).toRotationMatrix();
}

inline dae::Placement random_placement(Random& random) {
  dae::Placement placement;
  placement.position = random_vector(random);
  placement.rotation = random_rotation(random);
  placement.velocity = random_vector(random);
  placement.angular_velocity = random_vector(random);
  return placement;
}

inline dae::Attachment random_attachment(Random& random, const dae::Frame& frame) {
  const Eigen::Vector3d point = random_vector(random);
  return {frame, point, random_rotation(random)};
}

inline dae::RigidBody random_body(Random& random, const std::string& name) {
  const Eigen::Matrix3d axes = random_rotation(random);
  dae::RigidBody body;
  body.name = name;
  body.mass = 1.5 + random.entry();
  body.inertia = axes * Eigen::Vector3d(0.7, 1.1, 1.6).asDiagonal() * axes.transpose();
  body.inertia = (0.5 * (body.inertia + body.inertia.transpose())).eval();
  body.placement = random_placement(random);
  return body;
}

/// Near the initial state of `builder`, with Euler parameters that are not quite of unit length.
inline State random_state(Random& random, const dae::MultibodyBuilder& builder, int constraints) {
  State state;
  state.t = random.unit();
  state.q = builder.initial_q();
  for (double& x : state.q) x += 0.05 * random.entry();
  state.v = random.vector(static_cast<std::int64_t>(state.q.size()));
  state.a = random.vector(static_cast<std::int64_t>(state.q.size()));
  state.lambda = random.vector(constraints);
  return state;
}

}  // namespace mfs::test
