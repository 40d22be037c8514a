// What the readers of the parts of a model file share: the system under construction, and the bodies by name.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "dae/mechanics/joints.hpp"
#include "dae/mechanics/smooth_function.hpp"
#include "dae/model/model.hpp"

namespace mfs::dae {

struct ModelParts {
  MultibodyModel model;
  MultibodyBuilder builder;
  std::string folder;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  std::map<std::string, Material> materials;
  std::map<std::string, Joint> joints;
  std::map<std::string, Frame> interfaces;  ///< by "BODY:NODE_SET"
  std::vector<Attachment> sides;            ///< of the object that is being read, in its order

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
IntegratorOptions read_integrator(JsonObject& object);

/// A function of one variable, "constant", "linear", "harmonic", "smooth_step" or "spline".
Function read_function(JsonObject object);
/// Of the keys x, y, z; none where a key is missing.
std::array<Function, 3> read_functions(JsonObject& object);

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
