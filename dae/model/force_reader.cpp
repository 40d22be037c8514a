// Functions and forces of a model file.
#include <algorithm>

#include "dae/fem/surface_load.hpp"
#include "dae/mechanics/forces.hpp"
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
  if (object.has("force")) spring.force = read_function(object.object("force"));
  object.finish();
  add_spring_damper(parts.builder, spring);
}

void read_point_force(JsonObject& object, const std::string& name, ModelParts& parts) {
  const Attachment side =
      read_side(object, "side", object.vector("point"), Eigen::Matrix3d::Identity(), parts);
  const std::array<Function, 3> force = read_functions(object);
  object.finish();
  add_point_force(parts.builder, name, side, force);
}

void read_surface_force(JsonObject& object, const std::string& name, ModelParts& parts) {
  const NodeSet set = read_node_set(object, "side", parts);
  const std::array<Function, 3> force = read_functions(object);
  object.finish();
  add_nodal_force(parts.builder, name, set.body->range, set.nodes,
                  surface_shares(set.body->solid->mesh(), set.nodes), force);
}

Function read_constant(JsonObject& object) {
  return constant_function(object.number("value"));
}

Function read_linear(JsonObject& object) {
  return linear_function(object.number("value", 0.0), object.number("slope"));
}

Function read_harmonic(JsonObject& object) {
  return harmonic_function(object.number("offset", 0.0), object.number("amplitude"),
                           object.positive("frequency"), object.number("phase", 0.0));
}

Function read_smooth_step(JsonObject& object) {
  return smooth_step(object.number("begin"), object.number("end"), object.number("before", 0.0),
                     object.number("after"));
}

Function read_spline(JsonObject& object) {
  const std::vector<double> x = object.numbers("x"), y = object.numbers("y");
  if (x.size() != y.size() || x.size() < 2) object.refuse("y", "must have as many numbers as x, two or more");
  for (std::size_t i = 1; i < x.size(); ++i)
    if (!(x[i - 1] < x[i])) object.refuse("x", "must ascend");
  return spline_function(x, y);
}

}  // namespace

Function read_function(JsonObject object) {
  using Reader = Function (*)(JsonObject&);
  const Reader reader = object.choice<Reader>("type", {{"constant", read_constant},
                                                       {"linear", read_linear},
                                                       {"harmonic", read_harmonic},
                                                       {"smooth_step", read_smooth_step},
                                                       {"spline", read_spline}});
  Function function = reader(object);
  object.finish();
  return function;
}

std::array<Function, 3> read_functions(JsonObject& object) {
  std::array<Function, 3> functions;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string key(1, "xyz"[axis]);
    if (object.has(key)) functions[axis] = read_function(object.object(key));
  }
  return functions;
}

void read_force(JsonObject& object, const std::string& name, ModelParts& parts) {
  using Reader = void (*)(JsonObject&, const std::string&, ModelParts&);
  const Reader reader = object.choice<Reader>("type", {{"bushing", read_bushing},
                                                       {"spring_damper", read_spring_damper},
                                                       {"point", read_point_force},
                                                       {"surface", read_surface_force}});
  reader(object, name, parts);
}

}  // namespace mfs::dae
