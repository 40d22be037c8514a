// One element in any state: derivatives, mass, damping, what happens to it when it is turned inside out.
#include <gmock/gmock.h>

#include <mfs/error.hpp>

#include "test/dae/fem/element_fixtures.hpp"

namespace mfs::dae::testing {
namespace {

using Case = std::tuple<ElementKind, MaterialLaw, double, MassKind>;

class Element : public ::testing::TestWithParam<Case> {
 protected:
  SolidGroup body() const {
    const auto [kind, law, beta, mass] = GetParam();
    SolidOptions options;
    options.mass = mass;
    options.damping_alpha = 3.0;
    options.damping_beta = beta;
    options.gravity = {1, -2, -9.81};
    return make_body(distorted_box(kind, {1.0, 0.8, 0.6}, {1, 1, 1}, 3), {law, 200.0, 0.3, 5.0}, options);
  }
};

// Central differences of `force` by every entry of `x`, of fourth order.
template <class Force>
RowMatrix differences(const Force& force, Eigen::VectorXd x) {
  RowMatrix result(x.size(), x.size());
  constexpr double h = 1e-3;
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    const double at = x(j);
    const auto shifted = [&](double by) {
      x(j) = at + by;
      return Eigen::VectorXd(force(x));
    };
    result.col(j) = (8 * (shifted(h) - shifted(-h)) - (shifted(2 * h) - shifted(-2 * h))) / (12 * h);
    x(j) = at;
  }
  return result;
}

TEST_P(Element, TangentsAreTheDerivativesOfTheForce) {
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-0.02, 0.02);
  const SolidGroup body = this->body();
  const Eigen::Matrix3d r = random_rotation(random);
  Eigen::VectorXd q =
      map_nodes(body.mesh(), [&](const Eigen::Vector3d& x) { return Eigen::Vector3d(r * x); });
  Eigen::VectorXd v(q.size()), a(q.size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    q(i) += uniform(random);
    v(i) = 50 * uniform(random);
    a(i) = 50 * uniform(random);
  }
  const RowMatrix by_q = differences([&](const Eigen::VectorXd& x) { return body_force(body, x, v, a); }, q);
  const RowMatrix by_v = differences([&](const Eigen::VectorXd& x) { return body_force(body, q, x, a); }, v);
  const RowMatrix by_a = differences([&](const Eigen::VectorXd& x) { return body_force(body, q, v, x); }, a);

  const ElementTangent tangent = body_tangent(body, q, v);
  EXPECT_LT((tangent.force_q - by_q).norm(), 1e-7 * by_q.norm());
  EXPECT_LT((tangent.force_v - by_v).norm(), 1e-7 * by_v.norm());
  EXPECT_LT((tangent.force_a - by_a).norm(), 1e-7 * by_a.norm());

  const LocalStructure s = body.structure();
  const auto fits = [](LocalStructure::Kind kind, const RowMatrix& m) {
    const RowMatrix diagonal = m.diagonal().asDiagonal();
    return kind == LocalStructure::Kind::dense ||
           (kind == LocalStructure::Kind::diagonal ? m == diagonal : m.isZero(0));
  };
  EXPECT_TRUE(fits(s.force_v, tangent.force_v));
  EXPECT_TRUE(fits(s.force_a, tangent.force_a));
}

INSTANTIATE_TEST_SUITE_P(All, Element,
                         ::testing::Combine(::testing::ValuesIn(kKinds),
                                            ::testing::Values(MaterialLaw::st_venant_kirchhoff,
                                                              MaterialLaw::neo_hookean),
                                            ::testing::Values(0.0, 0.01),
                                            ::testing::Values(MassKind::consistent, MassKind::lumped)),
                         [](const auto& info) {
                           return kind_name(std::get<0>(info.param)) +
                                  (std::get<1>(info.param) == MaterialLaw::neo_hookean ? "_neo_hookean"
                                                                                       : "_svk") +
                                  (std::get<2>(info.param) > 0 ? "_viscous" : "") +
                                  (std::get<3>(info.param) == MassKind::lumped ? "_lumped" : "_consistent");
                         });

/// Four edges whose middle nodes are less than a quarter of their length from one end: there x' of xi is
/// -0.1, and positive from -0.83 on, where all points of integration are.
TEST(FoldedElement, IsNamed) {
  Mesh mesh = distorted_box(ElementKind::hex20, {1, 1, 1}, {1, 1, 1}, 3);
  straighten(mesh);
  const auto& nodes = reference_nodes(ElementKind::hex20);
  for (const double middle : {0.3, 0.2}) {
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const double x = nodes[i][k];
        mesh.nodes[static_cast<std::size_t>(mesh.elements[i])][k] = k == 0 && x == 0 ? middle : 0.5 * (1 + x);
      }
    const auto make = [&] { make_body(mesh, {MaterialLaw::st_venant_kirchhoff, 200.0, 0.3, 5.0}); };
    if (middle > 0.25)
      EXPECT_NO_THROW(make());
    else
      EXPECT_THAT(make, ::testing::Throws<InvalidInput>(::testing::Property(
                            &InvalidInput::what, ::testing::HasSubstr("element 0, shape"))));
  }
}

/// Two edges of no length make a wedge of it: at their ends there is no volume, and inside there is.
TEST(FoldedElement, ACollapsedOneIsNone) {
  for (const ElementKind kind : {ElementKind::hex8, ElementKind::hex20}) {
    Mesh mesh = distorted_box(kind, {1, 1, 1}, {1, 1, 1}, 3);
    const auto& nodes = reference_nodes(kind);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto& [x, y, z] = nodes[i];
      mesh.nodes[static_cast<std::size_t>(mesh.elements[i])] = {(1 - y) * (1 + x) / 4, (1 + y) / 2,
                                                                (1 + z) / 2};
    }
    EXPECT_NO_THROW(make_body(mesh, {MaterialLaw::st_venant_kirchhoff, 200.0, 0.3, 5.0}));
  }
}

}  // namespace
}  // namespace mfs::dae::testing
