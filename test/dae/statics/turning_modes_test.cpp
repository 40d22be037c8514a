// Small motions of what turns, beside closed formulas.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include <mfs/error.hpp>

#include "dae/model/model.hpp"
#include "dae/model/model_library.hpp"
#include "dae/statics/modes.hpp"
#include "dae/statics/steady_motion.hpp"
#include "test/dae/model/linear_bicycle.hpp"

namespace mfs::dae {
namespace {

using Complex = std::complex<double>;

/// Modes about a state of the motion.
class TurningModes : public testing::Test {
 protected:
  void find(const Json& json, double t, int count = 20) {
    model_ = make_model(json, "", 1);
    model_.integrator.threads = 1;
    model_.integrator.rtol = kMotionRtol;
    state_ = state_at({0.0, model_.q0, model_.v0, {}, {}}, t);
    modes_ = find_modes(*model_.system, state_, count, 1);
  }
  /// The same by what the motion comes to a little later.
  void find_in_motion(const Json& json, double t) {
    find(json, t);
    ModesInMotion found = find_modes_in_motion(
        *model_.system, state_, [this](double later) { return state_at(state_, later); }, 20, 1);
    modes_ = found.modes;
    steady_ = found.steady;
    kind_ = found.axes.kind();
    rate_ = found.axes.rate();
  }
  State state_at(const State& from, double t) const {
    Integrator integrator(*model_.system, model_.integrator);
    struct First : Observer {
      void output(const State& state) override { taken = state; }
      State taken;
    } first;
    integrator.run(from.t, from.q, from.v, std::max(t, from.t + 1e-3), {t}, first);
    return first.taken;
  }
  void expect_mode(Complex s, double tolerance) const {
    const auto is_near = [&](const Mode& mode) { return std::abs(mode.s - s) <= tolerance * std::abs(s); };
    EXPECT_EQ(std::count_if(modes_.begin(), modes_.end(), is_near), 1) << s;
  }
  TurningAxes axes() const { return {*model_.system, state_}; }

  MultibodyModel model_;
  State state_;
  std::vector<Mode> modes_;
  bool steady_ = false;
  TurningAxes::Kind kind_ = TurningAxes::Kind::of_ground;
  double rate_ = 0.0;
};

/// A disc that turns in a light case on springs: a w'' - i C W w' + k w = 0 of the case's tilt, whose roots
/// are 153.3 and -3.26 i. Nothing of it depends on where the disc has turned to.
TEST_F(TurningModes, OfARotorOnSprings) {
  Json json = Json::parse(R"({"name": "rotor", "end": 1, "outputs": 1, "bodies": {
    "box": {"type": "rigid", "mass": 0.5, "inertia": [0.01, 0.01, 0.01]},
    "disc": {"type": "rigid", "mass": 2, "inertia": [0.05, 0.05, 0.09], "angular_velocity": [0, 0, 100]}},
    "joints": {"axle": {"type": "revolute", "a": "box", "b": "disc", "point": [0, 0, 0], "axis": [0, 0, 1]}},
    "forces": {"mount": {"type": "bushing", "a": "ground", "b": "box", "point": [0, 0, 0],
      "stiffness": [500, 500, 500, 30, 30, 30]}}})");
  const double inertia = 0.06, spin = 0.09 * 100, stiffness = 30;
  const double root = std::sqrt(spin * spin + 4 * inertia * stiffness);
  for (const double turned : {0.0, 0.7}) {
    json["bodies"]["disc"]["rotation"] = {{"axis", {0, 0, 1}}, {"angle", turned}};
    find(json, 0.0);
    EXPECT_TRUE(axes().moves());
    EXPECT_FALSE(axes().turn_along());
    expect_mode({0.0, (root + spin) / (2 * inertia)}, 1e-6);
    expect_mode({0.0, (root - spin) / (2 * inertia)}, 1e-6);
    expect_mode({0.0, std::sqrt(30 / 0.01)}, 1e-6);
  }
}

