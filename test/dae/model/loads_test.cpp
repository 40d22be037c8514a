// Torques, springs of joints, followers, expressions: motions of whole models beside exact ones, and beside
// those that SciPy finds in minimal coordinates.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <mfs/error.hpp>

#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/expression.hpp"
#include "dae/mechanics/smooth_function.hpp"
#include "dae/model/model.hpp"

namespace mfs::dae {
namespace {

/// A wheel with the moment of inertia 2 about its axis z, which is oblique, and a slider of 3 kg along x.
Json machine() {
  return Json::parse(R"({
    "name": "machine", "end": 4, "outputs": 1,
    "parameters": {"k": "3 * 4", "half": 0.5},
    "bodies": {
      "wheel": {"type": "rigid", "mass": 1, "inertia": [1, 1, 2], "rotation": {"axis": [1, 2, 0], "angle": 0.8}},
      "slider": {"type": "rigid", "mass": "6 * half", "inertia": [1, 1, 1], "position": [1, 0, 0]}
    },
    "joints": {
      "bearing": {"type": "revolute", "a": "ground", "b": "wheel", "point": [0, 0, 0]},
      "guide": {"type": "translational", "a": "ground", "b": "slider", "point": [1, 0, 0], "axis": [1, 0, 0]}
    },
    "points": {"nose": {"body": "slider", "point": [1.5, 0, 0]}},
    "forces": {},
    "integrator": {"rtol": 1e-8, "atol_position": 1e-9, "atol_velocity": 1e-8}
  })");
}

Eigen::Vector3d wheel_axis() {
  return Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 2, 0).normalized()) * Eigen::Vector3d::UnitZ();
}

Json on_oblique_axis(Json json) {
  const Eigen::Vector3d axis = wheel_axis();
  json["joints"]["bearing"]["axis"] = {axis[0], axis[1], axis[2]};
  return json;
}

class ShortestStep final : public Observer {
 public:
  void step(const StepReport& line, const std::function<const State&()>&) override {
    h = std::min(h, line.h);
  }
  double h = HUGE_VAL;
};

class Loads : public testing::Test {
 protected:
  void run(const Json& json) {
    model_ = make_model(json, "", 1);
    Integrator integrator(*model_.system, model_.integrator);
    steps_ = {};
    end_ = integrator.run(0.0, model_.q0, model_.v0, model_.end, {}, steps_);
  }
  int coordinate(const std::string& name) const {
    for (int i = 0; i < model_.system->coordinates(); ++i)
      if (model_.system->coordinate_name(i) == name) return i;
    throw std::out_of_range(name);
  }
  double q(const std::string& name) const { return end_.q[coordinate(name)]; }
  double v(const std::string& name) const { return end_.v[coordinate(name)]; }
  /// Of the wheel about its axis from where it began, -pi ... pi.
  double wheel_turn() const {
    const auto p = [](const std::vector<double>& x, int first) {
      return Eigen::Quaterniond(x[first], x[first + 1], x[first + 2], x[first + 3]);
    };
    const int first = coordinate("wheel.e0");
    const Eigen::Quaterniond turn = p(end_.q, first) * p(model_.q0, first).conjugate();
    return std::remainder(2 * std::atan2(turn.vec().dot(wheel_axis()), turn.w()), 2 * std::acos(-1.0));
  }
  MultibodyModel model_;
  State end_;
  ShortestStep steps_;
};

/// A blow of 0.01 s in 10 s, in two units of time: between steps that end at rest there is nothing of it.
TEST_F(Loads, ABlowIsNotPassedOver) {
  for (const double second : {1.0, 1e4}) {
    Json json = on_oblique_axis(machine());
    json.erase("integrator");
    json["end"] = 10 * second;
    const std::string t = std::to_string(second), force = std::to_string(300 / (second * second));
    json["forces"]["blow"] = {{"type", "point"},
                              {"side", "slider"},
                              {"point", {1, 0, 0}},
                              {"x", "if(t > 3 * " + t + " && t < 3.01 * " + t + ", " + force + ", 0)"}};
    run(json);
    EXPECT_NEAR(v("slider.x") * second, 1.0, 5e-3) << second;
  }
}

