// Plates of eyes joined by bars: what the lever, the rod and the control arm have in common.
#pragma once

#include <string>
#include <vector>

#include "dae/fem/plane_mesh.hpp"

namespace mfs::dae {

struct Eye {
  std::string hole_set;  ///< node set of the hole's surface
  Point2 center;
  double hole, radius;  ///< radius of the hole and of the ring around it
};

/// A bar takes the part of each eye's ring within half_angle (rad) of the line between the centres.
struct Bar {
  std::size_t first, second;
  double first_half_angle, second_half_angle;
  int cells_along;
};

struct EyePlate {
  std::string name;  ///< in messages
  std::vector<Eye> eyes;
  std::vector<Bar> bars;
  double thickness;
  int layers;
};

/// Each number of cells is multiplied by refine. Throws InvalidInput where eyes overlap or have no ring, bars
/// overlap on a ring, or refine < 1.
Mesh eye_plate_mesh(const EyePlate& plate, int refine, ElementKind kind);

}  // namespace mfs::dae
