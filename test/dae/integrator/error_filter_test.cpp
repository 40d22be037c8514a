// What the matrix of a step leaves of an error of velocities, and what error control makes of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include "dae/integrator/condensed_newton.hpp"
#include "dae/integrator/integrator.hpp"
#include "dae/integrator/newton.hpp"
#include "dae/integrator/projection.hpp"
#include "dae/integrator/step_equations.hpp"
#include "test/dae/integrator/dense_system.hpp"
#include "test/dae/integrator/recorder.hpp"
#include "test/dae/integrator/turning_point.hpp"

namespace mfs::dae::test {
namespace {

/// Masses 1, 2, 3 with springs and dampers of very different size, coupled, whose positions (or velocities)
/// add up to a constant: all equations are linear.
struct Masses {
  int coordinates() const { return 3; }
  int constraints() const { return 1; }
  template <class T>
  std::vector<T> force(double /*t*/, const std::vector<T>& q, const std::vector<T>& v,
                       const std::vector<T>& a) const {
    std::vector<T> f;
    for (int i = 0; i < 3; ++i)
      f.push_back(T((i + 1.0) * a[i] + kDamping[i] * v[i] + kStiffness[i] * (q[i] - 0.5 * q[(i + 1) % 3])));
    return f;
  }
  template <class T>
  std::vector<T> constraint(const T& /*t*/, const std::vector<T>& q) const {
    return {q[0] + 0.5 * q[1] + 0.25 * q[2]};
  }
  static constexpr double kDamping[] = {0.1, 300.0, 2.0}, kStiffness[] = {10.0, 40.0, 5e4};
};

class System : public DenseSystem<Masses> {
 public:
  explicit System(bool nonholonomic) : nonholonomic_(nonholonomic) {}
  bool is_nonholonomic(int) const override { return nonholonomic_; }
  using DenseSystem<Masses>::evaluate;
  void evaluate(const StateView& state, Residual& residual) const override {
    DenseSystem<Masses>::evaluate(state, residual);
    if (nonholonomic_) residual.position[0] = 0.0;
  }

 private:
  bool nonholonomic_;
};

/// x of (M + h D + h^2 K) x + Phi_q^T mu = M e, Phi_q x = Phi_q e.
Eigen::Vector3d filtered(const Eigen::Vector3d& e, double h) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right;
  const Eigen::Vector3d gradient(1.0, 0.5, 0.25);
  for (int i = 0; i < 3; ++i) {
    matrix(i, i) = i + 1.0 + h * Masses::kDamping[i] + h * h * Masses::kStiffness[i];
    matrix(i, (i + 1) % 3) = -0.5 * h * h * Masses::kStiffness[i];
    matrix(i, 3) = matrix(3, i) = gradient(i);
    right(i) = (i + 1.0) * e(i);
  }
  right(3) = gradient.dot(e);
  return matrix.lu().solve(right).head<3>();
}

TEST(ErrorFilter, LeavesWhatForcesAndConstraintsLeave) {
  const Executor host(Executor::Place::host, 1);
  const Eigen::Vector3d e(0.3, -2.0, 1.0);
  for (const bool nonholonomic : {false, true})
    for (const Unknowns unknowns : {Unknowns::full, Unknowns::reduced})
      for (const double h : {1e-5, 1e-2, 0.3}) {
        SCOPED_TRACE(testing::Message() << nonholonomic << ' ' << static_cast<int>(unknowns) << ' ' << h);
        const System system(nonholonomic);
        IntegratorOptions options;
        options.threads = 1;
        options.backend = Backend::serial;
        IntegrationReport report;
        const std::vector<double> rest(3, 0.0);
        const StepEquations equations(system, unknowns, find_projection(system, 0.0, rest, 1.0), host);
        Newton newton(equations, options, host, report);
        Array<double> error;
        error.assign(host, std::vector<double>(e.data(), e.data() + 3));
        StepState state;
        assign(host, State{0.0, rest, rest, rest, {0.0}}, state);
        EXPECT_FALSE(newton.filter_error(state, error));  // there is no matrix yet
        EXPECT_EQ(error.on_host(host), std::vector<double>(e.data(), e.data() + 3));
        const StepRelation relation{
            h, h, h, make_array(host, rest), make_array(host, rest), make_array(host, rest)};
        const Array<double> lambda = make_array(host, std::vector<double>{0.0}),
                            weights = make_array(host, std::vector<double>(6, 1e-6));
        ASSERT_TRUE(newton.solve(relation, lambda, weights, state).converged);
        ASSERT_TRUE(newton.filter_error(state, error));
        const Eigen::Vector3d expected = filtered(e, h);
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(error.on_host(host)[i], expected(i), 1e-9) << i;
      }
}

// The condensed matrix filters where it leaves less than three quarters, which for these errors it does from
// h = 1e-2 on.
TEST(ErrorFilter, IsTheSameWithTheCondensedMatrix) {
  const Executor host(Executor::Place::host, 1);
  const Eigen::Vector3d e(0.3, -2.0, 1.0);
  for (const double h : {1e-5, 1e-2, 0.3}) {
    SCOPED_TRACE(h);
    const System system(false);
    IntegratorOptions options;
    options.threads = 1;
    options.backend = Backend::serial;
    IntegrationReport report;
    const std::vector<double> rest(3, 0.0), given(e.data(), e.data() + 3);
    CondensedNewton newton(system, find_projection(system, 0.0, rest, 1.0), options, host, report);
    Array<double> error = make_array(host, given);
    EXPECT_FALSE(newton.filter_error(error));  // there is no step yet
    StepState state;
    assign(host, State{0.0, rest, rest, rest, {0.0}}, state);
    const StepRelation relation{
        h, h, h, make_array(host, rest), make_array(host, rest), make_array(host, rest)};
    const Array<double> lambda = make_array(host, std::vector<double>{0.0}),
                        weights = make_array(host, std::vector<double>(6, 1e-6));
    ASSERT_TRUE(newton.solve(relation, lambda, weights, state).converged);
    const Eigen::Vector3d expected = filtered(e, h);
    const bool filters = expected.norm() < 0.75 * e.norm();
    EXPECT_EQ(filters, h > 1e-3);
    EXPECT_EQ(newton.filter_error(error), filters);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(error.on_host(host)[i], filters ? expected(i) : e(i), 1e-9) << i;
  }
}

// Five turns from a start that is exact. Errors fall by at least 30 in two powers of ten (in one of them by
// chance anything from 1.5 to 50).
TEST(ErrorFilter, KeepsAStiffBodyThatTurnsFromOrderOne) {
  const DenseSystem<TurningPoint> system;
  double error_before = HUGE_VAL, error_two_before = HUGE_VAL;
  for (const double rtol : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7}) {
    SCOPED_TRACE(rtol);
    IntegratorOptions options;
    options.rtol = rtol;
    options.threads = 1;
    options.backend = Backend::serial;
    Integrator integrator(system, options);
    Recorder recorder;
    integrator.run(0.0, {1.0, 0.0}, {0.0, TurningPoint::kSpeed}, 1.0, {}, recorder);
    int stretch = 0, longest = 0;
    double error = 0.0;
    for (std::size_t k = 0; k < recorder.steps.size(); ++k) {
      stretch = recorder.steps[k].order == 1 ? stretch + 1 : 0;
      longest = std::max(longest, stretch);
      const double angle = TurningPoint::kSpeed * recorder.steps[k].t;
      error = std::max(error, std::hypot(recorder.states[k].q[0] - std::cos(angle),
                                         recorder.states[k].q[1] - std::sin(angle)));
    }
    EXPECT_LE(longest, 50);
    EXPECT_LT(recorder.steps.size(), 1000U);  // without the filter 1479 to 31 526
    EXPECT_LT(error, error_before);
    EXPECT_LT(error, error_two_before / 30.0);
    error_two_before = std::exchange(error_before, error);
  }
}