/// A top that stands: A w'' - i C W w' - m g l w = 0, seen from axes that turn with it. It falls unless
/// C W is more than 2 sqrt(A m g l).
TEST_F(TurningModes, OfASleepingTop) {
  Json json = Json::parse(R"({"name": "top", "end": 1, "outputs": 1, "gravity": [0, 0, -9.81],
    "bodies": {"top": {"type": "rigid", "mass": 1, "inertia": [0.02, 0.02, 0.03], "position": [0, 0, 0.5]}},
    "joints": {"foot": {"type": "spherical", "a": "ground", "b": "top", "point": [0, 0, 0]}}})");
  for (const double rate : {30.0, 60.0, 100.0}) {
    json["bodies"]["top"]["angular_velocity"] = {0, 0, rate};
    find(json, 0.0);
    EXPECT_TRUE(axes().steady());
    EXPECT_NEAR(axes().rate(), rate, 1e-9);
    const double a = 0.02 + 0.25, c = 0.03 * rate, weight = 9.81 * 0.5;
    const Complex root = std::sqrt(Complex(4 * a * weight - c * c));
    for (const double sign : {1.0, -1.0}) {
      const Complex s = (Complex(0, c) + sign * root) / (2 * a) - Complex(0, rate);
      expect_mode({s.real(), std::abs(s.imag())}, 1e-6);
    }
  }
}

/// Euler's equations about each of the axes of a free body: s^2 = W^2 (I - J) (J - K) / (I K).
TEST_F(TurningModes, OfAFreeBodyAboutItsAxes) {
  const double inertia[3] = {0.1, 0.2, 0.25}, rate = 7.0;
  for (int axis = 0; axis < 3; ++axis) {
    Json json = {{"name", "body"}, {"end", 1}, {"outputs", 1}};
    std::vector<double> turn(3, 0.0);
    turn[axis] = rate;
    json["bodies"]["body"] = {
        {"type", "rigid"}, {"mass", 1}, {"inertia", inertia}, {"angular_velocity", turn}};
    find(json, 0.0);
    const double i = inertia[(axis + 1) % 3], j = inertia[axis], k = inertia[(axis + 2) % 3];
    expect_mode(std::sqrt(Complex((i - j) * (j - k) / (i * k))) * rate, 1e-6);
  }
}

/// A bar with two masses on springs along it, all free and turning: in step, they are slowed and sped by the
/// bar's change of rate, s^2 = W^2 - k / m - 8 m r^2 W^2 / J, J of all.
TEST_F(TurningModes, OfAFreeBarWithMassesOnSprings) {
  const double stiffness = 1000, out = 0.5, whole = 0.1 + 2 * 0.01 + 2 * out * out;
  for (const double rate : {1.0, 10.0}) {
    Json json = {{"name", "bar"}, {"end", 1}, {"outputs", 1}};
    const double travel = -out * rate * rate / stiffness;
    for (const auto& [name, x] : {std::pair("bar", 0.0), std::pair("left", -out), std::pair("right", out)}) {
      const double inertia = x == 0 ? 0.1 : 0.01;
      json["bodies"][name] = {{"type", "rigid"},
                              {"mass", 1},
                              {"inertia", {inertia, inertia, inertia}},
                              {"position", {x, 0, 0}},
                              {"velocity", {0, x * rate, 0}},
                              {"angular_velocity", {0, 0, rate}}};
      if (x == 0) continue;
      json["joints"][name] = {{"type", "translational"},
                              {"a", "bar"},
                              {"b", name},
                              {"point", {x, 0, 0}},
                              {"axis", {x / out, 0, 0}}};
      json["forces"][name] = {{"type", "translational_spring"},
                              {"joint", name},
                              {"stiffness", stiffness},
                              {"free_travel", travel}};
    }
    find(json, 0.0);
    expect_mode({0.0, std::sqrt(stiffness - rate * rate + 8 * out * out * rate * rate / whole)}, 1e-8);
    for (const Mode& mode : modes_) EXPECT_LE(std::abs(mode.s.real()), 1e-6 * rate) << mode.s;
  }
}

/// Two masses on a spring that hold each other on a circle: along it k / m + 3 W^2 of the reduced mass.
TEST_F(TurningModes, OfAPairOnASpring) {
  Json json = {{"name", "pair"}, {"end", 1}, {"outputs", 1}};
  for (const auto& [name, x] : {std::pair("a", -0.5), std::pair("b", 0.5)}) {
    json["bodies"][name] = {{"type", "rigid"},
                            {"mass", 1},
                            {"inertia", {0.1, 0.1, 0.1}},
                            {"position", {x, 0, 0}},
                            {"velocity", {0, x, 0}},
                            {"angular_velocity", {0, 0, 1}}};
  }
  json["forces"]["spring"] = {{"type", "spring_damper"},
                              {"a", "a"},
                              {"b", "b"},
                              {"point_a", {-0.5, 0, 0}},
                              {"point_b", {0.5, 0, 0}},
                              {"stiffness", 1000},
                              {"free_length", 1 - 0.5 / 1000}};
  find(json, 0.0);
  expect_mode({0.0, std::sqrt(1000 / 0.5 + 3)}, 1e-8);
  for (const Mode& mode : modes_) EXPECT_LE(std::abs(mode.s.real()), 1e-5) << mode.s;
}

