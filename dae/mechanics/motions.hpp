// Motions that are prescribed as functions of time, or of time and other coordinates. They are constraints as
// those of joints are; the force or moment that drives b, or the point, is -lambda.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dae/mechanics/frame.hpp"
#include "dae/mechanics/multibody.hpp"
#include "dae/mechanics/smooth_function.hpp"
#include "dae/mechanics/state_function.hpp"

namespace mfs::dae {

/// The angle of b's x axis from a's, about a's z axis, is angle(t) rad: a drive beside a revolute or
/// cylindrical joint with the same attachments. Any angle; what it is at the beginning must be less than half
/// a turn from the bodies' placement. Throws InvalidInput("motion NAME") as add_joint, or without a function.
void add_rotation(MultibodyBuilder& builder, const std::string& name, const Attachment& a,
                  const Attachment& b, const Function& angle);

/// b's point is distance(t) m from a's along a's z axis: beside a translational or cylindrical joint.
void add_translation(MultibodyBuilder& builder, const std::string& name, const Attachment& a,
                     const Attachment& b, const Function& distance);

/// The point of `attachment` is at position(t), m, in ground axes. Axes without a function are free.
/// Throws InvalidInput where there is none at all or the attachment is on the ground.
void add_point_motion(MultibodyBuilder& builder, const std::string& name, const Attachment& attachment,
                      const std::array<Function, 3>& position);

/// What the change of a coordinate is counted from.
enum class MotionFrom { initial, zero };

/// Each of `coordinates` of the system is its initial value (or zero) + change(t, q): nodes of a flexible
/// body that are held or moved, measures. Throws InvalidInput where there are none, one is not in the system,
/// or the change depends on rates or on one of these coordinates.
void add_coordinate_motion(MultibodyBuilder& builder, const std::string& name,
                           const std::vector<int>& coordinates, const StateFunction& change,
                           MotionFrom from = MotionFrom::initial);

}  // namespace mfs::dae
