// What Newton's method looks at against plain loops.
#include "dae/integrator/newton_norms.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "test/dae/integrator/dense_system.hpp"
#include "test/dae/integrator/pendulum.hpp"
#include "test/reference/random.hpp"

namespace mfs::dae::test {
namespace {

TEST(NewtonNorms, AreThoseOfRowsLevelsAndTheLastCorrection) {
  const DenseSystem<Pendulum> system;
  const Executor host(Executor::Place::host, 2);
  for (const Unknowns unknowns : {Unknowns::reduced, Unknowns::full}) {
    const StepEquations equations(system, unknowns, find_projection(system, 0.0, {1.0, 0.0}, 1.0), host);
    const auto size = static_cast<std::size_t>(equations.size());
    mfs::test::Random random(7);
    const std::vector<double> scales = random.vector(4);
    std::vector<double> weights;
    for (const double scale : scales) weights.push_back(1.5 + scale);
    const Array<double> weights_there = make_array(host, weights);
    Array<double> y;
    std::vector<double> before(4, 0.0);
    for (int iteration = 0; iteration < 3; ++iteration) {
      const std::vector<double> h = random.vector(static_cast<int>(size)), q = random.vector(2),
                                v = random.vector(2), now{q[0], q[1], v[0], v[1]};
      StepState state;
      assign(host, State{0.0, q, v, {0.0, 0.0}, {0.0}}, state);
      const NewtonNorms norms = newton_norms(host, equations, h.data(), state, weights_there, y);
      double largest = 0.0, sum = 0.0;
      for (const double value : h) largest = std::max(largest, std::abs(value));
      for (int k = 0; k < 4; ++k) sum += std::pow((now[k] - before[k]) / weights[k], 2);
      EXPECT_EQ(norms.residual, largest);
      for (int level = 0; level < 3; ++level)
        EXPECT_EQ(norms.violation[level], std::abs(h[equations.first_constraint() + level])) << level;
      EXPECT_NEAR(norms.correction, std::sqrt(sum / 4), 1e-14);
      before = now;
    }
    std::vector<double> h(size, 0.0);
    h[equations.first_constraint() + 1] = std::numeric_limits<double>::quiet_NaN();
    StepState state;
    assign(host, State{0.0, {0.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}, {0.0}}, state);
    const NewtonNorms norms = newton_norms(host, equations, h.data(), state, weights_there, y);
    EXPECT_EQ(norms.residual, HUGE_VAL);
    EXPECT_EQ(norms.violation[1], HUGE_VAL);
    EXPECT_EQ(norms.violation[2], 0.0);
  }
}

}  // namespace
}  // namespace mfs::dae::test
