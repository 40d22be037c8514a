// The formula alone: how errors decide the order.
#include "dae/integrator/bdf.hpp"

#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace mfs::dae
