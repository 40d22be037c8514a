#include "dae/fem/plane_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <mfs/error.hpp>

#include "dae/fem/shape.hpp"
#include "dae/mechanics/number_text.hpp"

namespace mfs::dae {

namespace {

// Place of a node in a cell: 0, 1 or 2 along each direction.
using Place = std::array<int, 3>;

// The 27 points of an extruded cell, at place i + 3 j + 9 k.
using Cell = std::array<int, 27>;

int at(const Cell& cell, const Place& p) {
  return cell[static_cast<std::size_t>(p[0] + 3 * p[1] + 9 * p[2])];
}

void add_hexahedron(const Cell& cell, ElementKind kind, std::vector<int>& elements) {
  for (const Point3& node : reference_nodes(kind))
    elements.push_back(at(
        cell, {static_cast<int>(node[0]) + 1, static_cast<int>(node[1]) + 1, static_cast<int>(node[2]) + 1}));
}

void add_tetrahedron(const Cell& cell, const std::array<Place, 4>& corners, std::vector<int>& elements) {
  for (const Point3& node : reference_nodes(ElementKind::tet10)) {
    const double bary[4] = {1 - node[0] - node[1] - node[2], node[0], node[1], node[2]};
    Place place{};
    for (std::size_t k = 0; k < 3; ++k) {
      double sum = 0;
      for (std::size_t v = 0; v < 4; ++v) sum += bary[v] * corners[v][k];
      place[k] = static_cast<int>(std::lround(sum));
    }
    elements.push_back(at(cell, place));
  }
}

int orientation(const std::array<Place, 4>& c) {
  std::array<Point3, 3> edges{};
  for (std::size_t e = 0; e < 3; ++e)
    for (std::size_t k = 0; k < 3; ++k) edges[e][k] = c[e + 1][k] - c[0][k];
  return determinant(edges) > 0 ? 1 : -1;
}

// The prism over a triangle a, b, c of the bottom face as three tetrahedra. Sides of prisms are cut from the
// point of the lower number at the bottom to the other at the top, so neighbours agree.
void add_prism(const Cell& cell, std::array<Place, 3> triangle, std::vector<int>& elements) {
  std::sort(triangle.begin(), triangle.end(),
            [&](const Place& p, const Place& q) { return at(cell, p) < at(cell, q); });
  const auto [a, b, c] = triangle;
  const auto top = [](Place p) { return Place{p[0], p[1], 2}; };
  for (std::array<Place, 4> corners :
       {std::array<Place, 4>{a, b, c, top(c)}, {a, b, top(b), top(c)}, {a, top(a), top(b), top(c)}}) {
    if (orientation(corners) < 0) std::swap(corners[2], corners[3]);
    add_tetrahedron(cell, corners, elements);
  }
}

void add_cell(const Cell& cell, ElementKind kind, std::vector<int>& elements) {
  if (kind != ElementKind::tet10) return add_hexahedron(cell, kind, elements);
  add_prism(cell, {Place{0, 0, 0}, {2, 0, 0}, {2, 2, 0}}, elements);
  add_prism(cell, {Place{0, 0, 0}, {2, 2, 0}, {0, 2, 0}}, elements);
}

// Keeps the nodes that elements use.
void drop_unused_nodes(Mesh& mesh) {
  std::vector<int> number(mesh.nodes.size(), -1);
  for (const int node : mesh.elements) number[static_cast<std::size_t>(node)] = 0;
  std::vector<Point3> kept;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] < 0) continue;
    number[i] = static_cast<int>(kept.size());
    kept.push_back(mesh.nodes[i]);
  }
  mesh.nodes = std::move(kept);
  for (int& node : mesh.elements) node = number[static_cast<std::size_t>(node)];
  for (auto& [name, set] : mesh.node_sets) {
    for (int& node : set) node = number[static_cast<std::size_t>(node)];
    set.erase(std::remove(set.begin(), set.end(), -1), set.end());
  }
}

}  // namespace

void check_cell_count(double cells, ElementKind kind) {
  // Of a cell inside a large block: 9 for each pair of coupled nodes. Cells at a surface have more.
  const double entries = kind == ElementKind::hex8 ? 243 : kind == ElementKind::hex20 ? 2106 : 2070;
  const double most = std::floor(std::numeric_limits<int>::max() / entries);
  if (!(cells <= most))
    throw InvalidInput("mesh", number_text(cells) + " cells are more than the " + number_text(most) +
                                   " of this element whose matrices can be counted");
}

int PlaneMesh::point_at(const Point2& x) {
  const long long i = std::llround(x[0] / tolerance_), j = std::llround(x[1] / tolerance_);
  for (long long di = -1; di <= 1; ++di)
    for (long long dj = -1; dj <= 1; ++dj) {
      const auto found = near_.find({i + di, j + dj});
      if (found != near_.end()) return found->second;
    }
  const int number = static_cast<int>(points_.size());
  near_[{i, j}] = number;
  points_.push_back(x);
  return number;
}

std::vector<int> PlaneMesh::add_patch(int cells_s, int cells_t,
                                      const std::function<Point2(double, double)>& map) {
  const int columns = 2 * cells_s + 1, rows = 2 * cells_t + 1;
  std::vector<int> grid(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  const auto place = [&](int i, int j) { return static_cast<std::size_t>(j * columns + i); };
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      grid[place(i, j)] =
          point_at(map(static_cast<double>(i) / (columns - 1), static_cast<double>(j) / (rows - 1)));
  for (int j = 0; j < 2 * cells_t; j += 2)
    for (int i = 0; i < 2 * cells_s; i += 2) {
      std::array<int, 9> cell{};
      for (int k = 0; k < 9; ++k) cell[static_cast<std::size_t>(k)] = grid[place(i + k % 3, j + k / 3)];
      cells_.push_back(cell);
    }
  std::vector<int> edge(static_cast<std::size_t>(rows));
  for (int j = 0; j < rows; ++j) edge[static_cast<std::size_t>(j)] = grid[place(0, j)];
  return edge;
}

void PlaneMesh::add_to_set(const std::string& name, const std::vector<int>& points) {
  std::vector<int>& set = sets_[name];
  set.insert(set.end(), points.begin(), points.end());
  std::sort(set.begin(), set.end());
  set.erase(std::unique(set.begin(), set.end()), set.end());
}

Mesh PlaneMesh::extrude(double thickness, int layers, ElementKind kind) const {
  Mesh mesh;
  mesh.kind = kind;
  const int levels = 2 * layers + 1, count = static_cast<int>(points_.size());
  for (int level = 0; level < levels; ++level) {
    for (const Point2& p : points_) mesh.nodes.push_back({p[0], p[1], thickness * level / (levels - 1)});
    for (const auto& [name, set] : sets_)
      for (const int point : set) mesh.node_sets[name].push_back(level * count + point);
  }
  for (int layer = 0; layer < layers; ++layer)
    for (const std::array<int, 9>& plane : cells_) {
      Cell cell{};
      for (std::size_t k = 0; k < 27; ++k)
        cell[k] = plane[k % 9] + (2 * layer + static_cast<int>(k / 9)) * count;
      add_cell(cell, kind, mesh.elements);
    }
  drop_unused_nodes(mesh);
  return mesh;
}

}  // namespace mfs::dae
