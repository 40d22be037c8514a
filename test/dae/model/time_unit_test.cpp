// The unit of time that the integrator has for models whose own leaves rates far from 1: their motion is the
// same whatever that is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <mfs/error.hpp>

#include "dae/integrator/scaled_system.hpp"
#include "dae/integrator/time_unit.hpp"
#include "test/dae/mechanics/system_derivatives.hpp"
#include "test/dae/model/units.hpp"
#include "test/reference/random.hpp"

namespace mfs::dae::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Property;
using testing::Throws;

constexpr Units kMinutes{"min", 1, 1, 1.0 / 60}, kHours{"h", 1, 1, 1.0 / 3600},
    kMilliseconds{"ms", 1, 1, 1e3}, kMicroseconds{"us", 1, 1, 1e6};

double unit_of(const Json& json) {
  const MultibodyModel model = make_model(json, "", 1);
  return time_unit(*model.system, {0.0, model.q0, model.v0, {}, {}}, model.end);
}

/// A body of 1 kg, and 3.12 kg with 1 kg m^2 for each unit of its Euler parameters.
Json block(const Vector3d& velocity, double end) {
  Json json = mechanism(end, 1, Vector3d::Zero());
  json["bodies"]["block"] = {
      {"type", "rigid"}, {"mass", 1.0}, {"inertia", {0.01, 0.01, 0.01}}, {"velocity", triple(velocity)}};
  return json;
}

TEST(TimeUnit, OfModelsInSecondsIsTheSecond) {
  for (const LibraryModel& model : model_library())
    EXPECT_EQ(unit_of(Json::parse(model.text)), 1.0) << model.name;
}

// A speed v of the block is v / sqrt(3.12) in the mean over its coordinates; an acceleration takes 1 over
// its root.
TEST(TimeUnit, IsWhatItTakesToMove) {
  const auto power = [](double x) { return std::exp2(std::round(std::log2(x))); };
  EXPECT_EQ(unit_of(block({1.0, 0, 0}, 10.0)), 1.0);
  EXPECT_EQ(unit_of(block({0, 1e-3, 0}, 100.0)), power(4e3 * std::sqrt(3.12)));
  EXPECT_EQ(unit_of(block({0, 0, 1e5}, 10.0)), power(4e-5 * std::sqrt(3.12)));
  Json json = block(Vector3d::Zero(), 1e4);
  EXPECT_EQ(unit_of(json), 1.0);  // nothing is known
  json["gravity"] = triple({0, -1e-6, 0});
  EXPECT_EQ(unit_of(json), power(4e3 * std::pow(3.12, 0.25)));
  json["gravity"] = triple(Vector3d::Zero());
  // A force that begins in the second half of the run, and a motion that does.
  json["forces"]["pull"] = {{"type", "point"},
                            {"side", "block"},
                            {"point", triple(Vector3d::Zero())},
                            {"x", "if(t < 6000, 0, 1e-6*(t - 6000)/3000)"}};
  EXPECT_NEAR(std::log2(unit_of(json)), std::log2(4e3), 1.0);
  json.erase("forces");
  json["joints"]["guide"] = joint("translational", "ground", "block", Vector3d::Zero(), Vector3d::UnitX());
  json["motions"]["drive"] = {
      {"type", "translation"},
      {"joint", "guide"},
      {"distance", {{"type", "smooth_step"}, {"begin", 6e3}, {"end", 9e3}, {"after", 1.0}}}};
  EXPECT_NEAR(std::log2(unit_of(json)), std::log2(4.0 * 3e3 / 1.875), 1.0);
}

// What moves by less than a thousandth of its size in the run is not waited for.
TEST(TimeUnit, IsNotOutOfProportionToTheRun) {
  EXPECT_EQ(unit_of(block({1e-12, 0, 0}, 1.0)), 1024.0);
}

// A system in another unit is a system: derivatives, and rates of constraints.
TEST(TimeUnit, LeavesDerivativesTrue) {
  Json json = of_library("slider_crank");
  json["forces"]["spring"] = {{"type", "spring_damper"}, {"a", "ground"},        {"b", "rod"},
                              {"point_a", {1, 2, 0}},    {"point_b", {2, 0, 0}}, {"stiffness", 3.0},
                              {"damping", 2.0}};
  const MultibodyModel model = make_model(converted(json, {"Tm", 1.0 / 512, 1.0, 1.0 / 8}), "", 1);
  const ScaledSystem system(*model.system, 0.0, model.q0, 1.0 / 8);
  mfs::test::Random random(7);
  mfs::test::State state{0.3, system.scaled({0.0, model.q0, {}, {}, {}}).q, {}, {}, {}};
  for (double& x : state.q) x += 0.05 * random.entry();
  state.v = random.vector(system.coordinates());
  state.a = random.vector(system.coordinates());
  state.lambda = random.vector(system.constraints());
  mfs::test::expect_true_derivatives(system, state);
}

