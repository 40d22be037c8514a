// Functions of one variable: values, derivatives, joins.
#include "dae/mechanics/smooth_function.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace mfs::dae {
namespace {

void expect_jet(const Jet& found, double value, double first, double second) {
  EXPECT_NEAR(found.value, value, 1e-14);
  EXPECT_NEAR(found.first, first, 1e-14);
  EXPECT_NEAR(found.second, second, 1e-13);
}

TEST(SmoothFunction, KnownValues) {
  const double pi = std::acos(-1.0);
  expect_jet(constant_function(3)->at(7), 3, 0, 0);
  expect_jet(linear_function(3, -2)->at(7), -11, -2, 0);
  expect_jet(harmonic_function(1, 2, 0.25, 0.5 * pi)->at(0), 3, 0, -2 * 0.25 * pi * pi);
  expect_jet(harmonic_function(1, 2, 0.25, 0)->at(2), 1, -pi, 0);
  const Function step = smooth_step(1, 3, 5, 9);
  expect_jet(step->at(0.5), 5, 0, 0);
  expect_jet(step->at(2), 7, 0.5 * 4 * 15.0 / 8, 0);
  expect_jet(step->at(3.5), 9, 0, 0);
}

TEST(SmoothFunction, SplineInterpolates) {
  const std::vector<double> x{0, 1, 1.5, 4, 5}, y{1, -1, 2, 0, 3};
  const Function spline = spline_function(x, y);
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(spline->at(x[i]).value, y[i], 1e-14);
  EXPECT_NEAR(spline->at(0).second, 0, 1e-14);  // natural
  EXPECT_NEAR(spline->at(5).second, 0, 1e-14);
  EXPECT_NE(spline->at(2).second, 0);
  // Two points are a line; three at equal distances have a moment of -3/2 of the second difference's -2 in
  // the middle.
  expect_jet(spline_function({1, 3}, {2, 8})->at(2), 5, 3, 0);
  expect_jet(spline_function({0, 1, 2}, {0, 1, 0})->at(1), 1, 0, -3);
}

/// Not at its ends, and not where it changes by less than a hundredth of its range.
TEST(SmoothFunction, SplineIsMarkedAtPeaksAndValleys) {
  using testing::ElementsAre;
  const auto marks = [](const std::vector<double>& y) {
    std::vector<double> x;
    for (std::size_t i = 0; i < y.size(); ++i) x.push_back(10.0 + static_cast<double>(i));
    return spline_function(x, y)->marks();
  };
  EXPECT_THAT(marks({0, 0, 0, 5, 0, 0}), ElementsAre(13));
  EXPECT_THAT(marks({0, 1, 3, 3, 2, -4, -4, -1}), ElementsAre(12, 15));
  EXPECT_THAT(marks({0, 0.01, -0.01, 5, 4.99, 5.01, 5.005, 0, 0.02, 0}), ElementsAre(15));
  EXPECT_THAT(marks({7, 5, 6, 8}), ElementsAre(11));
  EXPECT_THAT(marks({1, 2, 3}), ElementsAre());
  EXPECT_THAT(marks({2, 2, 2}), ElementsAre());
  EXPECT_THAT(harmonic_function(0, 1, 3, 0)->marks(), ElementsAre());
}

/// Derivatives against differences on both sides of every join, and past the ends.
TEST(SmoothFunction, IsTwiceContinuouslyDifferentiable) {
  constexpr double kStep = 1e-4;
  for (const Function& f : {smooth_step(-1, 2, 3, -4), harmonic_function(0, 1, 0.3, 0.2),
                            spline_function({-1, 0, 0.5, 2}, {1, 3, -1, 2})})
    for (double x = -2; x < 3; x += 0.05) {
      const Jet before = f->at(x - kStep), here = f->at(x), after = f->at(x + kStep);
      EXPECT_NEAR(here.first, (after.value - before.value) / (2 * kStep), 1e-2 * kStep * 100) << x;
      EXPECT_NEAR(here.second, (after.first - before.first) / (2 * kStep), 100 * kStep) << x;
      EXPECT_NEAR(after.second, before.second, 500 * kStep) << x;
    }
}

}  // namespace
}  // namespace mfs::dae
