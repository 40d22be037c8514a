// Joints that may not be where they are meant to be: axes that nearly agree, and points far from what they
// join. A door on two hinges turns where their axes are one line; where they are
// half a degree apart its constraints are independent, and it is locked. Nothing is wrong with such a model,
// so it is told of and not refused.
#pragma once

#include <string>
#include <vector>

#include "dae/model/model.hpp"

namespace mfs::dae {

/// A note for each joint that is out of line, with the joint beside which it is and the angle or distance
/// between their axes:
///
///   - a universal joint whose axes are not perpendicular where bodies are placed;
///   - a revolute, cylindrical or translational joint whose axis is less than 3 degrees off that of another
///     one, or as hinge of the same two bodies beside it by less than a tenth of their distance along it,
///     where constraints of both are so nearly redundant that the axes alone may hold a motion;
///   - a joint of two rigid bodies, hundreds of radii of gyration away from both, or of nodes that are ten
///   lengths of their mesh away: lengths may be in two units.
///
/// `q`: positions at t = 0 that fulfil the constraints.
std::vector<std::string> alignment_notes(const MultibodyModel& model, const std::vector<double>& q);

}  // namespace mfs::dae
