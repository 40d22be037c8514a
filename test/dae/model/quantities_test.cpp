// What is recorded, against what is known of the motion by other means: closed formulas of pendulum, rotor,
// oscillator, slider and bar.
#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include <gmock/gmock.h>

#include "dae/model/quantities.hpp"
#include "test/dae/mechanics/expect_refused.hpp"
#include "test/dae/model/small_model.hpp"

namespace mfs::dae {
namespace {

using Eigen::Vector3d;
using testing::Contains;
using testing::ElementsAre;
using testing::Not;

/// Values of every quantity, output by output.
class Recording final : public Observer {
 public:
  explicit Recording(const MultibodyModel& model)
      : model_(model), chosen_(chosen_quantities(model)), account_(model, true) {}
  void step(const StepReport&, const std::function<const State&()>& state) override {
    account_.follow(state());
  }
  void output(const State& state) override {
    times.push_back(state.t);
    Measurement measurement(model_, state, account_, 1);
    for (const Quantity& quantity : chosen_) {
      std::vector<double> values(quantity.size());
      quantity.measure(measurement, values.data());
      values_[quantity.path()].push_back(values);
    }
  }
  double number(const std::string& path, std::size_t output) const {
    return values_.at(path).at(output).at(0);
  }
  Vector3d vector(const std::string& path, std::size_t output) const {
    const std::vector<double>& x = values_.at(path).at(output);
    return {x.at(0), x.at(1), x.at(2)};
  }
  Eigen::Vector4d four(const std::string& path, std::size_t output) const {
    return Eigen::Map<const Eigen::Vector4d>(values_.at(path).at(output).data());
  }
  std::vector<double> values(const std::string& path, std::size_t output) const {
    return values_.at(path).at(output);
  }
  std::vector<double> times;

