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

/// On two springs, of which the second one is overdamped.
struct Sprung {
  int coordinates() const { return 2; }
  int constraints() const { return 1; }
  template <class T>
  std::vector<T> force(double /*t*/, const std::vector<T>& q, const std::vector<T>& v,
                       const std::vector<T>& a) const {
    return {T(2.0 * a[0] + 0.1 * v[0] + 50.0 * q[0]), T(3.0 * a[1] + 40.0 * v[1] + 20.0 * q[1])};
  }
  template <class T>
  std::vector<T> constraint(const T& t, const std::vector<T>& q) const {
    return Pendulum{}.constraint(t, q);
  }
};
/// The second coordinate is a measure, and pushes both.
struct Measured : DenseSystem<Sprung> {
  bool is_measure(int coordinate) const override { return coordinate == 1; }
};
const std::vector<double> kInertia{2.0, 3.0}, kRinging{1.0, std::pow(20.0 * 3.0 / (40.0 * 40.0), 2)};

/// Of -F_i dq_i as far as it rings: the velocity of all mass by this energy, in units of what is allowed.
double vibration(const std::vector<double>& h, const std::vector<double>& before,
                 const std::vector<double>& now, const std::vector<double>& weights) {
  double work = 0.0, mean = 0.0;
  const double mass = kInertia[0] + kInertia[1];
  for (int k = 0; k < 2; ++k) {
    work -= kRinging[k] * h[k] * (now[k] - before[k]);
    mean += kInertia[k] / mass / std::pow(weights[2 + k], 2);
  }
  return std::sqrt(std::abs(work) / mass * mean);
}

TEST(NewtonNorms, AreThoseOfRowsLevelsAndTheLastCorrection) {
  const Measured system;
  const Executor host(Executor::Place::host, 2);
  for (const Unknowns unknowns : {Unknowns::reduced, Unknowns::full}) {
    const StepEquations equations(system, unknowns, find_projection(system, 0.0, {1.0, 0.0}, 1.0), host);
    const auto size = static_cast<std::size_t>(equations.size());
    mfs::test::Random random(7);
    const std::vector<double> scales = random.vector(4);
    std::vector<double> weights;
    for (const double scale : scales) weights.push_back(1.5 + scale);
    const Array<double> weights_there = make_array(host, weights);
    StepState state;
    assign(host, State{0.0, {1.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}, {0.0}}, state);
    StepRelation some_step;
    some_step.v_by_a = some_step.q_by_v = 0.1;
    std::vector<double> values(equations.pattern().entries());
    equations.jacobian(state, some_step, values.data());
    Array<double> last;
    std::vector<double> before(4, 0.0), h_before(2, 0.0);
    for (int iteration = 0; iteration < 3; ++iteration) {
      const std::vector<double> h = random.vector(static_cast<int>(size)), q = random.vector(2),
                                v = random.vector(2), now{q[0], q[1], v[0], v[1]};
      assign(host, State{0.0, q, v, {0.0, 0.0}, {0.0}}, state);
      const NewtonNorms norms = newton_norms(host, equations, h.data(), state, weights_there, last);
      double largest = 0.0, sum = 0.0;
      for (const double value : h) largest = std::max(largest, std::abs(value));
      for (int k = 0; k < 4; ++k) sum += std::pow((now[k] - before[k]) / weights[k], 2);
      EXPECT_EQ(norms.residual, largest);
      EXPECT_EQ(norms.followed, std::max(std::abs(h[0]), std::abs(h[1])));
      for (int level = 0; level < 3; ++level)
        EXPECT_EQ(norms.violation[level], std::abs(h[equations.first_constraint() + level])) << level;
      EXPECT_NEAR(norms.correction, std::sqrt(sum / 4), 1e-14);
      EXPECT_NEAR(norms.vibration, vibration(h_before, before, now, weights), 1e-14);
      before = now;
      h_before = h;
    }
    std::vector<double> h(size, 0.0);
    h[equations.first_constraint() + 1] = std::numeric_limits<double>::quiet_NaN();
    assign(host, State{0.0, {0.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}, {0.0}}, state);
    const NewtonNorms norms = newton_norms(host, equations, h.data(), state, weights_there, last);
    EXPECT_EQ(norms.residual, HUGE_VAL);
    EXPECT_EQ(norms.violation[1], HUGE_VAL);
    EXPECT_EQ(norms.violation[2], 0.0);
  }
}

}  // namespace
}  // namespace mfs::dae::test
