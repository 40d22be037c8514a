// Known mechanisms of the library beside their references: errors are small and fall with the tolerance.
// Others are in closed_loops_test.cpp, spin_up_test.cpp and test/dae/integrator/rotation_test.cpp;
// docs/mechanisms.md lists all.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "dae/model/measure.hpp"
#include "test/dae/integrator/ivp_test_set.hpp"
#include "test/dae/model/linear_bicycle.hpp"
#include "test/dae/model/mechanism.hpp"

namespace mfs::dae::test {
namespace {

using Error = std::function<double(const MotionRun&, const State&)>;

/// The largest of all outputs, with this rtol and the tolerances that follow from it.
double largest_error(Json json, double rtol, const Error& error) {
  json["integrator"]["rtol"] = rtol;
  const MotionRun result = run(json);
  double most = 0.0;
  for (const State& state : result.outputs) most = std::max(most, error(result, state));
  return most;
}

/// Bounds for rtol 1e-4, 1e-6 and 1e-8: some three times what was seen.
void expect_errors(const Json& json, const std::array<double, 3>& bounds, const Error& error) {
  double rtol = 1e-4;
  for (const double bound : bounds) {
    EXPECT_LT(largest_error(json, rtol, error), bound) << "rtol " << rtol;
    rtol *= 1e-2;
  }
}

// At the first tolerance the error is 1.4e-2. It was 3e-3 while each of the 100 outputs ended a step,
// and 1.7e-2 then with one output.
TEST(SimplePendulum, SwingsAsItsEquationSays) {
  constexpr double kInertia = 1 + 1e-6;
  const auto f = [](double, const Eigen::Vector2d& y) {
    return Eigen::Vector2d(y[1], -9.81 / kInertia * std::sin(y[0]));
  };
  expect_errors(of_library("simple_pendulum"), {4e-2, 2e-4, 1e-6},
                [&](const MotionRun& result, const State& state) {
                  const double angle = runge_kutta(Eigen::Vector2d(-0.5 * M_PI, 0), 0.0, state.t, 5000, f)[0];
                  const Vector3d expected(std::sin(angle), -std::cos(angle), 0);
                  return (result.position(state, "bob") - expected).norm();
                });
}

// Angles at 0.03 s of the Test Set for IVP Solvers, where it is in other coordinates. Motor and first body
// turn 2.5 times by then.
TEST(AndrewsSqueezer, ArrivesWhereTheTestSetSays) {
  using Data = AndrewsSqueezer;
  const std::vector<double> angle = Data::reference();
  const double beta = angle[0], second = angle[0] + angle[1], gamma = angle[2];
  const Vector3d k2(Data::rr * std::cos(beta) - Data::da * std::cos(second),
                    Data::rr * std::sin(beta) - Data::da * std::sin(second), 0);
  const Vector3d k3(Data::xb + Data::sa * std::sin(gamma) + Data::sb * std::cos(gamma),
                    Data::yb - Data::sa * std::cos(gamma) + Data::sb * std::sin(gamma), 0);
  expect_errors(of_library("andrews_squeezer", Data::kEnd, 1), {4e-5, 3e-7, 1e-8},
                [&](const MotionRun& result, const State& state) {
                  if (state.t < Data::kEnd) return 0.0;
                  return std::max((result.position(state, "K2") - k2).norm(),
                                  (result.position(state, "K3") - k3).norm());
                });
}

// Where a rod's centre is: Radau of SciPy with 1e-11 on tilt, height and angle about the shaft
// (perf/mechanisms).
TEST(FlyballGovernor, StiffSpringsInPlaceOfRods) {
  const std::pair<double, Vector3d> expected[] = {
      {0.25, {0.0716145130, 0.9469881861, 0.6329152964}},  {0.5, {-0.9345317014, 0.3241918777, 0.7506729578}},
      {1.0, {0.6843376826, -0.5727208520, 0.5156373731}},  {2.0, {0.1581754719, -0.8807739258, 0.5199984697}},
      {3.0, {-0.4446430841, -0.7811971861, 0.5271276903}},
  };
  expect_errors(of_library("flyball_governor", 3.0, 12), {1e-2, 5e-4, 1e-5},
                [&](const MotionRun& result, const State& state) {
                  for (const auto& [t, place] : expected)
                    if (std::abs(state.t - t) < 1e-9) return (result.position(state, "right") - place).norm();
                  return 0.0;
                });
}

/// A rigid body's axis `k`, in ground axes.
Vector3d axis(const MotionRun& result, const State& state, const std::string& body, int k) {
  const double* p = &state.q[result.at(body) + 3];
  return Eigen::Quaterniond(p[0], p[1], p[2], p[3]).normalized() * Vector3d::Unit(k);
}

// Its steady precession: with moments of inertia A, C, the tilt b of the axle, which goes round with W, and
// the spin p about it A W^2 sin b cos b - (C + m r^2) p W sin b = m g r cos b, and the centre's velocity is r
// p.
// At the first tolerance the axle is 0.1 rad ahead after 2.4 turns. It was a thirtieth of that while each of
// the 50 outputs ended a step.
TEST(RollingDisc, PrecessesSteadily) {
  constexpr double kTilt = 1.2, kTurn = 3.0, kRadius = 0.5, kA = 0.0625, kC = 0.125, kGravity = 9.81;
  const double s = std::sin(kTilt), c = std::cos(kTilt);
  const double spin =
      (kA * kTurn * kTurn * s * c - kGravity * kRadius * c) / ((kC + kRadius * kRadius) * kTurn * s);
  const double way = kRadius * spin / kTurn;  // of the circle's centre along x
  const Error error = [&](const MotionRun& result, const State& state) {
    const double x = std::cos(kTurn * state.t), y = std::sin(kTurn * state.t);
    const Vector3d place(way * (1 - x), -way * y, kRadius * s), axle(s * x, s * y, c);
    return std::max((result.position(state, "disc") - place).norm(),
                    (axis(result, state, "disc", 2) - axle).norm());
  };
  expect_errors(of_library("rolling_disc"), {2e-1, 4e-3, 2e-4}, error);
  // The road bears the weight and bends the path; its multipliers are along its normal and two axes in it.
  const MotionRun result = run(of_library("rolling_disc"), 1e-8);
  for (const State& state : result.outputs) {
    EXPECT_NEAR(result.multiplier(state, "joint road", 0), -kGravity, 1e-4) << state.t;
    EXPECT_NEAR(
        std::hypot(result.multiplier(state, "joint road", 1), result.multiplier(state, "joint road", 2)),
        std::abs(way) * kTurn * kTurn, 1e-3)
        << state.t;
    const Wrench wrench = reaction(result.model.joints[0], state);  // on the disc, where it touches
    EXPECT_NEAR(wrench.force[2], kGravity, 1e-4);
    EXPECT_LT(wrench.moment.norm(), 1e-9);
    EXPECT_NEAR(joint_position(result.model.joints[0], state)[2], 0.0, 1e-6);
  }
}

TEST(RollingDisc, BeginsAsItCanRoll) {
  Json json = of_library("rolling_disc", 0.01, 1);
  json["bodies"]["disc"].erase("velocity");         // it would slide
  json["joints"]["road"]["plane"] = {5, 5, -0.01};  // it would float
  const MotionRun result = run(json, 1e-6);
  const State& state = result.outputs.at(0);
  Residual residual = make_residual(*result.model.system);
  result.model.system->evaluate({0.0, state.q.data(), state.v.data(), state.a.data(), state.lambda.data()},
                                residual);
  for (const double rate : residual.velocity) EXPECT_NEAR(rate, 0.0, 1e-8);
  const Vector3d axle = axis(result, state, "disc", 2), centre = result.position(state, "disc");
  EXPECT_NEAR(centre[2], -0.01 + 0.5 * std::sqrt(1 - axle[2] * axle[2]), 1e-9);
  EXPECT_LT((centre - Vector3d(0, 0, 0.5 * std::sin(1.2))).norm(),
            0.0101);  // straight down, and hardly tilted
  EXPECT_NEAR(centre.head<2>().norm(), 0.0, 1e-12);
  EXPECT_GT(Eigen::Map<const Vector3d>(&state.v[result.at("disc")]).norm(), 0.1);
}

// A wheel that is askew is put to where a motion begins on the shortest way, not by rolling there.
TEST(RollingWheels, AreMovedSidewaysToWhereTheyBegin) {
  const Vector3d axle = Vector3d(1, -1, 0).normalized(), centre(0, 0.02, 0.5);
  Json json = mechanism(0.01, 1, Vector3d(0, 0, -9.81));
  json["bodies"]["wheel"] = {
      {"type", "rigid"}, {"mass", 1.0}, {"inertia", {0.1, 0.1, 0.1}}, {"position", triple(centre)}};
  json["joints"]["road"] = joint("rolling_wheel", "ground", "wheel", centre, Vector3d::UnitZ());
  json["joints"]["road"]["axis_b"] = triple(axle);
  json["joints"]["road"]["radius"] = 0.5;
  json["motions"]["hold"] = {{"type", "point"}, {"side", "wheel"}, {"point", triple(centre)}, {"y", "0"}};
  const MotionRun result = run(json, 1e-6);
  EXPECT_LT((result.position(result.outputs.at(0), "wheel") - Vector3d(0, 0, 0.5)).norm(), 1e-9);
  EXPECT_LT((axis(result, result.outputs.at(0), "wheel", 0) - Vector3d::UnitX()).norm(), 1e-9);
}

// Two wheels on one axle hold it sideways twice: one row follows, first along y, then, as it turns, others.
// Their speeds make it go round a circle.
TEST(RollingWheels, OfACartAreRedundantOnce) {
  constexpr double kSpeed = 1.0, kTurn = 0.8, kRadius = 0.3, kHalf = 0.4;
  Json json = mechanism(5.0, 20, Vector3d(0, 0, -9.81));
  json["bodies"]["frame"] = {{"type", "rigid"},
                             {"mass", 10.0},
                             {"inertia", {0.3, 0.2, 0.3}},
                             {"position", {0, 0, kRadius - 0.1}},
                             {"velocity", {kSpeed, 0, 0}},
                             {"angular_velocity", {0, 0, kTurn}}};
  for (const auto& [name, y] : {std::pair("left", kHalf), {"right", -kHalf}}) {
    const Vector3d hub(0, y, kRadius);
    const double speed = kSpeed - kTurn * y;
    json["bodies"][name] = {{"type", "rigid"},
                            {"mass", 1.0},
                            {"inertia", {0.03, 0.05, 0.03}},
                            {"position", triple(hub)},
                            {"velocity", {speed, 0, 0}},
                            {"angular_velocity", {0, speed / kRadius, kTurn}}};
    const std::string side(name);
    json["joints"][side + "_hub"] = joint("revolute", "frame", name, hub, Vector3d::UnitY());
    Json& road = json["joints"][side + "_road"] =
        joint("rolling_wheel", "ground", name, hub, Vector3d::UnitZ());
    road["axis_b"] = {0, 1, 0};
    road["radius"] = kRadius;
  }
  const Error error = [&](const MotionRun& result, const State& state) {
    EXPECT_THAT(result.report.redundant, testing::SizeIs(1));
    const double angle = kTurn * state.t, way = kSpeed / kTurn;
    const Vector3d place(way * std::sin(angle), way * (1 - std::cos(angle)), kRadius - 0.1);
    return (result.position(state, "frame") - place).norm();
  };
  expect_errors(json, {1e-2, 1e-3, 1e-4}, error);
  json["integrator"]["method"] = "generalized_alpha";
  EXPECT_LT(largest_error(json, 1e-6, error), 1e-3);
  json["integrator"] = {{"unknowns", "full"}};
  EXPECT_LT(largest_error(json, 1e-6, error), 1e-3);
}

// A ball on a turntable goes round a circle with 2 / 7 of its speed (Routh), wherever that is.
TEST(RollingBall, OnATurntableGoesRoundWithTwoSeventhsOfItsSpeed) {
  constexpr double kTurn = 7.0, kRadius = 0.1, kSlow = 2.0;
  Json json = mechanism(4.0, 20, Vector3d(0, 0, -9.81));
  json["bodies"]["table"] = {{"type", "rigid"},
                             {"mass", 5.0},
                             {"inertia", {1, 1, 2}},
                             {"position", {0, 0, 0}},
                             {"angular_velocity", {0, 0, kTurn}}};
  const Vector3d begin(1, 0, kRadius), velocity(0, 0.8, 0), touching(0, kTurn, 0);
  const Vector3d spin =
      Vector3d::UnitZ().cross(velocity - touching) / kRadius;  // w x r = touching - velocity
  json["bodies"]["ball"] = {{"type", "rigid"},
                            {"mass", 2.0},
                            {"inertia", {0.008, 0.008, 0.008}},
                            {"position", triple(begin)},
                            {"velocity", triple(velocity)},
                            {"angular_velocity", triple(spin)}};
  json["joints"]["bearing"] = joint("revolute", "ground", "table", {0, 0, 0});
  json["joints"]["contact"] = joint("rolling_ball", "table", "ball", begin, Vector3d::UnitZ());
  json["joints"]["contact"]["radius"] = kRadius;
  json["motions"]["drive"] = drive("bearing", 0.0, kTurn);
  const Vector3d centre = begin - Vector3d::UnitZ().cross(-velocity) / kSlow;
  expect_errors(json, {5e-2, 2e-3, 1e-4}, [&](const MotionRun& result, const State& state) {
    const Eigen::AngleAxisd turn(kSlow * state.t, Vector3d::UnitZ());
    return (result.position(state, "ball") - centre - turn * (begin - centre)).norm();
  });
}

/// Lean to the right and steer to the right.
Eigen::Vector2d lean_and_steer(const MotionRun& result, const State& state) {
  const Vector3d across = axis(result, state, "frame", 1);
  // The fork's lateral axis, seen along the steering axis, which points down.
  const Vector3d down = std::sin(M_PI / 10) * axis(result, state, "frame", 0) -
                        std::cos(M_PI / 10) * axis(result, state, "frame", 2);
  const Vector3d fork = axis(result, state, "fork", 1);
  return {std::asin(across[2]), std::atan2(down.cross(across).dot(fork), across.dot(fork))};
}

// Nothing in the linear equations is this project's: they were derived by hand and by two programs.
TEST(Bicycle, LeansAndSteersAsTheBenchmarksLinearEquationsSay) {
  for (const double speed : {2.0, 4.6, 7.0}) {
    constexpr double kSmall = 1e-4;
    Json json = of_library("bicycle", 2.0, 10);
    json["parameters"] = {{"speed", speed}, {"lean_rate", kSmall}};
    json["integrator"] = {{"rtol", 1e-8}, {"atol_position", 1e-11}, {"atol_velocity", 1e-10}};
    const MotionRun result = run(json);
    EXPECT_EQ(result.report.constraints, 25);  // three freedoms, four more places where they may be
    EXPECT_THAT(result.report.redundant, testing::IsEmpty());
    const LinearBicycle linear(speed);
    const auto f = [&](double, const Eigen::Vector4d& y) { return linear.rate(y); };
    double largest = 0.0;
    for (const State& state : result.outputs) {
      const Eigen::Vector4d y = runge_kutta(Eigen::Vector4d(0, 0, kSmall, 0), 0.0, state.t, 2000, f);
      largest = std::max(largest, y.head<2>().norm());
      EXPECT_LE((lean_and_steer(result, state) - y.head<2>()).norm(), 1e-4 * largest)
          << speed << " m/s at " << state.t;
    }
  }
}

// Far from linear: a push of 0.5 rad/s at the speed at which it is stable. Where the frame is:
// perf/mechanisms.
TEST(Bicycle, RightsItselfAndKeepsItsEnergy) {
  const std::pair<double, Vector3d> expected[] = {{0.5, {2.591311514, -0.305897434, 0.894634295}},
                                                  {1.0, {4.840330985, -0.839462043, 0.899190512}},
                                                  {2.0, {9.373818724, -1.740483407, 0.898487991}},
                                                  {3.0, {13.870814294, -2.810316966, 0.899772364}},
                                                  {5.0, {22.875584331, -4.901594240, 0.899949740}}};
  const auto error = [&](const MotionRun& result, const State& state) {
    for (const auto& [t, place] : expected)
      if (std::abs(state.t - t) < 1e-9) return (result.position(state, "frame") - place).norm();
    return 0.0;
  };
  expect_errors(of_library("bicycle", 5.0, 10), {0.1, 1e-2, 1e-3}, error);
  const MotionRun result = run(of_library("bicycle", 5.0, 10), 1e-8);
  const auto energy = [&](const State& state) {
    double sum = 0.0;
    for (const RigidPart& body : result.model.rigid_bodies) {
      const int at = body.frame.first;
      const Energy own =
          body.element.group->energy(0, {state.t, &state.q[at], &state.v[at], &state.a[at], nullptr});
      sum += own.kinetic + own.potential;
    }
    return sum;
  };
  const double begin = energy(result.outputs.front());
  for (const State& state : result.outputs) EXPECT_NEAR(energy(state), begin, 2e-2) << state.t;
  EXPECT_LT(lean_and_steer(result, result.outputs.back()).norm(), 0.05);
}

}  // namespace
}  // namespace mfs::dae::test
