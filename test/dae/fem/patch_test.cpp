// States in which the answer is known in closed form: affine deformations of a distorted patch, rigid
// motions.
#include <gmock/gmock.h>

#include "test/dae/fem/element_fixtures.hpp"

namespace mfs::dae::testing {
namespace {

using Case = std::tuple<ElementKind, MaterialLaw>;

class Patch : public ::testing::TestWithParam<Case> {
 protected:
  Material material() const { return {std::get<1>(GetParam()), 2.1e11, 0.3, 7850}; }
  Mesh mesh() const { return distorted_box(std::get<0>(GetParam()), {1.0, 0.8, 0.6}, {3, 3, 3}, 7); }
};

// Second Piola-Kirchhoff stress of an affine deformation, by plain tensor algebra.
Eigen::Matrix3d stress(const Material& m, const Eigen::Matrix3d& f) {
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity(), c = f.transpose() * f, e = 0.5 * (c - one);
  if (m.law == MaterialLaw::st_venant_kirchhoff)
    return m.lame_lambda() * e.trace() * one + 2 * m.shear_modulus() * e;
  const Eigen::Matrix3d inverse = c.inverse();
  return m.shear_modulus() * (one - inverse) + m.lame_lambda() * std::log(f.determinant()) * inverse;
}

TEST_P(Patch, AffineDeformationLeavesInnerNodesInEquilibrium) {
  const Mesh mesh = this->mesh();
  const SolidGroup body = make_body(mesh, material());
  std::mt19937 random(11);
  std::normal_distribution<double> normal(0, 0.05);
  for (int trial = 0; trial < 3; ++trial) {
    Eigen::Matrix3d stretch;
    for (double& entry : stretch.reshaped()) entry = normal(random);
    const Eigen::Matrix3d f = random_rotation(random) * (Eigen::Matrix3d::Identity() + stretch);
    const Eigen::VectorXd q =
        map_nodes(mesh, [&](const Eigen::Vector3d& x) { return Eigen::Vector3d(f * x); });
    const Eigen::VectorXd force = body_force(body, q);

    // Traction on the whole boundary: sum of f_i X_i^T is the volume times the first Piola-Kirchhoff stress.
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
    const Mesh straight = box_mesh({1.0, 0.8, 0.6}, {3, 3, 3}, mesh.kind);
    double inner = 0, largest = force.cwiseAbs().maxCoeff();
    for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
      const Eigen::Vector3d fi = force.segment<3>(static_cast<Eigen::Index>(3 * i));
      moment += fi * Eigen::Map<const Eigen::Vector3d>(mesh.nodes[i].data()).transpose();
      const Point3& s = straight.nodes[i];
      const bool boundary = s[0] < 1e-9 || s[0] > 1 - 1e-9 || s[1] < 1e-9 || s[1] > 0.8 - 1e-9 ||
                            s[2] < 1e-9 || s[2] > 0.6 - 1e-9;
      if (!boundary) inner = std::max(inner, fi.cwiseAbs().maxCoeff());
    }
    EXPECT_LT(inner, 1e-10 * largest);
    const double volume = body.mass() / 7850;
    const Eigen::Matrix3d expected = volume * f * stress(material(), f);
    EXPECT_LT((moment - expected).norm(), 1e-10 * expected.norm());
  }
}

TEST_P(Patch, RigidMotionsAreFreeOfForce) {
  const Mesh mesh = this->mesh();
  SolidOptions damped;
  damped.damping_beta = 1e-4;
  const SolidGroup body = make_body(mesh, material(), damped);
  std::mt19937 random(5);
  for (int trial = 0; trial < 3; ++trial) {
    const Eigen::Matrix3d r = random_rotation(random);
    const Eigen::Vector3d shift(0.3, -2, 1), spin = 10 * Eigen::Vector3d::Random();
    const Eigen::VectorXd q =
        map_nodes(mesh, [&](const Eigen::Vector3d& x) { return Eigen::Vector3d(r * x + shift); });
    const Eigen::VectorXd v =
        map_nodes(mesh, [&](const Eigen::Vector3d& x) { return Eigen::Vector3d(spin.cross(r * x)); });
    const Eigen::VectorXd force = body_force(body, q, v, Eigen::VectorXd::Zero(q.size()));
    EXPECT_LT(force.cwiseAbs().maxCoeff(), 2.1e11 * 1e-13);  // of the force that a strain of 1 takes on 1 m^2
  }
}

TEST_P(Patch, OneElementHasSixFreeMotions) {
  const Mesh mesh = distorted_box(std::get<0>(GetParam()), {1.0, 0.8, 0.6}, {1, 1, 1}, 3);
  const SolidGroup body = make_body(mesh, material());
  const Eigen::VectorXd q = map_nodes(mesh, [](const Eigen::Vector3d& x) { return x; });
  const Eigen::MatrixXd k = element_tangent(body, 0, q, Eigen::VectorXd::Zero(q.size())).force_q;
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k).eigenvalues();
  const double most = values.maxCoeff();
  EXPECT_LT(values.head(6).cwiseAbs().maxCoeff(), 1e-11 * most);
  EXPECT_GT(values(6), 1e-4 * most);
}

INSTANTIATE_TEST_SUITE_P(Elements, Patch,
                         ::testing::Combine(::testing::ValuesIn(kKinds),
                                            ::testing::Values(MaterialLaw::st_venant_kirchhoff,
                                                              MaterialLaw::neo_hookean)),
                         [](const auto& info) {
                           return kind_name(std::get<0>(info.param)) +
                                  (std::get<1>(info.param) == MaterialLaw::neo_hookean ? "_neo_hookean"
                                                                                       : "_svk");
                         });

}  // namespace
}  // namespace mfs::dae::testing