/// About its axis a thin rod has next to no inertia, and is free.
TEST_F(TurningModes, OfAThinRodOnSprings) {
  const Json json = Json::parse(R"({"name": "rod", "end": 1, "outputs": 1, "bodies": {
    "rod": {"type": "rigid", "mass": 1, "inertia": [5e-9, 0.08333333333333333, 0.08333333333333333]}},
    "forces": {
    "left": {"type": "bushing", "a": "ground", "b": "rod", "point": [-0.5, 0, 0], "stiffness": [1e4, 1e4, 1e4, 0, 0, 0]},
    "right": {"type": "bushing", "a": "ground", "b": "rod", "point": [0.5, 0, 0], "stiffness": [1e4, 1e4, 1e4, 0, 0, 0]}}})");
  find(json, 0.0);
  const auto times = [&](double s) {
    return std::count_if(modes_.begin(), modes_.end(),
                         [&](const Mode& mode) { return std::abs(mode.s - Complex(0, s)) <= 1e-8 * s; });
  };
  EXPECT_EQ(times(std::sqrt(2e4)), 3);
  EXPECT_EQ(times(std::sqrt(2e4 * 0.25 / 0.08333333333333333)), 2);
}

/// A bob on a hinge of a turntable, out at cos(x) = g / (l W^2): W sin(x).
TEST_F(TurningModes, OfABobOnATurntable) {
  const double rate = 6.0, out = std::acos(9.81 / (rate * rate));
  Json json =
      Json::parse(R"({"name": "governor", "end": 1, "outputs": 1, "gravity": [0, 0, -9.81], "bodies": {
    "table": {"type": "rigid", "mass": 1, "inertia": [0.1, 0.1, 0.1], "angular_velocity": [0, 0, 6]},
    "bob": {"type": "rigid", "mass": 1, "inertia": [1e-9, 1e-9, 1e-9], "angular_velocity": [0, 0, 6]}},
    "joints": {"axle": {"type": "revolute", "a": "ground", "b": "table", "point": [0, 0, 0], "axis": [0, 0, 1]},
      "hinge": {"type": "revolute", "a": "table", "b": "bob", "point": [0, 0, 0], "axis": [0, 1, 0]}},
    "motions": {"drive": {"type": "rotation", "joint": "axle", "angle": "6 * t"}}})");
  json["bodies"]["bob"]["position"] = {std::sin(out), 0, -std::cos(out)};
  json["bodies"]["bob"]["velocity"] = {0, rate * std::sin(out), 0};
  for (const double t : {0.0, 0.2}) {
    find(json, t);
    EXPECT_TRUE(axes().steady());
    ASSERT_EQ(modes_.size(), 1U);
    expect_mode({0.0, rate * std::sin(out)}, 1e-6);
  }
}

