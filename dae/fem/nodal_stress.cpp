#include "dae/fem/nodal_stress.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

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

PointStresses element_stress(const SolidGroup& body, int e, const double* q) {
  const Mesh& mesh = body.mesh();
  const int nodes = nodes_per_element(mesh.kind);
  std::vector<double> reference(static_cast<std::size_t>(3 * nodes)), positions;
  body.gather_nodes(e, reference.data());
  for (int i = 0; i < nodes; ++i) {
    const double* x =
        q + 3 * static_cast<std::ptrdiff_t>(
                    mesh.elements[static_cast<std::size_t>(e) * static_cast<std::size_t>(nodes) +
                                  static_cast<std::size_t>(i)]);
    positions.insert(positions.end(), x, x + 3);
  }
  PointStresses stress(static_cast<Eigen::Index>(stiffness_rule(mesh.kind).points.size()), 6);
  point_stress(mesh.kind, body.constants(), reference.data(), positions.data(), stress.data());
  return stress;
}

}  // namespace

double von_mises(const std::array<double, 6>& s) {
  const auto square = [](double x) { return x * x; };
  return std::sqrt(0.5 * (square(s[0] - s[1]) + square(s[1] - s[2]) + square(s[2] - s[0])) +
                   3 * (square(s[3]) + square(s[4]) + square(s[5])));
}

NodalStress nodal_stress(const SolidGroup& body, const double* q) {
  const Mesh& mesh = body.mesh();
  const auto nodes = static_cast<Eigen::Index>(nodes_per_element(mesh.kind));
  const Eigen::MatrixXd to_nodes = extrapolation(mesh.kind);
  PointStresses all(nodes * body.size(), 6);
#pragma omp parallel for schedule(static)
  for (int e = 0; e < body.size(); ++e)
    all.middleRows(e * nodes, nodes) = to_nodes * element_stress(body, e, q);

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
