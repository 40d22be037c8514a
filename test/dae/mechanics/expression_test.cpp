// Expressions: values against the same formulas in C++, derivatives against differences and known ones,
// mistakes.
#include "dae/mechanics/expression.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <random>

#include "test/dae/mechanics/expect_refused.hpp"

namespace mfs::dae {
namespace {

double value_at(const std::string& text, const std::vector<double>& x = {}) {
  return Expression(text).value(x);
}

TEST(Expression, ComputesAsWritten) {
  EXPECT_EQ(value_at("2 + 3 * 4 ^ 2 / 8 - 1"), 7);
  EXPECT_EQ(value_at("2 ^ 3 ^ 2"), 512);
  EXPECT_EQ(value_at("-2 ^ 2"), -4);
  EXPECT_EQ(value_at("-(1 - 3) * +2"), 4);
  EXPECT_EQ(value_at("1.5e-3*2E3 + .5"), 3.5);
  EXPECT_EQ(value_at("7 - 2 - 1"), 4);
  EXPECT_EQ(value_at("8 / 2 / 2"), 2);
  EXPECT_EQ(value_at("x", {3}), 3);
  EXPECT_EQ(value_at("+x", {3}), 3);
  EXPECT_EQ(value_at("4"), 4);
  EXPECT_EQ(value_at("pi"), std::acos(-1.0));
  EXPECT_EQ(value_at("min(2, x) + 10 * max(2, x) + 100 * abs(-x) + 1000 * sign(-x)", {3}),
            2 + 30 + 300 - 1000);
  EXPECT_EQ(value_at("if(x < 2, 5, 7)", {3}), 7);
  EXPECT_EQ(value_at("if(x >= 3 && 1 != 2 || 0, 5, 7)", {3}), 5);
  EXPECT_EQ(value_at("(x > 3) + 2 * (x >= 3) + 4 * (x == 3) + 8 * (x <= 3) + 16 * (x < 3)", {3}), 14);
  EXPECT_NEAR(value_at("log10(1000) + log(exp(2))"), 5, 1e-15);
  EXPECT_EQ(value_at("if(x > 0, log(x), 0)", {-1}), 0);
}

/// In 0 to 10.
std::vector<double> marks_of(const std::string& text) {
  const Expression expression(text);
  std::vector<std::optional<double>> others;
  int time = -1;
  for (const std::string& name : expression.variables()) {
    if (name == "t") time = static_cast<int>(others.size());
    others.emplace_back();
    if (name == "two") others.back() = 2.0;
  }
  std::vector<double> marks;
  expression.add_marks(time, others, {0.0, 10.0}, marks);
  std::sort(marks.begin(), marks.end());
  return marks;
}

auto near(std::vector<double> times, double off = 1e-14) {
  return testing::Pointwise(testing::DoubleNear(off), std::move(times));
}

/// And at 0.382 of the way from one to the next.
TEST(Expression, IsMarkedWhereComparisonsOfTimeTurnOver) {
  EXPECT_THAT(marks_of("if(t > 3 && t < 3.01, 5, 0)"), near({3, 3.00382, 3.01}));
  EXPECT_THAT(marks_of("(3 <= t) * (2 * t - 1 <= 7)"), near({3, 3.382, 4}));
  EXPECT_THAT(marks_of("(t / two > 1 + sqrt(4)) - (5 >= t) + (t == 4)"), near({5, 5.382, 6}));
  EXPECT_THAT(marks_of("max(0, 1 - abs(t - 3))"), near({2, 2.382, 3, 3.382, 4}));
  EXPECT_THAT(marks_of("(t > 1) + (t > 1) + (t < 2 * 1)"), near({1, 1, 1.382, 2}));
  EXPECT_THAT(marks_of("if(t < 5, 1, -1) + t"), near({5}));
  EXPECT_THAT(marks_of("t * t > 9"), near({3}));
  EXPECT_THAT(marks_of("if(sin(t) > 0.99999999 && two > 1, 1, 0)"),
              near({1.570654905439, 1.570654905439 + 0.382 * 2.828427127e-4, 1.570937748152,
                    1.570937748152 + 0.382 * 6.282902464, 7.853840212619,
                    7.853840212619 + 0.382 * 2.828427127e-4, 7.854123055332},
                   1e-9));
  EXPECT_THAT(marks_of("1 / t < 3"), near({1 / 3.0}));
  // What turns over by other things is not known beforehand.
  EXPECT_THAT(marks_of("(x > 1) + (t < x) + (t * t > x) + (1 > two)"), near({}));
}

/// A step that ends at a mark has not come to what is behind it.
TEST(Expression, IsMarkedAsLateAsItIsWhatItWas) {
  for (const std::string text : {"t * t > 2", "sin(t) > 0.3 && t < 2", "exp(t) >= 7", "1 / t < 3"}) {
    const double mark = marks_of(text).front();
    EXPECT_EQ(value_at(text, {mark}), value_at(text, {0.9 * mark})) << text;
    EXPECT_NE(value_at(text, {std::nextafter(mark, 10.0)}), value_at(text, {mark})) << text;
  }
}

/// Sums with what does not move, and multiples by it, change as what moves does.
TEST(Expression, TellsWhichOperationsChange) {
  const auto changing = [](const std::string& text) {
    return Expression(text).changing_operations({true, false}).size();
  };
  EXPECT_EQ(changing("3 - 2 * x + y"), 0u);
  EXPECT_EQ(changing("0 * x + y^2 + sin(y)"), 0u);
  EXPECT_EQ(changing("x * x + 0 * y"), 1u);
  EXPECT_EQ(changing("x + 2 * x + 0 * y"), 1u);
  EXPECT_EQ(changing("1 / x + 0 * y"), 1u);
  EXPECT_EQ(changing("x^y"), 1u);
  EXPECT_EQ(changing("sin(x) + y"), 1u);
}

/// All results of an expression against values at random numbers in the intervals of its variables.
TEST(Expression, EnclosesItsValues) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-2.0, 2.0), part(0.0, 1.0);
  for (const std::string text : {"if(x < y, x + 3, 10 * y)", "(x <= y) - 2 * (y <= 0.5)",
                                 "(x == 1) + (x > 0 && y > 0)", "(x > 1 || y < 0.2) * 3",
                                 "max(x, y) - min(x, 2 * y)", "sign(x) * abs(y)", "if(x - 1 > 0, x, -x) + y"})
    for (int k = 0; k < 200; ++k) {
      const Expression expression(text);
      const auto [a, b] = std::minmax({any(random), any(random)});
      const auto [c, d] = std::minmax({any(random), any(random)});
      std::vector<Interval> bounds;
      expression.results({{a, b}, {c, d}}, bounds);
      for (int i = 0; i < 20; ++i) {
        std::vector<double> variables = {a + part(random) * (b - a), c + part(random) * (d - c)};
        const double value = expression.value(variables);
        EXPECT_LE(bounds.back().low, value + 1e-12) << text;
        EXPECT_GE(bounds.back().high, value - 1e-12) << text;
      }
    }
  std::vector<Interval> bounds;
  Expression("if(x == 1, 2, if(x <= 3, 4, 5))").results({1.0}, bounds);
  EXPECT_EQ(bounds.back().low, 2);
  EXPECT_EQ(bounds.back().high, 2);
}