/// A blade without hub: bending out of the plane of rotation at 4.7973 and 3.516 times sqrt(E I / (rho A)) /
/// L^2 at 3 and at 0 of these (Wright, Smith, Thresher and Wang, J. Applied Mechanics 49 (1982) 197-202). In
/// the plane there is W^2 less of its square. It is stretched by its rotation once that vibration has died
/// away. The velocity that it is given is off by rounding of the motion's text. What corrects it is rounding
/// across the plane, and was refused where all of that was asked to have a relative accuracy.
TEST_F(TurningModes, OfABlade) {
  const double unit = std::sqrt(2e11 / 7800 / 12) * 0.01, rate = 3 * unit;
  Json json = Json::parse(R"({"name": "blade", "end": 0.1, "outputs": 1,
    "materials": {"steel": {"law": "st_venant_kirchhoff", "young": 2e11, "poisson": 0.3, "density": 7800}},
    "bodies": {"hub": {"type": "rigid", "mass": 1, "inertia": [0.1, 0.1, 0.1]},
      "blade": {"type": "flexible", "material": "steel", "damping": {"beta": 1e-4}, "position": [0, -0.005, -0.005],
        "mesh": {"generator": "box", "element": "hex20", "refine": 1, "size": [1, 0.01, 0.01],
          "divisions": [20, 1, 1]}}},
    "joints": {"axle": {"type": "revolute", "a": "ground", "b": "hub", "point": [0, 0, 0], "axis": [0, 0, 1]},
      "root": {"type": "fixed", "a": "hub", "b": "blade:x0", "point": [0, 0, 0]}},
    "motions": {"drive": {"type": "rotation", "joint": "axle"}}})");
  json["motions"]["drive"]["angle"] = std::to_string(rate) + " * t";
  json["bodies"]["hub"]["angular_velocity"] = json["bodies"]["blade"]["angular_velocity"] = {0, 0, rate};
  json["bodies"]["blade"]["velocity"] = {0.005 * rate, 0, 0};
  find(json, 0.1, 4);
  EXPECT_TRUE(axes().steady());
  std::vector<double> rates;
  for (const Mode& mode : modes_) rates.push_back(std::abs(mode.s));
  EXPECT_NEAR(rates[0], std::sqrt(4.7973 * 4.7973 - 9) * unit, 0.01 * rates[0]);
  EXPECT_NEAR(rates[1], 4.7973 * unit, 0.01 * rates[1]);
}

/// What is at rest, or only goes along, has the axes of the ground.
TEST_F(TurningModes, DoNotDependOnAnEvenMotionAlong) {
  Json json = Json::parse(R"({"name": "cart", "end": 1, "outputs": 1, "bodies": {
    "cart": {"type": "rigid", "mass": 3, "inertia": [1, 1, 1], "velocity": [2, 0, 0]},
    "load": {"type": "rigid", "mass": 1, "inertia": [1, 1, 1], "velocity": [2, 0, 0]}},
    "joints": {"rail": {"type": "translational", "a": "ground", "b": "cart", "point": [0, 0, 0], "axis": [1, 0, 0]},
      "guide": {"type": "translational", "a": "cart", "b": "load", "point": [0, 0, 0], "axis": [1, 0, 0]}},
    "forces": {"spring": {"type": "translational_spring", "joint": "guide", "stiffness": 12}}})");
  find(json, 0.5);
  EXPECT_TRUE(axes().moves());
  EXPECT_FALSE(axes().turn_along());
  expect_mode({0.0, 4.0}, 1e-6);
  json["bodies"]["cart"]["velocity"] = json["bodies"]["load"]["velocity"] = {0, 0, 0};
  find(json, 0.0);
  EXPECT_FALSE(axes().moves());
  expect_mode({0.0, 4.0}, 1e-6);
}

/// A round disc on springs of 8000 N/m along x and 18000 N/m along y, half of them 0.5 m to either side. All
/// turns as one body, and in axes that turn along the springs would turn: modes are those in the ground's
/// axes,
///   2 x'' + 8000 x = 0 and the like, A a'' + C W b' + k_y a = 0, A b'' - C W a' + k_x b = 0
/// with k = 2000 and 4500 N m. Where the disc is not round there are none.
TEST_F(TurningModes, OfARotorOnSpringsThatDiffer) {
  Json json = Json::parse(R"({"name": "rotor", "end": 1, "outputs": 1, "bodies": {
    "disc": {"type": "rigid", "mass": 2, "inertia": [0.05, 0.05, 0.09], "angular_velocity": [0, 0, 100]}}})");
  for (const double z : {-0.5, 0.5})
    for (const int axis : {0, 1})
      for (const double side : {-50.0, 50.0}) {
        std::vector<double> from{0, 0, z};
        from[axis] = side;
        json["forces"]["spring" + std::to_string(json["forces"].size())] = {
            {"type", "spring_damper"}, {"a", "ground"},        {"b", "disc"},
            {"point_a", from},         {"point_b", {0, 0, z}}, {"stiffness", axis == 0 ? 2000 : 4500}};
      }
  const double a = 0.05, spin = 0.09 * 100, along_x = 2000, along_y = 4500;
  const double sum = a * (along_x + along_y) + spin * spin,
               root = std::sqrt(sum * sum - 4 * a * a * along_x * along_y);
  for (const double t : {0.0, 0.01, 0.3}) {
    find_in_motion(json, t);
    EXPECT_TRUE(steady_);
    EXPECT_EQ(kind_, TurningAxes::Kind::of_ground);
    expect_mode({0.0, std::sqrt(4000)}, 1e-5);
    expect_mode({0.0, std::sqrt(9000)}, 1e-5);
    expect_mode({0.0, std::sqrt((sum - root) / 2) / a}, 1e-5);
    expect_mode({0.0, std::sqrt((sum + root) / 2) / a}, 1e-5);
  }
  json["bodies"]["disc"]["inertia"] = {0.05, 0.07, 0.09};
  find_in_motion(json, 0.01);
  EXPECT_FALSE(steady_);
}

