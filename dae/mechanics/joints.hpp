// Joints between two frames (rigid bodies, interfaces of flexible bodies, the ground), without a redundant
// equation:
//
//   fixed          6   points together, axes together
//   revolute       5   points together; turns about the common z axis
//   spherical      3   points together
//   universal      4   points together; a's z axis (fixed in a) and b's z axis (fixed in b) stay
//   perpendicular translational  5   slides along the common z axis cylindrical    4   slides along the
//   common z axis and turns about it
#pragma once

#include <string>

#include "dae/mechanics/frame.hpp"
#include "dae/mechanics/multibody.hpp"

namespace mfs::dae {

enum class JointKind { fixed, revolute, spherical, universal, translational, cylindrical };

struct Joint {
  std::string name;
  JointKind kind = JointKind::fixed;
  Attachment a, b;
};

/// The constraints of `joint`, in this order, and what each multiplier does to b:
///
///   points together   P_b - P_a along ground axes: the force -lambda (N) on b at the point;
///                     where b slides, d . a_x and d . a_y: the force -lambda along a_x and a_y
///   axes parallel     a_x . b_z: the moment -lambda (N m) about a_y; a_y . b_z: lambda about a_x
///   no turn           a_x . b_y: the moment lambda about a_z
///   universal         a_z . b_z: the moment lambda about a_z x b_z
///
/// Throws InvalidInput("joint NAME") where both sides are on the same body or an attachment is no point with
/// axes.
void add_joint(MultibodyBuilder& builder, const Joint& joint);

}  // namespace mfs::dae
