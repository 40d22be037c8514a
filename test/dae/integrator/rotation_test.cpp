// Bodies that rotate many times, against exact solutions and those of another program: the error falls with
// the tolerance, and the order does not stay low.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/rotation.hpp"
#include "test/dae/integrator/jacobi.hpp"
#include "test/dae/model/mechanism.hpp"

namespace mfs::dae::test {
namespace {

/// What a state says about the body whose frame has these coordinates.
struct Motion {
  Motion(const State& state, const Frame& frame) : q(&state.q[frame.first]), v(&state.v[frame.first]) {}
  Vector3d turned(const Vector3d& s) const {
    const Triple<double> x = rotate(q + 3, s);
    return {x[0], x[1], x[2]};
  }
  Vector3d point(const Vector3d& s) const { return Vector3d(q[0], q[1], q[2]) + turned(s); }
  Vector3d velocity() const { return {v[0], v[1], v[2]}; }
  Vector3d angular_velocity() const {  // in body axes
    const Triple<double> half = g_times(q + 3, v + 3);
    return 2.0 * Vector3d(half[0], half[1], half[2]);
  }
  const double *q, *v;
};

/// A mechanism and how far a state is from where it should be.
struct Mechanism {
  explicit Mechanism(const Json& json) : model(make_model(json, "", 1, Backend::serial)) {}
  Frame frame(int body) const { return model.rigid_bodies[static_cast<std::size_t>(body)].frame; }
  MultibodyModel model;
  std::function<double(const State&)> error;
  std::vector<double> times;  ///< at which the error is known; none: after each step
};

class LargestError : public Observer {
 public:
  explicit LargestError(const Mechanism& mechanism) : mechanism_(mechanism) {}
  void step(const StepReport& report, const std::function<const State&()>& state) override {
    if (mechanism_.times.empty()) output(state());
    low_ = report.order == 1 ? low_ + 1 : 0;
    longest_low_ = std::max(longest_low_, low_);
  }
  void output(const State& state) override { error_ = std::max(error_, mechanism_.error(state)); }
  double error() const { return error_; }
  int longest_low() const { return longest_low_; }  ///< steps of order 1 in a row

