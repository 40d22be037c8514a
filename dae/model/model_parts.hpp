// What the readers of the parts of a model file share: the system under construction, and the bodies by name.
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "dae/mechanics/joints.hpp"
#include "dae/mechanics/state_function.hpp"
#include "dae/model/model.hpp"

namespace mfs::dae {

struct ModelParts {
  MultibodyModel model;
  MultibodyBuilder builder;
  std::string folder;
  Parameters parameters;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  std::map<std::string, Material> materials;
  std::map<std::string, Joint> joints;
  std::map<std::string, Frame> interfaces;  ///< by "BODY:NODE_SET"
  std::map<std::string, int> measures;      ///< coordinates, by "JOINT.angle", "POINT.x", ...
  std::set<const ElementGroup*> measuring;  ///< what ties those coordinates to what they measure
  std::vector<Attachment> sides;            ///< of the object that is being read, in its order
  JointCoordinate along;                    ///< of that object, too

  const FlexibleBody* flexible(const std::string& name) const;
  RigidPart* rigid(const std::string& name);
};

// Each reads one object of the file; `name` is its key.
void read_material(JsonObject& object, const std::string& name, ModelParts& parts);
void read_body(JsonObject& object, const std::string& name, ModelParts& parts);
void read_joint(JsonObject& object, const std::string& name, ModelParts& parts);
void read_motion(JsonObject& object, const std::string& name, ModelParts& parts);
void read_force(JsonObject& object, const std::string& name, ModelParts& parts);
void read_point(JsonObject& object, const std::string& name, ModelParts& parts);
IntegratorOptions read_integrator(JsonObject& object, double length_unit);

/// The object "parameters": numbers and expressions of those before.
void read_parameters(JsonObject& object, Parameters& parameters);

/// A function of one variable, "constant", "linear", "harmonic", "smooth_step" or "spline".
Function read_function(JsonObject object);
/// That, or an expression of `variable` and of parameters.
Function read_function(JsonObject& object, const std::string& key, const char* variable,
                       const ModelParts& parts);
/// A function of t, or an expression of t, parameters and quantities, which get their measures.
StateFunction read_state_function(JsonObject& object, const std::string& key, ModelParts& parts);
/// Of the keys x, y, z; none where a key is missing.
std::array<StateFunction, 3> read_functions(JsonObject& object, ModelParts& parts);

/// The coordinate of "JOINT.angle", "JOINT.travel", "POINT.x", "POINT.y" or "POINT.z". Throws
/// InvalidInput(`place`) where there is no such joint or point, or it does not move that way.
int measured(const std::string& quantity, const std::string& place, ModelParts& parts);
/// Whether such a joint has an "angle" or a "travel".
bool moves(JointKind kind, const std::string& member);
/// The joint that the key "joint" names.
const Joint& read_joint_name(JsonObject& object, const ModelParts& parts);
/// The measure of that joint, along which the object that is being read acts.
int read_joint_measure(JsonObject& object, const char* member, ModelParts& parts);

/// Nodes of a flexible body, written "BODY:NODE_SET".
struct NodeSet {
  const FlexibleBody* body = nullptr;
  std::vector<int> nodes;
};
NodeSet read_node_set(JsonObject& object, const std::string& key, const ModelParts& parts);

/// A side of a joint or force, "ground", "BODY" (rigid) or "BODY:NODE_SET" (the nodes are tied to a rigid
/// interface, one for all that attach there), at `point` with `axes` when time begins.
Attachment read_side(JsonObject& object, const std::string& key, const Eigen::Vector3d& point,
                     const Eigen::Matrix3d& axes, ModelParts& parts);

}  // namespace mfs::dae
