#include "dae/fem/generators.hpp"

#include <cmath>
#include <mfs/error.hpp>

#include "dae/fem/eye_plate.hpp"

namespace mfs::dae {

namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

}  // namespace

Mesh box_mesh(const std::array<double, 3>& size, const std::array<int, 3>& divisions, ElementKind kind) {
  for (std::size_t k = 0; k < 3; ++k)
    if (!(size[k] > 0) || divisions[k] < 1) throw InvalidInput("box", "sizes and divisions must be positive");
  check_cell_count(1.0 * divisions[0] * divisions[1] * divisions[2], kind);
  PlaneMesh plane(1e-6 * std::min(size[0] / divisions[0], size[1] / divisions[1]));
  plane.add_patch(divisions[0], divisions[1], [&](double s, double t) {
    return Point2{s * size[0], t * size[1]};
  });
  Mesh mesh = plane.extrude(size[2], divisions[2], kind);
  const char* names[3][2] = {{"x0", "x1"}, {"y0", "y1"}, {"z0", "z1"}};
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const double at = mesh.nodes[i][k], near = 1e-6 * size[k] / divisions[k];
      if (at < near) mesh.node_sets[names[k][0]].push_back(static_cast<int>(i));
      if (at > size[k] - near) mesh.node_sets[names[k][1]].push_back(static_cast<int>(i));
    }
  return mesh;
}

Mesh bell_crank_mesh(int refine, ElementKind kind, const BellCrankShape& s) {
  const Point2 end2 = {s.arm2 * std::cos(s.angle), s.arm2 * std::sin(s.angle)};
  const double at_hub = 38 * kDegree, at_end = 42 * kDegree;
  const EyePlate plate = {"bell crank",
                          {{"center_hole", {0, 0}, s.hub_hole, s.hub_radius},
                           {"arm1_hole", {s.arm1, 0}, s.end_hole, s.end_radius},
                           {"arm2_hole", end2, s.end_hole, s.end_radius}},
                          {{0, 1, at_hub, at_end, 5}, {0, 2, at_hub, at_end, 4}},
                          s.thickness,
                          2};
  return eye_plate_mesh(plate, refine, kind);
}

Mesh connecting_rod_mesh(int refine, ElementKind kind, const ConnectingRodShape& s) {
  const EyePlate plate = {"connecting rod",
                          {{"big_hole", {0, 0}, s.big_hole, s.big_radius},
                           {"small_hole", {s.length, 0}, s.small_hole, s.small_radius}},
                          {{0, 1, 40 * kDegree, 42 * kDegree, 8}},
                          s.thickness,
                          2};
  return eye_plate_mesh(plate, refine, kind);
}

Mesh control_arm_mesh(int refine, ElementKind kind, const ControlArmShape& s) {
  const double leg = 33 * kDegree, at_end = 42 * kDegree;
  const EyePlate plate = {"control arm",
                          {{"front_hole", {0, s.spread / 2}, s.bushing_hole, s.bushing_radius},
                           {"rear_hole", {0, -s.spread / 2}, s.bushing_hole, s.bushing_radius},
                           {"shock_hole", {s.shock, 0}, s.shock_hole, s.shock_radius},
                           {"ball_hole", {s.reach, 0}, s.ball_hole, s.ball_radius}},
                          {{0, 2, at_end, leg, 6}, {1, 2, at_end, leg, 6}, {2, 3, 40 * kDegree, at_end, 2}},
                          s.thickness,
                          1};
  return eye_plate_mesh(plate, refine, kind);
}

}  // namespace mfs::dae
