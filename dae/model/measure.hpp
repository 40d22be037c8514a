// What is read off a state: how frames and points move, what joints, motions and forces do to the bodies.
// Everything is along ground axes unless something else is said.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dae/model/model.hpp"

namespace mfs::dae {

struct FrameMotion {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();      ///< of the origin, m
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< columns: the frame's axes
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_acceleration = Eigen::Vector3d::Zero();
};

/// The ground rests.
FrameMotion frame_motion(const Frame& frame, const State& state);

struct PointMotion {
  Eigen::Vector3d position, velocity, acceleration;  ///< m, m/s, m/s^2
};

/// Of a point fixed in the frame, `arm` in its axes from its origin.
PointMotion point_motion(const FrameMotion& frame, const Eigen::Vector3d& arm);

PointMotion motion_of(const MultibodyModel& model, const ModelPoint& point, const State& state);

/// The unit quaternion (w, x, y, z) of a rotation, w >= 0.
Eigen::Vector4d quaternion(const Eigen::Matrix3d& rotation);

/// Force (N) and moment (N m).
struct Wrench {
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();
};

/// What the elements, those of a joint, a motion or a force, do to `b`: the moment is about b's point. Where
/// b is on the ground, minus what they do to the body of `a`.
Wrench wrench_on(const Attachment& b, const Attachment& a, const std::vector<ModelElement>& elements,
                 const State& state);

/// b's point, or where b touches what it rolls on.
Eigen::Vector3d joint_position(const ModelJoint& joint, const State& state);
/// What the joint does to b; the moment is about joint_position().
Wrench reaction(const ModelJoint& joint, const State& state);

/// The sum of the forces of elements that act on nodes.
Eigen::Vector3d force_on_nodes(const MultibodyModel& model, const std::vector<ModelElement>& elements,
                               const State& state);

/// The sum of what elements do along one coordinate: N where that is a length, N m where it is an angle.
double force_along(int coordinate, const std::vector<ModelElement>& elements, const State& state);

/// W.
Power power(const std::vector<ModelElement>& elements, const State& state);
/// J.
Energy energy(const std::vector<ModelElement>& elements, const State& state, int threads = 1);

/// How b is turned against a about the axes that the joint leaves free, and moved along them: rad, m, and
/// their rates. Angles are within half a turn of zero.
struct JointMotion {
  std::vector<double> angle, angle_rate;
  double travel = 0, travel_rate = 0;
};
JointMotion joint_motion(const ModelJoint& joint, const State& state);

/// How many angles it has: 0, 1, or 2 of a universal joint, about the axis in a and the axis in b.
int angles_of(JointKind kind);
/// Whether it slides along its axis.
bool slides(JointKind kind);

}  // namespace mfs::dae
