// A mesh of quadrilaterals in the plane, put together from mapped patches, that is extruded to a mesh of
// solids.
//
//      6---7---8      Each cell has nine points, those of a grid of twice the fineness. So the extruded cell
//      has 27, 3   4   5      and among them are the nodes of every kind of element on the exact geometry:
//      corners (hex8), 0---1---2      middles of edges (hex20), middles of faces and of the cell for the
//      edges of tetrahedra that
//                     cut across (tet10). Points that the kind does not use are dropped.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "dae/fem/mesh.hpp"

namespace mfs::dae {

using Point2 = std::array<double, 2>;

/// Throws InvalidInput("mesh") where a body of so many cells, as PlaneMesh makes them, has more entries in
/// its matrices than an int can count: before such a mesh is made, which would take minutes and all memory.
void check_cell_count(double cells, ElementKind kind);

class PlaneMesh {
 public:
  /// tolerance: points closer than that are one point.
  explicit PlaneMesh(double tolerance) : tolerance_(tolerance) {}

  /// Adds cells_s x cells_t cells; map takes (s, t) of the unit square, counter-clockwise, to the plane.
  /// Returns the points of the edge s = 0.
  std::vector<int> add_patch(int cells_s, int cells_t, const std::function<Point2(double, double)>& map);
  void add_to_set(const std::string& name, const std::vector<int>& points);

  int cells() const { return static_cast<int>(cells_.size()); }
  /// The solid between z = 0 and z = thickness; sets become node sets over all of it.
  Mesh extrude(double thickness, int layers, ElementKind kind) const;

 private:
  int point_at(const Point2& x);

  double tolerance_;
  std::vector<Point2> points_;
  std::vector<std::array<int, 9>> cells_;
  std::map<std::string, std::vector<int>> sets_;
  std::map<std::pair<long long, long long>, int> near_;  // grid square of the size of the tolerance -> point
};

}  // namespace mfs::dae
