// The motion of a flexible body as a whole, for output: that of its centre of mass, and the rotation that
// comes nearest to it. With x the positions, X the mesh and sums over the mass matrix,
//
//   c = int x dm / m,    R: the rotation with the largest tr(R^T int (x - c) (X - C)^T dm)     (Kabsch 1976)
//   J w = int (x - c) x (x' - c') dm,    (J w)' = int (x - c) x (x'' - c'') dm
//
// so a body that moves as a rigid one has its orientation, angular velocity and acceleration.
#pragma once

#include <Eigen/Core>

#include "dae/fem/solid_group.hpp"

namespace mfs::dae {

struct BodyMotion {
  Eigen::Vector3d position, velocity, acceleration;        ///< of the centre of mass; m, m/s, m/s^2
  Eigen::Matrix3d rotation;                                ///< from the mesh's axes to the ground's
  Eigen::Vector3d angular_velocity, angular_acceleration;  ///< ground axes; rad/s, rad/s^2
};

/// q, v, a: positions of the body's nodes (3 per node), and their derivatives.
BodyMotion body_motion(const SolidGroup& body, const double* q, const double* v, const double* a,
                       int threads);

}  // namespace mfs::dae