/// The same by a table, half of a sine.
TEST_F(Loads, ABlowByATableIsNotPassedOver) {
  Json json = on_oblique_axis(machine());
  json.erase("integrator");
  json["end"] = 10;
  std::vector<double> times, torques;
  const auto add = [&](double time) {
    times.push_back(time);
    torques.push_back(time > 3 && time < 3.01 ? 200 * std::sin((time - 3) * 100 * std::acos(-1.0)) : 0.0);
  };
  for (int i = 0; i < 12; ++i) add(0.25 * i);
  for (int i = -30; i <= 40; ++i) add(3 + 0.001 * i);  // next to which a spline swings
  for (int i = 13; i <= 40; ++i) add(0.25 * i);
  json["forces"]["kick"] = {{"type", "actuator"},
                            {"joint", "bearing"},
                            {"torque", {{"type", "spline"}, {"x", times}, {"y", torques}}}};
  run(json);
  const Function torque = spline_function(times, torques);
  double impulse = 0.0;
  for (int i = 0; i < 100000; ++i) impulse += torque->value((i + 0.5) * 1e-4) * 1e-4;
  const Eigen::Quaterniond p(q("wheel.e0"), q("wheel.e1"), q("wheel.e2"), q("wheel.e3")),
      change(v("wheel.e0"), v("wheel.e1"), v("wheel.e2"), v("wheel.e3"));
  EXPECT_GT(impulse, 1.0);
  EXPECT_NEAR(2 * (change * p.conjugate()).vec().dot(wheel_axis()), impulse / 2, 5e-3);
}

/// Steps end before a force jumps, and the next ones begin with what it is then.
TEST_F(Loads, BlowsOfConstantForcesAreExact) {
  for (const char* method : {"bdf", "generalized_alpha"})
    for (const char* force : {"if(t > 3 && t < 3.01, 300, 0)", "3 * (t >= 3) - 3 * (4 < t)",
                              "if(t * t > 9 && exp(t) < exp(4), 3, 0) + 0 * guide.travel"}) {
      Json json = on_oblique_axis(machine());
      json["integrator"] = {{"method", method}};
      json["end"] = 10;
      json["forces"]["blow"] = {{"type", "point"}, {"side", "slider"}, {"point", {1, 0, 0}}, {"x", force}};
      run(json);
      EXPECT_NEAR(v("slider.x"), 1.0, 1e-10) << method << ", " << force;
    }
}

/// Also where the last jump is where the run ends, but for rounding, and others are at outputs.
TEST_F(Loads, OutputsAtJumpsAreAllThere) {
  struct Counter : Observer {
    void output(const State& state) override { times.push_back(state.t); }
    std::vector<double> times;
  };
  for (int end = 1; end <= 7; ++end) {
    Json json = on_oblique_axis(machine());
    json["end"] = end;
    json["forces"]["wave"] = {{"type", "point"},
                              {"side", "slider"},
                              {"point", {1, 0, 0}},
                              {"x", "if(sin(2 * pi * 20 * t) > 0, 10, -10)"}};
    const MultibodyModel model = make_model(json, "", 1);
    std::vector<double> outputs;
    for (int i = 0; i <= 10 * end; ++i) outputs.push_back(i / 10.0);
    Counter counter;
    Integrator(*model.system, model.integrator).run(0.0, model.q0, model.v0, model.end, outputs, counter);
    EXPECT_EQ(counter.times, outputs) << end;
  }
}

