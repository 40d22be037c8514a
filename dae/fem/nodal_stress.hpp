// Stress at nodes, for output: Cauchy stresses of the integration points are carried to the nodes of each
// element by the linear (tetrahedra) or trilinear (hexahedra) field that fits them best, and a node takes the
// mean over its elements. Exact for fields of that kind, as in uniform tension and pure bending. The viscous
// part is left out.
#pragma once

#include <array>
#include <vector>

#include "dae/fem/solid_group.hpp"

namespace mfs::dae {

struct NodalStress {
  std::vector<std::array<double, 6>> cauchy;  ///< xx, yy, zz, xy, yz, xz in the inertial frame, Pa, per node
  std::vector<double> von_mises;              ///< of the mean tensor, Pa, per node
  int largest_node = -1;                      ///< where von_mises is largest; of equals the first
  double largest = 0.0;                       ///< Pa
};

/// q: the positions of the body's nodes (3 per node). Nodes of elements that are inside out have stress NaN.
NodalStress nodal_stress(const SolidGroup& body, const double* q, int threads = 1);

double von_mises(const std::array<double, 6>& cauchy);

}  // namespace mfs::dae
