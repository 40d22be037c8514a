// A rigid interface ("RBE2") joins nodes of a flexible body to a massless frame, to which joints and forces
// then attach: each node x keeps its place s in the frame,
//
//   x - r - A(p) s = 0       3 equations per node.
//
// Three nodes or more that are not on one line hold the frame's 6 freedoms; together with the constraint
// p.p = 1 no equation is redundant.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "dae/mechanics/frame.hpp"
#include "dae/mechanics/multibody.hpp"

namespace mfs::dae {

/// The coordinates of `nodes`, three each, of a body with 3 coordinates a node. Throws
/// InvalidInput("`owner`") where a node is not in the body.
std::vector<int> node_coordinates(CoordinateRange body, const std::vector<int>& nodes,
                                  const std::string& owner);

/// Adds the frame, with its origin at `origin` (m, ground axes, at the beginning), ground axes, and the rigid
/// motion that fits the initial velocities of the nodes best.
/// Throws InvalidInput("interface NAME") where a node is not in the body or is named twice, or the nodes are
/// fewer than three or on one line.
Frame add_rigid_interface(MultibodyBuilder& builder, const std::string& name, CoordinateRange body,
                          const std::vector<int>& nodes, const Eigen::Vector3d& origin);

}  // namespace mfs::dae
