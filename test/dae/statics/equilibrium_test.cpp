// Where springs, weights and beams come to rest.
#include "dae/statics/equilibrium.hpp"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>

#include <mfs/error.hpp>

#include "dae/model/model_library.hpp"
#include "test/dae/statics/at_rest.hpp"

namespace mfs::dae {
namespace {

const double kPi = std::acos(-1.0);

class Equilibrium : public test::AtRest {
 protected:
  /// Rods of the chain lie at these angles from the x axis.
  void expect_at(const std::vector<double>& angles, double within) const {
    double x = 0.0, y = 0.0, most = 0.0;
    for (std::size_t k = 0; k < angles.size(); ++k) {
      const std::string rod = "rod" + std::to_string(k);
      const double along_x = std::cos(angles[k]), along_y = std::sin(angles[k]);
      most = std::max(
          {most, std::abs(q(rod + ".x") - x - 0.5 * along_x), std::abs(q(rod + ".y") - y - 0.5 * along_y)});
      x += along_x;
      y += along_y;
    }
    EXPECT_LT(most, within);
  }
  /// Of a body, and of a frame from where it began, about z.
  double turn(const std::string& frame) const { return 2 * std::atan2(q(frame + ".e3"), q(frame + ".e0")); }
};

TEST_F(Equilibrium, AWeightOnSprings) {
  Json json = test::pendulum(0);
  json["joints"] = {{"guide",
                     {{"type", "translational"},
                      {"a", "ground"},
                      {"b", "bar"},
                      {"point", {0, 0, 0}},
                      {"axis", {0, 1, 0}}}}};
  json["forces"] = {
      {"spring", {{"type", "translational_spring"}, {"joint", "guide"}, {"stiffness", 40}}},
      {"cubic", {{"type", "point"}, {"side", "bar"}, {"point", {0, 0, 0}}, {"y", "-100 * guide.travel^3"}}}};
  find(json);
  const double y = q("bar.y");
  EXPECT_LT(y, -0.1);
  EXPECT_NEAR(40 * y + 100 * y * y * y, -2 * 9.81, 1e-8);
  EXPECT_LT(report_.iterations, 20);
}

TEST_F(Equilibrium, APendulumHangsDownFromWhereverItBegins) {
  for (const double degrees : {-90.0, -80.0, -30.0, 0.0, 40.0, 89.0, 179.0}) {
    SCOPED_TRACE(degrees);
    find(test::pendulum(degrees / 180 * kPi));
    EXPECT_NEAR(q("bar.x"), 0.0, 1e-8);
    EXPECT_NEAR(q("bar.y"), -0.6, 1e-8);
    // The hinge holds the weight: -lambda on the bar.
    EXPECT_THAT(state_.lambda, testing::Contains(testing::DoubleNear(-2 * 9.81, 1e-6)));
    EXPECT_LT(report_.force, 1e-7);
  }
}

/// The end goes 350 m, whatever the links are allowed.
TEST_F(Equilibrium, AChainThatIsHeldOutHangsDown) {
  find(test::chain(std::vector<double>(250, 0.0)));
  expect_at(std::vector<double>(250, -0.5 * kPi), 1e-8);
  EXPECT_LT(report_.iterations, 60);
}

/// What is below a rod's middle and what pulls at the end give its direction.
TEST_F(Equilibrium, AChainThatIsPulledAtItsEndIsTheFunicularPolygon) {
  Json json = test::chain(std::vector<double>(100, 0.0));
  json["forces"]["pull"] = {{"type", "point"}, {"side", "rod99"}, {"point", {100, 0, 0}}, {"x", "300"}};
  find(json);
  std::vector<double> angles;
  for (int k = 0; k < 100; ++k) angles.push_back(std::atan2(-9.81 * (99.5 - k), 300));
  expect_at(angles, 1e-8);
}

/// An arch of links between two supports falls through, to the polygon that hangs between them. It is
/// symmetric, so that the horizontal pull alone is unknown; SciPy's brentq on the span.
TEST_F(Equilibrium, AnArchOfLinksFallsToTheCatenary) {
  const int rods = 50;
  std::vector<double> arch;
  double span = 0.0;
  for (int k = 0; k < rods; ++k) {
    arch.push_back(1.2 * (rods - 1 - 2 * k) / (rods - 1));
    span += std::cos(arch.back());
  }
  Json json = test::chain(arch);
  json["joints"]["support"] = {
      {"type", "revolute"}, {"a", "ground"}, {"b", "rod49"}, {"point", {span, 0, 0}}, {"axis", {0, 0, 1}}};
  find(json);
  std::vector<double> angles;
  for (int k = 0; k < rods; ++k) angles.push_back(std::atan2(9.81 * (k - 24.5), 145.9819399717196));
  expect_at(angles, 1e-8);
}

/// Where links snap through, what mends their joints is longer than a step may be, whatever s is.
TEST_F(Equilibrium, AFoldedChainBetweenSupportsComesDownLinkByLink) {
  std::vector<double> folded;
  double span = 0.0, rise = 0.0;
  for (int k = 0; k < 250; ++k) {
    folded.push_back(k % 2 ? 0.9 : -0.8);
    span += std::cos(folded.back());
    rise += std::sin(folded.back());
  }
  Json json = test::chain(folded);
  json["joints"]["support"] = {{"type", "revolute"},
                               {"a", "ground"},
                               {"b", "rod249"},
                               {"point", {span, rise, 0}},
                               {"axis", {0, 0, 1}}};
  find(json);
  // One pull H and one weight at the left end fulfil all links.
  const auto slope = [&](int k) { return std::tan(turn("rod" + std::to_string(k))); };
  const double per_link = slope(1) - slope(0);
  EXPECT_GT(per_link, 0.0);
  for (int k = 2; k < 250; ++k) EXPECT_NEAR(slope(k), slope(0) + k * per_link, 1e-6) << k;
}

/// In 180 and 748 steps.
TEST_F(Equilibrium, AChainThatIsPressedTogetherComesDownLinkByLink) {
  std::vector<double> folded;
  for (int k = 0; k < 100; ++k) folded.push_back(k % 2 ? 0.9 : kPi - 0.8);
  for (const std::vector<double>& angles : {std::vector<double>(100, 0.5 * kPi + 0.01), folded}) {
    find(test::chain(angles));
    expect_at(std::vector<double>(100, -0.5 * kPi), 1e-8);
    EXPECT_EQ(report_.growth, 0.0);
  }
}

/// m g l cos(a) = k (pi / 2 - ...): the spring is relaxed where the bar is horizontal.
TEST_F(Equilibrium, ATorsionSpringHoldsThePendulum) {
  Json json = test::pendulum(0);
  json["forces"]["coil"] = {{"type", "rotational_spring"}, {"joint", "hinge"}, {"stiffness", 7.5}};
  find(json);
  const double angle = std::atan2(q("bar.y"), q("bar.x"));
  EXPECT_LT(angle, -0.5);
  EXPECT_NEAR(7.5 * angle + 2 * 9.81 * 0.6 * std::cos(angle), 0.0, 1e-7);
}

TEST_F(Equilibrium, AMotionHoldsItWhereItIsAtThatTime) {
  Json json = test::pendulum(0);
  json["motions"]["crank"] = {
      {"type", "rotation"}, {"joint", "hinge"}, {"angle", {{"type", "linear"}, {"slope", 3}}}};
  find(json);
  EXPECT_NEAR(q("bar.x"), 0.6, 1e-9);
  EXPECT_THAT(state_.lambda, testing::Contains(testing::DoubleNear(-2 * 9.81 * 0.6, 1e-6)));  // its torque
  EXPECT_EQ(state_.v, std::vector<double>(state_.v.size()));
}

/// A hinge given twice: half of the weight on each.
TEST_F(Equilibrium, RedundantHingesShareTheLoad) {
  Json json = test::pendulum(0);
  json["joints"]["second"] = json["joints"]["hinge"];
  find(json);
  EXPECT_NEAR(q("bar.y"), -0.6, 1e-8);
  EXPECT_THAT(state_.lambda, testing::Contains(testing::DoubleNear(-9.81, 1e-6)).Times(2));
}

TEST_F(Equilibrium, WhatNothingHoldsStaysWhereNothingPulls) {
  Json json = test::pendulum(0.3);
  json["gravity"] = {0, 0, -9.81};
  find(json);
  EXPECT_NEAR(turn("bar"), 0.3, 1e-9);
}

TEST_F(Equilibrium, WhatFallsHasNone) {
  Json json = test::pendulum(0);
  json["joints"] = Json::object();
  try {
    find(json);
    ADD_FAILURE() << "an equilibrium has been found";
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("bar.y moves most"));
  }
}

/// P L^3 / (3 E I) + P L / (k G A), k = 5/6 (Timoshenko).
TEST_F(Equilibrium, ACantileverBends) {
  Json json = test::cantilever(0.05, 0.05, 16);
  json["forces"]["load"] = {{"type", "point"}, {"side", "beam:x1"}, {"point", {1, 0, 0}}, {"y", "-1000"}};
  find(json);
  const double inertia = 0.05 * std::pow(0.05, 3) / 12, shear = 2e11 / 2.6;
  const double deflection = 1000 / (3 * 2e11 * inertia) + 1000 / (5.0 / 6 * shear * 0.0025);
  EXPECT_NEAR(q("beam:x1.y"), -deflection, 0.02 * deflection);
}

/// A square bar: the twist is T L / (0.1406 a^4 G) (Saint-Venant). Its ends do not warp, which stiffens them.
TEST_F(Equilibrium, ATorqueTwistsABar) {
  Json json = test::cantilever(0.02, 0.02, 10);
  json["bodies"]["beam"]["mesh"]["divisions"] = {10, 4, 4};
  json["forces"]["load"] = {{"type", "torque"}, {"side", "beam:x1"}, {"x", "5"}};
  find(json);
  const double twist = 5 / (0.1406 * std::pow(0.02, 4) * 2e11 / 2.6);
  EXPECT_NEAR(2 * std::asin(q("beam:x1.e1")), twist, 0.02 * twist);
}

/// A torque alone bends a beam to an arc, here a quarter of a circle.
TEST_F(Equilibrium, ATorqueBendsAThinBeamToAnArc) {
  Json json = test::cantilever(0.01, 0.02, 40);
  const double inertia = 0.02 * std::pow(0.01, 3) / 12;
  json["forces"]["load"] = {
      {"type", "torque"}, {"side", "beam:x1"}, {"z", std::to_string(2e11 * inertia * kPi / 2)}};
  find(json);
  EXPECT_NEAR(turn("beam:x1"), kPi / 2, 0.01 * kPi / 2);
  EXPECT_NEAR(q("beam:x1.x"), 2 / kPi, 0.01);
  EXPECT_NEAR(q("beam:x1.y"), 2 / kPi, 0.01);
}

/// The same load as a follower across the end. The moment at the wall is P times the distance of the load's
/// line; large deflections by the elastica E I phi'' = -P cos(phi - phi(L)), by SciPy's solve_bvp.
TEST_F(Equilibrium, AFollowerBendsAThinBeam) {
  Json json = test::cantilever(0.01, 0.02, 40);
  const double inertia = 0.02 * std::pow(0.01, 3) / 12;
  json["forces"]["load"] = {{"type", "point"},
                            {"side", "beam:x1"},
                            {"axes", "body"},
                            {"point", {1, 0, 0}},
                            {"y", std::to_string(4 * 2e11 * inertia)}};
  find(json);
  EXPECT_NEAR(q("beam:x1.x"), 0.3427457862, 0.01);
  EXPECT_NEAR(q("beam:x1.y"), 0.7861684257, 0.01);
}

// A flat parallelogram, whose cranks could turn against each other there: what follows from other joints at
// first does not later. With a rocker of 2 kg and 5 N across its middle 2.5 g cos a + 2.5 N sin a = 0.
TEST_F(Equilibrium, OfAParallelogramFromItsFlatPosition) {
  Json json = test::chain({0, 0, kPi});
  json["bodies"]["rod2"]["mass"] = 2;
  json["joints"]["hinge3"] = {
      {"type", "revolute"}, {"a", "ground"}, {"b", "rod2"}, {"point", {1, 0, 0}}, {"axis", {0, 0, 1}}};
  json["forces"]["push"] = {{"type", "point"}, {"side", "rod2"}, {"point", {1.5, 0, 0}}, {"x", "5"}};
  find(json);
  const double down = -9.81 / std::hypot(1, 9.81), right = 1 / std::hypot(1, 9.81);
  EXPECT_NEAR(q("rod0.x"), 0.5 * right, 1e-8);
  EXPECT_NEAR(q("rod0.y"), 0.5 * down, 1e-8);
  EXPECT_NEAR(q("rod1.x"), 0.5 + right, 1e-8);
  EXPECT_NEAR(q("rod1.y"), down, 1e-8);
  EXPECT_NEAR(q("rod2.x"), 1 + 0.5 * right, 1e-8);
}

// Its arms hang straight down, where the loop of both determines nothing: a step could not be solved next to
// it.
TEST_F(Equilibrium, OfALinkedGovernorIsSingular) {
  find(Json::parse(find_library_model("linked_governor")->text));
  for (const char* arm : {"arm1", "arm2"}) {
    EXPECT_NEAR(q(arm + std::string(".x")), 0, 1e-8);
    EXPECT_NEAR(q(arm + std::string(".y")), -0.5, 1e-8);
  }
  EXPECT_NEAR(q("collar.y"), -1.5, 1e-8);
  EXPECT_LT(report_.iterations, 60);
}

// A cantilever bent and twisted by a load across it, far beyond what is linear. Tip and twist: a
// geometrically exact beam (perf/mechanisms princeton_beam). Solids twist less, as the wall lets no section
// warp.
TEST_F(Equilibrium, OfThePrincetonBeam) {
  struct Case {
    double load, degrees;
    Eigen::Vector3d tip;
    double twist;
  };
  for (const Case& each : {Case{8.896, 45, {0.4936107, -0.0088889, -0.1090416}, -0.029060},
                           Case{13.345, 60, {0.4667936, -0.0117164, -0.1819212}, -0.048461}}) {
    Json json = Json::parse(find_library_model("princeton_beam")->text);
    json["parameters"] = {{"load", each.load}, {"theta", each.degrees * std::acos(-1.0) / 180}};
    const MultibodyModel model = make_model(json, "", 1);
    const State state = find_equilibrium(*model.system, model.integrator, {0.0, model.q0, model.v0, {}, {}});
    const auto place = [&](const ModelPoint& point) {
      return Eigen::Vector3d(&state.q[model.flexible_bodies[0].range.first + 3 * point.node]);
    };
    const Eigen::Vector3d left = place(model.points[0]), right = place(model.points[1]),
                          across = left - right;
    const double bent = (each.tip - Eigen::Vector3d(0.508, 0, 0)).norm();
    EXPECT_LT((0.5 * (left + right) - each.tip).norm(), 0.01 * bent) << each.load;
    EXPECT_NEAR(std::atan2(across[2], across[1]), each.twist, 0.04 * std::abs(each.twist)) << each.load;
  }
}

// A load that a universal and a cylindrical joint lock to the arm of a pendulum, two of their constraints
// redundant: without these it may be locked in another place, where long steps would end.
TEST_F(Equilibrium, OfALockedLoadIsInThePlaceInWhichItIsGiven) {
  const Json json = Json::parse(R"({
    "name": "locked", "end": 1, "outputs": 1, "gravity": [0, 0, -10],
    "bodies": {
      "arm": {"type": "rigid", "mass": 1, "inertia": [0.1, 0.1, 0.1], "position": [0.2, 0.2, 0.9]},
      "load": {"type": "rigid", "mass": 1, "inertia": [0.1, 0.1, 0.1], "position": [0.6, 0.6, -0.9]}},
    "joints": {
      "hinge": {"type": "revolute", "a": "ground", "b": "arm", "point": [0, 0, 0], "axis": [0, 1, 0]},
      "cross": {"type": "universal", "a": "arm", "b": "load", "point": [-0.3, -0.8, -0.6],
                "axis": [0.1, 0.8, -0.6], "axis_b": [0.3, -0.51, -0.63]},
      "rod": {"type": "cylindrical", "a": "load", "b": "arm", "point": [-0.6, 0.7, -0.7], "axis": [-0.4, 0, 0.7]}}
  })");
  find(json);
  EXPECT_NEAR(q("arm.x") + q("load.x"), 0.0, 1e-8);  // the centre hangs below the hinge
  EXPECT_NEAR(q("arm.z") + q("load.z"), -0.8, 1e-8);
  EXPECT_NEAR(std::hypot(q("arm.x") - q("load.x"), q("arm.z") - q("load.z")), std::hypot(0.4, 1.8), 1e-8);
}

}  // namespace
}  // namespace mfs::dae
