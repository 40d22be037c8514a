// Mechanisms of textbooks on mechanism theory, written as a user writes a model file, beside their closed
// formulas: J. J. Uicker, G. R. Pennock, J. E. Shigley, "Theory of Machines and Mechanisms" (Scotch yoke,
// quick return, Hooke's joint, Oldham's coupling, Peaucellier's linkage); E. J. Haug, "Computer Aided
// Kinematics and Dynamics of Mechanical Systems", 1989 (quick return); G. T. Bennett, "The skew isogram
// mechanism", Proc. London Math. Soc. 13 (1914); for the ball on a turntable W. Burns, American Journal of
// Physics 49 (1981) 56-58.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <complex>

#include "test/dae/model/mechanism.hpp"

namespace mfs::dae::test {
namespace {

using std::cos, std::sin;
using testing::SizeIs;

const Vector3d kX = Vector3d::UnitX(), kY = Vector3d::UnitY(), kZ = Vector3d::UnitZ();
const Vector3d kNone(0, 0, 0), kDown(0, -9.81, 0);

Json block(const Vector3d& position, double mass = 1.0) {
  return {{"type", "rigid"}, {"mass", mass}, {"inertia", {0.01, 0.01, 0.01}}, {"position", triple(position)}};
}

Json turns(const std::string& joint, const std::string& angle) {
  return {{"type", "rotation"}, {"joint", joint}, {"angle", angle}};
}

Vector3d velocity(const MotionRun& result, const State& state, const std::string& body) {
  return Eigen::Map<const Vector3d>(&state.v[result.at(body)]);
}
Vector3d acceleration(const MotionRun& result, const State& state, const std::string& body) {
  return Eigen::Map<const Vector3d>(&state.a[result.at(body)]);
}
/// About z of a body that turns about z alone, -pi ... pi.
double angle_about_z(const MotionRun& result, const State& state, const std::string& body) {
  const double* const p = &state.q[result.at(body) + 3];
  return 2.0 * std::atan2(p[3], p[0]);
}
/// What is left of a difference of angles.
double turned(double angle) {
  return std::remainder(angle, 2 * M_PI);
}

// A block on the crank slides in the yoke's slot, the yoke along x: x = r cos(angle), and the drive does the
// work of both masses.
TEST(ScotchYoke, MovesAsACosine) {
  constexpr double kR = 0.1;
  Json json = mechanism(2.0, 50, kNone);
  json["bodies"] = {{"crank", block(kNone)}, {"block", block(kR * kX, 0.2)}, {"yoke", block(kR * kX, 2.0)}};
  json["joints"] = {{"bearing", joint("revolute", "ground", "crank", kNone)},
                    {"pin", joint("revolute", "crank", "block", kR * kX)},
                    {"slot", joint("translational", "yoke", "block", kR * kX, kY)},
                    {"guide", joint("translational", "ground", "yoke", kR * kX, kX)}};
  json["motions"]["drive"] = turns("bearing", "2*pi*t + 0.3*t^2");
  const MotionRun result = run(json, 1e-6);
  EXPECT_THAT(result.report.redundant, SizeIs(3));
  for (const State& state : result.outputs) {
    const double t = state.t, angle = 2 * M_PI * t + 0.3 * t * t, w = 2 * M_PI + 0.6 * t;
    const double c = kR * cos(angle), s = kR * sin(angle);
    const double ax = -c * w * w - s * 0.6, ay = -s * w * w + c * 0.6;
    EXPECT_NEAR(result.position(state, "yoke")[0], c, 1e-8) << t;
    EXPECT_NEAR(acceleration(result, state, "yoke")[0], ax, 1e-5) << t;
    // Its multiplier is the torque on the crank, but for the sign.
    const double torque = 0.01 * 0.6 - 2.2 * ax * s + 0.2 * ay * c;
    EXPECT_NEAR(std::abs(result.multiplier(state, "motion drive", 0)), std::abs(torque), 1e-5) << t;
  }
}

// Crank r about O, which drives a rocker of length L about a pivot d below it; its end moves the ram.
TEST(QuickReturn, RamGoesAsTheCrankSays) {
  constexpr double kR = 0.1, kD = 0.3, kL = 0.7, kStart = M_PI / 6;
  const Vector3d pin = kR * Vector3d(cos(kStart), sin(kStart), 0), pivot = -kD * kY;
  const Vector3d along = (pin - pivot).normalized(), tip = pivot + kL * along;
  Json json = mechanism(2.0, 50, kDown);
  json["bodies"] = {{"crank", block(kNone)},
                    {"slider", block(pin, 0.3)},
                    {"rocker", rod(pivot, tip)},
                    {"block", block(tip, 0.2)},
                    {"ram", block(tip, 5.0)}};
  json["joints"] = {{"bearing", joint("revolute", "ground", "crank", kNone)},
                    {"pin", joint("revolute", "crank", "slider", pin)},
                    {"slide", joint("translational", "rocker", "slider", pin, along)},
                    {"pivot", joint("revolute", "ground", "rocker", pivot)},
                    {"tip", joint("revolute", "rocker", "block", tip)},
                    {"slot", joint("translational", "ram", "block", tip, kY)},
                    {"guide", joint("translational", "ground", "ram", tip, kX)}};
  json["motions"]["drive"] = turns("bearing", "2*pi*t");
  const MotionRun result = run(json, 1e-6);
  EXPECT_THAT(result.report.redundant, SizeIs(6));
  for (const State& state : result.outputs) {
    const double angle = kStart + 2 * M_PI * state.t;
    const double reach = std::sqrt(kR * kR + kD * kD + 2 * kR * kD * sin(angle));  // from pivot to pin
    const double x = kL * kR * cos(angle) / reach;
    const double slope =
        -kL * kR * (sin(angle) / reach + kR * kD * cos(angle) * cos(angle) / std::pow(reach, 3));
    EXPECT_NEAR(result.position(state, "ram")[0], x, 1e-8) << state.t;
    EXPECT_NEAR(velocity(result, state, "ram")[0], 2 * M_PI * slope, 1e-6) << state.t;
  }
}

// OC = OD = l, a rhombus of side s between C, D, B, P, and AB = OA = c: OB OP = l^2 - s^2, so P, which is on
// the line OB, is on x = (l^2 - s^2) / 2c.
TEST(Peaucellier, PointRunsAlongALine) {
  constexpr double kC = 0.35, kL = 1.0, kS = 0.4, kStart = 0.3;
  const Vector3d a(kC, 0, 0), b = a + kC * Vector3d(cos(kStart), sin(kStart), 0);
  const double ob = b.norm(), op = (kL * kL - kS * kS) / ob, middle = 0.5 * (ob + op);
  const Vector3d along = b / ob, across = std::sqrt(kL * kL - middle * middle) * kZ.cross(along);
  const Vector3d c = middle * along + across, d = middle * along - across, p = op * along;
  Json json = mechanism(2.0, 50, kDown);
  json["bodies"] = {{"ab", rod(a, b)}, {"oc", rod(kNone, c)}, {"od", rod(kNone, d)}, {"cb", rod(c, b)},
                    {"bd", rod(b, d)}, {"dp", rod(d, p)},     {"pc", rod(p, c)}};
  json["joints"] = {
      {"A", joint("revolute", "ground", "ab", a)},      {"O1", joint("revolute", "ground", "oc", kNone)},
      {"O2", joint("revolute", "ground", "od", kNone)}, {"C1", joint("revolute", "oc", "cb", c)},
      {"C2", joint("revolute", "oc", "pc", c)},         {"D1", joint("revolute", "od", "bd", d)},
      {"D2", joint("revolute", "od", "dp", d)},         {"B1", joint("revolute", "ab", "cb", b)},
      {"B2", joint("revolute", "ab", "bd", b)},         {"P", joint("revolute", "dp", "pc", p)}};
  json["motions"]["drive"] = turns("A", "0.5*sin(2*pi*t)");
  const MotionRun result = run(json, 1e-6);
  EXPECT_THAT(result.report.redundant, SizeIs(9));
  for (const State& state : result.outputs) {
    const double angle = kStart + 0.5 * sin(2 * M_PI * state.t), x = (kL * kL - kS * kS) / (2 * kC);
    // C and D are as far from the centres of their rods to P as these from P.
    const Vector3d end(x, x * std::tan(0.5 * angle), 0);
    for (const char* name : {"dp", "pc"}) {
      const Vector3d from = result.position(state, name) - end;
      EXPECT_NEAR(from.norm(), 0.5 * kS, 1e-8) << state.t;
      EXPECT_NEAR((end + 2 * from).norm(), kL, 1e-8) << state.t;
    }
  }
}

// All four axes meet in O: arcs of 30, 80 and 70 degrees on a sphere between two axes at 90, of which the
// first turns once around. The end of the third is where it is as far from both as they ask for.
TEST(SphericalFourBar, ClosesOnTheSphere) {
  const double first = M_PI / 6, second = M_PI * 80 / 180, third = M_PI * 70 / 180, start = 0.5;
  const auto input = [&](double angle) {
    return Vector3d(sin(first) * cos(angle), sin(first) * sin(angle), cos(first));
  };
  const auto output = [&](double angle) {
    const Vector3d b = input(angle), normal = b.cross(kX);
    const double cosine = b.dot(kX), sine2 = 1.0 - cosine * cosine;
    const double of_b = (cos(second) - cosine * cos(third)) / sine2;
    const double of_x = (cos(third) - cosine * cos(second)) / sine2;
    const Vector3d in_plane = of_b * b + of_x * kX;
    return Vector3d(in_plane + std::sqrt((1.0 - in_plane.squaredNorm()) / sine2) * normal);
  };
  const Vector3d b = input(start), c = output(start);
  Json json = mechanism(1.0, 50, kDown);
  json["bodies"] = {{"input", rod(0.9 * kZ, b)}, {"coupler", rod(b, c)}, {"output", rod(0.9 * kX, c)}};
  json["joints"] = {{"O1", joint("revolute", "ground", "input", kZ, kZ)},
                    {"B", joint("revolute", "input", "coupler", b, b)},
                    {"C", joint("revolute", "coupler", "output", c, c)},
                    {"O2", joint("revolute", "ground", "output", kX, kX)}};
  json["motions"]["drive"] = turns("O1", "2*pi*t");
  const MotionRun result = run(json, 1e-6);
  EXPECT_THAT(result.report.redundant, SizeIs(3));
  for (const State& state : result.outputs) {
    const double angle = start + 2 * M_PI * state.t;
    const Vector3d middle = 0.5 * (input(angle) + output(angle));
    EXPECT_LT((result.position(state, "coupler") - middle).norm(), 1e-8) << state.t;
  }
}

// Shafts at an angle b: tan(out) = cos b tan(in), with the fork of the driving one across both at in = 0.
TEST(HookesJoint, TurnsUnevenly) {
  constexpr double kBend = M_PI / 6;
  const Vector3d out(cos(kBend), sin(kBend), 0), across(-sin(kBend), cos(kBend), 0);
  Json json = mechanism(2.0, 50, kNone);
  json["bodies"] = {{"in", block(-0.2 * kX)}, {"out", block(0.2 * out)}};
  json["joints"] = {{"B1", joint("revolute", "ground", "in", -0.4 * kX, kX)},
                    {"B2", joint("revolute", "ground", "out", 0.4 * out, out)},
                    {"cross", joint("universal", "in", "out", kNone, kZ)}};
  json["joints"]["cross"]["axis_b"] = triple(across);
  json["motions"]["drive"] = turns("B1", "2*pi*t");
  const MotionRun result = run(json, 1e-6);
  EXPECT_THAT(result.report.redundant, SizeIs(3));
  for (const State& state : result.outputs) {
    const double in = 2 * M_PI * state.t, expected = std::atan2(sin(in) * cos(kBend), cos(in));
    const double* const p = &state.q[result.at("out") + 3];
    const double turn = 2.0 * std::atan2(Vector3d(p[1], p[2], p[3]).dot(out), p[0]);
    EXPECT_NEAR(turned(turn - expected), 0.0, 1e-8) << state.t;
  }
}

// Shafts side by side turn as one; the disc between them goes twice round a circle over their distance.
TEST(OldhamsCoupling, TurnsEvenly) {
  constexpr double kApart = 0.05;
  Json json = mechanism(2.0, 50, kNone);
  json["bodies"] = {{"in", block(kNone)}, {"out", block(kApart * kX)}, {"disc", block(kNone, 0.5)}};
  json["joints"] = {{"B1", joint("revolute", "ground", "in", kNone)},
                    {"B2", joint("revolute", "ground", "out", kApart * kX)},
                    {"S1", joint("translational", "in", "disc", kNone, kY)},
                    {"S2", joint("translational", "out", "disc", kNone, kX)}};
  json["motions"]["drive"] = turns("B1", "2*pi*t");
  const MotionRun result = run(json, 1e-6);
  for (const State& state : result.outputs) {
    const double in = 2 * M_PI * state.t;
    EXPECT_NEAR(turned(angle_about_z(result, state, "out") - in), 0.0, 1e-8) << state.t;
    const Vector3d centre(kApart * sin(in) * sin(in), -kApart * sin(in) * cos(in), 0);
    EXPECT_LT((result.position(state, "disc") - centre).norm(), 1e-8) << state.t;
  }
}

// A ball that rolls on a turntable goes in a circle at 2/7 of its angular velocity, wherever it is set down.
TEST(BallOnATurntable, CirclesAtTwoSevenths) {
  constexpr double kTable = 3.0, kRadius = 0.25, kMass = 0.2;
  const double inertia = 0.4 * kMass * kRadius * kRadius;
  Json json = mechanism(6.0, 50, {0, 0, -9.81});
  json["bodies"] = {{"table", block({0, 0, -0.1}, 10)},
                    {"ball",
                     {{"type", "rigid"},
                      {"mass", kMass},
                      {"inertia", {inertia, inertia, inertia}},
                      {"position", {0.5, 0, kRadius}}}}};
  json["joints"] = {{"axle", joint("revolute", "ground", "table", kNone)},
                    {"roll", joint("rolling_ball", "table", "ball", {0.5, 0, kRadius}, kZ)}};
  json["joints"]["roll"]["radius"] = kRadius;
  json["motions"]["drive"] = turns("axle", "3*t");
  using Complex = std::complex<double>;
  const auto error = [&](double rtol) {
    json["integrator"]["rtol"] = rtol;
    const MotionRun result = run(json);
    const auto plane = [](const Vector3d& x) { return Complex(x[0], x[1]); };
    const State& first = result.outputs[0];
    const Complex start = plane(result.position(first, "ball")), v = plane(velocity(result, first, "ball"));
    const Complex spin(0, 2.0 / 7.0 * kTable);
    double most = 0.0;
    for (const State& state : result.outputs)
      most = std::max(most, std::abs(plane(result.position(state, "ball")) - start -
                                     v * (std::exp(spin * state.t) - 1.0) / spin));
    return most;
  };
  const double coarse = error(1e-4), middle = error(1e-6), fine = error(1e-8);
  EXPECT_LT(coarse, 0.2);
  EXPECT_LT(middle, coarse / 25);
  EXPECT_LT(fine, middle / 25);
}

// A point hung by a ball joint from a turntable: J = 1e-9 kg m^2 about the string, which its tension of 10 N
// at 1.2 m would turn by any angle if its direction were that of the prediction. Newton's method converges
// with new Jacobians only: 688 steps and 217 rejections without them, of which 107 and 5 do with J = 1e-5.
TEST(PointOnATurntable, NeedsNoMoreStepsThanABody) {
  constexpr double kOut = 0.7, kLength = 1.2, kTable = 1.3;
  const Vector3d begin(kOut, 0, -kLength), hook = kOut * kX, gravity(0, 0, -9.81);
  Json json = mechanism(4.0, 20, gravity);
  json["bodies"] = {{"table", block(kNone, 5)}, {"bob", block(begin)}};
  json["bodies"]["bob"]["inertia"] = {1e-9, 1e-9, 1e-9};
  json["bodies"]["bob"]["velocity"] = triple({0, kOut * kTable, 0});
  json["joints"] = {{"axle", joint("revolute", "ground", "table", kNone)},
                    {"ball", joint("spherical", "table", "bob", hook)}};
  json["motions"]["drive"] = turns("axle", "1.3*t");
  const MotionRun result = run(json);
  EXPECT_LT(result.report.steps, 400);
  EXPECT_LT(result.report.newton_rejections, 60);

  using Motion = Eigen::Matrix<double, 6, 1>;
  const auto f = [&](double t, const Motion& y) {
    const Eigen::AngleAxisd turn(kTable * t, kZ);
    const Vector3d from = turn * hook, r = y.head<3>() - from, v = y.tail<3>() - kTable * kZ.cross(from);
    const Vector3d fall = gravity + kTable * kTable * from;  // seen from the hook
    Motion rate;
    rate << y.tail<3>(), gravity - (v.squaredNorm() + r.dot(fall)) / r.squaredNorm() * r;
    return rate;
  };
  Motion start;
  start << begin, 0, kOut * kTable, 0;
  for (const State& state : result.outputs) {
    const Motion y = runge_kutta(start, 0.0, state.t, 4000, f);
    EXPECT_LT((result.position(state, "bob") - y.head<3>()).norm(), 1e-3) << state.t;
  }
}

// Crosses of rods of 1 m, one upon the other, on a foot that is pushed along the ground: all are equally
// high.
TEST(ScissorLift, RisesByAllOfItsStages) {
  constexpr int kStages = 4;
  constexpr double kStart = 0.4;
  const double width = cos(kStart), height = sin(kStart);
  Json json = mechanism(2.0, 20, kDown);
  json["bodies"]["foot"] = block(width * kX);
  json["joints"] = {{"pin", joint("revolute", "ground", "up0", kNone)},
                    {"rail", joint("translational", "ground", "foot", width * kX, kX)},
                    {"heel", joint("revolute", "foot", "down0", width * kX)}};
  for (int i = 0; i < kStages; ++i) {
    const std::string n = std::to_string(i), below = std::to_string(i - 1);
    const Vector3d left = i * height * kY, right = left + width * kX, higher = height * kY;
    json["bodies"]["up" + n] = rod(left, right + higher);
    json["bodies"]["down" + n] = rod(right, left + higher);
    json["joints"]["cross" + n] = joint("revolute", "up" + n, "down" + n, 0.5 * (left + right + higher));
    if (i == 0) continue;
    json["joints"]["left" + n] = joint("revolute", "down" + below, "up" + n, left);
    json["joints"]["right" + n] = joint("revolute", "up" + below, "down" + n, right);
  }
  json["motions"]["push"] = {
      {"type", "translation"}, {"joint", "rail"}, {"distance", "0.3*(cos(1.5*t) - 1)"}};
  const MotionRun result = run(json, 1e-6);
  for (const State& state : result.outputs) {
    const double x = width + 0.3 * (cos(1.5 * state.t) - 1), h = std::sqrt(1 - x * x);
    const Vector3d middle(0.5 * x, (kStages - 0.5) * h, 0);
    EXPECT_LT((result.position(state, "up3") - middle).norm(), 1e-8) << state.t;
  }
}

// Miura's fold of 2 by 2 equal parallelograms of 60 degrees, flat facets about four creases that meet in a
// point, which leaves three rows too many. By the fold's angle f (M. Schenk, S. D. Guest, "Geometry of
// Miura-folded metamaterials", PNAS 110 (2013) 3276-3281).
Vector3d miura_vertex(int i, int j, double f) {
  const double skew = std::sqrt(3.0), c = cos(f) * skew, r = std::sqrt(1 + c * c), h = sin(f) * skew / 2;
  return {i * c / r, j * std::sqrt(1 - h * h) + (i % 2) / r, j % 2 == 0 ? 0.0 : h};
}

Json facet(int i, int j, double f) {
  const Vector3d a = miura_vertex(i, j, f), b = miura_vertex(i + 1, j, f), d = miura_vertex(i, j + 1, f);
  Eigen::Matrix3d axes;
  axes.col(0) = (b - a).normalized();
  axes.col(2) = axes.col(0).cross(d - a).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  const Eigen::AngleAxisd turn(axes);
  return {{"type", "rigid"},
          {"mass", 1.0},
          {"inertia", {0.08, 0.08, 0.16}},
          {"position", triple(0.5 * (b + d))},
          {"rotation", {{"axis", triple(turn.axis())}, {"angle", turn.angle()}}}};
}

TEST(MiurasFold, FoldsAsOne) {
  const auto v = [](int i, int j) { return miura_vertex(i, j, 1.0); };
  const auto crease = [&](const char* a, const char* b, const Vector3d& p, const Vector3d& q) {
    return joint("revolute", a, b, 0.5 * (p + q), q - p);
  };
  Json json = mechanism(1.0, 20, kNone);
  json["bodies"] = {{"f00", facet(0, 0, 1.0)},
                    {"f10", facet(1, 0, 1.0)},
                    {"f01", facet(0, 1, 1.0)},
                    {"f11", facet(1, 1, 1.0)}};
  json["joints"] = {{"south", crease("f00", "f10", v(1, 0), v(1, 1))},
                    {"north", crease("f01", "f11", v(1, 1), v(1, 2))},
                    {"west", crease("f00", "f01", v(0, 1), v(1, 1))},
                    {"east", crease("f10", "f11", v(1, 1), v(2, 1))}};
  const std::string c = "(sqrt(3)*cos(1 - 0.3*(1 - cos(3*t))))";
  json["motions"] = {
      {"corner",
       {{"type", "point"}, {"side", "f00"}, {"point", triple(v(0, 0))}, {"x", "0"}, {"y", "0"}, {"z", "0"}}},
      {"pull",
       {{"type", "point"},
        {"side", "f10"},
        {"point", triple(v(2, 0))},
        {"x", "2*" + c + "/sqrt(1 + " + c + "^2)"},
        {"y", "0"},
        {"z", "0"}}},
      {"flat", {{"type", "point"}, {"side", "f01"}, {"point", triple(v(0, 2))}, {"z", "0"}}}};
  const MotionRun result = run(json, 1e-6);
  EXPECT_THAT(result.report.redundant, SizeIs(3));
  for (const State& state : result.outputs) {
    const double f = 1 - 0.3 * (1 - cos(3 * state.t));
    const Vector3d middle = 0.5 * (miura_vertex(2, 1, f) + miura_vertex(1, 2, f));
    EXPECT_LT((result.position(state, "f11") - middle).norm(), 1e-8) << state.t;
  }
}

// They begin where the axes of the outer one and of the rotor are one line, and come back there: Euler's
// angles are singular, the mechanism moves on.
TEST(Gimbals, PassTheirLock) {
  Json json = mechanism(2.0, 40, kNone);
  json["bodies"] = {{"outer", block(kNone)}, {"middle", block(kNone)}, {"rotor", block(kNone)}};
  json["joints"] = {{"a", joint("revolute", "ground", "outer", kNone)},
                    {"b", joint("revolute", "outer", "middle", kNone, kX)},
                    {"c", joint("revolute", "middle", "rotor", kNone)}};
  json["motions"] = {
      {"a", turns("a", "sin(2*t)")}, {"b", turns("b", "1.2*cos(3*t) - 1.2")}, {"c", turns("c", "4*t")}};
  const MotionRun result = run(json, 1e-6);
  for (const State& state : result.outputs) {
    const double t = state.t;
    const Eigen::Quaterniond expected = Eigen::AngleAxisd(sin(2 * t), kZ) *
                                        Eigen::AngleAxisd(1.2 * cos(3 * t) - 1.2, kX) *
                                        Eigen::AngleAxisd(4 * t, kZ);
    const double* const p = &state.q[result.at("rotor") + 3];
    EXPECT_LT(expected.angularDistance(Eigen::Quaterniond(p[0], p[1], p[2], p[3])), 1e-7) << t;
  }
}

// Without friction it leaves the axis of a guide that turns evenly as cosh(w t).
TEST(SliderOnATurningGuide, LeavesItsAxis) {
  constexpr double kW = 2.5, kStart = 0.3;
  Json json = mechanism(1.0, 10, kNone);
  json["bodies"] = {{"guide", rod(kNone, 2 * kX)}, {"slider", block(kStart * kX)}};
  json["bodies"]["slider"]["velocity"] = triple(kW * kStart * kY);
  json["joints"] = {{"hinge", joint("revolute", "ground", "guide", kNone)},
                    {"slide", joint("translational", "guide", "slider", kStart * kX, kX)}};
  json["motions"]["drive"] = drive("hinge", 0.0, kW);
  const MotionRun result = run(json, 1e-7);
  for (const State& state : result.outputs) {
    const double angle = kW * state.t, r = kStart * std::cosh(angle);
    const Vector3d expected(r * cos(angle), r * sin(angle), 0);
    EXPECT_LT((result.position(state, "slider") - expected).norm(), 1e-4) << state.t;
  }
}

/// A wheel of 1 kg, `hub` above the ground's plane by its radius, on an axle of `carrier`.
void add_wheel(Json& json, const std::string& name, const std::string& carrier, const Vector3d& hub,
               const Vector3d& axle = kY) {
  json["bodies"][name] = block(hub);
  json["joints"][name + "_axle"] = joint("revolute", carrier, name, hub, axle);
  json["joints"][name + "_road"] = joint("rolling_wheel", "ground", name, hub);
  json["joints"][name + "_road"]["axis_b"] = triple(axle);
  json["joints"][name + "_road"]["radius"] = hub[2];
}

// Three constraints are redundant: the fourth wheel touches by itself, and two slip to no side then. Wheels
// weigh J / R^2 more than they do.
TEST(Wagon, RollsDownOnFourWheels) {
  constexpr double kR = 0.2, kSlope = 0.3, kG = 9.81;
  Json json = mechanism(2.0, 10, {kG * sin(kSlope), 0, -kG * cos(kSlope)});
  json["bodies"]["wagon"] = block({0, 0, 0.3}, 10.0);
  for (const int i : {0, 1, 2, 3})
    add_wheel(json, "wheel" + std::to_string(i), "wagon", {i < 2 ? 0.5 : -0.5, i % 2 ? 0.4 : -0.4, kR});
  const MotionRun result = run(json, 1e-6);
  EXPECT_THAT(result.report.redundant, SizeIs(3));
  const double a = kG * sin(kSlope) * 14 / (14 + 4 * 0.01 / (kR * kR));
  for (const State& state : result.outputs) {
    const Vector3d expected(0.5 * a * state.t * state.t, 0, 0.3);
    EXPECT_LT((result.position(state, "wagon") - expected).norm(), 1e-4) << state.t;
  }
}

// The front wheel is driven and turned by a fixed angle: rear hubs and fork go on circles about one point.
TEST(Tricycle, GoesInCircles) {
  constexpr double kR = 0.2, kLength = 1.0, kSteer = 0.3, kSpeed = 1.5, kAhead = 0.4;
  Json json = mechanism(2.0, 10, {0, 0, -9.81});
  json["bodies"] = {{"frame", block({kAhead, 0, 0.3}, 10.0)}, {"fork", block({kLength, 0, 0.4})}};
  json["joints"]["head"] = joint("revolute", "frame", "fork", {kLength, 0, 0.4});
  add_wheel(json, "left", "frame", {0, 0.4, kR});
  add_wheel(json, "right", "frame", {0, -0.4, kR});
  add_wheel(json, "front", "fork", {kLength, 0, kR}, {-sin(kSteer), cos(kSteer), 0});
  json["motions"] = {{"steer", turns("head", "0")}, {"drive", drive("front_axle", 0.0, kSpeed / kR)}};
  const MotionRun result = run(json, 1e-6);
  EXPECT_THAT(result.report.redundant, SizeIs(1));
  const double rate = kSpeed * sin(kSteer) / kLength, radius = kLength / std::tan(kSteer);
  for (const State& state : result.outputs) {
    const double angle = rate * state.t;
    const Vector3d rear(radius * sin(angle), radius * (1 - cos(angle)), 0.3);
    const Vector3d expected = rear + kAhead * Vector3d(cos(angle), sin(angle), 0);
    EXPECT_LT((result.position(state, "frame") - expected).norm(), 1e-5) << state.t;
  }
}

// It goes half as far as the plate above it.
TEST(BallBetweenPlates, GoesHalfTheWay) {
  constexpr double kR = 0.1;
  const Vector3d middle(0, 0, kR), above(0, 0, 0.25);
  Json json = mechanism(3.0, 15, {0, 0, -9.81});
  json["bodies"] = {{"ball", block(middle)}, {"stage", block(above)}, {"plate", block(above)}};
  json["joints"] = {{"x", joint("translational", "ground", "stage", above, kX)},
                    {"y", joint("translational", "stage", "plate", above, kY)},
                    {"below", joint("rolling_ball", "ground", "ball", middle)},
                    {"above", joint("rolling_ball", "plate", "ball", middle, -kZ)}};
  for (const char* side : {"below", "above"}) json["joints"][side]["radius"] = kR;
  json["motions"] = {{"x", {{"type", "translation"}, {"joint", "x"}, {"distance", "0.3*sin(2*t)"}}},
                     {"y", {{"type", "translation"}, {"joint", "y"}, {"distance", "0.2 - 0.2*cos(3*t)"}}}};
  const MotionRun result = run(json, 1e-7);
  EXPECT_THAT(result.report.redundant, SizeIs(1));
  for (const State& state : result.outputs) {
    const Vector3d expected(0.15 * sin(2 * state.t), 0.1 - 0.1 * cos(3 * state.t), kR);
    EXPECT_LT((result.position(state, "ball") - expected).norm(), 1e-6) << state.t;
  }
}

// Arms that meet in a ball where shafts bent by 0.8 rad are mirrored: both turn alike.
TEST(ClemensCoupling, TurnsBothShaftsAlike) {
  const Vector3d first(cos(0.4), sin(0.4), 0), second(cos(0.4), -sin(0.4), 0), ball(0, 0, 0.8);
  Json json = mechanism(2.0, 20, kNone);
  json["bodies"] = {{"driving", block(-first)},
                    {"driven", block(second)},
                    {"arm1", block(0.5 * (ball - first))},
                    {"arm2", block(0.5 * (ball + second))}};
  json["joints"] = {{"in", joint("revolute", "ground", "driving", -first, first)},
                    {"out", joint("revolute", "ground", "driven", second, second)},
                    {"hinge1", joint("revolute", "driving", "arm1", -first, first.cross(kZ))},
                    {"hinge2", joint("revolute", "driven", "arm2", second, second.cross(kZ))},
                    {"ball", joint("spherical", "arm1", "arm2", ball)}};
  json["motions"]["drive"] = turns("in", "3*t + 0.5*sin(4*t)");
  const MotionRun result = run(json, 1e-6);
  EXPECT_THAT(result.report.redundant, SizeIs(0));
  for (const State& state : result.outputs) {
    const Eigen::Quaterniond expected(Eigen::AngleAxisd(3 * state.t + 0.5 * sin(4 * state.t), second));
    const double* const p = &state.q[result.at("driven") + 3];
    EXPECT_LT(expected.angularDistance(Eigen::Quaterniond(p[0], p[1], p[2], p[3])), 1e-7) << state.t;
  }
}

/// A weight that is let go where a spring of no length holds it: z = -(m g / k) (1 - cos(w t)).
TEST(Spring, WhoseEndsAreTogether) {
  Json json = mechanism(1.0, 8, {0, 0, -10});
  json["bodies"]["p"] = {{"type", "rigid"}, {"mass", 1}, {"inertia", {1, 1, 1}}};
  json["forces"]["f"] = {{"type", "spring_damper"}, {"a", "ground"},        {"b", "p"},
                         {"point_a", {0, 0, 0}},    {"point_b", {0, 0, 0}}, {"stiffness", 100}};
  for (const bool given : {false, true}) {
    if (given) json["forces"]["f"]["free_length"] = 0;
    const MotionRun result = run(json, 1e-8);
    for (const State& state : result.outputs)
      EXPECT_LE((result.position(state, "p") - Vector3d(0, 0, 0.1 * (std::cos(10 * state.t) - 1))).norm(),
                1e-6);
  }
}

/// A pendulum that falls too fast for steps of 0.5 s, of which Newton's method takes some 0.1: from the first
/// ones, of 0.03 s, it came back to no longer ones.
TEST(FixedStep, IsComeBackToAfterARejection) {
  Json json = mechanism(1.0, 1, {0, -9.81, 0});
  json["bodies"]["p"] = {
      {"type", "rigid"}, {"mass", 1}, {"inertia", {0.1, 0.1, 0.1}}, {"position", {0.5, 0, 0}}};
  json["joints"]["h"] = joint("revolute", "ground", "p", {0, 0, 0});
  json["integrator"] = {{"fixed_step", 0.5}};
  const MultibodyModel model = make_model(json, "", 1);
  Integrator integrator(*model.system, model.integrator);
  Recorder recorder;
  integrator.run(0.0, model.q0, model.v0, model.end, {model.end}, recorder);
  ASSERT_GT(integrator.report().newton_rejections, 0);
  double longest = 0.0;
  for (const StepReport& step : recorder.steps) longest = std::max(longest, step.h);
  EXPECT_GT(longest, 0.1);
  EXPECT_LE(longest, 0.5);
}

}  // namespace
}  // namespace mfs::dae::test
