// Outputs between the ends of steps, against the exact motion of a pendulum: they are as good as the ends, on
// all levels, and leave the steps alone.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "dae/integrator/bdf.hpp"
#include "dae/integrator/dense_output.hpp"
#include "dae/integrator/integrator.hpp"
#include "test/dae/integrator/jacobi.hpp"
#include "test/dae/integrator/pendulum.hpp"
#include "test/dae/integrator/recorder.hpp"

namespace mfs::dae::test {
namespace {

constexpr double kAngle = 2.0;

/// From rest: sin(angle / 2) = k cn / dn (Landau and Lifshitz, Mechanics, section 11).
State exact(double t) {
  const double g = Pendulum::kGravity, k = std::sin(0.5 * kAngle), w = std::sqrt(g);
  const auto [sn, cn, dn] = jacobi(w * t, k * k);
  const double angle = 2.0 * std::asin(k * cn / dn), rate = -2.0 * k * w * std::sqrt(1.0 - k * k) * sn / dn;
  const double s = std::sin(angle), c = std::cos(angle), tension = rate * rate + g * c;
  return {t, {s, -c}, {rate * c, rate * s}, {-tension * s, tension * c - g}, {tension}};
}

/// Largest errors of q, v, a and multipliers, and violations of the constraint on three levels.
using Errors = std::array<double, 7>;

Errors errors(const std::vector<State>& states) {
  Errors largest{};
  for (const State& state : states) {
    const State truth = exact(state.t);
    const auto apart = [](const std::vector<double>& x, const std::vector<double>& y) {
      double most = 0.0;
      for (std::size_t i = 0; i < x.size(); ++i) most = std::max(most, std::abs(x[i] - y[i]));
      return most;
    };
    const auto dot = [](const std::vector<double>& x, const std::vector<double>& y) {
      return x[0] * y[0] + x[1] * y[1];
    };
    const Errors here{apart(state.q, truth.q),
                      apart(state.v, truth.v),
                      apart(state.a, truth.a),
                      apart(state.lambda, truth.lambda),
                      0.5 * std::abs(dot(state.q, state.q) - 1.0),
                      std::abs(dot(state.q, state.v)),
                      std::abs(dot(state.q, state.a) + dot(state.v, state.v))};
    for (std::size_t k = 0; k < here.size(); ++k) largest[k] = std::max(largest[k], here[k]);
  }
  return largest;
}

struct Swing {
  Recorder recorder;
  State end;
};

Swing swing(Method method, double rtol, int outputs) {
  const DenseSystem<Pendulum> system;
  IntegratorOptions options;
  options.method = method;
  options.rtol = rtol;
  options.backend = Backend::serial;
  options.threads = 1;
  Integrator integrator(system, options);
  std::vector<double> times;
  const double end = pendulum_period(kAngle);
  for (int k = 1; k <= outputs; ++k) times.push_back(k == outputs ? end : end * k / outputs);
  Swing swing;
  swing.end = integrator.run(0.0, pendulum_at(kAngle), {0.0, 0.0}, end, times, swing.recorder);
  return swing;
}

class DenseOutputTest : public testing::TestWithParam<Method> {};

TEST_P(DenseOutputTest, IsAsGoodAsTheEndsOfSteps) {
  for (const double rtol : {1e-4, 1e-6, 1e-8}) {
    const Swing run = swing(GetParam(), rtol, 997);
    const Errors at_ends = errors(run.recorder.states), between = errors(run.recorder.outputs);
    ASSERT_EQ(run.recorder.outputs.size(), 997U);
    ASSERT_LT(run.recorder.steps.size(), 20000U);
    for (std::size_t k = 0; k < between.size(); ++k)
      EXPECT_LT(between[k], 1.2 * at_ends[k] + 1e-3 * rtol) << "rtol " << rtol << ", number " << k;
  }
}

// Errors of velocities add up to several times rtol along a motion, and those of accelerations and
// multipliers follow from them: they are not more than four times as large, of what each comes to in the
// motion.
TEST_P(DenseOutputTest, MultipliersAreAboutAsGoodAsVelocities) {
  for (const double rtol : {1e-4, 1e-6, 1e-8}) {
    const Swing run = swing(GetParam(), rtol, 997);
    std::array<double, 4> sizes{};
    for (const State& state : run.recorder.outputs)
      for (const auto& [k, x] : {std::pair(1, &state.v), {2, &state.a}, {3, &state.lambda}})
        for (const double value : *x) sizes[k] = std::max(sizes[k], std::abs(value));
    for (const auto* states : {&run.recorder.states, &run.recorder.outputs}) {
      const Errors error = errors(*states);
      const double of_velocity = error[1] / sizes[1];
      EXPECT_LT(error[2] / sizes[2], 4.0 * of_velocity) << "accelerations, rtol " << rtol;
      EXPECT_LT(error[3] / sizes[3], 4.0 * of_velocity) << "multipliers, rtol " << rtol;
    }
  }
}

TEST_P(DenseOutputTest, LeavesTheStepsAlone) {
  const Swing few = swing(GetParam(), 1e-5, 1), many = swing(GetParam(), 1e-5, 500);
  EXPECT_EQ(few.recorder.steps.size(), many.recorder.steps.size());
  EXPECT_EQ(few.end.q, many.end.q);
  EXPECT_EQ(few.end.lambda, many.end.lambda);
  EXPECT_EQ(many.recorder.outputs.back().q, many.end.q);
  const Swing again = swing(GetParam(), 1e-5, 500);
  for (std::size_t k = 0; k < again.recorder.outputs.size(); ++k)
    EXPECT_EQ(again.recorder.outputs[k].a, many.recorder.outputs[k].a);
}

/// Coordinates: one by itself, five points of a body, three on a line.
constexpr int kFirst = 1, kPoints = 5, kLine = kFirst + 3 * kPoints, kAll = kLine + 9;

void put(const Eigen::Vector3d& x, double* to) {
  std::copy_n(x.data(), 3, to);
}

/// The body turns steadily about its centre, which moves as t^3, as the other coordinates do; in its axes
/// velocities and accelerations of its points are cubics.
StepState turning(const Executor& executor, double t) {
  const double points[kPoints][3] = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0.3, 0.4, 0.5}, {1, 1, 1}};
  std::vector<double> q(kAll), v(kAll), a(kAll);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.7 * t, Eigen::Vector3d(1, 2, 2) / 3.0).toRotationMatrix();
  const double cube = t * t * t;
  q[0] = 2.0 + cube;
  for (int i = 0; i < kPoints; ++i) {
    const Eigen::Vector3d local(points[i][0] - 0.46, points[i][1] - 0.68, points[i][2] - 0.3);
    put(turn * local + Eigen::Vector3d(t, cube, 7), &q[kFirst + 3 * i]);
    put(turn * (local * cube), &v[kFirst + 3 * i]);
    put(turn * (local * t), &a[kFirst + 3 * i]);
  }
  for (int i = kLine; i < kAll; ++i) q[i] = (i - kLine) / 3 * (1.0 + cube);
  StepState state;
  assign(executor, {t, q, v, a, {5.0 + t}}, state);
  return state;
}