/// Two marks each: where a quarter of the range is left, and where a second one is.
TEST(Expression, IsMarkedWhereItBeginsToChangeFaster) {
  const double from = std::sqrt(std::log(4.0)), to = std::sqrt(std::log(2.0));
  for (const double width : {1e-1, 1e-3, 1e-6}) {
    const std::string w = std::to_string(static_cast<int>(std::round(1 / width)));
    EXPECT_THAT(marks_of("5 - 100 * exp(-((t - 3) * " + w + ")^2) * x"),
                near({3 - from * width, 3 - to * width}, 0.2 * width));
    EXPECT_THAT(marks_of("x + tanh((t - 3) * " + w + ")"),
                near({3 - 0.6 * width, 3 - 0.1 * width}, 0.3 * width));
  }
  EXPECT_THAT(marks_of("sin(t)^400 + 1e-3 * exp(-((t - 3) / 0.001)^2)").size(), 8);
  EXPECT_THAT(marks_of("1 / ((t - 3)^2 + 1e-6)").size(), 2);
}

TEST(Expression, IsNotMarkedWhereItChangesAsEver) {
  for (const char* text :
       {"sin(2 * pi * t)", "cos(300 * t)^2 + 3 * t^2", "exp(-t) + sqrt(1 + t)", "t^4 - 5 / (2 + t)",
        "sin(3 * t)^3 * exp(-0.1 * t)", "sin(5 * t + 0.1 * sin(7 * t))", "sin(t^2)", "exp(x) * sin(3 * t)"})
    EXPECT_THAT(marks_of(text), near({})) << text;
}

