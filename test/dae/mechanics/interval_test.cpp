// Intervals against values at random numbers in them.
#include "dae/mechanics/interval.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>

namespace mfs::dae {
namespace {

struct Operation {
  std::string name;
  std::function<Interval(const Interval&, const Interval&)> of_intervals;
  std::function<double(double, double)> of_numbers;
};

const Operation kOperations[] = {
    {"+", [](auto x, auto y) { return x + y; }, [](double x, double y) { return x + y; }},
    {"-", [](auto x, auto y) { return x - y; }, [](double x, double y) { return x - y; }},
    {"*", [](auto x, auto y) { return x * y; }, [](double x, double y) { return x * y; }},
    {"/", [](auto x, auto y) { return x / y; }, [](double x, double y) { return x / y; }},
    {"exp", [](auto x, auto) { return exp(x); }, [](double x, double) { return std::exp(x); }},
    {"log", [](auto x, auto) { return log(x); }, [](double x, double) { return std::log(x); }},
    {"sqrt", [](auto x, auto) { return sqrt(x); }, [](double x, double) { return std::sqrt(x); }},
    {"sin", [](auto x, auto) { return sin(x); }, [](double x, double) { return std::sin(x); }},
    {"cos", [](auto x, auto) { return cos(x); }, [](double x, double) { return std::cos(x); }},
    {"tan", [](auto x, auto) { return tan(x); }, [](double x, double) { return std::tan(x); }},
    {"asin", [](auto x, auto) { return asin(x); }, [](double x, double) { return std::asin(x); }},
    {"acos", [](auto x, auto) { return acos(x); }, [](double x, double) { return std::acos(x); }},
    {"atan", [](auto x, auto) { return atan(x); }, [](double x, double) { return std::atan(x); }},
    {"atan2", [](auto x, auto y) { return atan2(x, y); },
     [](double x, double y) { return std::atan2(x, y); }},
    {"sinh", [](auto x, auto) { return sinh(x); }, [](double x, double) { return std::sinh(x); }},
    {"cosh", [](auto x, auto) { return cosh(x); }, [](double x, double) { return std::cosh(x); }},
    {"tanh", [](auto x, auto) { return tanh(x); }, [](double x, double) { return std::tanh(x); }},
    {"x^y", [](auto x, auto y) { return pow(x, y); }, [](double x, double y) { return std::pow(x, y); }},
    {"x^4", [](auto x, auto) { return pow(x, 4.0); }, [](double x, double) { return std::pow(x, 4); }},
    {"x^3", [](auto x, auto) { return pow(x, 3.0); }, [](double x, double) { return std::pow(x, 3); }},
    {"x^-2", [](auto x, auto) { return pow(x, -2.0); }, [](double x, double) { return std::pow(x, -2); }},
    {"x^-3", [](auto x, auto) { return pow(x, -3.0); }, [](double x, double) { return std::pow(x, -3); }},
    {"x^0.5", [](auto x, auto) { return pow(x, 0.5); }, [](double x, double) { return std::pow(x, 0.5); }},
};

TEST(Interval, ContainsTheValuesOfNumbersInIt) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-6.0, 6.0), part(0.0, 1.0);
  for (const Operation& operation : kOperations)
    for (int k = 0; k < 500; ++k) {
      const auto [a, b] = std::minmax({any(random), any(random)});
      const auto [c, d] = std::minmax({any(random), any(random)});
      const Interval z = operation.of_intervals({a, b}, {c, d});
      for (int i = 0; i < 20; ++i) {
        const double x = a + part(random) * (b - a), y = c + part(random) * (d - c);
        const double value = operation.of_numbers(x, y);
        if (std::isnan(value)) continue;
        const double off = 1e-12 * std::max(1.0, std::abs(value));
        EXPECT_TRUE(z.low <= value + off && value - off <= z.high)
            << operation.name << " of " << x << " in " << a << ", " << b << " and " << y << ": " << value
            << " in " << z.low << ", " << z.high;
      }
    }
}

/// Bounds of functions of one interval are values; else parts of time would be halved for nothing.
TEST(Interval, IsNoLargerThanNeeded) {
  const double pi = std::acos(-1.0);
  EXPECT_NEAR(sin(Interval(0.1, 3.0)).high, 1.0, 1e-15);
  EXPECT_NEAR(sin(Interval(0.1, 3.0)).low, std::sin(0.1), 1e-15);
  EXPECT_NEAR(cos(Interval(-0.5, 0.2)).low, std::cos(0.5), 1e-15);
  EXPECT_EQ(pow(Interval(-2, 1), 2.0).low, 0);
  EXPECT_EQ(pow(Interval(-2, 1), 2.0).high, 4);
  EXPECT_EQ((1.0 / Interval(2, 4)).low, 0.25);
  EXPECT_EQ((1.0 / Interval(0, 4)).high, HUGE_VAL);
  EXPECT_EQ((1.0 / Interval(-1, 4)).low, -HUGE_VAL);
  EXPECT_NEAR(atan2(Interval(1, 2), Interval(-1, 1)).high, 3 * pi / 4, 1e-15);
  EXPECT_NEAR(atan2(Interval(-2, -1), Interval(-1, 1)).low, -3 * pi / 4, 1e-15);
  EXPECT_EQ((1.0 / Interval(0, 4)).low, 0.25);
  EXPECT_EQ((1.0 / Interval(-4, 0)).high, -0.25);
  EXPECT_NEAR(sin(Interval(0.1, 1.0)).high, std::sin(1.0), 1e-15);
  EXPECT_EQ(sin(Interval::everything()).high, 1);
  EXPECT_NEAR(asin(Interval(0.5, 3.0)).high, pi / 2, 1e-15);
  EXPECT_EQ(pow(Interval(-1, 4), 0.5).low, 0);
  EXPECT_TRUE((Interval::everything() * 0.0).is_zero());
  EXPECT_EQ(sqrt(Interval(-3, -1)).width(), 0) << "where it has no value there is nothing to look for";
}

}  // namespace
}  // namespace mfs::dae
