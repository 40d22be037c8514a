// Newton's method in accelerations and multipliers alone: the motion is that of the whole matrix, which takes
// over where this one lets searches converge badly.
#include "dae/integrator/condensed_newton.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "dae/integrator/integrator.hpp"
#include "test/dae/integrator/dense_system.hpp"
#include "test/dae/integrator/recorder.hpp"

namespace mfs::dae::test {
namespace {

/// Two masses on circles of radius 1 and 2 with a spring and a damper between them, across both circles.
struct Sprung {
  double stiffness = 0.0, damping = 0.0, angle = 1.4;  ///< of the second
  int coordinates() const { return 4; }
  int constraints() const { return 2; }
  template <class T>
  std::vector<T> force(double /*t*/, const std::vector<T>& q, const std::vector<T>& v,
                       const std::vector<T>& a) const {
    using std::sqrt;
    const T x = q[2] - q[0], y = q[3] - q[1], length = sqrt(T(x * x + y * y));
    const T rate = T(x * (v[2] - v[0]) + y * (v[3] - v[1])) / length;
    const T pull = T(stiffness * (length - start_length()) + damping * rate) / length;
    return {T(a[0] - pull * x), T(a[1] + 9.81 - pull * y), T(a[2] + pull * x), T(a[3] + 9.81 + pull * y)};
  }
  template <class T>
  std::vector<T> constraint(const T& /*t*/, const std::vector<T>& q) const {
    return {T(0.5 * (q[0] * q[0] + q[1] * q[1] - 1.0)), T(0.5 * (q[2] * q[2] + q[3] * q[3] - 4.0))};
  }
  std::vector<double> start() const {
    return {std::sin(1.0), -std::cos(1.0), 2.0 * std::sin(angle), -2.0 * std::cos(angle)};
  }
  double start_length() const {
    const std::vector<double> q = start();
    return std::hypot(q[2] - q[0], q[3] - q[1]);
  }
};

struct Result {
  State end;
  IntegrationReport report;
};

Result swing(double stiffness, double damping, Unknowns unknowns, double angle = 1.4) {
  const Sprung sprung{stiffness, damping, angle};
  const DenseSystem<Sprung> system(sprung);
  IntegratorOptions options;
  options.unknowns = unknowns;
  options.rtol = 1e-7;
  options.backend = Backend::serial;
  options.threads = 1;
  Integrator integrator(system, options);
  Observer nobody;
  State end = integrator.run(0.0, sprung.start(), {0.0, 0.0, 0.0, 0.0}, 2.0, {}, nobody);
  return {std::move(end), integrator.report()};
}

constexpr int kCondensed = 4 + 2;  // accelerations, multipliers

TEST(CondensedNewton, MovesAsTheWholeMatrixDoes) {
  for (const double stiffness : {0.0, 10.0, 1000.0}) {
    const Result condensed = swing(stiffness, 0.0, Unknowns::reduced),
                 whole = swing(stiffness, 0.0, Unknowns::full);
    EXPECT_EQ(condensed.report.unknowns, kCondensed) << stiffness;
    EXPECT_GT(whole.report.unknowns, 2 * kCondensed);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(condensed.end.q[i], whole.end.q[i], 2e-5) << stiffness;
    for (std::size_t i = 0; i < 2; ++i)
      EXPECT_NEAR(condensed.end.lambda[i], whole.end.lambda[i], 1e-5 * (100.0 + stiffness)) << stiffness;
    EXPECT_LT(condensed.report.newton_iterations, 3 * condensed.report.steps) << stiffness;
  }
}

TEST(CondensedNewton, GivesWayToTheWholeMatrixWhereSpringsAreStiff) {
  // Nearly along the radii: what the constraints answer to a correction, the spring pulls along the circles.
  const double stiffness = 1e9, damping = 1e6, angle = 1.02;
  const Result begun = swing(stiffness, damping, Unknowns::reduced, angle),
               whole = swing(stiffness, damping, Unknowns::full, angle);
  EXPECT_GT(begun.report.unknowns, kCondensed);
  EXPECT_LT(begun.report.steps, 2 * whole.report.steps);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(begun.end.q[i], whole.end.q[i], 1e-4);
}

}  // namespace
}  // namespace mfs::dae::test