TEST(Expression, NamesItsVariables) {
  EXPECT_THAT(Expression("b_2 * hinge.angle_rate + a * b_2 + pi").variables(),
              testing::ElementsAre("b_2", "hinge.angle_rate", "a"));
}

struct Example {
  std::string text;
  std::function<double(double, double)> formula;
};

const Example kExamples[] = {
    {"x*y - x/y", [](double x, double y) { return x * y - x / y; }},
    {"x^y + y^3 + 2^x", [](double x, double y) { return std::pow(x, y) + y * y * y + std::pow(2, x); }},
    {"sin(x*y) + cos(y)*tan(x)",
     [](double x, double y) { return std::sin(x * y) + std::cos(y) * std::tan(x); }},
    {"asin(x/3) + acos(y/3) + atan(x*y)",
     [](double x, double y) { return std::asin(x / 3) + std::acos(y / 3) + std::atan(x * y); }},
    {"atan2(x, y) + atan2(-x, -y)", [](double x, double y) { return std::atan2(x, y) + std::atan2(-x, -y); }},
    {"sinh(x) + cosh(y) + tanh(x*y)",
     [](double x, double y) { return std::sinh(x) + std::cosh(y) + std::tanh(x * y); }},
    {"exp(-x*y) + log(x + y) + sqrt(x*y) + log10(x)",
     [](double x, double y) {
       return std::exp(-x * y) + std::log(x + y) + std::sqrt(x * y) + std::log10(x);
     }},
    {"if(x < y, x^2*y, 7) + min(x, y)*max(x, 2*y) + abs(x - y)^3",
     [](double x, double y) { return x * x * y + x * 2 * y + std::pow(y - x, 3); }},
    {"(x - 0.7)^2 + (x - 0.7)^1 + (x - 0.7)^0 + y",
     [](double x, double y) { return (x - 0.7) * (x - 0.7) + (x - 0.7) + 1 + y; }},
};

TEST(Expression, HasTheGradientOfItsFormula) {
  const double x = 0.7, y = 1.3, h = 1e-5;
  for (const Example& example : kExamples) {
    SCOPED_TRACE(example.text);
    const auto& f = example.formula;
    std::vector<double> gradient;
    const Expression expression(example.text);
    ASSERT_THAT(expression.variables()[0], "x");
    EXPECT_NEAR(expression.value<double>({x, y}, gradient), f(x, y), 1e-14);
    EXPECT_NEAR(gradient[0], (f(x + h, y) - f(x - h, y)) / (2 * h), 1e-8);
    EXPECT_NEAR(gradient[1], (f(x, y + h) - f(x, y - h)) / (2 * h), 1e-8);
  }
}

