#include "dae/model/mesh_generators.hpp"

#include <cmath>
#include <initializer_list>
#include <utility>

#include "dae/fem/generators.hpp"

namespace mfs::dae {
namespace {

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

template <class Shape>
using Lengths = std::initializer_list<std::pair<const char*, double Shape::*>>;

// A shape whose lengths are as the object says where it names them.
template <class Shape>
Shape read_shape(JsonObject& object, Lengths<Shape> lengths) {
  Shape shape;
  for (const auto& [key, length] : lengths) {
    if (object.has(key)) shape.*length = object.positive(key);
  }
  return shape;
}

Mesh read_bell_crank(JsonObject& object, int refine, ElementKind kind) {
  using Shape = BellCrankShape;
  const Lengths<Shape> lengths{{"arm1", &Shape::arm1},         {"arm2", &Shape::arm2},
                               {"angle", &Shape::angle},       {"hub_radius", &Shape::hub_radius},
                               {"hub_hole", &Shape::hub_hole}, {"end_radius", &Shape::end_radius},
                               {"end_hole", &Shape::end_hole}, {"thickness", &Shape::thickness}};
  return bell_crank_mesh(refine, kind, read_shape(object, lengths));
}

Mesh read_connecting_rod(JsonObject& object, int refine, ElementKind kind) {
  using Shape = ConnectingRodShape;
  const Lengths<Shape> lengths{{"length", &Shape::length},         {"big_radius", &Shape::big_radius},
                               {"big_hole", &Shape::big_hole},     {"small_radius", &Shape::small_radius},
                               {"small_hole", &Shape::small_hole}, {"thickness", &Shape::thickness}};
  return connecting_rod_mesh(refine, kind, read_shape(object, lengths));
}

Mesh read_control_arm(JsonObject& object, int refine, ElementKind kind) {
  using Shape = ControlArmShape;
  const Lengths<Shape> lengths{{"reach", &Shape::reach},
                               {"shock", &Shape::shock},
                               {"spread", &Shape::spread},
                               {"bushing_radius", &Shape::bushing_radius},
                               {"bushing_hole", &Shape::bushing_hole},
                               {"shock_radius", &Shape::shock_radius},
                               {"shock_hole", &Shape::shock_hole},
                               {"ball_radius", &Shape::ball_radius},
                               {"ball_hole", &Shape::ball_hole},
                               {"thickness", &Shape::thickness}};
  return control_arm_mesh(refine, kind, read_shape(object, lengths));
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
