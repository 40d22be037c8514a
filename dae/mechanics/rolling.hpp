// Rolling without slipping on a plane that is fixed in a: of a wheel, whose rim is a circle about b's point
// and z axis (a knife edge), or of a ball about b's point. With n = a_z, e = b_z, and c from b's point C to
// where it touches,
//
//   wheel   c = -r (n - (n.e) e) / sqrt(1 - (n.e)^2)        ball   c = -r n
//
//   on positions    n . (C + c - P_a) = 0
//   on velocities   a_x . u = 0,  a_y . u = 0                u: velocity there of b's material against a's
//
// The component of u along n is zero with the first. Where a wheel lies flat its equations have no solution.
#pragma once

#include <string>

#include "dae/mechanics/frame.hpp"
#include "dae/mechanics/multibody.hpp"

namespace mfs::dae {

enum class Roller { wheel, ball };

/// Where it touches, from b's point, when time begins (ground axes). `normal` and `axle`: n and e.
Eigen::Vector3d contact_arm(const Eigen::Vector3d& normal, const Eigen::Vector3d& axle, double radius,
                            Roller roller);

/// Adds the three constraints of what an error message calls `owner`. Throws InvalidInput("`owner`") where
/// both sides are on the same body, an attachment is no point with axes, the radius is not positive or a
/// wheel lies flat.
void add_rolling(MultibodyBuilder& builder, const std::string& owner, const Attachment& a,
                 const Attachment& b, double radius, Roller roller);

}  // namespace mfs::dae