/// A top that leans by x, spins at c / C and precesses at p: A p^2 cos x - c p + m g l = 0. It nutates as a
/// mass A in the potential (P - c cos x)^2 / (2 A sin^2 x) + m g l cos x with P = A p sin^2 x + c cos x,
/// whose second derivative is taken by differences. With another velocity it nutates, and there are no modes.
TEST_F(TurningModes, OfATopThatPrecesses) {
  const double a = 0.02 + 0.25, weight = 9.81 * 0.5;
  Json json = Json::parse(R"({"name": "top", "end": 1, "outputs": 1, "gravity": [0, 0, -9.81],
    "bodies": {"top": {"type": "rigid", "mass": 1, "inertia": [0.02, 0.02, 0.03]}},
    "joints": {"foot": {"type": "spherical", "a": "ground", "b": "top", "point": [0, 0, 0]}}})");
  Json& top = json["bodies"]["top"];
  for (const auto& [lean, rate] : {std::pair{0.3, 150.0}, {0.5, 100.0}, {1.0, 60.0}, {2.0, 50.0}}) {
    const double c = 0.03 * rate, up = std::cos(lean), across = std::sin(lean);
    const double turn = (c - std::sqrt(c * c - 4 * a * up * weight)) / (2 * a * up), spin = rate - turn * up;
    top["position"] = {0.5 * across, 0, 0.5 * up};
    top["rotation"] = {{"axis", {0, 1, 0}}, {"angle", lean}};
    top["angular_velocity"] = {spin * across, 0, turn + spin * up};
    top["velocity"] = {0, turn * 0.5 * across, 0};
    const double momentum = a * turn * across * across + c * up, h = 1e-3;
    const auto potential = [&](double x) {
      return std::pow((momentum - c * std::cos(x)) / std::sin(x), 2) / (2 * a) + weight * std::cos(x);
    };
    const double bend = (potential(lean + h) - 2 * potential(lean) + potential(lean - h)) / (h * h);
    for (const double t : {0.0, 0.05}) {
      find_in_motion(json, t);
      EXPECT_TRUE(steady_) << lean;
      EXPECT_EQ(kind_, TurningAxes::Kind::precessing);
      EXPECT_NEAR(rate_, turn, 1e-3 * turn);
      expect_mode({0.0, std::sqrt(bend / a)}, 1e-4);
    }
    top["angular_velocity"][0] = spin * across + 0.05 * rate;
    top["velocity"][1] = 0.5 * (turn * across - 0.05 * rate * up);
    find_in_motion(json, 0.05);
    EXPECT_FALSE(steady_) << lean;
  }
}

/// Seen from axes that turn with its angular momentum it nutates at the rate of that, |L| / A; what goes
/// along goes around at that rate, too.
TEST_F(TurningModes, OfAFreeRoundBodyThatPrecesses) {
  const Json json = Json::parse(R"({"name": "body", "end": 1, "outputs": 1, "bodies": {
    "body": {"type": "rigid", "mass": 1, "inertia": [0.2, 0.2, 0.1], "angular_velocity": [1, 0, 5],
      "velocity": [1, 2, 3]}}})");
  find_in_motion(json, 0.3);
  EXPECT_TRUE(steady_);
  const double rate = std::hypot(0.2 * 1, 0.1 * 5) / 0.2;
  EXPECT_NEAR(rate_, rate, 1e-4);
  EXPECT_EQ(std::count_if(modes_.begin(), modes_.end(),
                          [&](const Mode& mode) { return std::abs(mode.s - Complex(0, rate)) < 1e-3; }),
            3);
}