/// Pulses and steps of other forms, with whatever else the force has, beside the sum of their values.
TEST_F(Loads, APulseIsNotPassedOver) {
  for (const std::string force :
       {"300 * exp(-((t - 3) / 0.003)^2)", "1e5 * exp(-((t - 7.123) / 1e-4)^2)",
        "300 * exp(-((t^2 - 9) / 0.01)^2)", "100 * (tanh((t - 3) / 1e-3) - tanh((t - 3.01) / 1e-3))",
        "300 * sin(t)^4000", "if(sin(t) > 0.9999, 100, 0)", "3e6 * max(sin(t) - 0.9999, 0)",
        "1e-3 / ((t - 3)^2 + 1e-6)", "300 / cosh((t - 4) / 2e-3)",
        "5 * cos(t) + 600 * exp(-((t - 6) / 0.002)^2)"})
    for (const double second : {1.0, 1e4}) {
      const Function exact = expression_function(Expression(force), 0, {0.0});
      double impulse = 0.0;
      for (int i = 0; i < 1000000; ++i) impulse += exact->value((i + 0.5) * 1e-5) * 1e-5;
      ASSERT_GT(std::abs(impulse), 0.5) << force;
      Json json = on_oblique_axis(machine());
      json.erase("integrator");
      json["end"] = 10 * second;
      const std::string unit = std::to_string(second);
      const std::string of_unit = "(t / " + unit + ")", square = std::to_string(second * second);
      std::string text = force;
      for (std::size_t i = 0; (i = text.find('t', i)) != std::string::npos; i += of_unit.size()) {
        if (text.compare(i, 4, "tanh") == 0) {
          i += 4 - of_unit.size();
          continue;
        }
        text.replace(i, 1, of_unit);
      }
      json["forces"]["pulse"] = {{"type", "point"},
                                 {"side", "slider"},
                                 {"point", {1, 0, 0}},
                                 {"x", "(" + text + ") / " + square + " + 0 * guide.travel"}};
      run(json);
      EXPECT_NEAR(v("slider.x") * second, impulse / 3, 0.02) << force << ", " << second;
    }
}

/// The step that ends where a pulse begins takes what is there for a force that has grown all the way: at
/// 1e-3 by generalized-alpha that was five times all of the pulse's impulse.
TEST_F(Loads, AWeakPulseIsNotTakenForALongerOne) {
  for (const char* method : {"bdf", "generalized_alpha"})
    for (const double rtol : {1e-3, 3e-4, 1e-4, 3e-5, 1e-5}) {
      Json json = on_oblique_axis(machine());
      json["integrator"] = {{"method", method}, {"rtol", rtol}};
      json["end"] = 10;
      json["forces"]["pulse"] = {{"type", "point"},
                                 {"side", "slider"},
                                 {"point", {1, 0, 0}},
                                 {"x", "100 * exp(-((t - 3) / 1e-4)^2)"}};
      run(json);
      EXPECT_NEAR(v("slider.x"), 1e-2 / 3 * std::sqrt(std::acos(-1.0)), 15 * rtol) << method << " " << rtol;
    }
}

/// What lasts for a moment of the motion, beside its energy: at 10 m/s, 20 m ahead, by rtol alone.
TEST_F(Loads, WhatTheMotionPassesIsNotPassedOver) {
  struct Place {
    std::string force;
    double work;
  };
  for (const Place& place :
       {Place{"500 * exp(-((guide.travel - 20) / 0.05)^2)", 500 * 0.05 * std::sqrt(std::acos(-1.0))},
        {"if(guide.travel > 20 && guide.travel < 20.1, 600, 0)", 60},
        {"600 * (tanh((nose.x - 21.5) / 0.01) - tanh((nose.x - 21.6) / 0.01))", 120},
        {"500 * max(0, 1 - abs(guide.travel - 20) / 0.1)", 50},
        {"-500 * max(0, 1 - abs(guide.travel - 20) / 0.1) * guide.travel_rate / 10", -45.8333},
        {"3e-4 / ((guide.travel - 20)^2 + 1e-8)", 3 * std::acos(-1.0)}})
    for (const double second : {1.0, 1e3}) {
      Json json = on_oblique_axis(machine());
      json.erase("integrator");
      json["end"] = 5 * second;
      json["bodies"]["slider"]["velocity"] = {10 / second, 0, 0};
      const std::string square = std::to_string(second * second);
      json["forces"]["bump"] = {{"type", "point"},
                                {"side", "slider"},
                                {"point", {1, 0, 0}},
                                {"x", "(" + place.force + ") / " + square}};
      if (place.force.find("rate") != std::string::npos && second > 1) continue;
      run(json);
      EXPECT_NEAR(v("slider.x") * second, std::sqrt(100 + 2 * place.work / 3), 0.05) << place.force << second;
    }
}

