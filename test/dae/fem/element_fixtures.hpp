// What the tests of elements share: small distorted meshes, affine maps, a body evaluated as a whole.
#pragma once

#include <Eigen/Dense>
#include <memory>
#include <random>
#include <vector>

#include "dae/fem/generators.hpp"
#include "dae/fem/shape.hpp"
#include "dae/fem/solid_group.hpp"

namespace mfs::dae::testing {

constexpr ElementKind kKinds[] = {ElementKind::hex8, ElementKind::hex20, ElementKind::tet10};

inline std::string kind_name(ElementKind kind) {
  return kind == ElementKind::hex8 ? "hex8" : kind == ElementKind::hex20 ? "hex20" : "tet10";
}

inline void straighten(Mesh& mesh) {
  constexpr int kEdges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  for (std::size_t e = 0; e < mesh.elements.size(); e += 10)
    for (std::size_t k = 0; k < 6; ++k)
      for (std::size_t c = 0; c < 3; ++c) {
        const auto corner = [&](int i) {
          return mesh.nodes[static_cast<std::size_t>(mesh.elements[e + static_cast<std::size_t>(i)])][c];
        };
        mesh.nodes[static_cast<std::size_t>(mesh.elements[e + 4 + k])][c] =
            (corner(kEdges[k][0]) + corner(kEdges[k][1])) / 2;
      }
}

/// A box whose nodes are moved by a smooth, small, random map: no face is plane; edges of hex20 are curved,
/// those of tet10 straight, as its patch test asks.
inline Mesh distorted_box(ElementKind kind, std::array<double, 3> size, std::array<int, 3> divisions,
                          unsigned seed, double amount = 0.04) {
  Mesh mesh = box_mesh(size, divisions, kind);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  double phase[3][3];
  for (auto& row : phase)
    for (double& entry : row) entry = 3 * uniform(random);
  for (Point3& x : mesh.nodes) {
    const Point3 s = {x[0] / size[0], x[1] / size[1], x[2] / size[2]};
    for (std::size_t k = 0; k < 3; ++k)
      x[k] += amount * size[k] *
              (std::sin(2 * s[0] + phase[k][0]) + std::sin(3 * s[1] + phase[k][1]) +
               std::sin(2 * s[2] + phase[k][2]));
  }
  if (kind == ElementKind::tet10) straighten(mesh);
  return mesh;
}

/// f applied to every node: coordinates of the body.
template <class Map>
Eigen::VectorXd map_nodes(const Mesh& mesh, const Map& map) {
  Eigen::VectorXd q(static_cast<Eigen::Index>(3 * mesh.nodes.size()));
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    q.segment<3>(static_cast<Eigen::Index>(3 * i)) =
        map(Eigen::Vector3d(mesh.nodes[i][0], mesh.nodes[i][1], mesh.nodes[i][2]));
  return q;
}

inline Eigen::Matrix3d random_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
      .normalized()
      .toRotationMatrix();
}

/// F of the whole body, summed plainly.
inline Eigen::VectorXd body_force(const SolidGroup& group, const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                                  const Eigen::VectorXd& a) {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(q.size());
  const int n = group.local_coordinates();
  for (int e = 0; e < group.size(); ++e) {
    const Eigen::Map<const Eigen::VectorXi> where(group.coordinates(e), n);
    const Eigen::VectorXd qe = q(where), ve = v(where), ae = a(where);
    Eigen::VectorXd fe = Eigen::VectorXd::Zero(n);
    LocalResidual residual{fe.data(), nullptr, nullptr, nullptr};
    group.residual(e, {0, qe.data(), ve.data(), ae.data(), nullptr}, residual);
    force(where) += fe;
  }
  return force;
}

inline Eigen::VectorXd body_force(const SolidGroup& group, const Eigen::VectorXd& q) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(q.size());
  return body_force(group, q, zero, zero);
}

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct ElementTangent {
  RowMatrix force_q, force_v, force_a;
};

inline ElementTangent element_tangent(const SolidGroup& group, int e, const Eigen::VectorXd& q,
                                      const Eigen::VectorXd& v) {
  const int n = group.local_coordinates();
  const Eigen::Map<const Eigen::VectorXi> where(group.coordinates(e), n);
  const Eigen::VectorXd qe = q(where), ve = v(where), ae = Eigen::VectorXd::Zero(n);
  ElementTangent t{RowMatrix::Zero(n, n), RowMatrix::Zero(n, n), RowMatrix::Zero(n, n)};
  LocalTangent local{t.force_q.data(), t.force_v.data(), t.force_a.data(), nullptr,
                     nullptr,          nullptr,          nullptr};
  group.tangent(e, {0, qe.data(), ve.data(), ae.data(), nullptr}, local);
  return t;
}

/// The derivatives of the whole body, dense.
inline ElementTangent body_tangent(const SolidGroup& group, const Eigen::VectorXd& q,
                                   const Eigen::VectorXd& v) {
  ElementTangent sum{RowMatrix::Zero(q.size(), q.size()), RowMatrix::Zero(q.size(), q.size()),
                     RowMatrix::Zero(q.size(), q.size())};
  for (int e = 0; e < group.size(); ++e) {
    const Eigen::Map<const Eigen::VectorXi> where(group.coordinates(e), group.local_coordinates());
    const ElementTangent t = element_tangent(group, e, q, v);
    sum.force_q(where, where) += t.force_q;
    sum.force_v(where, where) += t.force_v;
    sum.force_a(where, where) += t.force_a;
  }
  return sum;
}

inline SolidGroup make_body(Mesh mesh, const Material& material, const SolidOptions& options = {}) {
  return SolidGroup("body", std::make_shared<const Mesh>(std::move(mesh)), material, options, 0);
}

}  // namespace mfs::dae::testing
