// Sides, joints and motions of a model file.
#include <Eigen/Geometry>
#include <algorithm>

#include <mfs/error.hpp>

#include "dae/mechanics/measures.hpp"
#include "dae/mechanics/motions.hpp"
#include "dae/mechanics/rigid_interface.hpp"
#include "dae/model/model_parts.hpp"
#include "parts/comma_list.hpp"

namespace mfs::dae {
namespace {

const std::vector<int>& nodes_of(const FlexibleBody& body, const std::string& set, const JsonObject& object,
                                 const std::string& key) {
  const auto& sets = body.solid->mesh().node_sets;
  const auto found = sets.find(set);
  if (found != sets.end()) return found->second;
  object.refuse(key, "the mesh of body '" + body.name + "' has no node set '" + set +
                         "', only: " + comma_list(sets, key_of));
}

Eigen::Vector3d mean_of(const NodeSet& set, const ModelParts& parts) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const int node : set.nodes)
    mean += Eigen::Map<const Eigen::Vector3d>(&parts.builder.initial_q()[set.body->range.first + 3 * node]);
  return mean / static_cast<double>(set.nodes.size());
}

// The interface of these nodes, its origin at their mean; made when it is asked for first.
Frame interface_of(const NodeSet& set, const std::string& name, ModelParts& parts) {
  const auto found = parts.interfaces.find(name);
  if (found != parts.interfaces.end()) return found->second;
  const Frame frame =
      add_rigid_interface(parts.builder, name, set.body->range, set.nodes, mean_of(set, parts));
  return parts.interfaces[name] = frame;
}

Attachment rigid_side(RigidPart& body, const Eigen::Vector3d& point, const Eigen::Matrix3d& axes,
                      ModelParts& parts) {
  Attachment side = attach(parts.builder, body.frame, point, axes);
  body.points.push_back(side.point);
  parts.builder.note_length(body.frame.first, side.point.norm());
  return side;
}

Attachment side_at(JsonObject& object, const std::string& key, const Eigen::Vector3d& point,
                   const Eigen::Matrix3d& axes, ModelParts& parts) {
  const std::string side = object.text(key);
  if (side == "ground") return attach(parts.builder, Frame(), point, axes);
  if (RigidPart* body = parts.rigid(side)) return rigid_side(*body, point, axes, parts);
  if (side.find(':') == std::string::npos)
    object.refuse(key, "'" + side + "' is neither ground nor a rigid body of this model nor BODY:NODE_SET");
  return attach(parts.builder, interface_of(read_node_set(object, key, parts), side, parts), point, axes);
}

// Along the coordinates of what moves where the motion depends on quantities.
void read_drive(JsonObject& object, const std::string& name, const char* quantity, const char* member,
                ModelParts& parts,
                void (*add)(MultibodyBuilder&, const std::string&, const Attachment&, const Attachment&,
                            const Function&)) {
  const Joint& joint = read_joint_name(object, parts);
  if (!moves(joint.kind, member)) object.refuse("joint", "'" + joint.name + "' does not move that way");
  const StateFunction function = read_state_function(object, quantity, parts);
  if (function.of_time())
    add(parts.builder, name, joint.a, joint.b, function.of_time());
  else
    add_coordinate_motion(parts.builder, name, {read_joint_measure(object, member, parts)}, function,
                          MotionFrom::zero);
  object.finish();
  parts.sides = {joint.a, joint.b};
}

void read_rotation(JsonObject& object, const std::string& name, ModelParts& parts) {
  read_drive(object, name, "angle", "angle", parts, add_rotation);
}

void read_translation(JsonObject& object, const std::string& name, ModelParts& parts) {
  read_drive(object, name, "distance", "travel", parts, add_translation);
}

void read_point_motion(JsonObject& object, const std::string& name, ModelParts& parts) {
  const Attachment side =
      read_side(object, "side", object.vector("point"), Eigen::Matrix3d::Identity(), parts);
  const std::array<StateFunction, 3> position = read_functions(object, parts);
  object.finish();
  std::array<Function, 3> of_time;
  bool any_else = false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    of_time[axis] = position[axis].of_time();
    if (!position[axis] || of_time[axis]) continue;
    any_else = true;
    const std::string component = name + "." + "xyz"[axis];
    const int moved = add_measure(parts.builder, "motion " + component, {}, side,
                                  std::array<Measure, 3>{Measure::x, Measure::y, Measure::z}[axis]);
    add_coordinate_motion(parts.builder, component, {moved}, position[axis], MotionFrom::zero);
  }
  if (!any_else || of_time[0] || of_time[1] || of_time[2])
    add_point_motion(parts.builder, name, side, of_time);
}

