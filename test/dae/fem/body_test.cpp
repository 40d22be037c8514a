// A flexible body as a whole: mass and inertia, gravity, damping, and what is refused.
#include <gmock/gmock.h>

#include <algorithm>
#include <mfs/error.hpp>
#include <mfs/version.hpp>

#include "test/dae/fem/element_fixtures.hpp"

namespace mfs::dae::testing {
namespace {

using ::testing::HasSubstr;

class Body : public ::testing::TestWithParam<std::tuple<ElementKind, MassKind>> {
 protected:
  ElementKind kind() const { return std::get<0>(GetParam()); }
  SolidOptions options() const {
    SolidOptions options;
    options.mass = std::get<1>(GetParam());
    return options;
  }
};

Eigen::VectorXd at_rest(const Mesh& mesh) {
  return map_nodes(mesh, [](const Eigen::Vector3d& x) { return x; });
}

// Force that an acceleration field takes, summed over the body with a weight.
template <class Acceleration, class Weight>
double inertia(const SolidGroup& body, const Acceleration& acceleration, const Weight& weight) {
  const Eigen::VectorXd q = at_rest(body.mesh()), a = map_nodes(body.mesh(), acceleration);
  return map_nodes(body.mesh(), weight).dot(body_force(body, q, Eigen::VectorXd::Zero(q.size()), a));
}

TEST_P(Body, HasTheMassAndInertiaOfABlock) {
  const SolidGroup body = make_body(box_mesh({2, 0.5, 0.4}, {6, 2, 2}, kind()),
                                    {MaterialLaw::neo_hookean, 1e3, 0.3, 5}, options());
  const double mass = 2 * 0.5 * 0.4 * 5;
  EXPECT_NEAR(body.mass(), mass, 1e-12);
  const auto along = [](int k) {
    return [k](const Eigen::Vector3d&) { return Eigen::Vector3d(Eigen::Vector3d::Unit(k)); };
  };
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(inertia(body, along(k), along(k)), mass, 1e-12);
  EXPECT_NEAR(inertia(body, along(0), along(1)), 0, 1e-13);
  const auto turn = [](const Eigen::Vector3d& x) {
    return Eigen::Vector3d(Eigen::Vector3d::UnitZ().cross(x));
  };
  const double about_z = mass * (4 + 0.25) / 3,
               lumping = std::get<1>(GetParam()) == MassKind::lumped ? 0.05 : 1e-12;
  EXPECT_NEAR(inertia(body, turn, turn), about_z, lumping * about_z);
}

TEST_P(Body, FallsFreelyAndIsHeldByItsWeight) {
  SolidOptions heavy = options();
  heavy.gravity = {1, 2, -9.81};
  const Mesh mesh = distorted_box(kind(), {1, 0.8, 0.6}, {2, 2, 2}, 5);
  const SolidGroup body = make_body(mesh, {}, heavy);
  const Eigen::Vector3d g(1, 2, -9.81);
  const Eigen::VectorXd q = at_rest(mesh), zero = Eigen::VectorXd::Zero(q.size());
  const Eigen::VectorXd falling = map_nodes(mesh, [&](const Eigen::Vector3d&) { return g; });
  const double weight = body.mass() * g.norm();
  EXPECT_LT(body_force(body, q, zero, falling).cwiseAbs().maxCoeff(),
            2e-3);  // rounding: 2.1e11 Pa * 1e-14 m^2
  Eigen::Vector3d held = Eigen::Vector3d::Zero();
  const Eigen::VectorXd force = body_force(body, q, zero, zero);
  for (Eigen::Index i = 0; i < force.size(); i += 3) held += force.segment<3>(i);
  EXPECT_LT((held + body.mass() * g).norm(), 1e-6 * weight);
}

TEST_P(Body, DampingIsProportionalForSmallStrains) {
  SolidOptions damped = options();
  damped.damping_alpha = 0.7;
  damped.damping_beta = 0.02;
  const Mesh mesh = distorted_box(kind(), {1, 0.8, 0.6}, {2, 1, 1}, 6);
  const SolidGroup body = make_body(mesh, {MaterialLaw::neo_hookean, 1e3, 0.3, 5}, damped);
  const Eigen::VectorXd q = at_rest(mesh), zero = Eigen::VectorXd::Zero(q.size());
  const Eigen::VectorXd v = Eigen::VectorXd::Random(q.size());
  const ElementTangent t = body_tangent(body, q, zero);
  const Eigen::VectorXd expected = 0.7 * t.force_a * v + 0.02 * t.force_q * v;
  EXPECT_LT((body_force(body, q, v, zero) - expected).norm(), 1e-11 * expected.norm());
}

INSTANTIATE_TEST_SUITE_P(All, Body,
                         ::testing::Combine(::testing::ValuesIn(kKinds),
                                            ::testing::Values(MassKind::consistent, MassKind::lumped)),
                         [](const auto& info) {
                           return kind_name(std::get<0>(info.param)) +
                                  (std::get<1>(info.param) == MassKind::lumped ? "_lumped" : "_consistent");
                         });

// Viscous stress takes energy out of any motion, however large the deformation.
TEST(Viscosity, NeverGivesEnergy) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  SolidOptions damped;
  damped.damping_beta = 0.1;
  for (const ElementKind kind : kKinds) {
    const Mesh mesh = distorted_box(kind, {1, 0.8, 0.6}, {1, 1, 1}, 6);
    const SolidGroup body = make_body(mesh, {MaterialLaw::neo_hookean, 100, 0.3, 5}, damped);
    Eigen::VectorXd q = at_rest(mesh), v(q.size());
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(q.size());
    for (int trial = 0; trial < 20; ++trial) {
      for (Eigen::Index i = 0; i < q.size(); ++i) {
        q(i) += 0.002 * uniform(random);
        v(i) = uniform(random);
      }
      EXPECT_GT(v.dot(body_force(body, q, v, zero) - body_force(body, q, zero, zero)), 0);
    }
  }
}

TEST(Solid, InsideOutIsNotANumber) {
  for (const ElementKind kind : kKinds)
    for (const MaterialLaw law : {MaterialLaw::st_venant_kirchhoff, MaterialLaw::neo_hookean}) {
      const Mesh mesh = box_mesh({1, 1, 1}, {1, 1, 1}, kind);
      const SolidGroup body = make_body(mesh, {law, 100, 0.3, 5});
      const Eigen::VectorXd mirrored =
          map_nodes(mesh, [](const Eigen::Vector3d& x) { return Eigen::Vector3d(x(0), x(1), -x(2)); });
      EXPECT_FALSE(body_force(body, mirrored).allFinite());
      EXPECT_FALSE(
          element_tangent(body, 0, mirrored, Eigen::VectorXd::Zero(mirrored.size())).force_q.allFinite());
    }
}

TEST(Solid, DerivativesAreIndependentOfWhichAreAskedFor) {
  SolidOptions damped;
  damped.damping_beta = 0.1;
  const Mesh mesh = distorted_box(ElementKind::hex8, {1, 1, 1}, {1, 1, 1}, 2);
  const SolidGroup body = make_body(mesh, {MaterialLaw::neo_hookean, 100, 0.3, 5}, damped);
  const Eigen::VectorXd q = at_rest(mesh), v = Eigen::VectorXd::Random(q.size());
  const ElementTangent all = element_tangent(body, 0, q, v);
  const Eigen::Map<const Eigen::VectorXi> where(body.coordinates(0), 24);
  const Eigen::VectorXd qe = q(where), ve = v(where);
  const RowMatrix zero = RowMatrix::Zero(24, 24);
  for (const Block block : {Block::force_q, Block::force_v, Block::force_a}) {
    RowMatrix by_q = zero, by_v = zero, by_a = zero;
    LocalTangent ask{by_q.data(), by_v.data(), by_a.data(), nullptr, nullptr, nullptr, nullptr, {block}};
    body.tangent(0, {0, qe.data(), ve.data(), ve.data(), nullptr}, ask);
    EXPECT_EQ(by_q, block == Block::force_q ? all.force_q : zero);
    EXPECT_EQ(by_v, block == Block::force_v ? all.force_v : zero);
    EXPECT_EQ(by_a, block == Block::force_a ? all.force_a : zero);
  }
}

std::string refusal(const Mesh& mesh, const Material& material, const SolidOptions& options = {}) {
  try {
    make_body(mesh, material, options);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Solid, HasNoForceOnADeviceThatIsNotThere) {
  const std::vector<Backend> usable = backends();
  if (std::count(usable.begin(), usable.end(), Backend::cuda) > 0) GTEST_SKIP() << "there is one";
  const SolidGroup body = make_body(box_mesh({1, 1, 1}, {1, 1, 1}, ElementKind::hex8), {});
  EXPECT_THROW((void)body.device_force(body.local_coordinates(), 1), BackendError);
}

// Whatever it is turned by.
TEST(Solid, TellsTheLeastStretchOfAnElement) {
  const auto mesh = std::make_shared<Mesh>(box_mesh({2, 1, 1}, {1, 1, 1}, ElementKind::hex20));
  const SolidGroup body("bar", mesh, {MaterialLaw::st_venant_kirchhoff, 1, 0.3, 1}, {}, 0);
  std::vector<double> q(static_cast<std::size_t>(body.local_coordinates()));
  for (std::size_t i = 0; i < q.size() / 3; ++i) {
    const auto& node = mesh->nodes[static_cast<std::size_t>(mesh->elements[i])];
    const double x = 0.4 * node[0], y = 1.5 * node[1];
    q[3 * i] = 0.6 * x - 0.8 * y;
    q[3 * i + 1] = 0.8 * x + 0.6 * y;
    q[3 * i + 2] = node[2];
  }
  EXPECT_NEAR(body.least_stretch(0, q.data()), 0.4, 1e-12);
}

TEST(Solid, RefusesWhatMakesNoSense) {
  const Mesh box = box_mesh({1, 1, 1}, {2, 1, 1}, ElementKind::hex8);
  const auto law = MaterialLaw::st_venant_kirchhoff;
  EXPECT_EQ(refusal(box, {}), "accepted");
  EXPECT_THAT(refusal(box, {law, 0, 0.3, 1}), HasSubstr("body body, young"));
  EXPECT_THAT(refusal(box, {law, 1, 0.5, 1}), HasSubstr("body body, poisson"));
  EXPECT_THAT(refusal(box, {law, 1, std::nan(""), 1}), HasSubstr("body body, poisson"));
  EXPECT_THAT(refusal(box, {law, 1, 0.3, -1}), HasSubstr("body body, density"));
  SolidOptions options;
  options.damping_alpha = -1;
  EXPECT_THAT(refusal(box, {}, options), HasSubstr("body body, damping_alpha"));
  options = {};
  options.damping_beta = -1;
  EXPECT_THAT(refusal(box, {}, options), HasSubstr("body body, damping_beta"));
  Mesh broken = box;
  broken.elements.pop_back();
  EXPECT_THAT(refusal(broken, {}), HasSubstr("body body, elements"));
  EXPECT_THAT(refusal({}, {}), HasSubstr("body body, elements"));
  broken = box;
  broken.elements[3] = 99;
  EXPECT_THAT(refusal(broken, {}), HasSubstr("body body, elements"));
  broken = box;
  std::swap(broken.elements[8], broken.elements[9]);
  EXPECT_THAT(refusal(broken, {}), HasSubstr("body body, element 1, shape"));
}

}  // namespace
}  // namespace mfs::dae::testing
