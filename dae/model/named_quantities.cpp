// What expressions of a model file may name, and the measures that stand for it.
#include <mfs/error.hpp>

#include "dae/mechanics/measures.hpp"
#include "dae/model/model_parts.hpp"

namespace mfs::dae {
namespace {

const std::map<std::string, Measure> kMeasures{{"angle", Measure::angle},
                                               {"travel", Measure::travel},
                                               {"x", Measure::x},
                                               {"y", Measure::y},
                                               {"z", Measure::z}};

int add_point_measure(const std::string& name, const ModelPoint& point, Measure measure, ModelParts& parts) {
  if (point.node < 0) {
    Attachment side;
    side.frame = point.frame;
    side.point = point.point;
    return add_measure(parts.builder, name, {}, side, measure);
  }
  const int axis = static_cast<int>(measure) - static_cast<int>(Measure::x);
  const FlexibleBody& body = parts.model.flexible_bodies[static_cast<std::size_t>(point.body)];
  return add_coordinate_measure(parts.builder, name, body.range.first + 3 * point.node + axis);
}

int add_quantity(const std::string& owner, const std::string& member, const std::string& place,
                 ModelParts& parts) {
  const std::string name = "quantity " + owner + "." + member;
  const auto measure = kMeasures.find(member);
  if (measure == kMeasures.end())
    throw InvalidInput(place, "there is no quantity '" + member +
                                  "': joints have angle, angle_rate, travel, travel_rate, points x, y, z, "
                                  "vx, vy, vz");
  if (measure->second == Measure::angle || measure->second == Measure::travel) {
    const auto joint = parts.joints.find(owner);
    if (joint == parts.joints.end()) throw InvalidInput(place, "there is no joint '" + owner + "'");
    if (!moves(joint->second.kind, member))
      throw InvalidInput(place, "joint '" + owner + "' does not move that way");
    return add_measure(parts.builder, name, joint->second.a, joint->second.b, measure->second);
  }
  for (const ModelPoint& point : parts.model.points)
    if (point.name == owner) return add_point_measure(name, point, measure->second, parts);
  throw InvalidInput(place, "there is no point '" + owner + "'");
}

}  // namespace

bool moves(JointKind kind, const std::string& member) {
  if (kind == JointKind::cylindrical) return true;
  return kind == (member == "angle" ? JointKind::revolute : JointKind::translational);
}

int measured(const std::string& quantity, const std::string& place, ModelParts& parts) {
  const auto found = parts.measures.find(quantity);
  if (found != parts.measures.end()) return found->second;
  const std::size_t dot = quantity.rfind('.');
  const auto& groups = parts.builder.groups();
  const std::size_t before = groups.size();
  const int coordinate = add_quantity(quantity.substr(0, dot), quantity.substr(dot + 1), place, parts);
  for (std::size_t g = before; g < groups.size(); ++g) parts.measuring.insert(groups[g].get());
  return parts.measures[quantity] = coordinate;
}

const Joint& read_joint_name(JsonObject& object, const ModelParts& parts) {
  const std::string joint = object.text("joint");
  const auto found = parts.joints.find(joint);
  if (found == parts.joints.end()) object.refuse("joint", "there is no joint '" + joint + "'");
  return found->second;
}

int read_joint_measure(JsonObject& object, const char* member, ModelParts& parts) {
  const Joint& joint = read_joint_name(object, parts);
  parts.sides = {joint.a, joint.b};
  parts.along.turns = std::string(member) == "angle";
  parts.along.number = measured(joint.name + "." + member, object.place_of("joint"), parts);
  return parts.along.number;
}

}  // namespace mfs::dae
