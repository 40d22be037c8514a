#include "dae/model/mesh_generators.hpp"

#include <cmath>

#include "dae/fem/generators.hpp"

namespace mfs::dae {
namespace {

void read_length(JsonObject& object, const char* key, double& value) {
  if (object.has(key)) value = object.positive(key);
}

Mesh read_box(JsonObject& object, int refine, ElementKind kind) {
  const Eigen::Vector3d size = object.vector("size"), divisions = object.vector("divisions");
  std::array<int, 3> cells{};
  for (int k = 0; k < 3; ++k) {
    if (!(size[k] > 0)) object.refuse("size", "must be positive");
    if (divisions[k] < 1 || divisions[k] > 1000 || divisions[k] != std::floor(divisions[k]))
      object.refuse("divisions", "must be integers from 1 to 1000");
    cells[static_cast<std::size_t>(k)] = refine * static_cast<int>(divisions[k]);
  }
  return box_mesh({size[0], size[1], size[2]}, cells, kind);
}

Mesh read_bell_crank(JsonObject& object, int refine, ElementKind kind) {
  BellCrankShape shape;
  read_length(object, "arm1", shape.arm1);
  read_length(object, "arm2", shape.arm2);
  read_length(object, "angle", shape.angle);
  read_length(object, "hub_radius", shape.hub_radius);
  read_length(object, "hub_hole", shape.hub_hole);
  read_length(object, "end_radius", shape.end_radius);
  read_length(object, "end_hole", shape.end_hole);
  read_length(object, "thickness", shape.thickness);
  return bell_crank_mesh(refine, kind, shape);
}

Mesh read_connecting_rod(JsonObject& object, int refine, ElementKind kind) {
  ConnectingRodShape shape;
  read_length(object, "length", shape.length);
  read_length(object, "big_radius", shape.big_radius);
  read_length(object, "big_hole", shape.big_hole);
  read_length(object, "small_radius", shape.small_radius);
  read_length(object, "small_hole", shape.small_hole);
  read_length(object, "thickness", shape.thickness);
  return connecting_rod_mesh(refine, kind, shape);
}

Mesh read_control_arm(JsonObject& object, int refine, ElementKind kind) {
  ControlArmShape shape;
  read_length(object, "reach", shape.reach);
  read_length(object, "shock", shape.shock);
  read_length(object, "spread", shape.spread);
  read_length(object, "bushing_radius", shape.bushing_radius);
  read_length(object, "bushing_hole", shape.bushing_hole);
  read_length(object, "shock_radius", shape.shock_radius);
  read_length(object, "shock_hole", shape.shock_hole);
  read_length(object, "ball_radius", shape.ball_radius);
  read_length(object, "ball_hole", shape.ball_hole);
  read_length(object, "thickness", shape.thickness);
  return control_arm_mesh(refine, kind, shape);
}

}  // namespace

Mesh generate_mesh(JsonObject& object) {
  using Generator = Mesh (*)(JsonObject&, int, ElementKind);
  const Generator generator = object.choice<Generator>("generator", {{"box", read_box},
                                                                     {"bell_crank", read_bell_crank},
                                                                     {"connecting_rod", read_connecting_rod},
                                                                     {"control_arm", read_control_arm}});
  const ElementKind kind = object.choice<ElementKind>(
      "element", {{"hex8", ElementKind::hex8}, {"hex20", ElementKind::hex20}, {"tet10", ElementKind::tet10}});
  return generator(object, object.integer("refine", 1, 100), kind);
}

}  // namespace mfs::dae
