// Outputs between the ends of steps, against the exact motion of a pendulum: they are as good as the ends, on
// all levels, and leave the steps alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

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
    ASSERT_LT(run.recorder.steps.size(), 10000U);
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

INSTANTIATE_TEST_SUITE_P(Methods, DenseOutputTest, testing::Values(Method::bdf, Method::generalized_alpha));

}  // namespace
}  // namespace mfs::dae::test