/// Largest distance of the first crank's end from that of the equation that a chain of `loops` parallel
/// four-bars has: a pendulum's, angle'' = rate sin(angle).
double four_bars_error(int loops, const Units& units, double rtol) {
  Json json = of_library("four_bars_" + std::to_string(loops));
  json["integrator"]["rtol"] = rtol;
  const MotionRun result = run(converted(json, units));
  const double rate = 9.81 * ((loops + 1) / 2.0 + loops) / ((loops + 1) / 3.0 + loops);
  using Y = Eigen::Vector2d;
  Y y(0.0, 1.0);
  double last = 0.0, most = 0.0;
  for (const State& state : result.outputs) {
    const double t = state.t / units.time;
    if (t > last)
      y = runge_kutta(y, last, t, 1000,
                      [rate](double, const Y& z) { return Y(z[1], rate * std::sin(z[0])); });
    last = t;
    const Vector3d middle = 0.5 * Vector3d(std::sin(y[0]), std::cos(y[0]), 0.0);
    most = std::max(most, 2.0 * (result.position(state, "up100") - middle).norm());
  }
  return most;
}

// With velocities to 1e-4 m/us they were 1.4 m off, with success; in hours the flat positions ended the runs.
TEST(TimeUnit, FourBarsMoveAsTheirPendulum) {
  for (const Units& units : {kMilliseconds, kMicroseconds, kMinutes, kHours}) {
    EXPECT_LE(four_bars_error(2, units, 1e-4), 0.25) << units.name;
    EXPECT_LE(four_bars_error(2, units, 1e-6), 2e-3) << units.name;
  }
  for (const Units& units : {kMicroseconds, kHours})
    EXPECT_LE(four_bars_error(40, units, 1e-4), 0.2) << units.name;
}

// Both are so slow in their own unit that the integrator's is the same: the numbers are, too.
TEST(TimeUnit, MakesMotionsTheSameToTheLastBit) {
  const Units first{"2^-12 s", 1.0, 1.0, 4096.0}, second{"2^-22 s", 1.0, 1.0, 4194304.0};
  const Json model = of_library("heavy_top", 0.5, 10);
  const MotionRun here = run(converted(model, first)), there = run(converted(model, second));
  for (std::size_t k = 0; k < here.outputs.size(); ++k) {
    EXPECT_EQ(here.outputs[k].t * 1024.0, there.outputs[k].t);
    EXPECT_EQ(here.outputs[k].q, there.outputs[k].q);
    for (std::size_t i = 0; i < here.outputs[k].v.size(); ++i) {
      EXPECT_EQ(here.outputs[k].v[i], 1024.0 * there.outputs[k].v[i]);
      EXPECT_EQ(here.outputs[k].a[i], 1048576.0 * there.outputs[k].a[i]);
    }
    for (std::size_t i = 0; i < here.outputs[k].lambda.size(); ++i)
      EXPECT_EQ(here.outputs[k].lambda[i], 1048576.0 * there.outputs[k].lambda[i]);
  }
}

// Tolerances and steps that are given are those of the model.
TEST(TimeUnit, IsNotThatOfWhatIsGiven) {
  Json model = of_library("four_bar", 1.0, 4);
  model["integrator"] = {{"rtol", 1e-6}, {"atol_position", 1e-6}, {"atol_velocity", 1e-3}};
  const std::int64_t steps = run(model).report.steps;
  Json in_microseconds = converted(model, kMicroseconds);
  in_microseconds["integrator"]["atol_velocity"] = 1e-9;
  EXPECT_NEAR(static_cast<double>(run(in_microseconds).report.steps), static_cast<double>(steps),
              0.1 * steps);
  in_microseconds["integrator"] = {{"fixed_step", 1e3}};
  EXPECT_EQ(run(in_microseconds).report.steps, 1000);
}

TEST(TimeUnit, IsNotThatOfMessages) {
  Json model = of_library("four_bar", 1.0, 1);
  const auto steps = [](double begin) {
    return Json{{"type", "rotation"},
                {"joint", "A"},
                {"angle", {{"type", "smooth_step"}, {"begin", begin}, {"end", 1e6}, {"after", 1.0}}}};
  };
  model = converted(model, kMicroseconds);
  model["motions"] = {{"one", steps(6e5)}, {"same", steps(5e5)}};
  EXPECT_THAT([&] { run(model); },
              Throws<InvalidInput>(
                  Property(&InvalidInput::what,
                           AllOf(HasSubstr("motion same"), HasSubstr("contradicts motion one at t = 50")))));
  model["motions"].erase("one");
  model["motions"]["same"]["angle"] = "if(t < 500000, 0, 0.5)";
  EXPECT_THAT([&] { run(model); },
              Throws<Error>(Property(&Error::what, HasSubstr("at t = 500000 s with order"))));
}

}  // namespace
}  // namespace mfs::dae::test
