// Orders of convergence, with fixed steps, against an exact solution.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "dae/integrator/integrator.hpp"
#include "test/dae/integrator/driven_circle.hpp"
#include "test/dae/integrator/recorder.hpp"

namespace mfs::dae::test {
namespace {

const DrivenCircle kMotion{};

/// The largest in the second half of the motion.
struct Errors {
  double q = 0.0, v = 0.0;
};

double distance(const std::vector<double>& x, const std::vector<double>& y) {
  return std::hypot(x[0] - y[0], x[1] - y[1]);
}

/// With steps of this length, or with every second one `change` times as long.
Errors errors(IntegratorOptions options, double step, double change = 1.0) {
  const double t_end = 2.0;
  std::vector<double> times;
  if (change != 1.0)
    for (double t = step; t < t_end; t += times.size() % 2 == 1 ? change * step : step) times.push_back(t);
  options.fixed_step = step;
  options.rtol = options.atol_position = options.atol_velocity = 1e-13;  // Newton's method goes on to there
  options.constraint_position = 1e-12;
  options.threads = 1;
  options.newton_iterations = 20;
  const DenseSystem<DrivenCircle> system(kMotion);
  Integrator integrator(system, options);
  Recorder recorder;
  integrator.run(0.0, kMotion.position(0.0), kMotion.velocity(0.0), t_end, times, recorder);
  Errors worst;
  for (const State& s : recorder.states) {
    if (s.t < 0.5 * t_end) continue;
    worst.q = std::max(worst.q, distance(s.q, kMotion.position(s.t)));
    worst.v = std::max(worst.v, distance(s.v, kMotion.velocity(s.t)));
  }
  return worst;
}

double observed_order(double coarse, double fine) {
  return std::log2(coarse / fine);
}

class BdfOrder : public testing::TestWithParam<int> {};

TEST_P(BdfOrder, IsReached) {
  IntegratorOptions options;
  options.max_order = GetParam();
  options.initial_step = 1e-7;  // small steps to begin with: the first ones are of order 1
  const double step = 0.01;     // above the tolerance of Newton's method
  const Errors coarse = errors(options, step), fine = errors(options, 0.5 * step);
  EXPECT_NEAR(observed_order(coarse.q, fine.q), GetParam(), 0.25) << coarse.q << " " << fine.q;
  EXPECT_NEAR(observed_order(coarse.v, fine.v), GetParam(), 0.25) << coarse.v << " " << fine.v;
}

INSTANTIATE_TEST_SUITE_P(Orders, BdfOrder, testing::Range(1, 6));

TEST(GeneralizedAlpha, IsOfOrderTwo) {
  for (const double rho : {0.0, 0.8, 1.0}) {
    for (const Unknowns unknowns : {Unknowns::full, Unknowns::reduced}) {
      IntegratorOptions options;
      options.method = Method::generalized_alpha;
      options.unknowns = unknowns;
      options.rho_inf = rho;
      const Errors coarse = errors(options, 0.02), fine = errors(options, 0.01);
      EXPECT_NEAR(observed_order(coarse.q, fine.q), 2.0, 0.25) << "rho " << rho;
      EXPECT_NEAR(observed_order(coarse.v, fine.v), 2.0, 0.25) << "rho " << rho;
    }
  }
}

TEST(GeneralizedAlpha, IsOfOrderTwoWhereStepsChange) {
  IntegratorOptions options;
  options.method = Method::generalized_alpha;
  options.rho_inf = 0.0;
  const Errors coarse = errors(options, 0.02, 0.25), fine = errors(options, 0.01, 0.25);
  EXPECT_NEAR(observed_order(coarse.q, fine.q), 2.0, 0.25) << coarse.q << " " << fine.q;
  EXPECT_NEAR(observed_order(coarse.v, fine.v), 2.0, 0.25) << coarse.v << " " << fine.v;
}

}  // namespace
}  // namespace mfs::dae::test
