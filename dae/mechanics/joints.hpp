// Joints between two frames (rigid bodies, interfaces of flexible bodies, the ground), without a redundant
// equation:
//
//   fixed          6   points together, axes together
//   revolute       5   points together; turns about the common z axis
//   spherical      3   points together
//   universal      4   points together; a's z axis (fixed in a) and b's z axis (fixed in b) stay
//   perpendicular translational  5   slides along the common z axis cylindrical    4   slides along the
//   common z axis and turns about it rolling_wheel  3   b's circle of `radius` about its point and z axis, a
//   knife edge, rolls without slipping on
//                      the plane through a's point perpendicular to a's z axis: one constraint on positions,
//                      two on velocities
//   rolling_ball   3   the same of a sphere of `radius` about b's point
#pragma once

#include <string>

#include "dae/mechanics/frame.hpp"
#include "dae/mechanics/multibody.hpp"
#include "dae/mechanics/rolling.hpp"

namespace mfs::dae {

enum class JointKind {
  fixed,
  revolute,
  spherical,
  universal,
  translational,
  cylindrical,
  rolling_wheel,
  rolling_ball
};

inline bool rolls(JointKind kind) {
  return kind == JointKind::rolling_wheel || kind == JointKind::rolling_ball;
}
inline Roller roller_of(JointKind kind) {
  return kind == JointKind::rolling_wheel ? Roller::wheel : Roller::ball;
}

struct Joint {
  std::string name;
  JointKind kind = JointKind::fixed;
  Attachment a, b;
  double radius = 0.0;  ///< of what rolls, m
};

/// The constraints of `joint`, in this order, and what each multiplier does to b:
///
///   points together   P_b - P_a along ground axes: the force -lambda (N) on b at the point;
///                     where b slides, d . a_x and d . a_y: the force -lambda along a_x and a_y
///   axes parallel     a_x . b_z: the moment -lambda (N m) about a_y; a_y . b_z: lambda about a_x
///   no turn           a_x . b_y: the moment lambda about a_z
///   universal         a_z . b_z: the moment lambda about a_z x b_z
///   rolling           the force -lambda along a_z, a_x and a_y, where b touches
///
/// Throws InvalidInput("joint NAME") where both sides are on the same body, an attachment is no point with
/// axes or a radius is not positive.
void add_joint(MultibodyBuilder& builder, const Joint& joint);

}  // namespace mfs::dae
