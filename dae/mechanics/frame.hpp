// What joints, motions and forces hold on to: a frame, rigid and moving with 7 coordinates (its origin's
// position x y z and its Euler parameters e0 e1 e2 e3), or the ground. Rigid bodies have one
// (rigid_body.hpp), nodes of a flexible body get one (rigid_interface.hpp). An attachment is a point and
// three axes fixed in a frame.
#pragma once

#include <Eigen/Core>
#include <string>

#include "dae/mechanics/multibody.hpp"

namespace mfs::dae {

struct Frame {
  std::string name = "ground";
  int first = -1;  ///< of the 7 coordinates; -1: the ground

  bool is_ground() const { return first < 0; }
};

/// Position and orientation of a frame when time begins, and how they change.
struct Placement {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();          ///< of the origin, m
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();      ///< columns: the frame's axes
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          ///< of the origin, m/s
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< in ground axes, rad/s
};

/// A new frame: its 7 coordinates and the constraint p.p = 1. Throws InvalidInput where the rotation is none
/// or a number is not finite.
Frame add_frame(MultibodyBuilder& builder, const std::string& name, const Placement& placement);

/// Where `frame` is when time begins. The ground rests at the origin.
Placement initial_placement(const MultibodyBuilder& builder, const Frame& frame);

/// A point and axes of a frame, in that frame's own axes.
struct Attachment {
  Frame frame;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();     ///< from the frame's origin, m
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: unit vectors x, y, z
};

/// The attachment that at the beginning is at `point` with `axes`, both given in ground axes.
Attachment attach(const MultibodyBuilder& builder, const Frame& frame, const Eigen::Vector3d& point,
                  const Eigen::Matrix3d& axes = Eigen::Matrix3d::Identity());

/// Right-handed unit axes, columns, with `z` (any length but 0) as the third. The first is the part of `x`
/// that is perpendicular to z, and any perpendicular where x is left out. Throws InvalidInput where z is zero
/// or x is along it.
Eigen::Matrix3d axes_along(const Eigen::Vector3d& z, const Eigen::Vector3d& x = Eigen::Vector3d::Zero());

/// Throws InvalidInput("`owner`") unless the columns of `axes` are right-handed unit vectors.
void check_axes(const Eigen::Matrix3d& axes, const std::string& owner);

}  // namespace mfs::dae
