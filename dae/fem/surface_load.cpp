#include "dae/fem/surface_load.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <mfs/error.hpp>
#include <numeric>

#include "dae/fem/shape.hpp"

namespace mfs::dae {

namespace {

// A face of the reference cell: the points origin + r * first + s * second.
struct Face {
  Point3 origin, first, second;
  std::vector<std::size_t> nodes;

  Point3 at(double r, double s) const {
    Point3 x;
    for (std::size_t k = 0; k < 3; ++k) x[k] = origin[k] + r * first[k] + s * second[k];
    return x;
  }
};

std::vector<Face> faces_of(ElementKind kind) {
  std::vector<Face> faces;
  const std::vector<Point3>& nodes = reference_nodes(kind);
  const auto add = [&](Face face, const auto& holds) {
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (holds(nodes[i])) face.nodes.push_back(i);
    faces.push_back(face);
  };
  for (std::size_t a = 0; a < 3; ++a) {
    Face face{};
    face.first[(a + 1) % 3] = face.second[(a + 2) % 3] = kind == ElementKind::tet10 ? 1 : 2;
    if (kind == ElementKind::tet10) {
      add(face, [a](const Point3& x) { return x[a] == 0; });
      continue;
    }
    for (const double side : {-1.0, 1.0}) {
      face.origin = {-1, -1, -1};
      face.origin[a] = side;
      add(face, [a, side](const Point3& x) { return x[a] == side; });
    }
  }
  if (kind == ElementKind::tet10)
    add({{1, 0, 0}, {-1, 1, 0}, {-1, 0, 1}, {}}, [](const Point3& x) { return x[0] + x[1] + x[2] == 1; });
  return faces;
}

struct FacePoint {
  double r, s, weight;
};

// On the unit square 3 x 3 Gauss; on the unit triangle 7 points of degree 5 (Radon 1948).
std::vector<FacePoint> face_rule(ElementKind kind) {
  std::vector<FacePoint> rule;
  if (kind == ElementKind::tet10) {
    const double root = std::sqrt(15.0);
    rule.push_back({1.0 / 3, 1.0 / 3, 9.0 / 80});
    for (const double sign : {-1.0, 1.0}) {
      const double a = (6 + sign * root) / 21, weight = (155 + sign * root) / 2400;
      for (const auto& [r, s] : {std::pair{a, a}, {1 - 2 * a, a}, {a, 1 - 2 * a}})
        rule.push_back({r, s, weight});
    }
    return rule;
  }
  const double points[] = {0.5 - std::sqrt(0.15), 0.5, 0.5 + std::sqrt(0.15)},
               weights[] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) rule.push_back({points[i], points[j], weights[i] * weights[j]});
  return rule;
}

// Area of the face at a point, per unit of r and s.
double stretch(ElementKind kind, const Face& face, const Point3& at, const double* nodes) {
  const auto j = jacobian(kind, at, nodes);
  Point3 u{}, w{};
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) {
      u[a] += j[a][b] * face.first[b];
      w[a] += j[a][b] * face.second[b];
    }
  return std::hypot(u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]);
}

// Adds the integrals of the shape functions over a face to their nodes.
void integrate(const Mesh& mesh, std::size_t element, const Face& face, std::vector<double>& integral) {
  const auto n = static_cast<std::size_t>(nodes_per_element(mesh.kind));
  const int* number = &mesh.elements[element * n];
  std::vector<double> nodes, shape(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Point3& x = mesh.nodes[static_cast<std::size_t>(number[i])];
    nodes.insert(nodes.end(), x.begin(), x.end());
  }
  for (const FacePoint& point : face_rule(mesh.kind)) {
    const Point3 at = face.at(point.r, point.s);
    shape_values(mesh.kind, at, shape.data());
    const double weight = point.weight * stretch(mesh.kind, face, at, nodes.data());
    for (const std::size_t i : face.nodes) integral[static_cast<std::size_t>(number[i])] += weight * shape[i];
  }
}

}  // namespace

std::vector<double> surface_shares(const Mesh& mesh, const std::vector<int>& nodes) {
  if (nodes.empty()) throw InvalidInput("nodes", "a load needs one node at least");
  std::vector<char> in_set(mesh.nodes.size());
  for (const int node : nodes) in_set[static_cast<std::size_t>(node)] = 1;

  struct Place {
    std::size_t element, face;
    int times;
  };
  std::map<std::vector<int>, Place> found;  // by sorted nodes; an inner face is there twice
  const std::vector<Face> faces = faces_of(mesh.kind);
  const auto n = static_cast<std::size_t>(nodes_per_element(mesh.kind));
  for (std::size_t e = 0; e < mesh.elements.size() / n; ++e)
    for (std::size_t f = 0; f < faces.size(); ++f) {
      std::vector<int> key;
      for (const std::size_t i : faces[f].nodes) key.push_back(mesh.elements[e * n + i]);
      if (!std::all_of(key.begin(), key.end(),
                       [&](int i) { return in_set[static_cast<std::size_t>(i)] != 0; }))
        continue;
      std::sort(key.begin(), key.end());
      ++found.insert({key, {e, f, 0}}).first->second.times;
    }

  std::vector<double> integral(mesh.nodes.size()), shares;
  for (const auto& [key, place] : found)
    if (place.times == 1) integrate(mesh, place.element, faces[place.face], integral);
  for (const int node : nodes) shares.push_back(integral[static_cast<std::size_t>(node)]);
  const double area = std::accumulate(shares.begin(), shares.end(), 0.0);
  for (double& share : shares) share = area > 0 ? share / area : 1.0 / static_cast<double>(nodes.size());
  return shares;
}

}  // namespace mfs::dae
