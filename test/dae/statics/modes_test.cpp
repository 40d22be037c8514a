// Frequencies and damping against closed formulas, and against dense eigenvalues of the reduced matrices.
#include "dae/statics/modes.hpp"

#include <gmock/gmock.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include <mfs/error.hpp>

#include "dae/model/model_library.hpp"
#include "dae/statics/equilibrium.hpp"
#include "test/dae/mechanics/dense.hpp"
#include "test/dae/statics/models.hpp"

namespace mfs::dae {
namespace {

const double kPi = std::acos(-1.0);

class Modes : public testing::Test {
 protected:
  void find(const Json& json, int count) {
    model_ = make_model(json, "", 1);
    model_.integrator.threads = 1;
    state_ = find_equilibrium(*model_.system, model_.integrator, {0.0, model_.q0, model_.v0, {}, {}});
    modes_ = find_modes(*model_.system, state_, count, 1);
  }
  std::complex<double> x(std::size_t mode, const std::string& name) const {
    return modes_.at(mode).x.at(test::coordinate(*model_.system, name));
  }
  void expect_frequency(std::size_t mode, double hertz, double tolerance) const {
    EXPECT_NEAR(natural_frequency(modes_.at(mode)), hertz, tolerance * hertz) << mode;
    EXPECT_NEAR(damping_ratio(modes_.at(mode)), 0.0, 1e-6) << mode;
  }
  MultibodyModel model_;
  State state_;
  std::vector<Mode> modes_;
};

TEST_F(Modes, OfACompoundPendulum) {
  find(test::pendulum(-1.0), 5);
  ASSERT_EQ(modes_.size(), 1U);
  expect_frequency(0, std::sqrt(2 * 9.81 * 0.6 / 0.96) / (2 * kPi), 1e-9);
  // It swings across its length, and turns by half of that change of e3 and e0.
  EXPECT_NEAR(std::abs(x(0, "bar.x")), 1.0, 1e-9);
  EXPECT_NEAR(std::abs(x(0, "bar.y")), 0.0, 1e-7);
}

// Of the upright bicycle that stands: the published growth of its falling (Meijaard et al. 2007, table 2).
TEST_F(Modes, OfABicycleThatStands) {
  Json json = Json::parse(find_library_model("bicycle")->text);
  json["parameters"] = {{"speed", 0.0}, {"lean_rate", 0.0}};
  model_ = make_model(json, "", 1);
  Integrator integrator(*model_.system, model_.integrator);
  struct First : Observer {
    void output(const State& state) override { taken = state; }
    State taken;
  } first;
  integrator.run(0.0, model_.q0, model_.v0, 1e-3, {0.0}, first);
  std::vector<double> growth;
  for (const Mode& mode : find_modes(*model_.system, first.taken, 10, 1))
    if (std::abs(mode.s) > 0.1) {
      EXPECT_NEAR(mode.s.imag(), 0.0, 1e-6);
      growth.push_back(mode.s.real());
    }
  EXPECT_THAT(growth, testing::ElementsAre(testing::DoubleNear(3.13164324790656, 1e-6),
                                           testing::DoubleNear(5.53094371765393, 1e-6)));
}

TEST_F(Modes, OfAPendulumThatStands) {
  // With the weight pulling up it is the same as upside down.
  Json json = test::pendulum(-kPi / 2);
  const MultibodyModel model = make_model(json, "", 1);
  State state{0.0, model.q0, model.v0, {}, {}};
  state = find_equilibrium(*model.system, model.integrator, state);
  json["gravity"] = {0, 9.81, 0};
  const MultibodyModel standing = make_model(json, "", 1);
  for (double& lambda : state.lambda) lambda = -lambda;
  const std::vector<Mode> modes = find_modes(*standing.system, state, 3, 1);
  ASSERT_EQ(modes.size(), 1U);
  EXPECT_NEAR(modes[0].s.real(), std::sqrt(2 * 9.81 * 0.6 / 0.96), 1e-8);
  EXPECT_NEAR(damping_ratio(modes[0]), -1.0, 1e-12);
}

/// Springs and dampers on measures, which have no inertia of their own.
TEST_F(Modes, OfADampedTorsionPendulum) {
  Json json = test::pendulum(0);
  json["gravity"] = {0, 0, 0};
  json["forces"]["coil"] = {
      {"type", "rotational_spring"}, {"joint", "hinge"}, {"stiffness", 24}, {"damping", 1.2}};
  find(json, 5);
  ASSERT_EQ(modes_.size(), 1U);
  // 0.96 s^2 + 1.2 s + 24 = 0
  EXPECT_NEAR(modes_[0].s.real(), -1.2 / 1.92, 1e-9);
  EXPECT_NEAR(modes_[0].s.imag(), std::sqrt(25 - 0.625 * 0.625), 1e-9);
  EXPECT_NEAR(damping_ratio(modes_[0]), 0.125, 1e-9);
}

TEST_F(Modes, OfAControllerThatDependsOnOthersAndOfACreepingOne) {
  // Slider and wheel: 2 x'' = -50 x + 3 a', 0.96 a'' = -8 a' - x.
  Json json = test::pendulum(0);
  json["gravity"] = {0, 0, 0};
  json["bodies"]["slider"] = {{"type", "rigid"}, {"mass", 2}, {"inertia", {1, 1, 1}}};
  json["joints"]["guide"] = {
      {"type", "translational"}, {"a", "ground"}, {"b", "slider"}, {"point", {0, 0, 0}}, {"axis", {1, 0, 0}}};
  json["forces"]["push"] = {
      {"type", "actuator"}, {"joint", "guide"}, {"force", "-50*guide.travel + 3*hinge.angle_rate"}};
  json["forces"]["brake"] = {
      {"type", "actuator"}, {"joint", "hinge"}, {"torque", "-8*hinge.angle_rate - guide.travel"}};
  find(json, 10);
  Eigen::Matrix4d a;  // of x, a, x', a'
  a << 0, 0, 1, 0, 0, 0, 0, 1, -25, 0, 0, 1.5, -1 / 0.96, 0, 0, -8 / 0.96;
  const Eigen::EigenSolver<Eigen::Matrix4d> solver(a, false);
  for (const std::complex<double> s : solver.eigenvalues()) {
    if (s.imag() < 0) continue;
    const auto is_near = [&](const Mode& mode) { return std::abs(mode.s - s) < 1e-6; };
    EXPECT_TRUE(std::any_of(modes_.begin(), modes_.end(), is_near)) << s;
  }
  EXPECT_EQ(modes_.size(), 3U);  // swinging, creeping, and the wheel where it likes
}

/// Euler and Bernoulli: (k L)^2 / (2 pi L^2) sqrt(E I / (rho A)), a square section: each bending twice. The
/// first longitudinal one: sqrt(E / rho) / (4 L).
TEST_F(Modes, OfASquareCantilever) {
  find(test::cantilever(0.02, 0.02, 24), 7);
  ASSERT_EQ(modes_.size(), 7U);
  const double bending = std::sqrt(2e11 / 8000 / 12) * 0.02 / (2 * kPi);
  const double numbers[] = {1.8751040687, 4.6940911330, 7.8547574382};
  for (std::size_t i = 0; i < 6; ++i) expect_frequency(i, numbers[i / 2] * numbers[i / 2] * bending, 0.01);
  // The two of a pair are different motions, one of which is not the other times a number.
  for (std::size_t i = 0; i < 6; i += 2) {
    const auto of = [&](std::size_t mode) {
      const auto& shape = modes_[mode].x;
      return Eigen::Map<const Eigen::VectorXcd>(shape.data(), static_cast<Eigen::Index>(shape.size()))
          .normalized()
          .eval();
    };
    EXPECT_LT(std::abs(of(i).dot(of(i + 1))), 0.99) << i;
  }
}

TEST_F(Modes, OfAFreeBeam) {
  Json json = test::cantilever(0.03, 0.02, 24);
  json["motions"] = Json::object();
  find(json, 9);
  ASSERT_EQ(modes_.size(), 9U);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_LT(natural_frequency(modes_[i]), 0.01) << i;
  const double bending = std::sqrt(2e11 / 8000 / 12) / (2 * kPi);
  expect_frequency(6, 22.3733 * 0.02 * bending, 0.01);
  expect_frequency(7, 22.3733 * 0.03 * bending, 0.01);
  expect_frequency(8, 61.6728 * 0.02 * bending, 0.01);
}

/// A block on the beam's tip, under its weight, with damping: all modes beside those of the dense pencil in
/// the null space of Phi_q, by another method (QZ).
TEST_F(Modes, OfALargeSystemAreThoseOfDenseMatrices) {
  Json json = test::cantilever(0.02, 0.03, 12);
  json["gravity"] = {0, -9.81, 0};
  json["bodies"]["beam"]["damping"] = {{"alpha", 2.0}, {"beta", 1e-4}};
  json["bodies"]["block"] = {
      {"type", "rigid"}, {"mass", 3}, {"inertia", {0.01, 0.02, 0.03}}, {"position", {1.05, 0, 0}}};
  json["joints"] = {
      {"pin",
       {{"type", "revolute"}, {"a", "beam:x1"}, {"b", "block"}, {"point", {1, 0, 0}}, {"axis", {0, 0, 1}}}}};
  json["forces"]["coil"] = {
      {"type", "rotational_spring"}, {"joint", "pin"}, {"stiffness", 40}, {"damping", 0.5}};
  find(json, 12);
  ASSERT_EQ(modes_.size(), 12U);
  const ConstrainedSystem& system = *model_.system;
  ASSERT_GT(system.coordinates() - system.constraints(), 150);  // not the reduced way
  Tangent tangent = make_tangent(system);
  system.evaluate({0.0, state_.q.data(), state_.v.data(), state_.a.data(), state_.lambda.data()}, tangent,
                  BlockSet::all());
  const auto dense = [&](Block b) { return test::dense(system.tangent_pattern()[b], tangent[b]); };
  const Eigen::MatrixXd basis = Eigen::FullPivLU<Eigen::MatrixXd>(dense(Block::position_q)).kernel();
  const Eigen::MatrixXd null = Eigen::HouseholderQR<Eigen::MatrixXd>(basis).householderQ() *
                               Eigen::MatrixXd::Identity(basis.rows(), basis.cols());
  const auto reduced = [&](Block b) -> Eigen::MatrixXd { return null.transpose() * dense(b) * null; };
  // Of 1 / s, as the largest of s are 1e6 times those looked for.
  const Eigen::FullPivLU<Eigen::MatrixXd> stiffness(reduced(Block::force_q));
  const Eigen::Index f = stiffness.rows();
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(2 * f, 2 * f);
  a.topLeftCorner(f, f) = -stiffness.solve(reduced(Block::force_v));
  a.topRightCorner(f, f) = -stiffness.solve(reduced(Block::force_a));
  a.bottomLeftCorner(f, f).setIdentity();
  std::vector<std::complex<double>> expected;
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(a, false);
  for (const std::complex<double> inverse : solver.eigenvalues())
    if (inverse.imag() <= 0) expected.push_back(1.0 / inverse);
  std::sort(expected.begin(), expected.end(), [](auto x, auto y) { return std::abs(x) < std::abs(y); });
  for (std::size_t i = 0; i < modes_.size(); ++i)
    EXPECT_LT(std::abs(modes_[i].s - expected[i]), 1e-6 * std::abs(expected[i])) << i << " " << expected[i];
}

/// Weights that slide along x, each on a spring to the one before, the first to the ground.
Json slides(const std::vector<double>& stiffness, const std::vector<double>& mass) {
  Json json{{"name", "slides"}, {"end", 1}, {"outputs", 1}};
  for (std::size_t i = 0; i < mass.size(); ++i) {
    const double x = static_cast<double>(i + 1);
    const std::string number = std::to_string(i), body = "b" + number;
    const std::string before = i == 0 ? "ground" : "b" + std::to_string(i - 1);
    const double inertia = 0.1 * mass[i];
    json["bodies"][body] = {{"type", "rigid"},
                            {"mass", mass[i]},
                            {"inertia", {inertia, inertia, inertia}},
                            {"position", {x, 0, 0}}};
    json["joints"]["j" + number] = {
        {"type", "translational"}, {"a", "ground"}, {"b", body}, {"point", {x, 0, 0}}, {"axis", {1, 0, 0}}};
    if (stiffness[i] == 0) continue;
    json["forces"]["s" + number] = {
        {"type", "spring_damper"},  {"a", before},          {"b", body},
        {"point_a", {x - 1, 0, 0}}, {"point_b", {x, 0, 0}}, {"stiffness", stiffness[i]}};
  }
  return json;
}

/// What is soft beside what is stiff, light beside heavy. Frequencies are those of the matrices of springs
/// and masses by mpmath 1.2, with 50 digits. K of the third case, as 1e9 + 1e-3, has 5 digits of 1e-3.
TEST_F(Modes, OfSoftSpringsBesideStiffOnes) {
  struct Case {
    std::vector<double> stiffness, mass, hertz;
    double tolerance;
  };
  for (const Case& c : std::vector<Case>{
           {{1, 1e8}, {1, 1e-8}, {0.159154942296, 15915494.3888}, 1e-7},
           {{1, 1e8}, {1, 1e-6}, {0.159154863514, 1591550.22669}, 1e-7},
           {{1e-3, 1e9}, {10, 1e-3}, {0.00159146985942, 159162.90064}, 1e-5},
           {{1, 1, 1}, {1e-6, 1, 1e6}, {9.18881288174e-05, 0.194924219259, 225.079107174}, 1e-8},
           {{1, 1e8, 1, 1e8},
            {1, 1e-6, 1e3, 1e-6},
            {0.0035583678266, 0.22510710611, 1591549.43171, 1591550.23465},
            1e-7}}) {
    find(slides(c.stiffness, c.mass), 10);
    ASSERT_EQ(modes_.size(), c.hertz.size());
    for (std::size_t i = 0; i < c.hertz.size(); ++i) {
      EXPECT_NEAR(natural_frequency(modes_[i]), c.hertz[i], c.tolerance * c.hertz[i]) << i;
      EXPECT_LT(modes_[i].rounding, 100 * c.tolerance) << i;
      EXPECT_LT(std::abs(natural_frequency(modes_[i]) / c.hertz[i] - 1), modes_[i].rounding + 1e-11) << i;
    }
  }
}

/// The same, not held to the ground: the one that is free is told from the others.
TEST_F(Modes, OfSoftSpringsBesideStiffOnesOfAFreeChain) {
  find(slides({0, 1, 1e8}, {1, 1, 1e-6}), 10);
  ASSERT_EQ(modes_.size(), 3U);
  EXPECT_GT(modes_[0].rounding, 0.1);
  expect_frequency(1, 0.22507902277, 1e-7);
  expect_frequency(2, 1591550.22669, 1e-8);
}

/// A block of steel on the ways of a heavy slide on a spring, whose first frequency is 27.6 kHz.
TEST_F(Modes, OfAStiffBlockOnASoftSpring) {
  for (const double mass : {1e8, 1e12}) {
    Json json = test::cantilever(0.02, 0.02, 2);
    json["bodies"]["beam"]["mesh"] = {{"generator", "box"},
                                      {"element", "hex20"},
                                      {"refine", 1},
                                      {"size", {0.02, 0.02, 0.02}},
                                      {"divisions", {2, 2, 2}}};
    json.erase("motions");
    json["bodies"]["slide"] = {{"type", "rigid"}, {"mass", mass}, {"inertia", {0.1, 0.1, 0.1}}};
    json["joints"]["bolt"] = {{"type", "fixed"}, {"a", "slide"}, {"b", "beam:x0"}, {"point", {0, 0, 0}}};
    json["joints"]["ways"] = {{"type", "translational"},
                              {"a", "ground"},
                              {"b", "slide"},
                              {"point", {0, 0, 0}},
                              {"axis", {1, 0, 0}}};
    json["forces"]["spring"] = {{"type", "translational_spring"}, {"joint", "ways"}, {"stiffness", 1e4}};
    find(json, 3);
    ASSERT_EQ(modes_.size(), 3U);
    ASSERT_GT(model_.system->coordinates() - model_.system->constraints(), 150);  // not the reduced way
    expect_frequency(0, std::sqrt(1e4 / (mass + 8000 * 8e-6)) / (2 * kPi), 3e-8);
    EXPECT_LT(modes_[0].rounding, 1e-6);
  }
}

// Arnoldi's method is left in the middle: nothing has been found by then.
TEST_F(Modes, AreGivenUpWhereThatIsAskedFor) {
  const MultibodyModel model = make_model(test::cantilever(0.1, 0.05, 20), "", 1);
  State state = find_equilibrium(*model.system, model.integrator, {0.0, model.q0, model.v0, {}, {}});
  int asked = 0;
  const auto go_on = [&] { return ++asked < 5; };
  EXPECT_THAT(find_modes(*model.system, state, 3, 1, Damping::as_it_is, go_on), testing::IsEmpty());
  EXPECT_EQ(asked, 5);
}

/// Of cranks of 0.3 m and a coupler of 1 m, rods of 1 kg, in a plane that is oblique to all axes. Three
/// constraints are redundant wherever it is; what of the mode moves with another phase is rounding, which
/// would lead to where they are not.
TEST_F(Modes, OfAParallelogramInAnObliquePlane) {
  const double r = 0.3, base = 1.0, g = 9.81;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(2.3, Eigen::Vector3d(-1.1, 0.6, -1.3).normalized()));
  const auto turned = [&](double x, double y, double z) {
    const Eigen::Vector3d there = turn * Eigen::Vector3d(x, y, z);
    return Json{there[0], there[1], there[2]};
  };
  const auto rod = [&](double x, double y, double length, double angle) {
    const Eigen::AngleAxisd rotation(turn * Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
    const double across = length * length / 12;
    return Json{{"type", "rigid"},
                {"mass", 1},
                {"inertia", {1e-3 * across, across, across}},
                {"position", turned(x, y, 0)},
                {"rotation",
                 {{"axis", {rotation.axis()[0], rotation.axis()[1], rotation.axis()[2]}},
                  {"angle", rotation.angle()}}}};
  };
  const auto hinge = [&](const char* a, const char* b, double x, double y) {
    return Json{
        {"type", "revolute"}, {"a", a}, {"b", b}, {"point", turned(x, y, 0)}, {"axis", turned(0, 0, 1)}};
  };
  Json json{{"name", "parallelogram"}, {"end", 1}, {"outputs", 1}, {"gravity", turned(0, -g, 0)}};
  json["bodies"] = {{"left", rod(0, -r / 2, r, kPi / 2)},
                    {"right", rod(base, -r / 2, r, kPi / 2)},
                    {"coupler", rod(base / 2, -r, base, 0)}};
  json["joints"] = {{"A", hinge("ground", "left", 0, 0)},
                    {"B", hinge("left", "coupler", 0, -r)},
                    {"C", hinge("coupler", "right", base, -r)},
                    {"D", hinge("right", "ground", base, 0)}};
  find(json, 1);
  expect_frequency(0, std::sqrt(2 * g * r / (r * r * (1 + 2.0 / 3))) / (2 * kPi), 1e-9);
}

// Arms that hang straight down may swing alike or against each other, and what holds the collar decides the
// frequencies of both; nothing determines it.
TEST_F(Modes, AboutASingularPositionAreRefused) {
  const Json governor = Json::parse(find_library_model("linked_governor")->text);
  EXPECT_THAT([&] { find(governor, 3); },
              testing::Throws<InvalidInput>(testing::Property(
                  &InvalidInput::what, testing::HasSubstr("there are no modes: it is singular"))));
}

}  // namespace
}  // namespace mfs::dae