void read_node_motion(JsonObject& object, const std::string& name, ModelParts& parts) {
  const NodeSet set = read_node_set(object, "side", parts);
  const std::array<StateFunction, 3> change = read_functions(object, parts);
  object.finish();
  if (!change[0] && !change[1] && !change[2]) object.refuse("x", "one of x, y, z is needed");
  const std::vector<int> coordinates = node_coordinates(set.body->range, set.nodes, object.place());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!change[axis]) continue;
    std::vector<int> along;
    for (std::size_t i = axis; i < coordinates.size(); i += 3) along.push_back(coordinates[i]);
    add_coordinate_motion(parts.builder, name + "." + "xyz"[axis], along, change[axis]);
  }
}

}  // namespace

NodeSet read_node_set(JsonObject& object, const std::string& key, const ModelParts& parts) {
  const std::string side = object.text(key);
  const std::size_t colon = std::min(side.find(':'), side.size());
  const FlexibleBody* body = parts.flexible(side.substr(0, colon));
  if (!body || colon == side.size())
    object.refuse(key, "'" + side + "' is no BODY:NODE_SET with a flexible body of this model");
  return {body, nodes_of(*body, side.substr(colon + 1), object, key)};
}

Attachment read_side(JsonObject& object, const std::string& key, const Eigen::Vector3d& point,
                     const Eigen::Matrix3d& axes, ModelParts& parts) {
  parts.sides.push_back(side_at(object, key, point, axes, parts));
  return parts.sides.back();
}

void read_joint(JsonObject& object, const std::string& name, ModelParts& parts) {
  Joint joint;
  joint.name = name;
  joint.kind = object.choice<JointKind>("type", {{"fixed", JointKind::fixed},
                                                 {"revolute", JointKind::revolute},
                                                 {"spherical", JointKind::spherical},
                                                 {"universal", JointKind::universal},
                                                 {"translational", JointKind::translational},
                                                 {"cylindrical", JointKind::cylindrical},
                                                 {"rolling_wheel", JointKind::rolling_wheel},
                                                 {"rolling_ball", JointKind::rolling_ball}});
  const Eigen::Vector3d point = object.vector("point");
  Eigen::Matrix3d axes_a = Eigen::Matrix3d::Identity(), axes_b = axes_a;
  if (joint.kind != JointKind::fixed && joint.kind != JointKind::spherical)
    axes_a = axes_b = axes_along(object.vector("axis"));
  if (joint.kind == JointKind::universal || joint.kind == JointKind::rolling_wheel)
    axes_b = axes_along(object.vector("axis_b"));
  // The constraint keeps them perpendicular, and of parallel axes it does not say which way to turn.
  constexpr double kParallel = 1e-6;
  if (joint.kind == JointKind::universal && axes_a.col(2).cross(axes_b.col(2)).norm() < kParallel)
    object.refuse("axis_b", "is parallel to axis, to which it has to be perpendicular");
  Eigen::Vector3d point_a = point;
  if (rolls(joint.kind)) {
    joint.radius = object.positive("radius");
    const Eigen::Vector3d arm =
        contact_arm(axes_a.col(2), axes_b.col(2), joint.radius, roller_of(joint.kind));
    point_a = object.has("plane") ? object.vector("plane") : Eigen::Vector3d(point + arm);
  }
  joint.a = read_side(object, "a", point_a, axes_a, parts);
  joint.b = read_side(object, "b", point, axes_b, parts);
  object.finish();
  add_joint(parts.builder, joint);
  parts.joints[name] = joint;
}

void read_motion(JsonObject& object, const std::string& name, ModelParts& parts) {
  using Reader = void (*)(JsonObject&, const std::string&, ModelParts&);
  const Reader reader = object.choice<Reader>("type", {{"rotation", read_rotation},
                                                       {"translation", read_translation},
                                                       {"point", read_point_motion},
                                                       {"nodes", read_node_motion}});
  reader(object, name, parts);
}

}  // namespace mfs::dae
