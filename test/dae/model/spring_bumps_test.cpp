// Springs whose force lasts for a part of the motion that is short beside steps, beside the energy that it
// takes or gives: a slider and a body that flies freely, of 3 kg and 10 m/s, and a wheel of 2 kg m^2 and
// 10 rad/s.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "dae/mechanics/expression.hpp"
#include "dae/mechanics/integral.hpp"
#include "dae/model/measure.hpp"
#include "test/dae/model/mechanism.hpp"

namespace mfs::dae::test {
namespace {

Json slider(const Json& force) {
  Json json = mechanism(5, 1, {0, 0, 0});
  json["bodies"]["body"] = {{"type", "rigid"}, {"mass", 3}, {"inertia", {1, 1, 1}}, {"velocity", {10, 0, 0}}};
  json["joints"]["guide"] = joint("translational", "ground", "body", {0, 0, 0}, {1, 0, 0});
  json["forces"]["spring"] = {{"type", "translational_spring"}, {"joint", "guide"}, {"force", force}};
  return json;
}

/// Past `side` m beside the spring's other end.
Json flyer(const Json& force, double from, double side) {
  Json json = mechanism(5, 1, {0, 0, 0});
  json["bodies"]["body"] = {{"type", "rigid"},
                            {"mass", 3},
                            {"inertia", {1, 1, 1}},
                            {"position", {from, side, 0}},
                            {"velocity", {10, 0, 0}}};
  json["forces"]["spring"] = {
      {"type", "spring_damper"},    {"a", "ground"},  {"b", "body"},     {"point_a", {0, 0, 0}},
      {"point_b", {from, side, 0}}, {"force", force}, {"free_length", 1}};
  return json;
}

Json wheel(const Json& torque) {
  Json json = mechanism(5, 1, {0, 0, 0});
  json["bodies"]["body"] = {
      {"type", "rigid"}, {"mass", 1}, {"inertia", {1, 1, 2}}, {"angular_velocity", {0, 0, 10}}};
  json["joints"]["bearing"] = joint("revolute", "ground", "body", {0, 0, 0});
  json["forces"]["spring"] = {{"type", "rotational_spring"}, {"joint", "bearing"}, {"torque", torque}};
  return json;
}

MotionRun run_with(Json json, double rtol) {
  json["integrator"]["rtol"] = rtol;
  return run(json);
}

/// At 20, 0.4 wide, among points that are 1.5 apart; it ripples beside it.
Json table(double height) {
  std::vector<double> x, y;
  for (int i = 0; i < 13; ++i) x.push_back(1.5 * i);
  for (int i = -20; i <= 20; ++i) x.push_back(20 + 0.01 * i);
  for (int i = 14; i < 40; ++i) x.push_back(1.5 * i);
  for (const double at : x) y.push_back(height * std::exp(-std::pow((at - 20) / 0.05, 2)));
  return {{"type", "spline"}, {"x", x}, {"y", y}};
}

struct Bump {
  Json force;
  double energy;
};
std::vector<Bump> bumps() {
  const double pi = std::acos(-1.0), gauss = 500 * 0.05 * std::sqrt(pi);
  return {{"-500 * exp(-((x - 20) / 0.05)^2)", -gauss},
          {"if(x > 20 && x < 20.1, -600, 0)", -60.0},
          {"-500 * max(0, 1 - abs(x - 20) / 0.1)", -50.0},
          {"-3e-4 / ((x - 20)^2 + 1e-8)", -3 * pi},
          {"1e-9 * sin(50 * x) - 500 * exp(-((x - 20) / 0.05)^2)", -gauss},
          {table(-500), -gauss}};
}

TEST(SpringBumps, AreNotPassedOver) {
  for (const double rtol : {1e-4, 1e-6, 1e-8})
    for (const Bump& bump : bumps()) {
      const double off = std::clamp(1000 * rtol, 1e-5, 0.05), after = std::sqrt(100 - 2 * bump.energy / 3);
      // What a spline swings beside the points of the bump is 1e-4 of its energy.
      const double more = bump.force.is_object() ? 1e-3 : 0.0;
      for (const Json& json : {slider(bump.force), flyer(bump.force, 1.0, 0.0)}) {
        const MotionRun result = run_with(json, rtol);
        EXPECT_NEAR(result.outputs.back().v[result.at("body")], after, off + more) << rtol << bump.force;
      }
      const MotionRun result = run_with(wheel(bump.force), rtol);
      const FrameMotion end = frame_motion(result.model.rigid_bodies.front().frame, result.outputs.back());
      EXPECT_NEAR(end.angular_velocity[2], std::sqrt(100 - 2 * bump.energy / 2), off + more)
          << rtol << bump.force;
    }
}

/// A ring around the spring's other end, which the body only touches in passing. By SciPy 1.17, solve_ivp
/// DOP853, rtol 1e-12, steps of at most 2 ms.
TEST(SpringBumps, AreNotPassedOverBesideTheirMiddle) {
  for (const double rtol : {1e-4, 1e-6, 1e-8}) {
    const double off = std::max(1e-6, 400 * rtol);
    const MotionRun near = run_with(flyer("500 * exp(-((x - 0.2) / 0.05)^2)", -20, 1.15), rtol),
                    far = run_with(flyer("-300 * exp(-((x - 0.5) / 0.02)^2)", -23, 1.4), rtol);
    const double* v = &near.outputs.back().v[near.at("body")];
    EXPECT_NEAR(v[0], 8.64547378, off);
    EXPECT_NEAR(v[1], -5.02551321, off);
    v = &far.outputs.back().v[far.at("body")];
    EXPECT_NEAR(v[0], 9.69852952, off);
    EXPECT_NEAR(v[1], 2.43690894, off);
  }
}

/// Two free bodies that turn about each other on a spring and pass a thin shell of its law again and again.
/// By SciPy 1.17, solve_ivp DOP853, rtol 1e-13, steps of at most 0.1 ms.
TEST(SpringBumps, AreNotPassedOverByBodiesThatTurnAboutEachOther) {
  Json json = mechanism(8, 1, {0, 0, 0});
  const Json body = {{"type", "rigid"}, {"mass", 1}, {"inertia", {1, 1, 1}}};
  json["bodies"] = {{"a", body}, {"b", body}};
  json["bodies"]["a"]["velocity"] = {0, -0.6, 0};
  json["bodies"]["b"]["mass"] = 2;
  json["bodies"]["b"]["position"] = {1.9, 0, 0};
  json["bodies"]["b"]["velocity"] = {0, 0.3, 0};
  json["forces"]["spring"] = {{"type", "spring_damper"},
                              {"a", "a"},
                              {"b", "b"},
                              {"point_a", {0, 0, 0}},
                              {"point_b", {1.9, 0, 0}},
                              {"free_length", 1},
                              {"force", "20 * x + 300 * exp(-((x - 0.3) / 0.005)^2)"}};
  for (const double rtol : {1e-4, 1e-6, 1e-8}) {
    const MotionRun result = run_with(json, rtol);
    const double* q = &result.outputs.back().q[result.at("b")];
    EXPECT_NEAR(q[0], 0.6667620329, std::max(1e-5, 1000 * rtol)) << rtol;
    EXPECT_NEAR(q[1], 0.1879073382, std::max(1e-5, 1000 * rtol)) << rtol;
  }
}

/// Friction at velocities that are met at the ends of a swing of the velocity alone. By SciPy 1.17, solve_ivp
/// DOP853 and, where there is friction, Radau, rtol 1e-11 and steps of a quarter of the width:
///   3 s'' = 3 cos(t) - 500 exp(-((s' - 0.9995) / 0.001)^2)
TEST(SpringBumps, FrictionAtTheLargestVelocityIsNotPassedOver) {
  for (const double rtol : {1e-4, 1e-6, 1e-8}) {
    Json json = slider(1.0);
    json["end"] = 10;
    json["bodies"]["body"].erase("velocity");
    json["forces"]["spring"] = {
        {"type", "actuator"},
        {"joint", "guide"},
        {"force", "3 * cos(t) - 500 * exp(-((guide.travel_rate - 0.9995) / 0.001)^2)"}};
    const MotionRun result = run_with(json, rtol);
    EXPECT_NEAR(result.outputs.back().q[result.at("body")], 1.80726664, std::max(1e-6, 100 * rtol)) << rtol;
    EXPECT_NEAR(result.outputs.back().v[result.at("body")], -0.54785229, std::max(1e-6, 100 * rtol)) << rtol;
  }
}

/// Friction that is ten times steeper than the default atol_velocity: a body that is stuck breaks loose when
/// the force is more than it holds. It was held for up to another quarter of a second. By SciPy 1.17,
/// solve_ivp Radau, rtol 1e-11, steps of at most 3 ms.
TEST(SpringBumps, FrictionHoldsNoMoreThanItCan) {
  struct Case {
    std::string force;
    double end, most;
  };
  for (const Case& each : {Case{"9 * cos(2 * t) - 6 * tanh(guide.travel_rate / 1e-5)", 0.0464135, 50},
                           {"-30 * guide.travel - 15 * tanh((guide.travel_rate - 0.5) / 1e-5) * "
                            "(0.6 + 0.4 * exp(-abs(guide.travel_rate - 0.5) / 0.5))",
                            0.09943196, 100}})
    for (const char* method : {"bdf", "generalized_alpha"})
      for (const double rtol : {3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 1e-6}) {
        Json json = slider(1.0);
        json["end"] = 10;
        json["bodies"]["body"].erase("velocity");
        json["forces"]["spring"] = {{"type", "actuator"}, {"joint", "guide"}, {"force", each.force}};
        json["integrator"]["method"] = method;
        const MotionRun result = run_with(json, rtol);
        EXPECT_NEAR(result.outputs.back().q[result.at("body")], each.end, each.most * rtol)
            << method << " " << rtol << " " << each.force;
      }
}

TEST(SpringBumps, HaveTheirEnergy) {
  for (const Bump& bump : bumps())
    for (const double from : {0.0, 30.0}) {
      const Function force = bump.force.is_object() ? spline_function(bump.force["x"], bump.force["y"])
                                                    : expression_function(Expression(bump.force), 0, {0.0});
      const double energy = integral(*force, from, 53.0);
      if (from > 20)
        EXPECT_NEAR(energy, 0, 2e-3) << bump.force;
      else
        EXPECT_NEAR(energy, bump.energy, 4e-3) << bump.force;
    }
  const double pi = std::acos(-1.0);
  EXPECT_NEAR(integral(*harmonic_function(0, 5, 50, 0), 0.0, 50.013), 0.05 / pi * (1 - std::cos(1.3 * pi)),
              1e-8);
  EXPECT_TRUE(std::isnan(integral(*harmonic_function(0, 5, 5e6, 0), 0.0, 50.013)));
  const MotionRun result = run_with(slider(bumps()[0].force), 1e-6);
  EXPECT_NEAR(energy(result.model.forces.front().elements, result.outputs.back()).elastic, bumps()[0].energy,
              1e-7);
}
}  // namespace
}  // namespace mfs::dae::test
