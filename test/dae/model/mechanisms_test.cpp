// Known mechanisms of the library beside their references: errors are small and fall with the tolerance.
// Others are in closed_loops_test.cpp, spin_up_test.cpp and test/dae/integrator/rotation_test.cpp;
// docs/mechanisms.md lists all.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "test/dae/integrator/ivp_test_set.hpp"
#include "test/dae/model/mechanism.hpp"

namespace mfs::dae::test {
namespace {

using Error = std::function<double(const MotionRun&, const State&)>;

/// The largest of all outputs, with this rtol and the tolerances that follow from it.
double largest_error(Json json, double rtol, const Error& error) {
  json["integrator"]["rtol"] = rtol;
  const MotionRun result = run(json);
  double most = 0.0;
  for (const State& state : result.outputs) most = std::max(most, error(result, state));
  return most;
}

/// Bounds for rtol 1e-4, 1e-6 and 1e-8: some three times what was seen.
void expect_errors(const Json& json, const std::array<double, 3>& bounds, const Error& error) {
  double rtol = 1e-4;
  for (const double bound : bounds) {
    EXPECT_LT(largest_error(json, rtol, error), bound) << "rtol " << rtol;
    rtol *= 1e-2;
  }
}

TEST(SimplePendulum, SwingsAsItsEquationSays) {
  constexpr double kInertia = 1 + 1e-6;
  const auto f = [](double, const Eigen::Vector2d& y) {
    return Eigen::Vector2d(y[1], -9.81 / kInertia * std::sin(y[0]));
  };
  expect_errors(of_library("simple_pendulum"), {1e-2, 2e-4, 1e-6},
                [&](const MotionRun& result, const State& state) {
                  const double angle = runge_kutta(Eigen::Vector2d(-0.5 * M_PI, 0), 0.0, state.t, 5000, f)[0];
                  const Vector3d expected(std::sin(angle), -std::cos(angle), 0);
                  return (result.position(state, "bob") - expected).norm();
                });
}

// Angles at 0.03 s of the Test Set for IVP Solvers, where it is in other coordinates. Motor and first body
// turn 2.5 times by then.
TEST(AndrewsSqueezer, ArrivesWhereTheTestSetSays) {
  using Data = AndrewsSqueezer;
  const std::vector<double> angle = Data::reference();
  const double beta = angle[0], second = angle[0] + angle[1], gamma = angle[2];
  const Vector3d k2(Data::rr * std::cos(beta) - Data::da * std::cos(second),
                    Data::rr * std::sin(beta) - Data::da * std::sin(second), 0);
  const Vector3d k3(Data::xb + Data::sa * std::sin(gamma) + Data::sb * std::cos(gamma),
                    Data::yb - Data::sa * std::cos(gamma) + Data::sb * std::sin(gamma), 0);
  expect_errors(of_library("andrews_squeezer", Data::kEnd, 1), {4e-5, 3e-7, 1e-8},
                [&](const MotionRun& result, const State& state) {
                  if (state.t < Data::kEnd) return 0.0;
                  return std::max((result.position(state, "K2") - k2).norm(),
                                  (result.position(state, "K3") - k3).norm());
                });
}

// Where a rod's centre is: Radau of SciPy with 1e-11 on tilt, height and angle about the shaft
// (perf/mechanisms).
TEST(FlyballGovernor, StiffSpringsInPlaceOfRods) {
  const std::pair<double, Vector3d> expected[] = {
      {0.25, {0.0716145130, 0.9469881861, 0.6329152964}},  {0.5, {-0.9345317014, 0.3241918777, 0.7506729578}},
      {1.0, {0.6843376826, -0.5727208520, 0.5156373731}},  {2.0, {0.1581754719, -0.8807739258, 0.5199984697}},
      {3.0, {-0.4446430841, -0.7811971861, 0.5271276903}},
  };
  expect_errors(of_library("flyball_governor", 3.0, 12), {1e-2, 5e-4, 1e-5},
                [&](const MotionRun& result, const State& state) {
                  for (const auto& [t, place] : expected)
                    if (std::abs(state.t - t) < 1e-9) return (result.position(state, "right") - place).norm();
                  return 0.0;
                });
}

}  // namespace
}  // namespace mfs::dae::test