 private:
  const Mechanism& mechanism_;
  double error_ = 0.0;
  int low_ = 0, longest_low_ = 0;
};

double error_at(const Mechanism& mechanism, double rtol, Method method = Method::bdf) {
  IntegratorOptions options;
  options.method = method;
  options.rtol = rtol;
  options.threads = 1;
  options.backend = Backend::serial;
  const MultibodyModel& model = mechanism.model;
  Integrator integrator(*model.system, options);
  LargestError observer(mechanism);
  integrator.run(0.0, model.q0, model.v0, model.end, mechanism.times, observer);
  EXPECT_LE(observer.longest_low(), 50) << "rtol " << rtol;
  EXPECT_EQ(integrator.report().analyses, 1);
  return observer.error();
}

/// Below `at_default` with the default tolerance, and by at least 40 when rtol falls by 100: local errors are
/// made such that it should be 100.
void expect_falling(const Mechanism& mechanism, double at_default) {
  EXPECT_LT(error_at(mechanism, 1e-4), at_default);
  for (const double rtol : {1e-4, 1e-5, 1e-6})
    EXPECT_LT(error_at(mechanism, 1e-2 * rtol), error_at(mechanism, rtol) / 40.0) << "rtol " << rtol;
}

/// The same of order 2.
void expect_alpha_falling(const Mechanism& mechanism) {
  const double coarse = error_at(mechanism, 1e-4, Method::generalized_alpha);
  EXPECT_LT(error_at(mechanism, 1e-6, Method::generalized_alpha), coarse / 40.0);
}

/// 32 turns about an axis that is along no coordinate, of a body whose own axes are turned: a circle.
TEST(Rotation, AboutAnObliqueAxisIsACircle) {
  constexpr double kSpeed = 100.0;
  const Vector3d axis = Vector3d(1, 2, 3).normalized(), centre(0.4, 0.1, -0.2), tip(1, 0, 0);
  const Vector3d turned_about(0.3, -0.5, 0.8);
  Json json = mechanism(2.0, 1, Vector3d::Zero());
  json["bodies"]["rod"] = {{"type", "rigid"},
                           {"mass", 1.0},
                           {"inertia", {0.1, 0.2, 0.25}},
                           {"position", triple(centre)},
                           {"rotation", {{"axis", triple(turned_about)}, {"angle", 2.0}}},
                           {"velocity", triple(kSpeed * axis.cross(centre))},
                           {"angular_velocity", triple(kSpeed * axis)}};
  json["joints"]["pin"] = joint("revolute", "ground", "rod", Vector3d::Zero(), axis);
  Mechanism mechanism(json);
  const Frame frame = mechanism.frame(0);
  const Vector3d arm = Eigen::AngleAxisd(-2.0, turned_about.normalized()) * (tip - centre);
  mechanism.error = [=](const State& state) {
    return (Motion(state, frame).point(arm) - Eigen::AngleAxisd(kSpeed * state.t, axis) * tip).norm();
  };
  expect_falling(mechanism, 0.05);
  expect_alpha_falling(mechanism);
}

/// Turning about the middle axis, which it leaves again and again: Euler's solution (Landau and Lifshitz,
/// Mechanics, section 37) for the angular velocity; the angular momentum stays where it is.
TEST(Rotation, FreeAboutTheMiddleAxisFlipsAsEulerSays) {
  const Vector3d inertia(1, 2, 3), start(10.0, 0.0, std::sqrt(101.0 / 3.0));
  Mechanism mechanism(of_library("free_flip"));
  const Frame frame = mechanism.frame(0);
  const double twice_energy = start.dot(inertia.cwiseProduct(start));
  const Vector3d momentum =
      Eigen::AngleAxisd(0.7, Vector3d(2, 1, -1).normalized()) * inertia.cwiseProduct(start);
  const double m2 = momentum.squaredNorm(), low = m2 - twice_energy * inertia[0],
               high = twice_energy * inertia[2] - m2;
  const double i1 = inertia[0], i2 = inertia[1], i3 = inertia[2];
  mechanism.error = [=](const State& state) {
    const auto [sn, cn, dn] =
        jacobi(state.t * std::sqrt((i3 - i2) * low / (i1 * i2 * i3)), (i2 - i1) * high / ((i3 - i2) * low));
    const Vector3d exact(std::sqrt(high / (i1 * (i3 - i1))) * cn, std::sqrt(high / (i2 * (i3 - i2))) * sn,
                         std::sqrt(low / (i3 * (i3 - i1))) * dn);
    const Motion motion(state, frame);
    const Vector3d w = motion.angular_velocity();
    return std::max((w - exact).norm() / start.norm(),
                    (motion.turned(inertia.cwiseProduct(w)) - momentum).norm() / momentum.norm());
  };
  expect_falling(mechanism, 1.5);
}

/// A heavy symmetric top at 150 rad/s keeps its energy, its spin and its momentum about the vertical. Where
/// its centre is after 2 s: DOP853 of SciPy 1.10 with rtol 1e-13, by perf/mechanisms.
TEST(Rotation, OfAHeavyTopKeepsItsIntegrals) {
  constexpr double kMass = 15.0, kGravity = 9.81;
  const Vector3d inertia(0.234375, 0.46875, 0.234375), centre(0, 1, 0);
  const Vector3d reference(-0.1504168228, -0.7241655916, -0.6730222696);
  Mechanism mechanism(of_library("heavy_top"));
  const Frame frame = mechanism.frame(0);
  const Vector3d about_tip = inertia + kMass * Vector3d(1, 0, 1);
  const auto integrals = [=](const State& state) -> Vector3d {
    const Motion motion(state, frame);
    const Vector3d w = motion.angular_velocity();
    return {0.5 * w.dot(about_tip.cwiseProduct(w)) + kMass * kGravity * motion.turned(centre)[2], w[1],
            motion.turned(about_tip.cwiseProduct(w))[2]};
  };
  const Vector3d first = integrals({0.0, mechanism.model.q0, mechanism.model.v0, {}, {}});
  mechanism.error = [=](const State& state) {
    const double drift = (integrals(state) - first).cwiseQuotient(first).cwiseAbs().maxCoeff();
    return state.t < 2.0 ? drift
                         : std::max(drift, (Motion(state, frame).point(Vector3d::Zero()) - reference).norm());
  };
  expect_falling(mechanism, 0.6);
  expect_alpha_falling(mechanism);
}

/// Two bodies on universal joints, pulled aside. Where the second one's corner is after 1, 2 and 3 s: DOP853
/// of SciPy 1.17 with rtol 1e-13 on the four joint angles, equations of motion by Newton and Euler.
TEST(Rotation, OfADoublePendulumOfUniversalJoints) {
  Mechanism mechanism(of_library("universal_pendulum"));
  mechanism.times = {1.0, 2.0, 3.0};
  const Frame last = mechanism.frame(1);
  const Vector3d references[] = {{-1.8606676211958, 0.4983276603892, -0.5559768352665},
                                 {0.7030450653695, 0.2114495425984, -1.5328405197776},
                                 {0.2275047760334, -0.2391598421196, -1.6535314450977}};
  mechanism.error = [last, references](const State& state) {
    const Vector3d& expected = references[static_cast<int>(std::lround(state.t)) - 1];
    return (Motion(state, last).point({0.5, 0.3, 0.0}) - expected).norm();
  };
  expect_falling(mechanism, 0.6);
}

}  // namespace
}  // namespace mfs::dae::test