 private:
  const MultibodyModel& model_;
  std::vector<Quantity> chosen_;
  Account account_;
  std::map<std::string, std::vector<std::vector<double>>> values_;
};

Recording record(const std::string& text) {
  Json json = Json::parse(text);
  if (!json.contains("integrator"))
    json["integrator"] = {
        {"rtol", 1e-9}, {"atol_position", 1e-10}, {"atol_velocity", 1e-9}, {"max_step", 2e-3}};
  static std::vector<std::unique_ptr<MultibodyModel>> kept;  // a recording looks at its model
  kept.push_back(std::make_unique<MultibodyModel>(make_model(json, "", 1)));
  const MultibodyModel& model = *kept.back();
  Recording recording(model);
  Integrator(*model.system, model.integrator)
      .run(0.0, model.q0, model.v0, model.end, output_times(model), recording);
  return recording;
}

void expect_near(const Vector3d& value, const Vector3d& expected, double tolerance) {
  EXPECT_LT((value - expected).norm(), tolerance) << value.transpose() << " for " << expected.transpose();
}

// A compound pendulum let go level. Everything follows from its angle p below the horizontal, by the energy
// integral w^2 = 2 m g l sin p / J.
TEST(Recorded, Pendulum) {
  const Recording r = record(R"({"name": "pendulum", "end": 2.0, "outputs": 20, "gravity": [0, 0, -10],
    "bodies": {"bob": {"type": "rigid", "mass": 2, "inertia": [0.1, 0.3, 0.25], "position": [1.2, 0, 0]}},
    "joints": {"pin": {"type": "revolute", "a": "ground", "b": "bob", "point": [0.2, 0, 0], "axis": [0, 1, 0]}},
    "points": {"tip": {"body": "bob", "point": [1.7, 0, 0]}}})");
  const double m = 2, g = 10, l = 1, j = 0.3 + m * l * l;
  double largest = 0;
  for (std::size_t i = 0; i < r.times.size(); ++i) {
    const double p = r.number("joints.pin.angle", i), s = std::sin(p), c = std::cos(p);
    const double w = r.number("joints.pin.angle_rate", i);
    largest = std::max(largest, p);
    EXPECT_NEAR(w * w, 2 * m * g * l * s / j, 1e-5);
    const double turning = m * g * l * c / j;
    const Vector3d radial(c, 0, -s), tangent(-s, 0, -c);
    expect_near(r.vector("bodies.bob.position", i), Vector3d(0.2, 0, 0) + l * radial, 1e-8);
    expect_near(r.vector("bodies.bob.velocity", i), l * w * tangent, 1e-6);
    expect_near(r.vector("bodies.bob.acceleration", i), l * turning * tangent - l * w * w * radial, 1e-3);
    expect_near(r.vector("bodies.bob.angular_velocity", i), Vector3d(0, w, 0), 1e-6);
    expect_near(r.vector("bodies.bob.angular_acceleration", i), Vector3d(0, turning, 0), 1e-3);
    const Eigen::Vector4d q = r.four("bodies.bob.orientation", i);
    EXPECT_LT((q - Eigen::Vector4d(std::cos(p / 2), 0, std::sin(p / 2), 0)).norm(), 1e-8);
    expect_near(r.vector("points.tip.position", i), Vector3d(0.2, 0, 0) + 1.5 * radial, 1e-8);
    expect_near(r.vector("points.tip.velocity", i), 1.5 * w * tangent, 1e-6);
    expect_near(r.vector("points.tip.acceleration", i), 1.5 * (turning * tangent - w * w * radial), 1e-3);
    // The pin carries what weight and motion leave: m (a - g).
    const Vector3d force = m * (l * turning * tangent - l * w * w * radial + Vector3d(0, 0, g));
    expect_near(r.vector("joints.pin.reaction_force", i), force, 1e-3);
    expect_near(r.vector("joints.pin.reaction_moment", i), Vector3d::Zero(), 1e-3);
    EXPECT_NEAR(r.number("energy.kinetic", i), 0.5 * j * w * w, 1e-5);
    EXPECT_NEAR(r.number("bodies.bob.potential_energy", i), -m * g * l * s, 1e-7);
    EXPECT_NEAR(r.number("energy.balance", i), 0, 1e-5);
  }
  EXPECT_GT(largest, 1.2);  // it has swung
}

// What the motors of an arm of two links have to do: its equations (as in Craig, "Introduction to Robotics",
// section 6.7, with links of I = 0.05 kg m^2 about their middles).
TEST(Recorded, MotorsOfAnArm) {
  const Recording r = record(R"json({"name": "arm", "end": 2, "outputs": 20, "gravity": [0, -9.81, 0],
    "bodies": {"upper": {"type": "rigid", "mass": 2, "inertia": [0.05, 0.05, 0.05], "position": [0.5, 0, 0]},
               "lower": {"type": "rigid", "mass": 1, "inertia": [0.05, 0.05, 0.05], "position": [1.5, 0, 0]}},
    "joints": {"shoulder": {"type": "revolute", "a": "ground", "b": "upper", "point": [0, 0, 0], "axis": [0, 0, 1]},
               "elbow": {"type": "revolute", "a": "upper", "b": "lower", "point": [1, 0, 0], "axis": [0, 0, 1]}},
    "motions": {"m1": {"type": "rotation", "joint": "shoulder", "angle": "0.8*sin(3*t) - 0.3*t^2"},
                "m2": {"type": "rotation", "joint": "elbow", "angle": "1 - cos(5*t)"}},
    "integrator": {"rtol": 1e-6}})json");
  constexpr double kG = 9.81, kI = 0.05, kL = 0.5;  // of the middles of both from their joints
  for (std::size_t i = 0; i < r.times.size(); ++i) {
    const double t = r.times[i], a = 0.8 * std::sin(3 * t) - 0.3 * t * t, b = 1 - std::cos(5 * t);
    const double a1 = 2.4 * std::cos(3 * t) - 0.6 * t, b1 = 5 * std::sin(5 * t);
    const double a2 = -7.2 * std::sin(3 * t) - 0.6, b2 = 25 * std::cos(5 * t);
    const double lower = (kI + kL * kL) * (a2 + b2) + kG * kL * std::cos(a + b);
    const double across = kL * std::sin(b), along = kL * std::cos(b);
    const double elbow = lower + along * a2 + across * a1 * a1;
    const double shoulder = lower + (kI + 2 * kL * kL + 1) * a2 + along * (2 * a2 + b2) -
                            across * (2 * a1 + b1) * b1 + kG * (2 * kL + 1) * std::cos(a);
    EXPECT_NEAR(r.number("motions.m1.moment_about_axis", i), shoulder, 1e-6) << t;
    EXPECT_NEAR(r.number("motions.m2.moment_about_axis", i), elbow, 1e-6) << t;
  }
}

