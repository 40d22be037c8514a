// Functions of one variable: values, derivatives, joins.
#include "dae/mechanics/smooth_function.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>

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

/// In 0 to 80, of a table at 0, 1, ... 80.
std::vector<double> marks_of(const std::vector<double>& y) {
  std::vector<double> x, marks;
  for (std::size_t i = 0; i < y.size(); ++i) x.push_back(static_cast<double>(i));
  spline_function(x, y)->add_marks({0.0, 80.0}, marks);
  std::sort(marks.begin(), marks.end());
  marks.erase(std::unique(marks.begin(), marks.end()), marks.end());
  return marks;
}

TEST(SmoothFunction, SplineIsMarkedWhereItBeginsToChangeFaster) {
  using testing::ElementsAre, testing::IsEmpty;
  std::vector<double> y(81, 0.0);
  y[50] = 5.0;
  EXPECT_THAT(marks_of(y), ElementsAre(49, 50));
  y[70] = -0.2;
  EXPECT_THAT(marks_of(y), ElementsAre(49, 50));
  y[70] = -0.5;
  EXPECT_THAT(marks_of(y), ElementsAre(49, 50, 69, 70)) << "a tenth of the other";
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = i < 50 ? 1.0 : 3.0;
  EXPECT_THAT(marks_of(y), ElementsAre(49, 50)) << "a step";
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = std::sin(0.3 * static_cast<double>(i));
  EXPECT_THAT(marks_of(y), IsEmpty());
}

TEST(SmoothFunction, SplineOfNoiseIsMarkedAtBlowsAlone) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> noise(-0.02, 0.02);
  std::vector<double> y(81);
  for (double& value : y) value = 1.0 + noise(random);
  EXPECT_THAT(marks_of(y), testing::IsEmpty());
  y[50] = 3.0;
  EXPECT_THAT(marks_of(y), testing::ElementsAre(49, 50));
}

TEST(SmoothFunction, SmoothStepIsMarkedWhereItIsShort) {
  std::vector<double> marks;
  harmonic_function(0, 1, 3, 0)->add_marks({0.0, 100.0}, marks);
  smooth_step(3, 12, 0, 1)->add_marks({0.0, 100.0}, marks);
  EXPECT_THAT(marks, testing::IsEmpty());
  smooth_step(3, 4, 0, 1)->add_marks({0.0, 100.0}, marks);
  EXPECT_THAT(marks, testing::ElementsAre(3, 4));
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

/// Bounds of values contain them, and come to them on short parts.
TEST(SmoothFunction, EnclosesItsValues) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1.0, 7.0), part(0.0, 1.0);
  for (const Function& function :
       {linear_function(3, -2), harmonic_function(1, 2, 0.25, 0.5), smooth_step(1, 3, 9, 5),
        spline_function({0, 1, 1.5, 4, 5}, {1, -1, 2, 0, 3}), spline_function({1, 3}, {2, 8})}) {
    std::vector<Interval> bounds;
    for (int k = 0; k < 300; ++k) {
      const auto [low, high] = std::minmax({any(random), any(random)});
      function->enclose({low, high}, bounds);
      for (int i = 0; i < 30; ++i) {
        const double value = function->value(low + part(random) * (high - low));
        EXPECT_LE(bounds.back().low, value + 1e-12);
        EXPECT_GE(bounds.back().high, value - 1e-12);
      }
      function->enclose({low, low + 1e-6}, bounds);
      EXPECT_LT(bounds.back().width(), 2e-5);
      function->enclose(low, bounds);
      EXPECT_NEAR(bounds.back().low, function->value(low), 1e-14);
    }
  }
}

}  // namespace
}  // namespace mfs::dae
