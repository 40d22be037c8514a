// Forces and torques whose sizes are given: by functions of time, or by expressions of time and of the state
// (state_function.hpp). They act on a frame, on nodes of a flexible body, or along one coordinate, as a
// measure's (measures.hpp).
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dae/mechanics/frame.hpp"
#include "dae/mechanics/multibody.hpp"
#include "dae/mechanics/state_function.hpp"

namespace mfs::dae {

/// Along which axes the components of a load are.
enum class LoadAxes {
  ground,
  attachment,  ///< those of the attachment, which turn with its frame: a follower
};

/// A force on the point of `attachment`: components in N, none: zero.
/// Throws InvalidInput("force NAME") where there is no function, or the frame is the ground.
void add_point_force(MultibodyBuilder& builder, const std::string& name, const Attachment& attachment,
                     const std::array<StateFunction, 3>& force, LoadAxes axes = LoadAxes::ground);

/// A torque on the frame of `attachment`: components in N m. Throws as add_point_force.
void add_torque(MultibodyBuilder& builder, const std::string& name, const Attachment& attachment,
                const std::array<StateFunction, 3>& torque, LoadAxes axes = LoadAxes::ground);

/// A force (N, ground axes) on a flexible body, split over nodes: node `nodes[i]` of `body` gets the fraction
/// `fractions[i]` of it. Functions must not depend on the coordinates of these nodes.
/// Throws InvalidInput("force NAME") where there is no function or no node, or a node is not in the body.
void add_nodal_force(MultibodyBuilder& builder, const std::string& name, CoordinateRange body,
                     const std::vector<int>& nodes, const std::vector<double>& fractions,
                     const std::array<StateFunction, 3>& force);

/// A force along coordinate `coordinate`: N where that is a length, N m where it is an angle.
void add_coordinate_force(MultibodyBuilder& builder, const std::string& name, int coordinate,
                          const StateFunction& force);

/// Spring and damper along one coordinate: the force -stiffness (q - free) - damping v.
struct CoordinateSpring {
  std::string name;
  int coordinate = -1;
  double stiffness = 0.0;  ///< N/m or N m/rad
  double damping = 0.0;    ///< N s/m or N m s/rad
  double free = 0.0;       ///< where it is relaxed, m or rad
  Function force;          ///< in place of the stiffness: of q - free, positive where it pulls q back
};

/// Throws InvalidInput("spring NAME") where stiffness or damping is negative, or both a stiffness and a
/// function are given.
void add_coordinate_spring(MultibodyBuilder& builder, const CoordinateSpring& spring);

}  // namespace mfs::dae
