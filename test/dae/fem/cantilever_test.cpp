// A slender cantilever against beam theory, on meshes so coarse that an element that locks is far off;
// statics by Newton's method on the body's own residual and derivatives, frequencies from the dense
// eigenvalue problem.
//
// Tip deflection: w = P L^3 / (3 E I) + P L / (k A G), k = 5/6 (Timoshenko). Frequencies: Euler-Bernoulli's
//   omega_i = (b_i / L)^2 sqrt(E I / (rho A)),   b = 1.8751, 4.6941, 7.8548,
// times 1 - (b_i / L)^2 I / (2 A) (1 + E / (k G)), the first-order correction for rotary inertia and shear
// (Timoshenko 1921; Han, Benaroya and Wei, J. Sound Vib. 225 (1999) 935): 2.6 % for the third.
#include <gmock/gmock.h>

#include <Eigen/Sparse>

#include "dae/fem/surface_load.hpp"
#include "test/dae/fem/element_fixtures.hpp"

namespace mfs::dae::testing {
namespace {

constexpr double kLength = 2.0, kHeight = 0.1, kWidth = 0.08, kYoung = 2.1e11, kDensity = 7850;

struct Cantilever {
  Cantilever(Mesh beam, const Material& material, const SolidOptions& options = {})
      : body(make_body(std::move(beam), material, options)) {
    // The root may contract across, as the beam of the theory does: of its face, x is held everywhere, y and
    // z on one edge each.
    const Mesh& mesh = body.mesh();
    for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        if (mesh.nodes[i][0] > 0 || (k > 0 && mesh.nodes[i][k] > 0))
          free.push_back(static_cast<int>(3 * i + k));
    reference = map_nodes(body.mesh(), [](const Eigen::Vector3d& x) { return x; });
  }

  // Positions under a dead force at the end face, put on in equal steps.
  Eigen::VectorXd bend(const Eigen::Vector3d& force, int steps = 1) const {
    Eigen::VectorXd load = Eigen::VectorXd::Zero(reference.size()), q = reference;
    const std::vector<int>& face = body.mesh().node_sets.at("x1");
    const std::vector<double> shares = surface_shares(body.mesh(), face);
    for (std::size_t i = 0; i < face.size(); ++i) load.segment<3>(3 * face[i]) += shares[i] * force;
    for (int step = 1; step <= steps; ++step) find_equilibrium(load * step / steps, q);
    return q;
  }

  void find_equilibrium(const Eigen::VectorXd& load, Eigen::VectorXd& q) const {
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(q.size());
    for (int iteration = 0; iteration < 30; ++iteration) {
      const Eigen::SparseMatrix<double> k =
          RowMatrix(body_tangent(body, q, zero).force_q(free, free)).sparseView();
      const Eigen::VectorXd change =
          Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(k).solve((load - body_force(body, q))(free));
      q(free) += change;
      if (change.cwiseAbs().maxCoeff() < 1e-10) return;
    }
    ADD_FAILURE() << "no equilibrium found";
  }

  double tip(const Eigen::VectorXd& q, int direction) const {
    double sum = 0;
    const std::vector<int>& face = body.mesh().node_sets.at("x1");
    const std::vector<double> shares = surface_shares(body.mesh(), face);
    for (std::size_t i = 0; i < face.size(); ++i) sum += shares[i] * (q - reference)(3 * face[i] + direction);
    return sum;
  }

  Eigen::VectorXd frequencies() const {  // rad/s, ascending
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(reference.size());
    const ElementTangent t = body_tangent(body, reference, zero);
    const Eigen::MatrixXd k = t.force_q(free, free), m = t.force_a(free, free);
    return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(k, m, Eigen::EigenvaluesOnly)
        .eigenvalues()
        .cwiseSqrt();
  }

