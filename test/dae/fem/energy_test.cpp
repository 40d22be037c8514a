// Energy, power and motion of flexible bodies as a whole, where they are known.
#include <gmock/gmock.h>

#include <cmath>

#include "dae/fem/body_motion.hpp"
#include "test/dae/fem/element_fixtures.hpp"

namespace mfs::dae::testing {
namespace {

using Eigen::Vector3d;

using Case = std::tuple<ElementKind, MaterialLaw>;
class BodyOf : public ::testing::TestWithParam<Case> {
 protected:
  const ElementKind kind = std::get<0>(GetParam());
  const Material material{std::get<1>(GetParam()), 2e5, 0.3, 1200};
};

// Sums over the elements, by plain loops.
template <class Of>
auto sum_over(const SolidGroup& body, const Eigen::VectorXd& q, const Eigen::VectorXd& v, const Of& of) {
  decltype(of(0, LocalState{})) sum{};
  for (int e = 0; e < body.size(); ++e) {
    std::vector<double> local_q, local_v;
    for (int k = 0; k < body.local_coordinates(); ++k) {
      local_q.push_back(q[body.coordinates(e)[k]]);
      local_v.push_back(v[body.coordinates(e)[k]]);
    }
    const std::vector<double> rest(local_q.size());
    sum += of(e, LocalState{0.0, local_q.data(), local_v.data(), rest.data(), nullptr});
  }
  return sum;
}

// By differences of the energy along a direction: the power of the internal forces.
TEST_P(BodyOf, EnergyGrowsByThePowerOfTheForces) {
  const Mesh mesh = distorted_box(kind, {1.0, 0.8, 0.6}, {2, 1, 1}, 4);
  const SolidGroup body = make_body(mesh, material);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> small(-0.02, 0.02);
  Eigen::VectorXd q =
      map_nodes(mesh, [](const Vector3d& x) { return Vector3d(1.1 * x[0], x[1] + 0.2 * x[0], x[2]); });
  Eigen::VectorXd v(q.size());
  for (double& x : q) x += small(random);
  for (double& x : v) x = small(random);
  const auto energy = [&](const Eigen::VectorXd& at) {
    return sum_over(body, at, v, [&](int e, const LocalState& state) { return body.energy(e, state); });
  };
  struct Sum {
    double power = 0;
    Sum& operator+=(const Sum& other) {
      power += other.power;
      return *this;
    }
  };
  const double power = sum_over(body, q, v, [&](int e, const LocalState& state) {
                         std::vector<double> force(static_cast<std::size_t>(body.local_coordinates()));
                         LocalResidual residual{force.data(), nullptr, nullptr, nullptr};
                         body.residual(e, state, residual);  // at rest but for v: no inertia
                         Sum sum;
                         for (std::size_t k = 0; k < force.size(); ++k) sum.power += force[k] * state.v[k];
                         return sum;
                       }).power;
  const double h = 1e-4;
  const double difference = (energy(q + h * v).elastic - energy(q - h * v).elastic) / (2 * h);
  EXPECT_NEAR(difference, power, 1e-6 * std::abs(power));
  EXPECT_GT(energy(q).elastic, 0);
}

// Uniform strain E: V (lambda / 2 tr(E)^2 + mu E : E), for both laws as long as E is small.
TEST_P(BodyOf, EnergyOfUniformStrain) {
  const Mesh mesh = box_mesh({1.0, 0.8, 0.6}, {2, 2, 1}, kind);
  const SolidGroup body = make_body(mesh, material);
  const double e = 1e-5;
  const Eigen::VectorXd q =
      map_nodes(mesh, [&](const Vector3d& x) { return Vector3d((1 + e) * x[0], (1 - 2 * e) * x[1], x[2]); });
  const double stored =
      sum_over(body, q, 0 * q, [&](int i, const LocalState& s) { return body.energy(i, s); }).elastic;
  const double expected =
      0.48 * (0.5 * material.lame_lambda() * e * e + material.shear_modulus() * (e * e + 4 * e * e));
  EXPECT_NEAR(stored, expected, 1e-4 * expected);
}

// Stretched evenly at rate s along x from rest: beta (lambda + 2 mu) s^2 V; the drag takes alpha times twice
// the kinetic energy, here s^2 int x^2 dm / 2.
TEST_P(BodyOf, DampersTakeWhatTheirViscositySays) {
  const Mesh mesh = box_mesh({1.0, 0.8, 0.6}, {2, 1, 1}, kind);
  SolidOptions options;
  options.damping_alpha = 3;
  options.damping_beta = 1e-2;
  const SolidGroup body("body", std::make_shared<const Mesh>(mesh), material, options, 0);
  const double rate = 0.7, volume = 0.48;
  const Eigen::VectorXd q = map_nodes(mesh, [](const Vector3d& x) { return x; });
  const Eigen::VectorXd v = map_nodes(mesh, [&](const Vector3d& x) { return Vector3d(rate * x[0], 0, 0); });
  const double kinetic = 0.5 * rate * rate * 1200 * volume / 3;
  const double viscous =
      1e-2 * (material.lame_lambda() + 2 * material.shear_modulus()) * rate * rate * volume;
  const Power power = sum_over(body, q, v, [&](int e, const LocalState& s) { return body.power(e, s); });
  EXPECT_NEAR(power.dissipated, viscous + 3 * 2 * kinetic, 1e-9 * viscous);
  EXPECT_EQ(power.input, 0);
  const Energy energy = sum_over(body, q, v, [&](int e, const LocalState& s) { return body.energy(e, s); });
  EXPECT_NEAR(energy.kinetic, kinetic, 1e-9 * kinetic);
}

// A rigid motion has its own centre, rotation, angular velocity and acceleration, with both masses.
TEST_P(BodyOf, MovesAsARigidOneWhereItDoes) {
  const Mesh mesh = box_mesh({1.0, 0.8, 0.6}, {2, 2, 1}, kind);
  std::mt19937 random(8);
  const Eigen::Matrix3d r = random_rotation(random);
  const Vector3d place(1e3, -2, 3), velocity(3, 1, -2), acceleration(1, 2, 3), w(4, -5, 6), up(-7, 8, 9);
  for (const MassKind mass : {MassKind::consistent, MassKind::lumped}) {
    SolidOptions options;
    options.mass = mass;
    const SolidGroup body("body", std::make_shared<const Mesh>(mesh), material, options, 0);
    const auto moved = [&](const auto& of_arm) {
      return map_nodes(mesh, [&](const Vector3d& x) { return Vector3d(of_arm(Vector3d(r * x))); });
    };
    const Eigen::VectorXd q = moved([&](const Vector3d& s) -> Vector3d { return place + s; });
    const Eigen::VectorXd v = moved([&](const Vector3d& s) -> Vector3d { return velocity + w.cross(s); });
    const Eigen::VectorXd a = moved(
        [&](const Vector3d& s) -> Vector3d { return acceleration + up.cross(s) + w.cross(w.cross(s)); });
    const BodyMotion motion = body_motion(body, q.data(), v.data(), a.data(), 3);
    const Vector3d arm = motion.position - place;
    EXPECT_LT((arm - r * Vector3d(0.5, 0.4, 0.3)).norm(), mass == MassKind::consistent ? 1e-9 : 0.1);
    EXPECT_LT((motion.velocity - velocity - w.cross(arm)).norm(), 1e-9);
    EXPECT_LT((motion.acceleration - acceleration - up.cross(arm) - w.cross(w.cross(arm))).norm(), 1e-8);
    EXPECT_LT((motion.rotation - r).norm(), 1e-9);
    EXPECT_LT((motion.angular_velocity - w).norm(), 1e-9);
    EXPECT_LT((motion.angular_acceleration - up).norm(), 1e-8);
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, BodyOf,
    ::testing::Combine(::testing::Values(ElementKind::hex8, ElementKind::hex20, ElementKind::tet10),
                       ::testing::Values(MaterialLaw::st_venant_kirchhoff, MaterialLaw::neo_hookean)));

}  // namespace
}  // namespace mfs::dae::testing
