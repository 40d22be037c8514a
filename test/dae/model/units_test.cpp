// Models of the library in other units than metres, kilograms and seconds: their motion is the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "dae/model/measure.hpp"
#include "dae/statics/equilibrium.hpp"
#include "test/dae/model/units.hpp"

namespace mfs::dae::test {
namespace {

constexpr Units kMillimetres{"mm, t, s", 1e3, 1e-3, 1.0}, kMicrometres{"um, g, s", 1e6, 1e3, 1.0},
    kKilometres{"km, kg, s", 1e-3, 1.0, 1.0}, kMilliseconds{"m, kg, ms", 1.0, 1.0, 1e3},
    kHours{"km, t, h", 1e-3, 1e-3, 1.0 / 3600.0};

/// By how much (m, 1) bodies' centres and Euler parameters, or nodes, are not where they are in metres,
/// kilograms and seconds.
double largest_difference(const Json& model, const Units& units) {
  const MotionRun here = run(model), there = run(converted(model, units));
  EXPECT_EQ(here.outputs.size(), there.outputs.size());
  double largest = 0.0;
  for (std::size_t k = 0; k < here.outputs.size(); ++k) {
    const auto compare = [&](int i, double unit) {
      largest = std::max(largest, std::abs(here.outputs[k].q[i] - there.outputs[k].q[i] / unit));
    };
    for (const RigidPart& body : here.model.rigid_bodies)
      for (int i = 0; i < 7; ++i) compare(body.frame.first + i, i < 3 ? units.length : 1.0);
    for (const FlexibleBody& body : here.model.flexible_bodies)
      for (int i = 0; i < body.range.count; ++i) compare(body.range.first + i, units.length);
  }
  return largest;
}

/// The first quarter of the motions by rtol 1e-7.
void expect_alike(const std::vector<std::string>& names, const Units& units) {
  for (const std::string& name : names) {
    Json model = of_library(name);
    model["end"] = 0.25 * model["end"].get<double>();
    model["integrator"] = {{"rtol", 1e-7}};
    EXPECT_LE(largest_difference(model, units), 1e-4) << name << " in " << units.name;
  }
}

class InUnits : public testing::TestWithParam<Units> {};

// In micrometres both pendulums were refused: what is left of an Euler parameter is a million times as much
// of a length.
TEST_P(InUnits, RigidMechanismsMoveAlike) {
  expect_alike({"andrews_squeezer", "bicycle", "bricard", "door", "flyball_governor", "four_bar",
                "four_bars_2", "free_flip", "heavy_top", "linked_governor", "rolling_disc", "simple_pendulum",
                "slider_crank", "universal_pendulum"},
               GetParam());
}

INSTANTIATE_TEST_SUITE_P(Library, InUnits,
                         testing::Values(kMillimetres, kMicrometres, kKilometres, kMilliseconds));

// Without a unit for constraints, too, 1e-8 Gm may be left of one.
TEST(Units, MayBeFarFromAnyMechanisms) {
  for (const Units& units : {Units{"Gm, kg, s", 1e-9, 1.0, 1.0}, Units{"nm, kg, s", 1e9, 1.0, 1.0}})
    expect_alike({"four_bar", "simple_pendulum"}, units);
}

// What may be left of accelerations, 1e-4 km/h^2, is less than rounding.
TEST(Units, WhatIsLessThanRoundingIsNotAskedFor) {
  expect_alike({"andrews_squeezer", "bicycle", "rolling_disc"}, kHours);
}

TEST(Units, AFlexibleBeamMovesAlike) {
  for (const Units& units : {kMillimetres, kMicrometres, kKilometres})
    EXPECT_LE(largest_difference(of_library("spin_up_beam", 2.0, 4), units), 1e-2) << units.name;
}

// The integrator has a unit of its own for them.
TEST(Units, TolerancesAreInThoseOfTheModel) {
  Json model = of_library("four_bar", 1.0, 4);
  for (const char* key : {"rtol", "atol_position", "atol_velocity"}) model["integrator"][key] = 1e-6;
  const std::int64_t steps = run(model).report.steps;
  Json in_micrometres = converted(model, kMicrometres);
  for (const char* key : {"atol_position", "atol_velocity"}) in_micrometres["integrator"][key] = 1.0;
  EXPECT_NEAR(static_cast<double>(run(in_micrometres).report.steps), static_cast<double>(steps), 0.1 * steps);
}

// The bearing's force, in N and in those that 1 kg, 1 um and 1 s make.
TEST(Units, MultipliersAreThoseOfTheModel) {
  const Json model = of_library("simple_pendulum", 0.5, 1);
  const MotionRun here = run(model), there = run(converted(model, {"um, kg, s", 1e6, 1.0, 1.0}));
  const double force = here.multiplier(here.outputs.back(), "joint bearing", 1);
  EXPECT_GT(std::abs(force), 1.0);
  EXPECT_NEAR(there.multiplier(there.outputs.back(), "joint bearing", 1), 1e6 * force, 1e3 * std::abs(force));
}

/// Three joints that each hold the same body alone, its weight of 10 N beside them. Forces, and moments over
/// 3.0886890423 m, the longest arm, have the least sum of squares: by NumPy's lstsq.
TEST(Units, ReactionsOfRedundantJointsAreTheSame) {
  Json model = mechanism(0.01, 1, {0, 0, -10});
  model["bodies"]["block"] = {
      {"type", "rigid"}, {"mass", 1}, {"inertia", {0.1, 0.1, 0.1}}, {"position", {0.5, 0, 0.7}}};
  model["joints"] = {{"a", joint("fixed", "ground", "block", {0, 0, 0})},
                     {"b", joint("fixed", "ground", "block", {0, 0, 1})},
                     {"c", joint("spherical", "ground", "block", {1, 2, 3})}};
  const Vector3d forces[] = {{0.0942893816, -0.3343595275, 3.4769407517},
                             {0.007495787, -0.0755516027, 3.4769407517},
                             {-0.1017851686, 0.4099111302, 3.0461184966}};
  const Vector3d moment(-2.4690276027, -0.8280108922, -0.3067407337);
  for (const Units& units : {Units{"m, kg, s", 1.0, 1.0, 1.0}, kMillimetres, kMicrometres, kKilometres}) {
    const MotionRun there = run(converted(model, units));
    const double force = units.length * units.mass / (units.time * units.time);
    for (std::size_t i = 0; i < 3; ++i) {
      const Wrench on_b = reaction(there.model.joints[i], there.outputs.back());
      EXPECT_LE((on_b.force / force - forces[i]).norm(), 1e-8) << units.name << " " << i;
      if (i < 2) {
        EXPECT_LE((on_b.moment / (force * units.length) - moment).norm(), 1e-8) << units.name << " " << i;
      }
    }
  }
}

// A step of the search was at most 0.3 of a coordinate's unit long: in micrometres a pendulum did not hang
// down in 300 steps.
TEST(Units, EquilibriaAreTheSame) {
  for (const Units& units : {kMillimetres, kMicrometres, kKilometres}) {
    const MultibodyModel model = make_model(converted(of_library("universal_pendulum"), units), "", 1);
    const State rest = find_equilibrium(*model.system, model.integrator, {0.0, model.q0, model.v0, {}, {}});
    const Vector3d upper = Eigen::Map<const Vector3d>(rest.q.data()) / units.length;
    EXPECT_LE((upper - 0.5 * Vector3d(0.0, 3.0, -9.81).normalized()).norm(), 1e-9) << units.name;
  }
}

}  // namespace
}  // namespace mfs::dae::test
