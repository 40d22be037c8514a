// Shape functions and integration rules of the three elements, on their reference cells: the cube [-1, 1]^3
// for hexahedra, the tetrahedron with the vertices 0, e1, e2, e3. Nodes are numbered as in VTK.
//
// Rules for the stiffness: hex8 2x2x2 Gauss. hex20 3x3x3 Gauss: products of a shape function's gradient with
// the cofactors of the Jacobian have degree 5 in each coordinate at most, so curved elements pass the patch
// test, and there is no deformation without energy (2x2x2 costs a third but leaves six such to a free
// element). tet10 4 points, exact to degree 2: the patch test is passed where edges are straight. Rules for
// the mass: 2x2x2, 3x3x3 Gauss, 14 points of degree 5 (Walkington 2000).
#pragma once

#include <array>
#include <vector>

#include "dae/fem/mesh.hpp"

namespace mfs::dae {

using Point3 = std::array<double, 3>;

struct QuadratureRule {
  std::vector<Point3> points;
  std::vector<double> weights;  ///< sum: volume of the reference cell, 8 or 1/6
};

const QuadratureRule& stiffness_rule(ElementKind kind);
const QuadratureRule& mass_rule(ElementKind kind);

/// Positions of the nodes of the reference cell.
const std::vector<Point3>& reference_nodes(ElementKind kind);

/// values: nodes_per_element(kind) entries.
void shape_values(ElementKind kind, const Point3& xi, double* values);
/// gradients: nodes x 3, the derivatives by xi.
void shape_gradients(ElementKind kind, const Point3& xi, double* gradients);

/// J[a][b] = dX_a / dxi_b of the map from the cell to an element whose nodes lie at `nodes` (nodes x 3).
std::array<Point3, 3> jacobian(ElementKind kind, const Point3& xi, const double* nodes);
double determinant(const std::array<Point3, 3>& matrix);

}  // namespace mfs::dae