/// x = 0.7 + 0.4 s - 0.3 s^2, y = 1.3 - 0.2 s + 0.5 s^2: the series of the value and of the gradient.
TEST(Expression, HasTheDerivativesAlongAMotion) {
  const double h = 1e-4;
  const Taylor<double> x(0.7, 0.4, -0.3), y(1.3, -0.2, 0.5);
  const auto at = [](const Taylor<double>& u, double s) { return u.c0 + s * (u.c1 + s * u.c2); };
  for (const Example& example : kExamples) {
    SCOPED_TRACE(example.text);
    const Expression expression(example.text);
    std::vector<Taylor<double>> gradient;
    std::vector<double> before, here, after;
    const Taylor<double> f = expression.value<Taylor<double>>({x, y}, gradient);
    const double f_before = expression.value<double>({at(x, -h), at(y, -h)}, before);
    const double f_here = expression.value<double>({x.c0, y.c0}, here);
    const double f_after = expression.value<double>({at(x, h), at(y, h)}, after);
    EXPECT_NEAR(f.c0, f_here, 1e-15);
    EXPECT_NEAR(f.c1, (f_after - f_before) / (2 * h), 1e-6);
    EXPECT_NEAR(2 * f.c2, (f_after - 2 * f_here + f_before) / (h * h), 1e-5);
    EXPECT_EQ(expression.value<Taylor<double>>({x, y}).c2, f.c2);
    for (int k = 0; k < 2; ++k) {
      EXPECT_NEAR(gradient[k].c0, here[k], 1e-14);
      EXPECT_NEAR(gradient[k].c1, (after[k] - before[k]) / (2 * h), 1e-6) << k;
      EXPECT_NEAR(2 * gradient[k].c2, (after[k] - 2 * here[k] + before[k]) / (h * h), 1e-5) << k;
    }
  }
}

TEST(Expression, WhatIsNotChosenNeedsNoDerivative) {
  std::vector<double> gradient;
  EXPECT_EQ(Expression("if(x > 0, sqrt(x), 3*x)").value<double>({0.0}, gradient), 0.0);
  EXPECT_EQ(gradient[0], 3.0);
}

TEST(Expression, IsAFunctionOfOneVariable) {
  const Function f = expression_function(Expression("a * sin(w * t)"), 2, {3, 2, 0});
  const Jet jet = f->at(0.4);
  EXPECT_NEAR(jet.value, 3 * std::sin(0.8), 1e-15);
  EXPECT_NEAR(jet.first, 6 * std::cos(0.8), 1e-15);
  EXPECT_NEAR(jet.second, -12 * std::sin(0.8), 1e-14);
  EXPECT_EQ(expression_function(Expression("3"), -1, {})->at(7).value, 3);
}

// A force need not have a second derivative, one of time none at all.
TEST(Expression, OnlyWhatIsAskedForHasToBeFinite) {
  const Function root = expression_function(Expression("2 + sqrt(t)"), 0, {0});
  EXPECT_EQ(root->value(0), 2);
  test::expect_refused("expression '2 + sqrt(t)'", "not finite at t = 0", [&] { root->slope(0); });
  const Function hertz = expression_function(Expression("k * x + x^1.5"), 1, {3, 0});
  EXPECT_EQ(hertz->slope(0).first, 3);
  EXPECT_DOUBLE_EQ(hertz->slope(4).value, 20);
  EXPECT_DOUBLE_EQ(hertz->slope(4).first, 6);
  test::expect_refused("expression 'k * x + x^1.5'", "not finite at x = 0", [&] { hertz->at(0); });
  EXPECT_EQ(expression_function(Expression("3"), -1, {})->slope(7).first, 0);
}

TEST(Expression, MistakesAreRefused) {
  for (const char* text : {"",    "  ",     "1 +",  "(1",    "1)",        "sin 3", "sin(1, 2)",
                           "2 3", "foo(1)", "1, 2", "x = 3", "1 ? 2 : 3", "\"a\"", "a b",
                           "2x",  "min(1)", "1e",   "0x10",  "#",         "a - ",  "if(1, 2)"})
    try {
      const Expression expression(text);
      ADD_FAILURE() << text << " has been read";
    } catch (const InvalidInput& e) {
      EXPECT_EQ(e.argument(), "expression '" + std::string(text) + "'");
    }
  test::expect_refused("expression 'log(t)'", "not finite at t = -1e-09",
                       [] { expression_function(Expression("log(t)"), 0, {0})->at(-1e-9); });
}

// A text of 400 kB is not a message.
TEST(Expression, IsNotRepeatedAsAWholeInMessages) {
  std::string sum = "u";
  for (int i = 0; i < 300; ++i) sum += "+u";
  EXPECT_EQ(Expression(sum).text(), sum.substr(0, 200) + "...");
  EXPECT_EQ(Expression("u+1").text(), "u+1");
}

}  // namespace
}  // namespace mfs::dae
