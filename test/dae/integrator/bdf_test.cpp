// The formula alone: how errors decide the order.
#include "dae/integrator/bdf.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace mfs::dae {
namespace {

// Differences of what alternates double with each order: orders below have smaller errors. Of what is smooth
// they shrink.
TEST(Bdf, TheOrderFallsWhereValuesAlternate) {
  Bdf bdf(5, false, 1);
  bdf.start({1.0}, {1.0}, 0.01);
  const std::vector<double> weights{0.02};
  double t = 0.0, h = 0.01;
  const auto step = [&](double added) {
    std::vector<double> y, dy;
    bdf.predict(h, y, dy);
    t += h;
    const std::vector<double> correction{std::exp(t) + added - y[0]};
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

}  // namespace
}  // namespace mfs::dae