/// A stop of 1e9 N/m, met within 2e-4 s: stiffness that is not there before is no reason to take errors for
/// vibrations.
TEST_F(Loads, ABodyBouncesOffAStiffStop) {
  const Json of_expression = {
      {"type", "point"}, {"side", "slider"}, {"point", {1, 0, 0}}, {"x", "-1e9 * max(0, guide.travel - 30)"}};
  const Json of_spring = {
      {"type", "translational_spring"}, {"joint", "guide"}, {"force", "1e9 * max(0, x - 30)"}};
  const Json smooth = {{"type", "translational_spring"},
                       {"joint", "guide"},
                       {"force", "1e9 * (x - 30 + sqrt((x - 30)^2 + 1e-8)) / 2"}};
  for (const char* method : {"bdf", "generalized_alpha"})
    for (const Json& stop : {of_expression, of_spring, smooth}) {
      Json json = on_oblique_axis(machine());
      json["integrator"] = {{"method", method}};
      json["end"] = 5;
      json["bodies"]["slider"]["velocity"] = {10, 0, 0};
      json["forces"]["stop"] = stop;
      run(json);
      EXPECT_NEAR(v("slider.x"), -10, 0.1) << method << ", " << stop;
    }
}

/// What the slider is driven by, and a function of the angle of the wheel.
TEST_F(Loads, AMotionForAMomentIsNotPassedOver) {
  struct Ends : Observer {
    void step(const StepReport& step, const std::function<const State&()>&) override {
      if (step.t > 3 && step.t < 3.01) ++inside;
    }
    int inside = 0;
  };
  const std::string bump = "if(t > 3 && t < 3.01, ((t - 3) * (3.01 - t) * 1e4)^3, 0)";
  for (const std::string& way : {bump, bump + " + 0 * bearing.angle"}) {
    Json json = on_oblique_axis(machine());
    json.erase("integrator");
    json["motions"]["drive"] = {{"type", "translation"}, {"joint", "guide"}, {"distance", way}};
    const MultibodyModel model = make_model(json, "", 1);
    for (const double fixed_step : {0.0, 0.5}) {
      IntegratorOptions options = model.integrator;
      options.fixed_step = fixed_step;
      Ends ends;
      Integrator(*model.system, options).run(0.0, model.q0, model.v0, 4.0, {}, ends);
      EXPECT_EQ(ends.inside > 0, fixed_step == 0.0) << way;
    }
  }
}

/// Where times until the end are not resolved to what steps have to be, that is said, and no force blamed.
TEST_F(Loads, AnEndThatIsTooFarIsNoFaultOfForces) {
  Json json = on_oblique_axis(machine());
  json["bodies"]["slider"]["velocity"] = {10, 0, 0};
  json["forces"]["coil"] = {{"type", "translational_spring"}, {"joint", "guide"}, {"stiffness", 12}};
  json.erase("integrator");
  for (const double end : {1e20, 1e100}) {
    json["end"] = end;
    try {
      run(json);
      ADD_FAILURE() << end;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("times until 1e+")) << end;
      EXPECT_THAT(error.what(), testing::HasSubstr("are resolved to")) << end;
      EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("force"))) << end;
    }
  }
}

TEST_F(Loads, ATorqueSpinsAWheelUp) {
  // t^2 / 2 . 12 / 2: 12 rad after 2 s, 48 after 4.
  const Eigen::Vector3d torque = 12 * wheel_axis();
  for (const char* axes : {"ground", "body"}) {
    Json json = on_oblique_axis(machine());
    json["end"] = 2;
    json["forces"]["motor"] = {{"type", "torque"}, {"side", "wheel"}, {"axes", axes}};
    // Neither the bearing nor the wheel feels the parts across the axis.
    for (int k = 0; k < 3; ++k) json["forces"]["motor"][std::string(1, "xyz"[k])] = std::to_string(torque[k]);
    run(json);
    EXPECT_NEAR(wheel_turn(), std::remainder(12.0, 2 * std::acos(-1.0)), 2e-5) << axes;
  }
  Json json = on_oblique_axis(machine());
  json["forces"]["motor"] = {{"type", "actuator"}, {"joint", "bearing"}, {"torque", "k"}};
  run(json);
  EXPECT_NEAR(wheel_turn(), std::remainder(48.0, 2 * std::acos(-1.0)), 2e-5);
  EXPECT_NEAR(q("quantity bearing.angle.value"), 48, 2e-5);  // which counts turns
  EXPECT_NEAR(v("quantity bearing.angle.value"), 24, 2e-5);
}