// A rotor with a centre beside its axis and a product of inertia, driven evenly: the bearing turns its
// angular momentum (Jxz w, 0, Jz w) and its centre; the drive lifts the weight.
TEST(Recorded, DrivenRotor) {
  const Recording r = record(R"({"name": "rotor", "end": 2, "outputs": 3, "gravity": [0, -10, 0],
    "bodies": {"rotor": {"type": "rigid", "mass": 3, "inertia": [1, 1, 0.8, 0, 0, 0.2], "position": [0.5, 0, 0],
      "velocity": [0, 5, 0], "angular_velocity": [0, 0, 10]}},
    "joints": {"bearing": {"type": "revolute", "a": "ground", "b": "rotor", "point": [0, 0, 0], "axis": [0, 0, 1]}},
    "motions": {"drive": {"type": "rotation", "joint": "bearing", "angle": {"type": "linear", "slope": 10}}},
    "integrator": {"rtol": 1e-8, "atol_position": 1e-9, "atol_velocity": 1e-7, "max_step": 1e-3}})");
  const double m = 3, g = 10, l = 0.5, w = 10, jxz = 0.2;
  for (std::size_t i = 0; i < r.times.size(); ++i) {
    const double p = w * r.times[i], c = std::cos(p), s = std::sin(p);
    // More than a turn between outputs: counted along the steps.
    EXPECT_NEAR(r.number("joints.bearing.angle", i), p, 1e-7);
    EXPECT_NEAR(r.number("joints.bearing.angle_rate", i), w, 1e-6);
    const Vector3d centre = l * Vector3d(c, s, 0), force = -m * w * w * centre + Vector3d(0, m * g, 0);
    expect_near(r.vector("joints.bearing.reaction_force", i), force, 1e-4 * force.norm());
    const double lift = m * g * l * c;
    EXPECT_NEAR(r.number("motions.drive.moment_about_axis", i), lift, 5e-3);
    expect_near(r.vector("motions.drive.moment", i), Vector3d(0, 0, lift), 5e-3);
    const Vector3d turned = w * w * jxz * Vector3d(-s, c, 0);
    expect_near(r.vector("joints.bearing.reaction_moment", i), turned, 1e-4 * turned.norm());
    const Vector3d in_axes = r.vector("joints.bearing.reaction_moment_in_joint_axes", i);
    EXPECT_NEAR(in_axes.norm(), turned.norm(), 1e-4 * turned.norm());
    EXPECT_NEAR(in_axes[2], 0, 5e-3);
    EXPECT_NEAR(r.number("motions.drive.power", i), lift * w, 0.05);
    EXPECT_NEAR(r.number("energy.input", i), m * g * l * s, 0.02);
    EXPECT_NEAR(r.number("energy.balance", i), 0, 0.02);
  }
}