  SolidGroup body;
  std::vector<int> free;
  Eigen::VectorXd reference;
};

Mesh beam(ElementKind kind, int cells = 10) {
  return box_mesh({kLength, kWidth, kHeight}, {cells, 1, 1}, kind);
}

double inertia() {
  return kWidth * std::pow(kHeight, 3) / 12;
}

double timoshenko(double force, double poisson) {
  const double shear = kYoung / (2 * (1 + poisson));
  return force * std::pow(kLength, 3) / (3 * kYoung * inertia()) +
         force * kLength / (5.0 / 6 * kWidth * kHeight * shear);
}

// rad/s, for the root b_i and the height of the section in the plane of the motion.
double timoshenko_frequency(double root, double height) {
  const double radius = height / std::sqrt(12.0), wave = root / kLength, e_by_g = 2 * (1 + 0.3);
  return wave * wave * radius * std::sqrt(kYoung / kDensity) *
         (1 - wave * wave * radius * radius / 2 * (1 + e_by_g * 6 / 5));
}

class CantileverOf : public ::testing::TestWithParam<ElementKind> {};

TEST_P(CantileverOf, TipDeflection) {
  const Cantilever c(beam(GetParam()), {MaterialLaw::st_venant_kirchhoff, kYoung, 0.3, kDensity});
  const double force = 100;
  EXPECT_NEAR(c.tip(c.bend({0, 0, force}), 2), timoshenko(force, 0.3), 0.01 * timoshenko(force, 0.3));
}

TEST_P(CantileverOf, NearlyIncompressibleTipDeflection) {
  for (const MaterialLaw law : {MaterialLaw::st_venant_kirchhoff, MaterialLaw::neo_hookean}) {
    const Cantilever c(beam(GetParam()), {law, kYoung, 0.499, kDensity});
    const double force = 100;
    EXPECT_NEAR(c.tip(c.bend({0, 0, force}), 2), timoshenko(force, 0.499), 0.05 * timoshenko(force, 0.499));
  }
}

TEST_P(CantileverOf, FirstThreeFrequenciesInBothPlanes) {
  for (const MassKind mass : {MassKind::consistent, MassKind::lumped}) {
    SolidOptions options;
    options.mass = mass;
    const Cantilever c(beam(GetParam(), 16), {MaterialLaw::st_venant_kirchhoff, kYoung, 0.3, kDensity},
                       options);
    const Eigen::VectorXd computed = c.frequencies();
    constexpr double kTolerance[] = {0.005, 0.015, 0.03};
    int mode = 0;
    for (const double root : {1.87510407, 4.69409113, 7.85475744}) {
      const double tolerance = kTolerance[mode++];
      for (const double height : {kHeight, kWidth}) {
        const double expected = timoshenko_frequency(root, height);
        double nearest = 0;
        for (const double omega : computed.head(12))
          if (std::abs(omega - expected) < std::abs(nearest - expected)) nearest = omega;
        EXPECT_NEAR(nearest, expected, tolerance * expected) << "mode " << mode << " across " << height;
      }
    }
  }
}

// Large rotation: the tip moves by 0.67 L. Elastica of Bisshopp and Drucker (1945): for P L^2 / (E I) = 4 the
// tip falls by 0.6700 L and comes nearer by 0.3289 L.
TEST_P(CantileverOf, ElasticaUnderALargeForce) {
  const Mesh slender = box_mesh({2, 0.02, 0.02}, {16, 1, 1}, GetParam());
  const Cantilever c(slender, {MaterialLaw::st_venant_kirchhoff, kYoung, 0.0, kDensity});
  const double stiffness = kYoung * std::pow(0.02, 4) / 12;
  const Eigen::VectorXd q = c.bend({0, 0, 4 * stiffness / 4.0}, 12);
  EXPECT_NEAR(c.tip(q, 2) / 2, 0.6700, 0.01);
  EXPECT_NEAR(-c.tip(q, 0) / 2, 0.3289, 0.01);
}

INSTANTIATE_TEST_SUITE_P(Elements, CantileverOf, ::testing::ValuesIn(kKinds),
                         [](const auto& info) { return kind_name(info.param); });

}  // namespace
}  // namespace mfs::dae::testing
