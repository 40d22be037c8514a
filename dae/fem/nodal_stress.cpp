#include "dae/fem/nodal_stress.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "dae/fem/by_threads.hpp"
#include "dae/fem/shape.hpp"

namespace mfs::dae {

namespace {

// 1, x, y, z and, for hexahedra, xy, yz, xz, xyz.
Eigen::MatrixXd monomials(ElementKind kind, const std::vector<Point3>& points) {
  Eigen::MatrixXd result(static_cast<Eigen::Index>(points.size()), kind == ElementKind::tet10 ? 4 : 8);
  for (Eigen::Index i = 0; i < result.rows(); ++i) {
    const auto [x, y, z] = points[static_cast<std::size_t>(i)];
    result.row(i).head(4) << 1, x, y, z;
    if (kind != ElementKind::tet10) result.row(i).tail(4) << x * y, y * z, x * z, x * y * z;
  }
  return result;
}

// Nodes x points: from values at the points to the best fit's at the nodes.
Eigen::MatrixXd extrapolation(ElementKind kind) {
  const Eigen::MatrixXd at_points = monomials(kind, stiffness_rule(kind).points);
  return monomials(kind, reference_nodes(kind)) * at_points.completeOrthogonalDecomposition().pseudoInverse();
}

using PointStresses = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;

// At the integration points, 6 each.
void element_stress(const SolidGroup& body, int e, const double* q, double* stress) {
  constexpr int kMostNodes = 20;
  const Mesh& mesh = body.mesh();
  const int nodes = nodes_per_element(mesh.kind);
  const int* element = &mesh.elements[static_cast<std::size_t>(e) * static_cast<std::size_t>(nodes)];
  double reference[3 * kMostNodes], positions[3 * kMostNodes];
  body.gather_nodes(e, reference);
  for (int i = 0; i < nodes; ++i)
    std::copy_n(q + 3 * static_cast<std::ptrdiff_t>(element[i]), 3, positions + 3 * i);
  point_stress(mesh.kind, body.constants(), reference, positions, stress);
}

}  // namespace

double von_mises(const std::array<double, 6>& s) {
  const auto square = [](double x) { return x * x; };
  return std::sqrt(0.5 * (square(s[0] - s[1]) + square(s[1] - s[2]) + square(s[2] - s[0])) +
                   3 * (square(s[3]) + square(s[4]) + square(s[5])));
}

NodalStress nodal_stress(const SolidGroup& body, const double* q, int threads) {
  const Mesh& mesh = body.mesh();
  const auto nodes = static_cast<Eigen::Index>(nodes_per_element(mesh.kind));
  const Eigen::MatrixXd to_nodes = extrapolation(mesh.kind);
  PointStresses all(nodes * body.size(), 6);
  by_threads(threads, body.size(), [&](int begin, int end) {
    PointStresses at_points(static_cast<Eigen::Index>(stiffness_rule(mesh.kind).points.size()), 6);
    for (int e = begin; e < end; ++e) {
      element_stress(body, e, q, at_points.data());
      all.middleRows(e * nodes, nodes).noalias() = to_nodes * at_points;
    }
  });

  NodalStress result;
  std::vector<int> shares(mesh.nodes.size());
  result.cauchy.resize(mesh.nodes.size());
  for (std::size_t k = 0; k < mesh.elements.size(); ++k) {
    const auto node = static_cast<std::size_t>(mesh.elements[k]);
    ++shares[node];
    for (std::size_t c = 0; c < 6; ++c)
      result.cauchy[node][c] += all(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(c));
  }
  for (std::size_t node = 0; node < mesh.nodes.size(); ++node) {
    for (double& component : result.cauchy[node]) component /= std::max(shares[node], 1);
    result.von_mises.push_back(von_mises(result.cauchy[node]));
    if (result.largest_node < 0 || result.von_mises[node] > result.largest) {
      result.largest_node = static_cast<int>(node);
      result.largest = result.von_mises[node];
    }
  }
  return result;
}

}  // namespace mfs::dae