// Force and moment that hold a weight, seen from either side of the joint.
TEST(Recorded, StaticMoment) {
  const auto text = [](const char* sides) {
    return std::string(R"({"name": "arm", "end": 0.01, "outputs": 1, "gravity": [0, 0, -10],
      "bodies": {"arm": {"type": "rigid", "mass": 3, "inertia": [1, 1, 1], "position": [1, 0.2, 0.5]}},
      "joints": {"wall": {"type": "fixed", )") +
           sides + R"("point": [0, 0, 0.5]}}})";
  };
  const Recording r = record(text(R"("a": "ground", "b": "arm", )"));
  expect_near(r.vector("joints.wall.reaction_force", 1), {0, 0, 30}, 1e-9);
  expect_near(r.vector("joints.wall.reaction_moment", 1), {6, -30, 0}, 1e-9);
  expect_near(r.vector("joints.wall.reaction_moment_in_joint_axes", 1), {6, -30, 0}, 1e-9);
  const Recording turned = record(text(R"("a": "arm", "b": "ground", )"));
  expect_near(turned.vector("joints.wall.reaction_force", 1), {0, 0, -30}, 1e-9);
  expect_near(turned.vector("joints.wall.reaction_moment", 1), {-6, 30, 0}, 1e-9);
}

// A mass on an inclined guide, held by a spring with a damper: x'' + 2 d x' + k/m x = 0 about its rest.
TEST(Recorded, DampedOscillator) {
  const Recording r = record(R"({"name": "oscillator", "end": 2, "outputs": 20, "gravity": [0, 0, 0],
    "bodies": {"mass": {"type": "rigid", "mass": 2, "inertia": [1, 1, 1], "position": [1.5, 2, 0],
      "velocity": [0, 0, 0]}},
    "joints": {"guide": {"type": "translational", "a": "ground", "b": "mass", "point": [1.5, 2, 0], "axis": [3, 4, 0]}},
    "forces": {"spring": {"type": "spring_damper", "a": "ground", "b": "mass", "point_a": [0, 0, 0],
      "point_b": [1.5, 2, 0], "stiffness": 200, "damping": 4, "free_length": 2}}})");
  const double m = 2, k = 200, d = 1, x0 = 0.5, w = std::sqrt(k / m - d * d);
  const Vector3d along(0.6, 0.8, 0);
  for (std::size_t i = 0; i < r.times.size(); ++i) {
    const double t = r.times[i], decay = x0 * std::exp(-d * t);
    const double x = decay * (std::cos(w * t) + d / w * std::sin(w * t));
    const double v = -decay * (w + d * d / w) * std::sin(w * t);
    EXPECT_NEAR(r.number("joints.guide.travel", i), x - x0, 1e-6);
    EXPECT_NEAR(r.number("joints.guide.travel_rate", i), v, 1e-5);
    expect_near(r.vector("forces.spring.force", i), -(k * x + 4 * v) * along, 1e-3);
    const double kinetic = 0.5 * m * v * v, elastic = 0.5 * k * x * x;
    EXPECT_NEAR(r.number("energy.kinetic", i), kinetic, 1e-4);
    EXPECT_NEAR(r.number("forces.spring.elastic_energy", i), elastic, 1e-4);
    EXPECT_NEAR(r.number("energy.dissipated", i), 0.5 * k * x0 * x0 - kinetic - elastic, 1e-4);
    EXPECT_NEAR(r.number("forces.spring.power", i), -4 * v * v - k * x * v + k * x * v, 1e-3);
    EXPECT_NEAR(r.number("energy.balance", i), 0, 1e-5);
  }
}

// A driven slider under gravity: the force of the motion is m (x'' + g sin).
TEST(Recorded, DrivenSlider) {
  const Recording r = record(R"({"name": "slider", "end": 1, "outputs": 10, "gravity": [0, -10, 0],
    "bodies": {"block": {"type": "rigid", "mass": 2, "inertia": [1, 1, 1]}},
    "joints": {"guide": {"type": "translational", "a": "ground", "b": "block", "point": [0, 0, 0], "axis": [3, 4, 0]}},
    "motions": {"push": {"type": "translation", "joint": "guide",
      "distance": {"type": "smooth_step", "begin": 0, "end": 1, "after": 2}}}})");
  const double m = 2, g = 10, rise = 2;
  for (std::size_t i = 0; i < r.times.size(); ++i) {
    const double s = r.times[i], second = rise * 60 * s * (1 - s) * (1 - 2 * s);
    const double travel = rise * s * s * s * (10 + s * (6 * s - 15));
    EXPECT_NEAR(r.number("joints.guide.travel", i), travel, 1e-7);
    EXPECT_NEAR(r.number("motions.push.force_along_axis", i), m * (second + 0.8 * g), 1e-3);
    expect_near(r.vector("motions.push.force", i), m * (second + 0.8 * g) * Vector3d(0.6, 0.8, 0), 1e-3);
    // The guide carries the rest of the weight, across.
    expect_near(r.vector("joints.guide.reaction_force", i), m * g * 0.6 * Vector3d(-0.8, 0.6, 0), 1e-3);
    EXPECT_NEAR(r.number("energy.balance", i), 0, 1e-4);
  }
}

