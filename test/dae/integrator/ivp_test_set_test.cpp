// The integrator against published solutions.
#include "test/dae/integrator/ivp_test_set.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "dae/integrator/integrator.hpp"
#include "test/dae/integrator/recorder.hpp"
#include "test/dae/integrator/slider_crank.hpp"

namespace mfs::dae::test {
namespace {

/// Correct digits as the test set counts them: -log10 of the largest relative error.
double correct_digits(const std::vector<double>& values, const std::vector<double>& reference) {
  double worst = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i)
    worst = std::max(worst, std::abs(values[i] - reference[i]) / std::abs(reference[i]));
  return -std::log10(worst);
}

IntegratorOptions tolerance(double value, Unknowns unknowns) {
  IntegratorOptions options;
  options.unknowns = unknowns;
  options.rtol = options.atol_position = options.atol_velocity = value;
  options.constraint_position = 1e-9;
  options.constraint_velocity = 1e-6;
  options.constraint_acceleration = 1e-2;
  options.threads = 1;
  return options;
}

void expect_constraints(const IntegrationReport& report, const IntegratorOptions& options) {
  EXPECT_LE(report.violation[0], options.constraint_position);
  EXPECT_LE(report.violation[1], options.constraint_velocity);
  EXPECT_LE(report.violation[2], options.constraint_acceleration);
}

class IvpTestSet : public testing::TestWithParam<Unknowns> {};

TEST_P(IvpTestSet, AndrewsSqueezer) {
  const DenseSystem<AndrewsSqueezer> system;
  const IntegratorOptions options = tolerance(1e-8, GetParam());
  Integrator integrator(system, options);
  Recorder recorder;
  const State end = integrator.run(0.0, AndrewsSqueezer::start(), std::vector<double>(7, 0.0),
                                   AndrewsSqueezer::kEnd, {}, recorder);
  const double digits = correct_digits(end.q, AndrewsSqueezer::reference());
  RecordProperty("digits", std::to_string(digits));
  EXPECT_GT(digits, 5.0);
  expect_constraints(integrator.report(), options);
}

TEST_P(IvpTestSet, CarAxis) {
  const DenseSystem<CarAxis> system;
  const IntegratorOptions options = tolerance(5e-9, GetParam());
  Integrator integrator(system, options);
  Recorder recorder;
  const State end =
      integrator.run(0.0, CarAxis::start(), CarAxis::start_velocity(), CarAxis::kEnd, {}, recorder);
  EXPECT_GT(correct_digits(end.q, CarAxis::reference()), 5.0);
  EXPECT_GT(correct_digits(end.v, CarAxis::reference_velocity()), 4.0);
  expect_constraints(integrator.report(), options);
}

// The stretch of the rod swings fast and without damping, which is the hard part: BDF takes some of its
// amplitude, less with smaller tolerances (2.3e-3 in 10 000 steps, 4e-4 in 300 000).
TEST_P(IvpTestSet, FlexibleSliderCrank) {
  const DenseSystem<SliderCrank> system;
  const IntegratorOptions options = tolerance(1e-8, GetParam());
  Integrator integrator(system, options);
  Recorder recorder;
  const State end = integrator.run(0.0, SliderCrank::start(), SliderCrank::start_velocity(),
                                   SliderCrank::kEnd, {}, recorder);
  const std::vector<double> q = SliderCrank::reference(), v = SliderCrank::reference_velocity();
  const auto first = [](const std::vector<double>& x, int count) {
    return std::vector<double>(x.begin(), x.begin() + count);
  };
  EXPECT_GT(correct_digits(first(end.q, 3), first(q, 3)), 6.0);  // of rigid bodies
  EXPECT_GT(correct_digits(first(end.v, 3), first(v, 3)), 4.0);
  EXPECT_GT(correct_digits(first(end.q, 5), first(q, 5)), 3.5);  // and of bending
  EXPECT_GT(correct_digits(first(end.v, 4), first(v, 4)), 2.5);
  EXPECT_GT(correct_digits(end.q, q), 2.0);
  expect_constraints(integrator.report(), options);
}

INSTANTIATE_TEST_SUITE_P(Unknowns, IvpTestSet, testing::Values(Unknowns::full, Unknowns::reduced));

}  // namespace
}  // namespace mfs::dae::test
