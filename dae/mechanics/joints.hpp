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

/// The constraints of `joint`. Its multipliers are forces (N) along ground axes where points are together,
/// along a's axes for what slides, and moments (N m) about a's axes. Throws InvalidInput("joint NAME") where
/// both sides are on the same body or an attachment is no point with axes.
void add_joint(MultibodyBuilder& builder, const Joint& joint);

}  // namespace mfs::dae