// A wheel of 2 kg m^2 on a rod of 8 N m/rad that is relaxed at 9 rad: it swings by 9 rad about there, which
// is past a full turn, with 2 rad/s, or damped by 0.2 / s. The axis is oblique.
TEST(Recorded, TorsionPendulum) {
  Json json = Json::parse(R"({"name": "pendulum", "end": 4, "outputs": 9,
    "bodies": {"wheel": {"type": "rigid", "mass": 1, "inertia": [2, 2, 2]}},
    "joints": {"bearing": {"type": "revolute", "a": "ground", "b": "wheel", "point": [0, 0, 0], "axis": [1, 2, 2]}},
    "forces": {"rod": {"type": "rotational_spring", "joint": "bearing", "stiffness": 8, "free_angle": 9}}})");
  const double j = 2, k = 8, x0 = 9, energy = 0.5 * k * x0 * x0;
  for (const double damping : {0.0, 0.8}) {
    json["forces"]["rod"]["damping"] = damping;
    const Recording r = record(json.dump());
    const double decay = 0.5 * damping / j, w = std::sqrt(k / j - decay * decay);
    for (std::size_t i = 0; i < r.times.size(); ++i) {
      const double t = r.times[i], c = std::cos(w * t), s = std::sin(w * t), e = std::exp(-decay * t);
      const double x = -x0 * e * (c + decay / w * s), v = x0 * e * (w + decay * decay / w) * s;
      const double kinetic = 0.5 * j * v * v, elastic = 0.5 * k * x * x, moment = -k * x - damping * v;
      EXPECT_NEAR(r.number("joints.bearing.angle", i), x0 + x, 1e-5);
      EXPECT_NEAR(r.number("energy.kinetic", i), kinetic, 1e-3);
      EXPECT_NEAR(r.number("energy.elastic", i), elastic, 1e-3);
      EXPECT_NEAR(r.number("forces.rod.elastic_energy", i), elastic, 1e-3);
      EXPECT_NEAR(r.number("forces.rod.moment_about_axis", i), moment, 1e-3);
      expect_near(r.vector("forces.rod.moment", i), moment * Vector3d(1, 2, 2) / 3, 1e-3);
      expect_near(r.vector("forces.rod.force", i), Vector3d::Zero(), 1e-12);
      EXPECT_NEAR(r.number("forces.rod.power", i), -damping * v * v, 1e-3);
      EXPECT_NEAR(r.number("energy.dissipated", i), energy - kinetic - elastic, 1e-2);
      EXPECT_NEAR(r.number("energy.input", i), 0, 1e-12);
      EXPECT_NEAR(r.number("energy.balance", i), 0, 1e-2);
    }
  }
}

