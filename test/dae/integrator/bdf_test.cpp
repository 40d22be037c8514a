// The formula alone: how errors decide the order.
#include "dae/integrator/bdf.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace mfs::dae {
namespace {

// Differences of what alternates double with each order: orders below have smaller errors. Of what is smooth
// they shrink.
TEST(Bdf, TheOrderFallsWhereValuesAlternate) {
  const Executor host(Executor::Place::host, 1);
  const auto array = [&](double value) { return make_array<double>(host, {value}); };
  Bdf bdf(5, false, host);
  bdf.start(array(1.0), array(1.0), 0.01);
  const Array<double> weights = array(0.02);
  double t = 0.0, h = 0.01;
  const auto step = [&](double added) {
    Array<double> y, dy;
    bdf.predict(h, y, dy);
    t += h;
    const Array<double> correction = array(std::exp(t) + added - *y.data());
    bdf.local_error(correction, weights);
    return bdf.accept(correction, weights);
  };
  for (int n = 0; n < 8; ++n) h = step(0.0);
  for (int n = 8; n < 13; ++n) step(0.0);
  ASSERT_EQ(bdf.order(), 5);
  step(0.02);
  EXPECT_EQ(bdf.order(), 5);  // one jump is as bad for all orders
  step(-0.02);
  EXPECT_EQ(bdf.order(), 4);
}

struct Taken {
  int order;
  double step;
};

/// Steps through (cos t, sin t), each of which the formula is told, with an error of `allowed`.
std::vector<Taken> go_round(double allowed, std::size_t count) {
  const Executor host(Executor::Place::host, 1);
  const auto array = [&](double x, double y) { return make_array<double>(host, {x, y}); };
  Bdf bdf(5, false, host);
  bdf.start(array(1.0, 0.0), array(0.0, 1.0), 0.01);
  const Array<double> weights = array(allowed, allowed);
  std::vector<Taken> taken;
  double t = 0.0, h = 0.01;
  for (int rejections = 0; taken.size() < count;) {
    Array<double> y, dy;
    bdf.predict(h, y, dy);
    const Array<double> e = array(std::cos(t + h) - y.data()[0], std::sin(t + h) - y.data()[1]);
    if (bdf.local_error(e, weights) > 1.0) {
      h = bdf.reject(++rejections);
      continue;
    }
    rejections = 0;
    t += h;
    taken.push_back({bdf.order(), h});
    h = bdf.accept(e, weights);
  }
  return taken;
}

// What oscillates is the motion. Order 2 needs 0.6 of the steps of order 5; without what tells a false alarm
// three of four steps are of order 2.
TEST(Bdf, HighOrdersComeBackAfterAFalseAlarm) {
  const std::vector<Taken> taken = go_round(0.03, 200);
  const auto first =
      std::find_if(taken.begin() + 20, taken.end(), [](const Taken& s) { return s.order == 2; });
  ASSERT_NE(first, taken.end());  // there is an alarm
  EXPECT_LT(first->step, 0.7 * (first - 1)->step);
  const auto low = [](const Taken& s) { return s.order <= 2; };
  EXPECT_LE(std::count_if(first, taken.end(), low), 20);
  EXPECT_EQ(taken.back().order, 5);
}

// An alarm after which order 2 takes longer steps is none.
TEST(OrderHold, LastsTwiceAsLongEachTimeWhereItPays) {
  OrderHold hold;
  for (const int length : {50, 100, 200}) {
    hold.begin(1.0, true);
    for (int k = 0; k < length; ++k) {
      EXPECT_TRUE(hold.holds()) << k;
      hold.add(k == 5 ? 0.8 : 0.5);
    }
    EXPECT_FALSE(hold.holds());
    EXPECT_FALSE(hold.ignores_alarms());
  }
}

TEST(OrderHold, LastsWhateverOrderTwoComesToWhereNothingIsDoubtful) {
  OrderHold hold;
  hold.begin(1.0, false);
  for (int k = 0; k < 50; ++k) {
    EXPECT_TRUE(hold.holds()) << k;
    hold.add(0.1);
  }
  EXPECT_FALSE(hold.holds());
}

TEST(OrderHold, EndsAfterTenStepsWhereItDoesNotAndIsNotTriedAgainSoon) {
  OrderHold hold;
  for (const int length : {100, 200}) {
    hold.begin(1.0, true);
    for (int k = 0; k < 10; ++k) {
      EXPECT_TRUE(hold.holds()) << k;
      hold.add(0.7);
    }
    EXPECT_FALSE(hold.holds());
    for (int k = 0; k < length; ++k) {
      EXPECT_TRUE(hold.ignores_alarms()) << k;
      hold.add(1.0);
    }
    EXPECT_FALSE(hold.ignores_alarms());
  }
}

// A motion of few times what is allowed. Order 2 is better than order 1, but not by a half, as IDA asks for:
// 380 steps of order 1 in a row.
TEST(Bdf, DoesNotStayAtOrderOne) {
  int low = 0, longest = 0;
  for (const Taken& step : go_round(0.3, 460)) {
    low = step.order == 1 ? low + 1 : 0;
    longest = std::max(longest, low);
  }
  EXPECT_GT(longest, 0);
  EXPECT_LE(longest, 40);
}

}  // namespace
}  // namespace mfs::dae
