// Rigid bodies with any inertia tensor. With w' the angular velocity in body axes, w' = 2 G(p) p', the
// kinetic energy m/2 r'.r' + 1/2 w'.J w' gives the equations of motion (Haug 1989, section 11.3; Nikravesh)
//
//   m r''                                       = m g + ...
//   4 G^T J G p'' + 8 G'^T J G p'               = ...          G' = G(p')
//
// with the constraint p.p = 1, whose multiplier takes what would change the length of p.
#pragma once

#include <Eigen/Core>
#include <string>

#include "dae/mechanics/frame.hpp"
#include "dae/mechanics/multibody.hpp"

namespace mfs::dae {

struct RigidBody {
  std::string name;
  double mass = 0.0;        ///< kg
  Eigen::Matrix3d inertia;  ///< about the centre of mass, in body axes, kg m^2
  Placement placement;      ///< of the centre of mass and the body axes
};

/// Adds the body with its weight in the field `gravity` (m/s^2, ground axes). Its frame sits at the centre of
/// mass. Throws InvalidInput unless the mass is positive and the inertia tensor symmetric, positive
/// definite and that of some body: no principal moment more than the sum of the others (by 1 %, as tensors
/// are rounded).
Frame add_rigid_body(MultibodyBuilder& builder, const RigidBody& body, const Eigen::Vector3d& gravity);

}  // namespace mfs::dae