// 3 kg on a guide between a spring of 12 N/m and an actuator that pushes with 2 N/m: what both measure, the
// travel, is one coordinate, and each has its own force along it.
TEST(Recorded, ForcesAlongOneGuide) {
  const Recording r = record(R"({"name": "guide", "end": 2, "outputs": 5,
    "bodies": {"slider": {"type": "rigid", "mass": 3, "inertia": [1, 1, 1], "position": [1, 0, 0]}},
    "joints": {"guide": {"type": "translational", "a": "ground", "b": "slider", "point": [1, 0, 0], "axis": [3, 0, 4]}},
    "forces": {
      "coil": {"type": "translational_spring", "joint": "guide", "stiffness": 12, "free_travel": 0.3},
      "push": {"type": "actuator", "joint": "guide", "force": "2 * guide.travel"}}})");
  const double w = std::sqrt(10.0 / 3);
  const Vector3d axis(0.6, 0, 0.8);
  for (std::size_t i = 0; i < r.times.size(); ++i) {
    const double x = 0.36 * (1 - std::cos(w * r.times[i])), v = 0.36 * w * std::sin(w * r.times[i]);
    EXPECT_NEAR(r.number("joints.guide.travel", i), x, 1e-6);
    EXPECT_NEAR(r.number("forces.coil.force_along_axis", i), 12 * (0.3 - x), 1e-5);
    expect_near(r.vector("forces.coil.force", i), 12 * (0.3 - x) * axis, 1e-5);
    expect_near(r.vector("forces.push.force", i), 2 * x * axis, 1e-5);
    expect_near(r.vector("forces.push.moment", i), Vector3d::Zero(), 1e-12);
    EXPECT_NEAR(r.number("forces.push.power", i), 2 * x * v, 1e-5);
    EXPECT_NEAR(r.number("forces.coil.elastic_energy", i), 6 * (x - 0.3) * (x - 0.3), 1e-5);
    EXPECT_NEAR(r.number("energy.input", i), x * x, 1e-5);
    EXPECT_NEAR(r.number("energy.balance", i), 0, 1e-5);
  }
}

// A motor of 12 N m turns a wheel of 2 kg m^2 and by a rack, s = -a / 2, moves 3 kg, so that a'' = 12 / 2.75.
// The rack brings in nothing of its own.
TEST(Recorded, MotionThatFollowsAnother) {
  const Recording r = record(R"({"name": "rack", "end": 2, "outputs": 4,
    "bodies": {"wheel": {"type": "rigid", "mass": 1, "inertia": [1, 1, 2]},
      "slider": {"type": "rigid", "mass": 3, "inertia": [1, 1, 1], "position": [1, 0, 0]}},
    "joints": {"bearing": {"type": "revolute", "a": "ground", "b": "wheel", "point": [0, 0, 0], "axis": [0, 0, 1]},
      "guide": {"type": "translational", "a": "ground", "b": "slider", "point": [1, 0, 0], "axis": [1, 0, 0]}},
    "motions": {"rack": {"type": "translation", "joint": "guide", "distance": "-0.5 * bearing.angle"}},
    "forces": {"motor": {"type": "actuator", "joint": "bearing", "torque": "12"}}})");
  const double turning = 12 / 2.75;
  for (std::size_t i = 0; i < r.times.size(); ++i) {
    const double t = r.times[i], angle = 0.5 * turning * t * t, force = -3 * 0.5 * turning;
    EXPECT_NEAR(r.number("joints.bearing.angle", i), angle, 1e-5);
    EXPECT_NEAR(r.number("motions.rack.force_along_axis", i), force, 1e-4);
    expect_near(r.vector("motions.rack.force", i), Vector3d(force, 0, 0), 1e-4);
    EXPECT_NEAR(r.number("motions.rack.power", i), 0, 1e-9);
    EXPECT_NEAR(r.number("forces.motor.moment_about_axis", i), 12, 1e-9);
    expect_near(r.vector("forces.motor.moment", i), Vector3d(0, 0, 12), 1e-6);
    EXPECT_NEAR(r.number("energy.input", i), 12 * angle, 1e-3);
    EXPECT_NEAR(r.number("energy.balance", i), 0, 1e-3);
  }
}