/// What moves between springs has constant matrices where these are linear alone.
TEST_F(TurningModes, OfASwingingMassAreThoseOfLinearSprings) {
  Json json = Json::parse(R"({"name": "mass", "end": 1, "outputs": 1, "bodies": {
    "mass": {"type": "rigid", "mass": 1, "inertia": [1, 1, 1], "velocity": [1, 0, 0]}},
    "joints": {"guide": {"type": "translational", "a": "ground", "b": "mass", "point": [0, 0, 0], "axis": [1, 0, 0]}},
    "forces": {"spring": {"type": "translational_spring", "joint": "guide"}}})");
  json["forces"]["spring"]["force"] = "9 * x";
  find_in_motion(json, 0.3);
  EXPECT_TRUE(steady_);
  expect_mode({0.0, 3.0}, 1e-6);
  json["forces"]["spring"]["force"] = "9 * x + 30 * x^3";
  find_in_motion(json, 0.3);
  EXPECT_FALSE(steady_);
}

/// Of lean and steer, published; what the bicycle has besides, its place and its speed, is free.
TEST_F(TurningModes, OfABicycle) {
  Json json = Json::parse(find_library_model("bicycle")->text);
  for (const double speed : {2.0, 5.0, 8.0}) {
    json["parameters"] = {{"speed", speed}, {"lean_rate", 0.0}};
    Eigen::Matrix4d rate;
    for (int k = 0; k < 4; ++k) rate.col(k) = test::LinearBicycle(speed).rate(Eigen::Vector4d::Unit(k));
    const Eigen::Vector4cd published = rate.eigenvalues();
    for (const double t : {0.0, 0.3}) {
      find_in_motion(json, t);
      EXPECT_TRUE(steady_);
      EXPECT_EQ(kind_, TurningAxes::Kind::of_ground);
      for (const Complex s : published)
        if (s.imag() >= 0) expect_mode(s, t > 0 ? 1e-4 : 1e-8);
      EXPECT_EQ(std::count_if(modes_.begin(), modes_.end(),
                              [](const Mode& mode) { return std::abs(mode.s) > 0.01; }),
                std::count_if(published.begin(), published.end(), [](Complex s) { return s.imag() >= 0; }));
    }
  }
  json["parameters"] = {{"speed", 5.0}, {"lean_rate", 0.5}};
  find_in_motion(json, 0.3);
  EXPECT_FALSE(steady_);
}

/// A thin disc whose axle is x off the vertical; it turns by n about the axle and goes around a circle by p.
/// With its moments of inertia A and C, B = m r^2, and the turn P = p sin x about its steepest line, moments
/// about where it touches are
///   (A + B) x'' = A P^2 cot x - (C + B) n P - m g r cos x,   A P' = (C n - A P cot x) x',
///   (C + B) n' = B P x'
/// (Routh, Advanced Rigid Dynamics, art. 244). Its centre goes around with p besides.
class RollingDisc : public TurningModes {
 protected:
  static constexpr double kMass = 1.0, kRadius = 0.5, kAcross = 0.0625, kAlong = 0.125, kRolls = 0.25;
  /// `wobble`: a rate of x, 1/s.
  static Json disc(double x, double n, double p, double wobble = 0.0) {
    Json json = Json::parse(R"({"name": "disc", "end": 1, "outputs": 1, "gravity": [0, 0, -9.81], "bodies": {
      "disc": {"type": "rigid", "mass": 1, "inertia": [0.0625, 0.0625, 0.125]}}, "joints": {
      "road": {"type": "rolling_wheel", "a": "ground", "b": "disc", "axis": [0, 0, 1], "radius": 0.5}}})");
    const double up = std::cos(x), out = std::sin(x), spin = n - p * up;
    Json &body = json["bodies"]["disc"], &road = json["joints"]["road"];
    body["position"] = road["point"] = {0, 0, kRadius * out};
    body["rotation"] = {{"axis", {0, 1, 0}}, {"angle", x}};
    body["angular_velocity"] = {spin * out, wobble, p + spin * up};
    body["velocity"] = {wobble * kRadius * out, -n * kRadius, wobble * kRadius * up};
    road["axis_b"] = {out, 0, up};
    return json;
  }
  static double square(double x, double n, double p) {
    const double turn = p * std::sin(x), along = p * std::cos(x);
    return ((2 * kAcross * along - (kAlong + kRolls) * n) * (kAlong / kAcross * n - along) - kAcross * p * p +
            kMass * 9.81 * kRadius * std::sin(x) - kRolls * turn * turn) /
           (kAcross + kRolls);
  }
};