TEST_F(Loads, ATorsionPendulumSwingsPastAFullTurn) {
  Json json = on_oblique_axis(machine());
  json["forces"]["rod"] = {
      {"type", "rotational_spring"}, {"joint", "bearing"}, {"stiffness", 8}, {"free_angle", 9.0}};
  run(json);
  EXPECT_NEAR(q("quantity bearing.angle.value"), 9 - 9 * std::cos(2 * 4.0), 1e-5);

  json["forces"]["rod"] = {{"type", "rotational_spring"},
                           {"joint", "bearing"},
                           {"torque", "k * x * 2 / 3"},
                           {"free_angle", 9.0},
                           {"damping", 0.8}};
  run(json);
  const double decay = 0.2, frequency = std::sqrt(4 - decay * decay), t = 4;
  EXPECT_NEAR(
      q("quantity bearing.angle.value"),
      9 - 9 * std::exp(-decay * t) * (std::cos(frequency * t) + decay / frequency * std::sin(frequency * t)),
      1e-5);
}

TEST_F(Loads, ASpringAlongAGuideAndAnActuatorBetweenPoints) {
  Json json = on_oblique_axis(machine());
  json["forces"]["coil"] = {
      {"type", "translational_spring"}, {"joint", "guide"}, {"stiffness", 12}, {"free_travel", 0.3}};
  run(json);
  EXPECT_NEAR(q("slider.x"), 1.3 - 0.3 * std::cos(2 * 4.0), 1e-6);

  // The points' distance is x itself.
  json = on_oblique_axis(machine());
  json["forces"]["ram"] = {{"type", "actuator"},   {"a", "ground"},        {"b", "slider"},
                           {"point_a", {0, 0, 0}}, {"point_b", {1, 0, 0}}, {"force", "3 * cos(t)"}};
  json["integrator"] = {{"rtol", 1e-9}, {"atol_position", 1e-10}, {"atol_velocity", 1e-9}};
  run(json);
  EXPECT_NEAR(q("slider.x"), 2 - std::cos(4.0), 1e-6);
}

// Initial velocities that contradict a joint are corrected by the least change of those of the bodies: of
// 3 m/s and 0 rad/s at l = 0.6 m to (l w, w) with 4 |dp'|^2 = w^2 of the Euler parameters.
TEST_F(Loads, ASpringLeavesInitialVelocitiesAlone) {
  Json json = Json::parse(R"({
    "name": "bar", "end": 1e-6, "outputs": 1,
    "bodies": {"bar": {"type": "rigid", "mass": 2, "inertia": [1, 1, 1], "position": [0.6, 0, 0], "velocity": [0, 3, 0]}},
    "joints": {"hinge": {"type": "revolute", "a": "ground", "b": "bar", "point": [0, 0, 0], "axis": [0, 0, 1]}}
  })");
  const double l = 0.6, rate = 3 * l / (l * l + 0.25);
  run(json);
  EXPECT_NEAR(v("bar.y"), l * rate, 1e-5);
  json["forces"]["coil"] = {{"type", "rotational_spring"}, {"joint", "hinge"}};
  run(json);
  EXPECT_NEAR(v("bar.y"), l * rate, 1e-5);
  EXPECT_NEAR(v("quantity hinge.angle.value"), rate, 1e-5);
}

/// A body with a thrust fixed in it beside its centre: it turns by t^2 alpha / 2, and its velocity is a
/// Fresnel integral.
TEST_F(Loads, AFollowerTurnsWithItsBody) {
  Json json = Json::parse(R"({
    "name": "rocket", "end": 4, "outputs": 1,
    "bodies": {"rocket": {"type": "rigid", "mass": 2, "inertia": [2, 2, 3]}},
    "forces": {"thrust": {"type": "point", "side": "rocket", "point": [0, -0.6, 0], "axes": "body", "x": "10"}},
    "integrator": {"rtol": 1e-8, "atol_position": 1e-9, "atol_velocity": 1e-8}
  })");
  run(json);
  double along = 0.0, across = 0.0;  // by Simpson's rule
  const int intervals = 4000;
  for (int i = 0; i <= intervals; ++i) {
    const double t = 4.0 * i / intervals, weight = i == 0 || i == intervals ? 1 : i % 2 == 1 ? 4 : 2;
    along += weight * 4.0 / intervals / 3 * 5 * std::cos(t * t);
    across += weight * 4.0 / intervals / 3 * 5 * std::sin(t * t);
  }
  EXPECT_NEAR(v("rocket.x"), along, 1e-5);
  EXPECT_NEAR(v("rocket.y"), across, 1e-5);
}

