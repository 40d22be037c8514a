#include "dae/fem/shape.hpp"

#include <cmath>

namespace mfs::dae {

namespace {

QuadratureRule gauss(const std::vector<double>& points, const std::vector<double>& weights) {
  QuadratureRule rule;
  for (std::size_t k = 0; k < points.size(); ++k)
    for (std::size_t j = 0; j < points.size(); ++j)
      for (std::size_t i = 0; i < points.size(); ++i) {
        rule.points.push_back({points[i], points[j], points[k]});
        rule.weights.push_back(weights[i] * weights[j] * weights[k]);
      }
  return rule;
}

QuadratureRule gauss_2() {
  const double x = 1 / std::sqrt(3.0);
  return gauss({-x, x}, {1, 1});
}

QuadratureRule gauss_3() {
  const double x = std::sqrt(0.6);
  return gauss({-x, 0, x}, {5.0 / 9, 8.0 / 9, 5.0 / 9});
}

// The four points with barycentric coordinates (1 - 3 a, a, a, a) in some order.
void add_vertex_orbit(QuadratureRule& rule, double a, double weight) {
  for (int vertex = 0; vertex < 4; ++vertex) {
    Point3 point{a, a, a};
    if (vertex > 0) point[static_cast<std::size_t>(vertex - 1)] = 1 - 3 * a;
    rule.points.push_back(point);
    rule.weights.push_back(weight);
  }
}

QuadratureRule tetrahedron_4() {
  QuadratureRule rule;
  add_vertex_orbit(rule, (5 - std::sqrt(5.0)) / 20, 1.0 / 24);
  return rule;
}

// Walkington, Quadrature on simplices of arbitrary dimension (2000).
QuadratureRule tetrahedron_14() {
  QuadratureRule rule;
  add_vertex_orbit(rule, 0.31088591926330060980, 0.018781320953002641800);
  add_vertex_orbit(rule, 0.092735250310891226402, 0.012248840519393658257);
  const double a = 0.045503704125649649492, b = 0.5 - a, weight = 0.0070910034628469110730;
  for (const Point3& point : {Point3{a, a, b}, {a, b, a}, {b, a, a}, {a, b, b}, {b, a, b}, {b, b, a}}) {
    rule.points.push_back(point);
    rule.weights.push_back(weight);
  }
  return rule;
}

// The vertices first; then, for quadratic elements, the midpoints of these edges.
std::vector<Point3> with_midpoints(std::vector<Point3> nodes, const std::vector<std::array<int, 2>>& edges) {
  for (const auto& [p, q] : edges) {
    const Point3 a = nodes[static_cast<std::size_t>(p)], b = nodes[static_cast<std::size_t>(q)];
    nodes.push_back({(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2});
  }
  return nodes;
}

// One factor of a shape function along one axis, for a node at `node` (-1, 0 or 1), and its derivative.
struct Factor {
  double value, slope;
};

Factor factor(double node, double x) {
  if (node == 0) return {1 - x * x, -2 * x};
  return {(1 + node * x) / 2, node / 2};
}

void hexahedron_node(const Point3& node, const Point3& xi, bool serendipity, double& value,
                     double* gradient) {
  const Factor f = factor(node[0], xi[0]), g = factor(node[1], xi[1]), h = factor(node[2], xi[2]);
  value = f.value * g.value * h.value;
  gradient[0] = f.slope * g.value * h.value;
  gradient[1] = f.value * g.slope * h.value;
  gradient[2] = f.value * g.value * h.slope;
  if (!serendipity || node[0] * node[1] * node[2] == 0) return;
  const double lowered = node[0] * xi[0] + node[1] * xi[1] + node[2] * xi[2] - 2;
  for (std::size_t k = 0; k < 3; ++k) gradient[k] = gradient[k] * lowered + value * node[k];
  value *= lowered;
}

void tetrahedron(const Point3& xi, double* values, double* gradients) {
  const double bary[4] = {1 - xi[0] - xi[1] - xi[2], xi[0], xi[1], xi[2]};
  constexpr double slope[4][3] = {{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  constexpr int edge[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  for (int i = 0; i < 4; ++i) {
    values[i] = bary[i] * (2 * bary[i] - 1);
    for (int k = 0; k < 3; ++k) gradients[3 * i + k] = (4 * bary[i] - 1) * slope[i][k];
  }
  for (int e = 0; e < 6; ++e) {
    const int p = edge[e][0], q = edge[e][1];
    values[4 + e] = 4 * bary[p] * bary[q];
    for (int k = 0; k < 3; ++k)
      gradients[3 * (4 + e) + k] = 4 * (bary[p] * slope[q][k] + bary[q] * slope[p][k]);
  }
}

void evaluate(ElementKind kind, const Point3& xi, double* values, double* gradients) {
  if (kind == ElementKind::tet10) return tetrahedron(xi, values, gradients);
  const std::vector<Point3>& nodes = reference_nodes(kind);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    hexahedron_node(nodes[i], xi, kind == ElementKind::hex20, values[i], gradients + 3 * i);
}

constexpr int kMostNodes = 20;

}  // namespace

const QuadratureRule& stiffness_rule(ElementKind kind) {
  static const QuadratureRule hex8 = gauss_2(), hex20 = gauss_3(), tet10 = tetrahedron_4();
  return kind == ElementKind::hex8 ? hex8 : kind == ElementKind::hex20 ? hex20 : tet10;
}

const QuadratureRule& mass_rule(ElementKind kind) {
  static const QuadratureRule hex8 = gauss_2(), hex20 = gauss_3(), tet10 = tetrahedron_14();
  return kind == ElementKind::hex8 ? hex8 : kind == ElementKind::hex20 ? hex20 : tet10;
}

const std::vector<Point3>& reference_nodes(ElementKind kind) {
  static const std::vector<Point3> hex8 = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                           {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
  static const std::vector<Point3> hex20 = with_midpoints(
      hex8, {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}});
  static const std::vector<Point3> tet10 = with_midpoints({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                                          {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}});
  return kind == ElementKind::hex8 ? hex8 : kind == ElementKind::hex20 ? hex20 : tet10;
}

void shape_values(ElementKind kind, const Point3& xi, double* values) {
  double gradients[3 * kMostNodes];
  evaluate(kind, xi, values, gradients);
}

void shape_gradients(ElementKind kind, const Point3& xi, double* gradients) {
  double values[kMostNodes];
  evaluate(kind, xi, values, gradients);
}

std::array<Point3, 3> jacobian(ElementKind kind, const Point3& xi, const double* nodes) {
  double gradients[3 * kMostNodes];
  shape_gradients(kind, xi, gradients);
  std::array<Point3, 3> result{};
  for (std::size_t i = 0; i < static_cast<std::size_t>(nodes_per_element(kind)); ++i)
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t b = 0; b < 3; ++b) result[a][b] += nodes[3 * i + a] * gradients[3 * i + b];
  return result;
}

double determinant(const std::array<Point3, 3>& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

}  // namespace mfs::dae
