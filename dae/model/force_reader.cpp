// Functions and forces of a model file.
#include <algorithm>

#include "dae/fem/surface_load.hpp"
#include "dae/mechanics/forces.hpp"
#include "dae/mechanics/loads.hpp"
#include "dae/mechanics/measures.hpp"
#include "dae/model/model_parts.hpp"

namespace mfs::dae {
namespace {

std::array<double, 6> read_six(JsonObject& object, const std::string& key) {
  const std::vector<double> values = object.numbers(key);
  if (values.size() != 6)
    object.refuse(
        key, "must have six numbers: along x, y, z and about x, y, z, not " + std::to_string(values.size()));
  std::array<double, 6> six{};
  std::copy(values.begin(), values.end(), six.begin());
  return six;
}

void read_bushing(JsonObject& object, const std::string& name, ModelParts& parts) {
  Bushing bushing;
  bushing.name = name;
  const Eigen::Vector3d point = object.vector("point");
  const Eigen::Matrix3d axes =
      object.has("axis") ? axes_along(object.vector("axis")) : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  bushing.a = read_side(object, "a", point, axes, parts);
  bushing.b = read_side(object, "b", point, axes, parts);
  bushing.stiffness = read_six(object, "stiffness");
  if (object.has("damping")) bushing.damping = read_six(object, "damping");
  object.finish();
  add_bushing(parts.builder, bushing);
}

void read_spring_damper(JsonObject& object, const std::string& name, ModelParts& parts) {
  SpringDamper spring;
  spring.name = name;
  const Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  const Eigen::Vector3d from = object.vector("point_a"), to = object.vector("point_b");
  spring.a = read_side(object, "a", from, axes, parts);
  spring.b = read_side(object, "b", to, axes, parts);
  spring.free_length = object.not_negative("free_length", (to - from).norm());
  spring.stiffness = object.not_negative("stiffness", 0.0);
  spring.damping = object.not_negative("damping", 0.0);
  if (object.has("force")) spring.force = read_function(object, "force", "x", parts);
  object.finish();
  add_spring_damper(parts.builder, spring);
}

// Ground axes, or what they were when time began on the body.
LoadAxes read_axes(JsonObject& object) {
  if (!object.has("axes")) return LoadAxes::ground;
  return object.choice<LoadAxes>("axes", {{"ground", LoadAxes::ground}, {"body", LoadAxes::attachment}});
}

void read_point_force(JsonObject& object, const std::string& name, ModelParts& parts) {
  const Attachment side =
      read_side(object, "side", object.vector("point"), Eigen::Matrix3d::Identity(), parts);
  const LoadAxes axes = read_axes(object);
  const std::array<StateFunction, 3> force = read_functions(object, parts);
  object.finish();
  add_point_force(parts.builder, name, side, force, axes);
}

// A torque has no point; in pictures it is at the origin of a rigid body.
void read_torque(JsonObject& object, const std::string& name, ModelParts& parts) {
  const RigidPart* const body = parts.rigid(object.text("side"));
  const Eigen::Vector3d point = body ? initial_placement(parts.builder, body->frame).position
                                     : Eigen::Vector3d(Eigen::Vector3d::Zero());
  const Attachment side = read_side(object, "side", point, Eigen::Matrix3d::Identity(), parts);
  const LoadAxes axes = read_axes(object);
  const std::array<StateFunction, 3> torque = read_functions(object, parts);
  object.finish();
  add_torque(parts.builder, name, side, torque, axes);
}

void read_surface_force(JsonObject& object, const std::string& name, ModelParts& parts) {
  const NodeSet set = read_node_set(object, "side", parts);
  const std::array<StateFunction, 3> force = read_functions(object, parts);
  object.finish();
  add_nodal_force(parts.builder, name, set.body->range, set.nodes,
                  surface_shares(set.body->solid->mesh(), set.nodes), force);
}

// A spring about or along the axis of a joint.
template <bool turns>
void read_joint_spring(JsonObject& object, const std::string& name, ModelParts& parts) {
  CoordinateSpring spring;
  spring.name = name;
  spring.coordinate = read_joint_measure(object, turns ? "angle" : "travel", parts);
  spring.stiffness = object.not_negative("stiffness", 0.0);
  spring.damping = object.not_negative("damping", 0.0);
  spring.free = object.number(turns ? "free_angle" : "free_travel", 0.0);
  const char* const key = turns ? "torque" : "force";
  if (object.has(key)) spring.force = read_function(object, key, "x", parts);
  object.finish();
  add_coordinate_spring(parts.builder, spring);
}

// About or along the axis of a joint, or along the line between two points.
void read_actuator(JsonObject& object, const std::string& name, ModelParts& parts) {
  const bool has_joint = object.has("joint"), turns = has_joint && object.has("torque");
  int coordinate = -1;
  if (has_joint && !turns && !object.has("force")) object.refuse("joint", "has neither torque nor force");
  if (has_joint) {
    coordinate = read_joint_measure(object, turns ? "angle" : "travel", parts);
  } else {
    const Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
    const Attachment a = read_side(object, "a", object.vector("point_a"), axes, parts);
    const Attachment b = read_side(object, "b", object.vector("point_b"), axes, parts);
    coordinate = add_measure(parts.builder, "force " + name, a, b, Measure::distance);
  }
  const StateFunction force = read_state_function(object, turns ? "torque" : "force", parts);
  object.finish();
  add_coordinate_force(parts.builder, name, coordinate, force);
}

}  // namespace

void read_force(JsonObject& object, const std::string& name, ModelParts& parts) {
  using Reader = void (*)(JsonObject&, const std::string&, ModelParts&);
  const Reader reader = object.choice<Reader>("type", {{"bushing", read_bushing},
                                                       {"spring_damper", read_spring_damper},
                                                       {"rotational_spring", read_joint_spring<true>},
                                                       {"translational_spring", read_joint_spring<false>},
                                                       {"actuator", read_actuator},
                                                       {"point", read_point_force},
                                                       {"torque", read_torque},
                                                       {"surface", read_surface_force}});
  reader(object, name, parts);
}

}  // namespace mfs::dae
