// What is read off a state for the results: where a point of a model is, how it is accelerated, the force of
// a joint.
#pragma once

#include <Eigen/Core>

#include "dae/model/model.hpp"

namespace mfs::dae {

/// Of the point `point` (in the frame's axes) of the frame whose 7 coordinates begin at q, m.
Eigen::Vector3d frame_point(const double* q, const Eigen::Vector3d& point);

/// m/s^2, ground axes.
Eigen::Vector3d point_acceleration(const MeasuredPoint& point, const State& state);

/// Magnitude, N.
double joint_force(const MeasuredJoint& joint, const State& state);

}  // namespace mfs::dae
