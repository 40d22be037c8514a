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
#include "dae/statics/equilibrium.hpp"
#include "dae/statics/modes.hpp"
#include "test/dae/mechanics/system_derivatives.hpp"
#include "test/dae/model/units.hpp"
#include "test/dae/statics/models.hpp"
#include "test/reference/random.hpp"

namespace mfs::dae::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Property;
using testing::Throws;

constexpr Units kMinutes{"min", 1, 1, 1.0 / 60}, kHours{"h", 1, 1, 1.0 / 3600}, kDays{"d", 1, 1, 1.0 / 86400},
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

/// Where a model comes to rest, and its modes.
struct Rest {
  MultibodyModel model;
  State state;
  std::vector<Mode> modes;

  Rest(const Json& json, int count) : model(make_model(json, "", 1)) {
    state = find_equilibrium(*model.system, model.integrator, {0.0, model.q0, model.v0, {}, {}});
    modes = find_modes(*model.system, state, count, 1);
  }
  double q(const std::string& name) const { return state.q[mfs::test::coordinate(*model.system, name)]; }
};

// In microseconds it stayed where it was given, with success; in milliseconds it came to 5e-6 m; in minutes a
// last step of 1.2e-6 m, which mends a constraint against the weight, was refused whatever its length.
TEST(TimeUnit, PendulumHangsAndSwingsInAny) {
  Json json = mfs::test::pendulum(0.0);
  json["bodies"]["slider"] = {{"type", "rigid"}, {"mass", 2.0}, {"inertia", {1, 1, 1}}};
  json["joints"]["guide"] = joint("translational", "ground", "slider", Vector3d::Zero(), Vector3d::UnitX());
  json["forces"]["spring"] = {{"type", "translational_spring"}, {"joint", "guide"}, {"stiffness", 2e6}};
  for (const Units& units : {kMilliseconds, kMicroseconds, kMinutes, kHours, kDays}) {
    SCOPED_TRACE(units.name);
    const Rest rest(converted(json, units), 3);
    EXPECT_NEAR(rest.q("bar.x"), 0.0, 1e-9);
    EXPECT_NEAR(rest.q("bar.y"), -0.6, 1e-9);
    ASSERT_EQ(rest.modes.size(), 2U);
    const double slow = std::sqrt(2 * 9.81 * 0.6 / 0.96);
    EXPECT_NEAR(units.time * std::abs(rest.modes[0].s), slow, 1e-9 * slow);
    EXPECT_NEAR(units.time * std::abs(rest.modes[1].s), 1e3, 1e-6);
  }
}

// A spring that holds it up at 1.001 of what it takes, and one that does not at 0.999, wherever it stands.
TEST(TimeUnit, StandingPendulumIsUnstableInAny) {
  const double critical = 2 * 9.81 * 0.6;
  for (const Units& units :
       {kMilliseconds, kMicroseconds, kMinutes, kHours, kDays, Units{"mm, t", 1e3, 1e-3, 1},
        Units{"um, g", 1e6, 1e3, 1}, Units{"km, kg, h", 1e-3, 1, 1.0 / 3600}})
    for (const double part : {0.0, 0.999, 1.001}) {
      SCOPED_TRACE(std::string(units.name) + " " + std::to_string(part));
      Json json = converted(mfs::test::pendulum(std::acos(0.0)), units);
      json["forces"]["coil"] = {{"type", "rotational_spring"},
                                {"joint", "hinge"},
                                {"stiffness", part * critical * units.mass * units.length * units.length /
                                                  (units.time * units.time)}};
      const MultibodyModel model = make_model(json, "", 1);
      EquilibriumReport report;
      find_equilibrium(*model.system, model.integrator, {0.0, model.q0, model.v0, {}, {}}, &report);
      const double rate = std::sqrt(std::max(0.0, 1 - part) * critical / 0.96);
      EXPECT_NEAR(units.time * report.growth, rate, 1e-6 * rate);
      EXPECT_EQ(report.escapes, 0);
    }
}

// The travel has the stiffness, the body has the mass: 3 % were wrong in picoseconds, with success.
TEST(TimeUnit, BodyOnASpringSwingsInAny) {
  Json json = mechanism(1.0, 1, Vector3d::Zero());
  json["bodies"]["slider"] = {{"type", "rigid"}, {"mass", 2.0}, {"inertia", {1, 1, 1}}};
  json["joints"]["guide"] = joint("translational", "ground", "slider", Vector3d::Zero(), Vector3d::UnitX());
  json["forces"]["spring"] = {{"type", "translational_spring"}, {"joint", "guide"}, {"stiffness", 50.0}};
  for (const Units& units : {Units{"s", 1, 1, 1}, Units{"ps", 1, 1, 1e12}, kDays}) {
    SCOPED_TRACE(units.name);
    const Rest rest(converted(json, units), 1);
    ASSERT_EQ(rest.modes.size(), 1U);
    EXPECT_NEAR(units.time * std::abs(rest.modes[0].s), 5.0, 1e-12);
  }
}

// Euler's and Bernoulli's beam sags by g L^4 / 8 (rho A / E I); (k L)^2 are those of a cantilever. Arnoldi's
// method lost modes in days, and the search ended before the beam had sagged in microseconds.
TEST(TimeUnit, BeamSagsAndSwingsInAny) {
  constexpr double kHeight = 0.02, kSpeed = 5000.0;  // of sound
  Json json = mfs::test::cantilever(kHeight, 0.03, 24);
  json["gravity"] = triple({0, -9.81, 0});
  const double per_square = 12.0 / std::pow(kSpeed * kHeight, 2);
  std::vector<double> in_seconds;
  for (const Units& units : {Units{"s", 1, 1, 1}, kMicroseconds, kDays}) {
    SCOPED_TRACE(units.name);
    const Rest rest(converted(json, units), 5);
    double sag = 0.0;
    for (std::size_t i = 0; i < rest.state.q.size(); ++i)
      sag = std::max(sag, std::abs(rest.state.q[i] - rest.model.q0[i]));
    EXPECT_NEAR(sag, 9.81 / 8.0 * per_square, 0.015 * sag);
    ASSERT_EQ(rest.modes.size(), 5U);
    const double first = 1.8751040687 * 1.8751040687 / std::sqrt(per_square);
    EXPECT_NEAR(units.time * std::abs(rest.modes[0].s), first, 0.01 * first);
    EXPECT_NEAR(units.time * std::abs(rest.modes[1].s), 1.5 * first, 0.015 * first);
    for (std::size_t i = 0; i < 5; ++i) {
      const double s = units.time * std::abs(rest.modes[i].s);
      if (units.time == 1.0) in_seconds.push_back(s);
      EXPECT_NEAR(s, in_seconds[i], 1e-6 * s);
    }
  }
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
