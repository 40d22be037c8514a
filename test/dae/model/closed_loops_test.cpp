// Mechanisms with closed loops: redundant constraints, no freedom, contradictions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mfs/error.hpp>

#include "dae/integrator/redundancy.hpp"
#include "test/dae/model/mechanism.hpp"

namespace mfs::dae::test {
namespace {

using testing::AllOf;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Property;
using testing::SizeIs;
using testing::Throws;

const Vector3d kDown(0, -9.81, 0), kNone(0, 0, 0);
const Vector3d kX = Vector3d::UnitX(), kY = Vector3d::UnitY(), kZ = Vector3d::UnitZ();

template <class Matcher>
void expect_refused(const Json& json, const Matcher& text) {
  EXPECT_THAT([&] { run(json, 1e-6); }, Throws<InvalidInput>(Property(&InvalidInput::what, text)));
}

template <class Matcher>
void expect_ended(const Json& json, const Matcher& text) {
  EXPECT_THAT([&] { run(json, 1e-6); }, Throws<Error>(Property(&Error::what, text)));
}

/// The library's: crank 1 m, coupler and rocker sqrt 5 m, ground 3 m.
struct FourBar {
  Vector3d c{2, 2, 0}, d{3, 0, 0};

  Json model(double end, int outputs) const { return of_library("four_bar", end, outputs); }
  /// Where B and C are by the crank's angle from x: two circles meet (Freudenstein's equation in points).
  std::pair<Vector3d, Vector3d> positions(double angle) const {
    const Vector3d pin(std::cos(angle), std::sin(angle), 0.0);
    const Vector3d line = d - pin;
    const double half = 0.5 * line.norm(), height = std::sqrt(5.0 - half * half);
    const Vector3d across(-line[1], line[0], 0.0);
    return {pin, pin + 0.5 * line + height * across.normalized()};
  }
};

TEST(FourBar, ThreeOfItsConstraintsAreRedundant) {
  const MotionRun result = run(FourBar().model(0.1, 1), 1e-6);
  EXPECT_THAT(result.report.redundant, ElementsAre("joint D, equation 3 of 5 (along ground z)",
                                                   "joint D, equation 4 of 5 (about [1 0 0])",
                                                   "joint D, equation 5 of 5 (about [0 1 0])"));
  EXPECT_EQ(result.report.constraints, 20);
}

TEST(FourBar, ALooseBodyChangesNothing) {
  Json json = FourBar().model(0.1, 1);
  json["bodies"]["loose"] = rod({0, 5, 0}, {1, 6, 1});
  EXPECT_THAT(run(json, 1e-6).report.redundant, AllOf(SizeIs(3), Each(HasSubstr("joint D"))));
}

TEST(FourBar, WithASphericalPinOne) {
  Json json = FourBar().model(0.1, 1);
  json["joints"]["C"] = joint("spherical", "coupler", "rocker", FourBar().c);
  EXPECT_THAT(run(json, 1e-6).report.redundant, SizeIs(1));
}

TEST(FourBar, ConservesEnergy) {
  const MotionRun result = run(FourBar().model(3.0, 30), 1e-8);
  const auto energy = [&](const State& state) {
    double sum = 0.0;
    for (const auto& [body, length2] : {std::pair("crank", 1.0), {"coupler", 5.0}, {"rocker", 5.0}}) {
      const int at = result.at(body);
      const double w =
          2 * (state.q[at + 3] * state.v[at + 6] - state.q[at + 6] * state.v[at + 3]);  // about z
      sum += 0.5 * Eigen::Map<const Vector3d>(&state.v[at]).squaredNorm() + 0.5 * length2 / 12 * w * w +
             9.81 * state.q[at + 1];
    }
    return sum;
  };
  const double start = 9.81 * (0.5 + 1.5 + 1.0);
  for (const State& state : result.outputs) EXPECT_NEAR(energy(state), start, 1e-4) << state.t;
}

TEST(FourBar, DrivenItIsWhereTheLoopCloses) {
  const FourBar bars;
  Json json = bars.model(2.0, 16);
  json["motions"]["drive"] = drive("A", 0.0, 2 * M_PI);
  const MotionRun result = run(json, 1e-5);
  EXPECT_EQ(result.report.constraints, 21);  // as many as coordinates
  ASSERT_THAT(result.outputs, SizeIs(17));
  for (const State& state : result.outputs) {
    const auto [b, c] = bars.positions(0.5 * M_PI + 2 * M_PI * state.t);
    EXPECT_LT((result.position(state, "crank") - 0.5 * b).norm(), 1e-7) << state.t;
    EXPECT_LT((result.position(state, "coupler") - 0.5 * (b + c)).norm(), 1e-7) << state.t;
    EXPECT_LT((result.position(state, "rocker") - 0.5 * (bars.d + c)).norm(), 1e-7) << state.t;
  }
}

// On the nearest way, which is that of the crank's angle less whole turns.
TEST(FourBar, IsMovedToWhereItsMotionBegins) {
  const FourBar bars;
  for (const double start : {0.02, 1.0, -2.5, 3.0, 3.5}) {
    Json json = bars.model(0.1, 1);
    json["motions"]["drive"] = drive("A", start, 1.0);
    const MotionRun result = run(json, 1e-5);
    for (const State& state : result.outputs) {
      const auto [b, c] = bars.positions(0.5 * M_PI + start + state.t);
      EXPECT_LT((result.position(state, "crank") - 0.5 * b).norm(), 1e-7) << start;
      EXPECT_LT((result.position(state, "rocker") - 0.5 * (bars.d + c)).norm(), 1e-7) << start;
    }
  }
  Json json = bars.model(0.1, 1);
  json["motions"]["drive"] = drive("A", M_PI, 1.0);
  expect_refused(json, AllOf(HasSubstr("motion drive"), HasSubstr("half a turn")));
  json["motions"]["drive"] = {{"type", "point"}, {"side", "crank"}, {"point", {0, 1, 0}}};
  json["motions"]["drive"]["x"] = {{"type", "constant"}, {"value", 1.5}};  // it reaches 1
  expect_refused(json,
                 AllOf(HasSubstr("motion drive, equation 1 of 1 (along ground x)"), HasSubstr("-1.5 off")));
}

TEST(FourBar, ByOtherFormulas) {
  const FourBar bars;
  Json json = bars.model(1.0, 8);
  json["motions"]["drive"] = drive("A", 0.0, 2 * M_PI);
  for (const Json& integrator :
       {Json{{"unknowns", "full"}}, {{"method", "generalized_alpha"}, {"fixed_step", 0.01}}}) {
    json["integrator"] = integrator;
    const MotionRun result = run(json, 1e-6);
    EXPECT_THAT(result.report.redundant, SizeIs(3));
    for (const State& state : result.outputs) {
      const auto [b, c] = bars.positions(0.5 * M_PI + 2 * M_PI * state.t);
      EXPECT_LT((result.position(state, "coupler") - 0.5 * (b + c)).norm(), 1e-7) << state.t;
    }
  }
}

TEST(FourBar, MotionsThatContradictAreNamed) {
  Json json = FourBar().model(1.0, 1);
  json["motions"]["one"] = drive("A", 0.0, 1.0);
  json["motions"]["same"] = drive("A", 0.0, 1.0);
  EXPECT_THAT(run(json, 1e-6).report.redundant, SizeIs(4));
  json["motions"]["same"]["angle"] = {{"type", "smooth_step"}, {"begin", 0.5}, {"end", 1.0}, {"after", 1.0}};
  expect_refused(json, AllOf(HasSubstr("motion same"),
                             HasSubstr("contradicts motion one at t = 0: of its velocity 1 is left")));
  json["motions"]["one"] = json["motions"]["same"];
  json["motions"]["one"]["angle"]["begin"] = 0.6;
  expect_refused(json, AllOf(HasSubstr("motion same"), HasSubstr("contradicts motion one at t = 0.5")));
  json["motions"].erase("one");
  json["motions"]["same"]["joint"] = "D";
  json["motions"]["crank"] = drive("A", 0.0, 1.0);
  expect_refused(json, AllOf(HasSubstr("motion same"), HasSubstr("motion crank"), HasSubstr("joint B")));
}

// Crank 1 m, coupler and rocker sqrt 2 m, ground 2.5 m: the crank comes as far as the others reach.
TEST(FourBar, ThatLeadsBeyondItsDeadPointIsNamed) {
  const Vector3d b = kY, d(2.5, 0, 0), line = 0.5 * (d - b);
  const Vector3d c = b + line + std::sqrt(2.0 - line.squaredNorm()) * kZ.cross(line).normalized();
  Json json = mechanism(1.0, 1, kNone);
  json["bodies"] = {{"crank", rod(kNone, b)}, {"coupler", rod(b, c)}, {"rocker", rod(d, c)}};
  json["joints"] = {{"A", joint("revolute", "ground", "crank", kNone)},
                    {"B", joint("revolute", "crank", "coupler", b)},
                    {"C", joint("revolute", "coupler", "rocker", c)},
                    {"D", joint("revolute", "ground", "rocker", d)}};
  json["motions"]["drive"] = drive("A", 0.0, 2 * M_PI);
  expect_ended(json, AllOf(HasSubstr("motion drive, equation 1 of 1 (about [0 0 1]) nearly follows from"),
                           HasSubstr("joint A"), HasSubstr("joint D")));
}

/// Six bodies in a ring, hinges of each across each other and 1 m apart, which has one freedom (Bricard's
/// trihedral linkage). The hinge that is driven turns back at its dead point.
Json ring_of_six() {
  Json json = mechanism(2.0, 2, Vector3d::Zero());
  std::vector<Vector3d> place, axis;
  for (int k = 0; k < 6; ++k) {
    const double out = k % 2 == 0 ? 0.7504546491289555 : 0.8883503719251519,
                 up = k % 2 == 0 ? 0.0 : 0.5606407967387388, lean = k % 2 == 0 ? 0.5 : -0.7411735725196716;
    const Eigen::AngleAxisd around(k * std::acos(-1.0) / 3, Vector3d::UnitZ());
    place.emplace_back(around * Vector3d(out, 0, up));
    axis.emplace_back(around * Vector3d(std::cos(lean), 0, std::sin(lean)));
  }
  for (int k = 0; k < 6; ++k) {
    const std::string body = "b" + std::to_string(k);
    json["bodies"][body] = {{"type", "rigid"},
                            {"mass", 1},
                            {"inertia", {0.1, 0.12, 0.12}},
                            {"position", triple(0.5 * (place[k] + place[(k + 1) % 6]))}};
    json["joints"]["j" + std::to_string(k)] =
        joint("revolute", "b" + std::to_string((k + 5) % 6), body, place[k], axis[k]);
  }
  json["motions"]["drive"] = {{"type", "rotation"}, {"joint", "j0"}, {"angle", "0.8*sin(t) + 0.3*t"}};
  return json;
}

TEST(Ring, ThatIsDrivenBeyondItsDeadPointIsNamed) {
  for (const double rtol : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8}) {
    Json json = ring_of_six();
    json["integrator"]["rtol"] = rtol;
    EXPECT_THAT(
        [&] { run(json); },
        Throws<Error>(Property(&Error::what, HasSubstr("motion drive, equation 1 of 1 (about [0.878 0 "
                                                       "0.479]) nearly follows from"))))
        << rtol;
  }
}

TEST(Motions, ThatJumpAreNamed) {
  Json json = of_library("four_bar", 1.0, 1);
  for (const char* angle : {"if(t < 0.5, 0, 0.5)", "abs(t - 0.5) - 0.5"}) {
    json["motions"]["drive"] = {{"type", "rotation"}, {"joint", "A"}, {"angle", angle}};
    expect_ended(json, HasSubstr("motion drive, equation 1 of 1 (about [0 0 1]) jumps"));
  }
  json["motions"].clear();
  json["forces"]["motor"] = {{"type", "actuator"}, {"joint", "A"}, {"torque", "log(0.5 - t)"}};
  expect_ended(
      json,
      HasSubstr(
          "forces.motor.torque: expression 'log(0.5 - t)': it or a derivative is not finite at t = 0.5"));
}

TEST(Forces, WithAPoleAreNamedByWhatTheyActOn) {
  Json json = of_library("four_bar", 1.0, 1);
  json["forces"]["steady"] = {{"type", "actuator"}, {"joint", "D"}, {"torque", "1"}};
  json["forces"]["motor"] = {{"type", "actuator"}, {"joint", "A"}, {"torque", "1/(t - 0.5)"}};
  expect_ended(json, HasSubstr("; the force on quantity A.angle.value jumps or has a pole"));
  json["forces"]["motor"] = {
      {"type", "point"}, {"side", "coupler"}, {"point", triple(kNone)}, {"x", "1/(t - 0.5)"}};
  expect_ended(json, HasSubstr("; the force on coupler.x jumps or has a pole"));
  // A double pole in time turns the crank faster and faster long before; one in space draws it there.
  json["forces"].erase("steady");
  json["forces"]["motor"] = {{"type", "actuator"}, {"joint", "A"}, {"torque", "1/(t - 0.5)^2"}};
  expect_ended(json, HasSubstr("; the force on quantity A.angle.value has become "));
  for (const char* force : {"1/(1 - middle.x)", "1/(1 - middle.x)^2"}) {
    Json free = mechanism(2.0, 1, kNone);
    free["bodies"]["block"] = {
        {"type", "rigid"}, {"mass", 1.0}, {"inertia", {1, 1, 1}}, {"velocity", {1, 0, 0}}};
    free["points"]["middle"] = {{"body", "block"}, {"point", triple(kNone)}};
    free["forces"]["pull"] = {{"type", "point"}, {"side", "block"}, {"point", triple(kNone)}, {"x", force}};
    expect_ended(free, HasSubstr("; the force on block.x jumps or has a pole"));
  }
}

// Dry friction that holds the pendulum: its force jumps wherever a step ends, however short that is.
TEST(Forces, ThatJumpWithTheMotionEndARunThatWouldTakeDays) {
  Json json = of_library("simple_pendulum", 10.0, 1);
  json["forces"]["friction"] = {
      {"type", "actuator"}, {"joint", "bearing"}, {"torque", "-100*sign(bearing.angle_rate)"}};
  expect_ended(json, AllOf(HasSubstr("more steps would be needed"), HasSubstr("a force jumps")));
}

// No step fails: the crank turns faster and faster, and its steps become as short as that takes.
TEST(Motions, WithoutBoundEndARunThatWouldTakeDays) {
  Json json = of_library("simple_pendulum", 2.0, 1);
  json["motions"]["drive"] = {{"type", "rotation"}, {"joint", "bearing"}, {"angle", "tan(t)"}};
  EXPECT_THAT([&] { run(json); },
              Throws<Error>(Property(
                  &Error::what,
                  AllOf(HasSubstr("ever shorter until t = 1.570"),
                        HasSubstr("motion drive, equation 1 of 1 (about [0 0 1]) has become as fast as")))));
}

// A slide is followed until that is not possible any more: it does not jump, and a spring on it contradicts
// nothing.
TEST(Motions, WithoutBoundOfASlideAreNamedByTheirRate) {
  Json json = mechanism(1.0, 1, kNone);
  json["bodies"]["cart"] = {{"type", "rigid"}, {"mass", 1.0}, {"inertia", {1, 1, 1}}};
  json["joints"]["rail"] = joint("translational", "ground", "cart", kNone, Vector3d::UnitX());
  const auto drive = [&](const char* distance) {
    json["motions"]["drive"] = {{"type", "translation"}, {"joint", "rail"}, {"distance", distance}};
  };
  const auto too_fast = HasSubstr("motion drive, equation 1 of 1 (along [1 0 0]) has become as fast as ");
  for (const char* distance : {"exp(1000*t) - 1", "tan(2*t)", "1/(1 - 2*t) - 1"}) {
    drive(distance);
    expect_ended(json, AllOf(too_fast, Not(HasSubstr("jumps"))));
  }
  drive("if(t < 0.5, 3*t, 3*t + 1)");
  expect_ended(json, HasSubstr("motion drive, equation 1 of 1 (along [1 0 0]) jumps"));
  drive("exp(1000*t) - 1");
  json["bodies"]["load"] = {{"type", "rigid"}, {"mass", 1.0}, {"inertia", {1, 1, 1}}};
  json["joints"]["guide"] = joint("translational", "cart", "load", kNone, Vector3d::UnitX());
  json["forces"]["spring"] = {{"type", "translational_spring"}, {"joint", "guide"}, {"stiffness", 100}};
  EXPECT_THAT([&] { run(json); }, Throws<Error>(Property(&Error::what, too_fast)));
}

// The hinges share the weight, and the moment of the weight: a pair of forces H at 0.8 m and two moments M
// with 1.6 H + 2 M = g / 2 and the least sum of squares of H and M / l, l^2 = 0.5^2 + 0.8^2 of the longest
// arm.
TEST(Door, OnTwoHingesTurnsAndHangsOnBoth) {
  const MotionRun result = run(of_library("door"), 1e-7);
  EXPECT_THAT(result.report.redundant, AllOf(SizeIs(5), Each(HasSubstr("joint low"))));
  const double square = 0.89, share = 0.5 * 9.81 / (2 * (square + 0.64)), moment = square * share,
               force = 0.8 * share;
  for (const State& state : result.outputs) {
    const Vector3d out(std::cos(state.t), 0, -std::sin(state.t));
    EXPECT_LT((result.position(state, "door") - Vector3d(0, 1, 0) - 0.5 * out).norm(), 1e-6);
    for (const auto& [hinge, side] : {std::pair("joint high", 1.0), {"joint low", -1.0}}) {
      const Vector3d on_door =
          -Vector3d(result.multiplier(state, hinge, 0), result.multiplier(state, hinge, 1),
                    result.multiplier(state, hinge, 2));
      const Vector3d expected = Vector3d(0, 9.81 / 2, 0) + (-side * force - 0.25) * out;  // m w^2 r = 0.5
      EXPECT_LT((on_door - expected).norm(), 1e-4) << hinge << " at " << state.t;
      EXPECT_NEAR(std::hypot(result.multiplier(state, hinge, 3), result.multiplier(state, hinge, 4)), moment,
                  1e-4);
    }
  }
}

// The same with the lower hinge at the height of the centre: 0.8 H + 2 M = g / 2, and H less what turns the
// door below. In slow motion the integrator has a unit of time and multipliers in units of their own.
TEST(Door, SharesItsWeightAlikeInSlowMotion) {
  const double force = (1 + 0.4 * 9.81 / 0.89) / (4 + 0.64 / 0.89);
  for (const double rate : {1.0, 1e-3}) {
    const double square = rate * rate;
    Json json = of_library("door");
    json["end"] = 2 / rate;
    json["gravity"] = {0, -9.81 * square, 0};
    json["bodies"]["door"]["velocity"] = {0, 0, -0.5 * rate};
    json["bodies"]["door"]["angular_velocity"] = {0, rate, 0};
    json["joints"]["low"]["point"] = {0, 1, 0};
    json["integrator"]["rtol"] = 1e-7;
    const MotionRun result = run(json);
    for (const State& state : result.outputs) {
      const Vector3d out(std::cos(rate * state.t), 0, -std::sin(rate * state.t));
      for (const auto& [hinge, along] : {std::pair("joint high", -force), {"joint low", force - 0.5}}) {
        const Vector3d on_door =
            -Vector3d(result.multiplier(state, hinge, 0), result.multiplier(state, hinge, 1),
                      result.multiplier(state, hinge, 2));
        const Vector3d expected = Vector3d(0, 9.81 / 2, 0) + along * out;
        EXPECT_LT((on_door / square - expected).norm(), 1e-4) << hinge << ", " << rate << " at " << state.t;
      }
    }
  }
}

// As where a step of 1e-14 s leaves rounding of velocities in all accelerations.
TEST(Redundant, IsAsExactAsWhatItFollowsFrom) {
  Json json = mechanism(0.1, 1, kDown);
  json["bodies"]["bar"] = rod({0, 0, 0}, {1, 0, 0});
  json["joints"] = {{"one", joint("revolute", "ground", "bar", {0, 0, 0})},
                    {"two", joint("revolute", "ground", "bar", {0, 0, 0.5})}};
  const MultibodyModel model = make_model(json, "", 1);
  Redundancy redundancy(*model.system, std::vector<double>(model.q0.size(), 1.0));
  redundancy.leave_out(redundancy.find(0.0, model.q0));
  std::vector<double> a(model.q0.size(), 0.0);
  const auto at = static_cast<std::size_t>(model.rigid_bodies.at(0).frame.first);
  a[at + 2] = 0.1;  // along z, out of both joints
  EXPECT_NO_THROW(
      redundancy.check({0.0, model.q0.data(), model.v0.data(), a.data(), nullptr}, IntegratorOptions()));
}

TEST(Redundant, AJointGivenTwiceIsOneJoint) {
  Json json = mechanism(0.1, 1, kDown);
  json["bodies"]["bar"] = rod({0, 0, 0}, {1, 0, 0});
  json["joints"] = {{"one", joint("revolute", "ground", "bar", {0, 0, 0})},
                    {"two", joint("revolute", "ground", "bar", {0, 0, 0})}};
  const MotionRun result = run(json, 1e-7);
  EXPECT_THAT(result.report.redundant, AllOf(SizeIs(5), Each(HasSubstr("joint two"))));
  for (int k = 0; k < 5; ++k)
    EXPECT_NEAR(result.multiplier(result.outputs[0], "joint one", k),
                result.multiplier(result.outputs[0], "joint two", k), 1e-10);
  // l / 2 of 1.5 g / l bears three quarters of the weight.
  EXPECT_NEAR(result.multiplier(result.outputs[0], "joint one", 1), -9.81 / 8, 1e-8);
}

// The interface of a flexible body has Euler parameters and ties: none of them is redundant.
TEST(Redundant, AJointGivenTwiceToAFlexibleBody) {
  Json json = mechanism(0.01, 1, kDown);
  json["materials"]["steel"] = {
      {"law", "st_venant_kirchhoff"}, {"young", 2e11}, {"poisson", 0.3}, {"density", 7800}};
  json["bodies"]["beam"] = {{"type", "flexible"},
                            {"material", "steel"},
                            {"damping", {{"beta", 1e-4}}},
                            {"mesh",
                             {{"generator", "box"},
                              {"element", "hex8"},
                              {"refine", 1},
                              {"size", {1, 0.1, 0.1}},
                              {"divisions", {4, 1, 1}}}}};
  json["joints"] = {{"one", joint("revolute", "ground", "beam:x0", {0, 0.05, 0.05})},
                    {"two", joint("revolute", "ground", "beam:x0", {0, 0.05, 0.05})}};
  EXPECT_THAT(run(json, 1e-4).report.redundant, AllOf(SizeIs(5), Each(HasSubstr("joint two"))));
  json["motions"]["drive"] = drive("one", 0.1, 0.0);
  expect_refused(json, AllOf(HasSubstr("motion drive"), HasSubstr("flexible")));
}

// A rod of 1 m on a rod of 2 m: the crank drives the slider, x = cos a + sqrt(4 - sin^2 a).
TEST(SliderCrank, WithAllMotionPrescribed) {
  const double speed = 3.0;
  const MotionRun result = run(of_library("slider_crank"), 1e-6);
  EXPECT_THAT(result.report.redundant, SizeIs(3));
  const auto slider = [](double angle) {
    return std::cos(angle) + std::sqrt(4 - std::sin(angle) * std::sin(angle));
  };
  // Twice the kinetic energy at unit speed, by differences of where things are.
  const auto inertia = [&](double angle) {
    const double e = 1e-4, tilt = std::cos(angle) / std::sqrt(4 - std::sin(angle) * std::sin(angle));
    const auto rate = [&](const auto& f) { return (f(angle + e) - f(angle - e)) / (2 * e); };
    const double x = rate(slider), middle_x = rate([&](double a) { return 0.5 * (std::cos(a) + slider(a)); });
    return 1.0 / 3 + 4.0 / 12 * tilt * tilt + middle_x * middle_x + 0.25 * std::cos(angle) * std::cos(angle) +
           x * x;
  };
  for (const State& state : result.outputs) {
    const double angle = speed * state.t;
    EXPECT_NEAR(result.position(state, "slider")[0], slider(angle), 1e-7) << state.t;
    const double torque = 0.5 * speed * speed * (inertia(angle + 1e-3) - inertia(angle - 1e-3)) / 2e-3;
    EXPECT_NEAR(-result.multiplier(state, "motion drive", 0), torque, 1e-3) << state.t;
  }
}

// It is a pendulum: with angle a from upright, J = (N + 1) / 3 + N and moment of weight ((N + 1) / 2 + N) g
// sin a.
void expect_pendulum(int loops, const MotionRun& result, double within) {
  EXPECT_EQ(result.report.redundant.size(), 3U * static_cast<unsigned>(loops));
  const double rate = 9.81 * ((loops + 1) / 2.0 + loops) / ((loops + 1) / 3.0 + loops);
  const auto f = [&](double, const Eigen::Vector2d& y) {
    return Eigen::Vector2d(y[1], rate * std::sin(y[0]));
  };
  for (const State& state : result.outputs) {
    const double angle = runge_kutta(Eigen::Vector2d(0, 1), 0.0, state.t, 20000, f)[0];
    const Vector3d tip(std::sin(angle), std::cos(angle), 0);
    EXPECT_LT((result.position(state, "up100") - 0.5 * tip).norm(), within) << state.t;
    EXPECT_LT((result.position(state, "up" + std::to_string(100 + loops)) - loops * kX - 0.5 * tip).norm(),
              within)
        << state.t;
  }
}

TEST(ChainOfFourBars, TwoFallThroughFlatPositions) {
  expect_pendulum(2, run(of_library("four_bars_2", 10.0, 10), 1e-7), 2e-3);
}

// Where Newton's method fails in a flat position local errors become larger, but not for the rest of the run:
// errors of 2e-5 m.
TEST(ChainOfFourBars, TwoAreExactBehindFlatPositions) {
  Json json = of_library("four_bars_2", 10.0, 10);
  json["integrator"]["rtol"] = 3.1622776601683795e-9;
  const MotionRun result = run(json);
  EXPECT_GT(result.report.newton_rejections, 0);
  expect_pendulum(2, result, 6e-6);
}

// With local errors of 1.6e-9 rounding stops Newton's method there, with those of 1e-8 it does not.
TEST(ChainOfFourBars, FortyGetPastAFlatPositionAtATightTolerance) {
  Json json = of_library("four_bars_40", 1.5, 1);
  json["integrator"]["rtol"] = 1e-8;
  EXPECT_GT(run(json).report.newton_rejections, 0);
}

// Steps that were shortened beside a flat position, and stayed short, came to end in it, which made them
// shorter and shorter, at one tolerance of 30 or so.
TEST(ChainOfFourBars, PassFlatPositionsAtTightTolerances) {
  Json json = of_library("four_bars_40", 1.0, 1);
  for (const double rtol : {1.0000000000000082e-8, 1.5848931924611476e-9}) {
    json["integrator"]["rtol"] = rtol;
    EXPECT_NO_THROW(run(json)) << rtol;
  }
}

TEST(ChainOfFourBars, Forty) {
  expect_pendulum(40, run(of_library("four_bars_40", 2.0, 10), 1e-6), 2e-3);
}

// Six rods along the edges of a cube, joined by axes perpendicular to both (Bricard's loop); one is the
// ground. Its 35 constraints leave 35 coordinates one freedom. Reference: perf/mechanisms (Newton's and
// Euler's equations, constraints on accelerations, SciPy's DOP853 with 1e-12).
TEST(Bricard, OneConstraintIsRedundant) {
  const MotionRun result = run(of_library("bricard", 5.0, 10), 1e-8);
  EXPECT_THAT(result.report.redundant, AllOf(SizeIs(1), Each(HasSubstr("joint joint5"))));
  const std::pair<double, Vector3d> expected[] = {
      {0.5, {1.1183428240, 0.8449310682, 0.7638749690}},   {1.0, {1.2518973276, -0.4773025838, 1.1159742167}},
      {1.5, {-0.6863304788, -1.1922777137, 0.0469281730}}, {2.0, {-1.2503151855, 0.4846572012, 1.1115508249}},
      {3.0, {-1.0305105485, 0.9675066689, 0.5628793262}},  {5.0, {1.1175426269, 0.8463030286, 0.7619188531}}};
  for (const auto& [t, middle] : expected) {
    const State& state = result.outputs.at(static_cast<std::size_t>(std::lround(2 * t)));
    EXPECT_LT((result.position(state, "rod3") - middle).norm(), 1e-4) << t;
  }
}

// Two arms of 1 m hang on a shaft, links of 0.5 m from their middles carry a collar that slides on it. With
// the angle b of the arms from the shaft, J the inertia about it and the momentum J w, which stays,
// m b'' + m' b'^2 / 2 = J' w^2 / 2 - V'. As it turns, other rows of the joints, which are along ground axes,
// become redundant, which long steps see late.
TEST(LinkedGovernor, SwingsAsItTurns) {
  const double begin = 0.5, spin = 6.0;

  const double thin = 1e-3 / 12, across = 0.25 / 12;
  const double by_sine = 2 * (1.0 / 3 + 1.0 / 16 + across), by_cosine = 4 * thin;
  const auto inertia = [&](double b) {
    return by_sine * std::sin(b) * std::sin(b) + by_cosine * std::cos(b) * std::cos(b) + 2 * thin;
  };
  const double momentum = inertia(begin) * spin;
  const auto f = [&](double, const Vector3d& y) {  // b, b', angle about the shaft
    const double s = std::sin(y[0]), c = std::cos(y[0]), w = momentum / inertia(y[0]);
    const double m = 2 * (1.0 / 3 + c * c / 16 + 9 * s * s / 16 + across) + s * s;
    const double m_b = 2 * s * c * (2 * (8.0 / 16) + 1), inertia_b = 2 * s * c * (by_sine - by_cosine);
    return Vector3d(y[1], (0.5 * inertia_b * w * w - 3.5 * 9.81 * s - 0.5 * m_b * y[1] * y[1]) / m, w);
  };
  for (const auto& [tolerance, within] : {std::pair(1e-4, 0.3), {1e-5, 3e-2}, {1e-7, 1e-3}}) {
    const MotionRun result = run(of_library("linked_governor"), tolerance);
    EXPECT_THAT(result.report.redundant, SizeIs(6));
    for (const State& state : result.outputs) {
      const Vector3d y = runge_kutta(Vector3d(begin, 0, 0), 0.0, state.t, 2000, f);
      const double out = std::sin(y[0]), down = std::cos(y[0]);
      const Vector3d middle(out * std::cos(y[2]), -down, -out * std::sin(y[2]));
      EXPECT_LT((result.position(state, "arm1") - 0.5 * middle).norm(), within) << state.t;
      EXPECT_NEAR(result.position(state, "collar")[1], -down - 0.5, within) << state.t;
    }
  }
}

}  // namespace
}  // namespace mfs::dae::test