// Both angles of a universal joint, where b is turned by the one about a's axis and then by the other about
// its own.
TEST(Recorded, AnglesOfAUniversalJoint) {
  const MultibodyModel model = make_model(Json::parse(R"({"name": "cross", "end": 1, "outputs": 1,
    "bodies": {"b": {"type": "rigid", "mass": 1, "inertia": [1, 1, 1]}},
    "joints": {"cross": {"type": "universal", "a": "ground", "b": "b", "point": [0, 0, 0], "axis": [1, 2, 0],
      "axis_b": [2, -1, 3]}}})"),
                                          "", 1);
  const Vector3d of_a = Vector3d(1, 2, 0).normalized(), of_b = Vector3d(2, -1, 3).normalized();
  for (const auto& [first, second] : {std::pair{0.0, 0.0}, {0.4, -1.1}, {-2.0, 0.3}, {1.5, 3.0}}) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(first, of_a) * Eigen::AngleAxisd(second, of_b));
    State state;
    state.q = {0, 0, 0, turn.w(), turn.x(), turn.y(), turn.z()};
    state.v = state.a = std::vector<double>(7);
    const JointMotion motion = joint_motion(model.joints.at(0), state);
    EXPECT_THAT(motion.angle,
                ElementsAre(testing::DoubleNear(first, 1e-13), testing::DoubleNear(second, 1e-13)));
  }
}

// A bar that hangs: without lateral contraction its stress is that of the weight below, the energy its
// integral. Let go suddenly, it is brought to rest by a drag.
TEST(Recorded, HangingBar) {
  const Recording r = record(R"({"name": "bar", "end": 0.4, "outputs": 4, "gravity": [-10, 0, 0],
    "materials": {"soft": {"law": "st_venant_kirchhoff", "young": 1e7, "poisson": 0, "density": 1000}},
    "bodies": {"bar": {"type": "flexible", "material": "soft", "damping": {"alpha": 200},
      "mesh": {"generator": "box", "element": "hex8", "refine": 1, "size": [1, 0.2, 0.1], "divisions": [8, 1, 1]}}},
    "motions": {"hold": {"type": "nodes", "side": "bar:x1", "x": {"type": "constant", "value": 0},
      "y": {"type": "constant", "value": 0}, "z": {"type": "constant", "value": 0}}},
    "forces": {"wind": {"type": "surface", "side": "bar:y0", "z": {"type": "constant", "value": 0.001}}},
    "points": {"middle": {"body": "bar", "point": [0.5, 0, 0]}},
    "record": ["bodies", "motions.hold.force", "forces.*.force", "points.middle", "energy.*", "energy.dissipated",
      "energy.input", "energy.balance"],
    "integrator": {"rtol": 1e-7, "atol_position": 1e-10, "atol_velocity": 1e-8}})");
  const double weight = 1000 * 10, area = 0.02, young = 1e7;
  const std::size_t end = 4;
  const std::vector<double> stress = r.values("points.middle.stress", end);
  EXPECT_NEAR(stress[0], 0.5 * weight, 2e-3 * weight);  // squares of strains of 1e-3 are left out
  for (int k = 1; k < 6; ++k) EXPECT_NEAR(stress[static_cast<std::size_t>(k)], 0, 2e-3 * weight);
  EXPECT_NEAR(r.number("points.middle.von_mises", end), 0.5 * weight, 2e-3 * weight);
  expect_near(r.vector("motions.hold.force", end), {weight * area, 0, -0.001}, 1e-3);
  expect_near(r.vector("forces.wind.force", end), {0, 0, 0.001}, 1e-12);
  const double elastic = weight * weight * area / (6 * young);
  EXPECT_NEAR(r.number("bodies.bar.elastic_energy", end), elastic, 0.01 * elastic);  // 8 elements: 1 / 256
  EXPECT_NEAR(r.number("energy.elastic", end), elastic, 0.01 * elastic);
  // Its centre sinks by weight / (3 E); of that energy half is stored.
  EXPECT_NEAR(r.vector("bodies.bar.position", end)[0], 0.5 - weight / (3 * young), 3e-6);
  EXPECT_NEAR(r.number("energy.dissipated", end), elastic, 0.01 * elastic);
  EXPECT_NEAR(r.number("energy.balance", end), 0, 0.01 * elastic);
}

