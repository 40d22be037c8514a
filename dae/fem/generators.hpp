// Meshes of the bodies that the models are made of. Each is a plate of constant thickness between z = 0 and
// z = thickness: eyes (a ring around a hole) joined by bars whose sides leave the eyes along their tangents.
// `refine` divides every cell of the coarsest mesh refine^3 times. The surface of each hole is a node set.
//
// All throw InvalidInput for refine < 1 and for dimensions that leave no valid mesh.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "dae/fem/mesh.hpp"

namespace mfs::dae {

/// [0, size[0]] x [0, size[1]] x [0, size[2]] in divisions[0] x ... cells. Node sets x0, x1, y0, y1, z0, z1:
/// its faces.
Mesh box_mesh(const std::array<double, 3>& size, const std::array<int, 3>& divisions, ElementKind kind);

/// An L-shaped lever: hub at the origin, arm 1 along x, arm 2 at `angle` to it. Node sets center_hole,
/// arm1_hole, arm2_hole.
struct BellCrankShape {
  double arm1 = 0.24, arm2 = 0.18;              ///< from hub to the hole at the end, m
  double angle = 1.5707963267948966;            ///< rad
  double hub_radius = 0.06, hub_hole = 0.03;    ///< outer radius and radius of the hole, m
  double end_radius = 0.036, end_hole = 0.018;  ///< of both ends, m
  double thickness = 0.03;                      ///< m
};
Mesh bell_crank_mesh(int refine, ElementKind kind, const BellCrankShape& shape = {});

/// A shaft with an eye at each end: the big one at the origin, the small one on the x axis. Node sets
/// big_hole, small_hole.
struct ConnectingRodShape {
  double length = 0.2;                          ///< between the centres of the holes, m
  double big_radius = 0.044, big_hole = 0.024;  ///< m
  double small_radius = 0.026, small_hole = 0.013;
  double thickness = 0.022;
};
Mesh connecting_rod_mesh(int refine, ElementKind kind, const ConnectingRodShape& shape = {});

/// The lower arm of a double wishbone, A-shaped: two bushing eyes on the y axis at +-spread / 2, legs from
/// them to the eye of the shock, from there a stem to the ball joint at (reach, 0). Node sets front_hole (y >
/// 0), rear_hole, shock_hole, ball_hole. All holes are along z.
struct ControlArmShape {
  double reach = 0.38, shock = 0.25,
         spread = 0.40;  ///< x of ball joint and shock, distance of the bushings, m
  double bushing_radius = 0.042, bushing_hole = 0.024;
  double shock_radius = 0.056, shock_hole = 0.02;
  double ball_radius = 0.036, ball_hole = 0.018;
  double thickness = 0.03;
};
Mesh control_arm_mesh(int refine, ElementKind kind, const ControlArmShape& shape = {});

}  // namespace mfs::dae