TEST(InterpolationTest, IsExactForTurnsAndCubics) {
  const Executor executor(Executor::Place::host, 1);
  PastStates past(Bdf::kMostOrder);
  for (const double t : {-0.6, -0.25, -0.2, -0.1}) {
    StepState state = turning(executor, t);
    past.add(state);
  }
  const StepState now = turning(executor, 0.0);
  StepState there;
  for (const double t : {-0.1, -0.07, -0.01, 0.0}) {
    const std::vector<PointRange> bodies{{kFirst, kPoints}, {kLine, 3}};
    interpolate(executor, bodies, t, now, past, 3, there);
    const State found = on_host(executor, there), exact = on_host(executor, turning(executor, t));
    for (int i = 0; i < kAll; ++i) {
      EXPECT_NEAR(found.q[i], exact.q[i], 1e-13) << i;
      EXPECT_NEAR(found.v[i], exact.v[i], 1e-13) << i;
      EXPECT_NEAR(found.a[i], exact.a[i], 1e-13) << i;
    }
    EXPECT_NEAR(found.lambda[0], exact.lambda[0], 1e-13);
    // Without the body points are on the polynomials, which a turn is not.
    interpolate(executor, {}, t, now, past, 3, there);
    const double off = std::abs(there.q.data()[kFirst + 3] - exact.q[kFirst + 3]);
    EXPECT_LT(off, 1e-4);
    EXPECT_EQ(off > 1e-9, t > -0.1 && t < 0.0);
  }
}

TEST(InterpolationTest, TakesNoMoreOfThePastThanIsKnown) {
  const Executor executor(Executor::Place::host, 1);
  PastStates past(2);
  StepState there, now = turning(executor, 1.0);
  interpolate(executor, {}, 1.0, now, past, 5, there);
  EXPECT_EQ(there.q.data()[0], now.q.data()[0]);
  for (const double t : {-1.0, 0.0, 0.5}) {
    StepState state = turning(executor, t);
    past.add(state);
  }
  EXPECT_EQ(past.size(), 2U);
  EXPECT_EQ(past[0].t, 0.5);
  EXPECT_EQ(past[1].t, 0.0);
  past.forget_multipliers();
  EXPECT_FALSE(past.knows_multipliers());
  interpolate(executor, {}, 0.75, now, past, 5, there);
  EXPECT_NEAR(there.q.data()[0], 2.0 + 0.421875 + 0.0, 0.1);  // a parabola near 2 + t^3
  EXPECT_EQ(there.lambda.data()[0], 6.0);
}

INSTANTIATE_TEST_SUITE_P(Methods, DenseOutputTest, testing::Values(Method::bdf, Method::generalized_alpha));

}  // namespace
}  // namespace mfs::dae::test