/// Minimal coordinates a (wheel) and s (slider), by SciPy 1.17, solve_ivp DOP853, rtol 1e-13:
///   2 a'' = -k sin(a) + 2 (s - 0.5) a' - 0.3 a'^3,   3 s'' = -5 (s + s^3) - s' |s'| + 4 cos(3 t) + a
TEST_F(Loads, ExpressionsAreThoseOfMinimalCoordinates) {
  Json json = on_oblique_axis(machine());
  const Eigen::Vector3d spin = 1.5 * wheel_axis();
  json["bodies"]["wheel"]["angular_velocity"] = {spin[0], spin[1], spin[2]};
  json["forces"]["brake"] = {
      {"type", "actuator"},
      {"joint", "bearing"},
      {"torque",
       "-k*sin(bearing.angle) + 2*(guide.travel - half)*bearing.angle_rate - 0.3*bearing.angle_rate^3"}};
  json["forces"]["push"] = {
      {"type", "point"},
      {"side", "slider"},
      {"point", {1, 0.2, 0}},
      {"x", "-5*(nose.x - 1.5 + (nose.x - 1.5)^3) - nose.vx*abs(nose.vx) + 4*cos(3*t) + bearing.angle"}};
  run(json);
  EXPECT_NEAR(q("quantity bearing.angle.value"), -0.0390889930687, 2e-6);
  EXPECT_NEAR(q("quantity guide.travel.value"), -0.1466431412295, 2e-6);
  EXPECT_NEAR(q("slider.x"), 1 + -0.1466431412295, 2e-6);
}

/// A rack, and a cam that depends on time, too: s = -0.25 a + 0.1 sin(a) t, by SciPy as above.
TEST_F(Loads, AMotionFollowsOthers) {
  Json json = on_oblique_axis(machine());
  json["forces"]["motor"] = {{"type", "actuator"}, {"joint", "bearing"}, {"torque", "12"}};
  json["motions"]["rack"] = {
      {"type", "translation"}, {"joint", "guide"}, {"distance", "-half * bearing.angle"}};
  run(json);
  // (2 + 3 / 4) a'' = 12
  EXPECT_NEAR(q("quantity bearing.angle.value"), 0.5 * 12 / 2.75 * 16, 1e-5);
  EXPECT_NEAR(q("slider.x"), 1 - 0.5 * q("quantity bearing.angle.value"), 1e-9);

  json["motions"]["rack"] = {{"type", "point"},
                             {"side", "slider"},
                             {"point", {1, 0, 0}},
                             {"x", "1 - 0.25*bearing.angle + 0.1*sin(bearing.angle)*t"}};
  run(json);
  const double a = q("quantity bearing.angle.value");
  EXPECT_NEAR(a, 41.7219293041491, 1e-5);
  EXPECT_NEAR(q("slider.x"), 1 - 0.25 * a + 0.1 * std::sin(a) * 4, 1e-8);
}

/// x'' + x' / 4 + 4 x = 1.5 cos 2 t from rest: x = 3 sin 2 t - (6 / w) exp(-t / 8) sin w t, w^2 = 4 - 1 / 64.
/// A first step, of order 1, makes an arc of rates by its own error, however short it is.
TEST_F(Loads, AControllerBeginsWithoutTinySteps) {
  Json json = on_oblique_axis(machine());
  json["forces"]["motor"] = {
      {"type", "actuator"},
      {"joint", "bearing"},
      {"torque", "2 * (1.5 * cos(2*t) + (-bearing.angle_rate / 4 - 4 * bearing.angle))"}};
  const double w = std::sqrt(4 - 1.0 / 64);
  for (const double rtol : {1e-4, 1e-6, 1e-8}) {
    json["integrator"] = {{"rtol", rtol}};
    run(json);
    EXPECT_NEAR(q("quantity bearing.angle.value"), 3 * std::sin(8) - 6 / w * std::exp(-0.5) * std::sin(4 * w),
                300 * rtol);
    EXPECT_GE(steps_.h, 1e-11) << rtol;
  }
}

}  // namespace
}  // namespace mfs::dae