TEST_F(RollingDisc, StandsWhereItIsFastEnough) {
  // It falls unless n^2 > g / 3 r = 2.56^2.
  for (const double n : {1.5, 2.5, 2.6, 4.0}) {
    EXPECT_EQ(n<2.56, square(M_PI_2, n, 0.0)> 0);
    for (const double t : {0.0, 0.1}) {
      find_in_motion(disc(M_PI_2, n, 0.0), t);
      EXPECT_TRUE(steady_);
      EXPECT_EQ(kind_, TurningAxes::Kind::of_ground);
      expect_mode(std::sqrt(Complex(square(M_PI_2, n, 0.0))), t > 0 ? 1e-4 : 1e-8);
    }
  }
}

TEST_F(RollingDisc, GoesAroundACircle) {
  for (const auto& [x, p] : {std::pair{1.2, 3.0}, {0.8, 4.0}, {1.5, -0.5}}) {
    const double turn = p * std::sin(x);
    const double n = (kAcross * p * turn * std::cos(x) - kMass * 9.81 * kRadius * std::cos(x)) /
                     ((kAlong + kRolls) * turn);
    for (const double t : {0.0, 0.4}) {
      find_in_motion(disc(x, n, p), t);
      EXPECT_TRUE(steady_) << x;
      EXPECT_EQ(kind_, TurningAxes::Kind::precessing);
      EXPECT_NEAR(rate_, std::abs(p), 1e-3 * std::abs(p));
      expect_mode(std::sqrt(Complex(square(x, n, p))), 1e-3);
      expect_mode({0.0, std::abs(p)}, 1e-3);
    }
    find_in_motion(disc(x, n, p, 1.0), 0.1);
    EXPECT_FALSE(steady_) << x;
  }
}

/// Its centre goes around by 2/7 of the table's turn, wherever that has begun.
TEST_F(TurningModes, OfABallOnATurntable) {
  const Json json =
      Json::parse(R"({"name": "ball", "end": 1, "outputs": 1, "gravity": [0, 0, -9.81], "bodies": {
    "table": {"type": "rigid", "mass": 1, "inertia": [1, 1, 1], "angular_velocity": [0, 0, 7]},
    "ball": {"type": "rigid", "mass": 2, "inertia": [0.008, 0.008, 0.008], "position": [0, 0, 0.1]}},
    "joints": {"axle": {"type": "revolute", "a": "ground", "b": "table", "point": [0, 0, 0], "axis": [0, 0, 1]},
      "table": {"type": "rolling_ball", "a": "table", "b": "ball", "point": [0, 0, 0.1], "axis": [0, 0, 1],
        "radius": 0.1}},
    "motions": {"drive": {"type": "rotation", "joint": "axle", "angle": "7 * t"}}})");
  find_in_motion(json, 0.2);
  EXPECT_TRUE(steady_);
  EXPECT_EQ(kind_, TurningAxes::Kind::of_ground);
  expect_mode({0.0, 2.0}, 1e-6);
}

/// As A x = 0 is what Arnoldi's method knows.
TEST_F(RollingDisc, IsRefusedWithALargeMesh) {
  Json json = disc(M_PI_2, 4.0, 0.0);
  json["materials"]["rubber"] = {
      {"law", "st_venant_kirchhoff"}, {"young", 1e7}, {"poisson", 0.3}, {"density", 1000}};
  json["bodies"]["box"] = {{"type", "flexible"},
                           {"material", "rubber"},
                           {"damping", {{"beta", 1e-3}}},
                           {"position", {-0.05, -0.05, 0.45}},
                           {"velocity", {0.2, -2.2, 0}},
                           {"angular_velocity", {4, 0, 0}},
                           {"mesh",
                            {{"generator", "box"},
                             {"element", "hex8"},
                             {"refine", 1},
                             {"size", {0.1, 0.1, 0.1}},
                             {"divisions", {6, 6, 6}}}}};
  json["joints"]["hub"] = {{"type", "fixed"}, {"a", "disc"}, {"b", "box:x0"}, {"point", {-0.05, 0, 0.5}}};
  EXPECT_THAT([&] { find(json, 0.0); },
              testing::Throws<InvalidInput>(testing::Property(
                  &InvalidInput::what, testing::AllOf(testing::HasSubstr("joint road"),
                                                      testing::HasSubstr("up to 150 degrees of freedom")))));
}

}  // namespace
}  // namespace mfs::dae