/// A slider crank: a pin that is driven round a circle of 1 m with kSpeed, a slider of 1 kg on the line y = 0
/// and, as connecting rod, a stiff damped spring of 2 m.
struct SpringRod {
  static constexpr double kSpeed = 3.0;
  int coordinates() const { return 4; }
  int constraints() const { return 3; }
  template <class T>
  std::vector<T> force(double /*t*/, const std::vector<T>& q, const std::vector<T>& v,
                       const std::vector<T>& a) const {
    using std::sqrt;
    const T dx = q[2] - q[0], dy = q[3] - q[1], r = sqrt(T(dx * dx + dy * dy)), x = dx / r, y = dy / r;
    const T pull = 1e9 * (r - 2.0) + 1e5 * (x * (v[2] - v[0]) + y * (v[3] - v[1]));
    return {T(a[0] - pull * x), T(a[1] - pull * y), T(a[2] + pull * x), T(a[3] + pull * y)};
  }
  template <class T>
  std::vector<T> constraint(const T& t, const std::vector<T>& q) const {
    using std::cos;
    using std::sin;
    return {T(q[0] - cos(kSpeed * t)), T(q[1] - sin(kSpeed * t)), q[3]};
  }
};

TEST(ErrorFilter, KeepsStiffSpringsOfRigidMechanismsFromOrderOne) {
  const DenseSystem<SpringRod> system;
  ASSERT_TRUE(CondensedNewton::suits(system));
  for (const double rtol : {1e-4, 1e-5, 1e-6}) {
    SCOPED_TRACE(rtol);
    IntegratorOptions options;
    options.rtol = rtol;
    options.threads = 1;
    options.backend = Backend::serial;
    Integrator integrator(system, options);
    Recorder recorder;
    integrator.run(0.0, {1.0, 0.0, 3.0, 0.0}, {0.0, SpringRod::kSpeed, 0.0, 0.0}, 1.0, {}, recorder);
    double error = 0.0;
    for (std::size_t k = 0; k < recorder.steps.size(); ++k) {
      const double angle = SpringRod::kSpeed * recorder.steps[k].t, height = std::sin(angle);
      error = std::max(
          error, std::abs(recorder.states[k].q[2] - std::cos(angle) - std::sqrt(4.0 - height * height)));
    }
    EXPECT_LT(recorder.steps.size(), 1000U);
    EXPECT_LT(error, 10.0 * rtol);
  }
}

}  // namespace
}  // namespace mfs::dae::test