// The polynomial through four values is exact for cubics, on steps of any lengths.
TEST(RunningIntegral, IsExactForCubicsAndCanGoBackAStep) {
  const auto f = [](double t) { return 1 - 2 * t + 3 * t * t - 4 * t * t * t; };
  const auto integral_of_f = [](double t) { return t - t * t + t * t * t - t * t * t * t; };
  RunningIntegral sum(2);
  double begin = 0;
  for (const double t : {0.0, 0.1, 0.25, 0.3, 0.7, 0.8}) {
    sum.add(t, {f(t), 5.0});
    // The first intervals have fewer values.
    if (t == 0.3) begin = sum.at(t)[0] - integral_of_f(t);
  }
  EXPECT_NEAR(sum.at(0.8)[0] - integral_of_f(0.8), begin, 1e-14);
  EXPECT_NEAR(sum.at(0.72)[0] - integral_of_f(0.72), begin, 1e-14);
  EXPECT_NEAR(sum.at(0.8)[1], 4.0, 1e-14);
}

std::vector<std::string> chosen_of(const std::vector<std::string>& patterns) {
  Json json = small_model();
  json["record"] = patterns;
  std::vector<std::string> paths;
  for (const Quantity& quantity : chosen_quantities(make_model(json, "", 1)))
    paths.push_back(quantity.path());
  return paths;
}

TEST(Record, ChoosesByPlacesAndStars) {
  EXPECT_THAT(chosen_of({"bodies.block.velocity", "energy.kinetic"}),
              ElementsAre("bodies.block.velocity", "energy.kinetic"));
  EXPECT_THAT(chosen_of({"*.*.position", "points.tip.position"}),
              ElementsAre("bodies.block.position", "bodies.bar.position", "joints.hinge.position",
                          "joints.tip.position", "points.block_top.position", "points.tip.position"));
  EXPECT_THAT(chosen_of({"forces.strut"}), ElementsAre("forces.strut.force", "forces.strut.moment",
                                                       "forces.strut.elastic_energy", "forces.strut.power"));
  // What costs the states of all steps is taken by its own name alone.
  EXPECT_THAT(chosen_of({"energy"}), ElementsAre("energy.kinetic", "energy.potential", "energy.elastic"));
  EXPECT_THAT(chosen_of({"energy.balance"}), ElementsAre("energy.balance"));
  const std::vector<std::string> all = chosen_of({});
  EXPECT_THAT(all, Contains("points.tip.stress"));
  EXPECT_THAT(all, Not(Contains("energy.balance")));
}

TEST(Record, RefusesWhatIsNotThere) {
  const auto refused = [](const std::string& pattern, const std::string& text) {
    mfs::test::expect_refused("record", text, [&] { chosen_of({"energy", pattern}); });
  };
  refused("body.block",
          "body.block: there is no 'body'; known are: bodies, energy, forces, joints, motions, points");
  refused("bodies.blok.position", "bodies.blok.position: there is no 'blok'; known are: bar, block");
  refused("joints.tip.angle",
          "there is no 'angle'; known are: orientation, position, reaction_force, "
          "reaction_force_in_joint_axes, reaction_moment, reaction_moment_in_joint_axes");
  refused("energy.kinetic.x", "has more parts");
  refused("", "there is no ''");
}

}  // namespace
}  // namespace mfs::dae
