// What the local error may be for what the user asks for.
#include "dae/integrator/tolerances.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace mfs::dae {
namespace {

IntegratorOptions local(IntegratorOptions options) {
  set_local_tolerances(options);
  return options;
}

IntegratorOptions with_rtol(double rtol, Method method = Method::bdf) {
  IntegratorOptions options;
  options.rtol = rtol;
  options.method = method;
  return options;
}

/// All three follow from one number.
void expect_tolerances(const IntegratorOptions& options, double relative, double absolute) {
  EXPECT_NEAR(options.rtol, relative, 1e-12 * relative);
  EXPECT_NEAR(options.atol_position, 1e-2 * absolute, 1e-14 * absolute);
  EXPECT_NEAR(options.atol_velocity, absolute, 1e-12 * absolute);
}

TEST(LocalTolerances, AreRtolItselfFromTheDefaultUp) {
  for (const double rtol : {1e-2, 1e-3, 1e-4}) {
    const IntegratorOptions options = local(with_rtol(rtol));
    EXPECT_EQ(options.rtol, rtol);
    EXPECT_EQ(options.atol_position, 1e-2 * rtol);
    EXPECT_EQ(options.atol_velocity, rtol);
  }
}

// The global error, (local error)^(k / (k + 1)), falls by 100 when rtol does.
TEST(LocalTolerances, MakeTheErrorOfTheMotionFallAsRtolDoes) {
  const double by_bdf = std::pow(100.0, 6.0 / 5.0), by_alpha = std::pow(100.0, 3.0 / 2.0);
  expect_tolerances(local(with_rtol(1e-6)), 1e-4 / by_bdf, 1e-4 / by_bdf);
  expect_tolerances(local(with_rtol(1e-8)), 1e-4 / (by_bdf * by_bdf), 1e-4 / (by_bdf * by_bdf));
  expect_tolerances(local(with_rtol(1e-6, Method::generalized_alpha)), 1e-4 / by_alpha, 1e-4 / by_alpha);
  IntegratorOptions of_order_two = with_rtol(1e-6);
  of_order_two.max_order = 2;
  expect_tolerances(local(of_order_two), 1e-4 / by_alpha, 1e-4 / by_alpha);
}

TEST(LocalTolerances, AreNotMadeLessThanRoundingLets) {
  expect_tolerances(local(with_rtol(1e-9)), 1e-10, 1e-9);
  for (const double rtol : {1e-10, 1e-12}) expect_tolerances(local(with_rtol(rtol)), rtol, rtol);
}

TEST(LocalTolerances, CanBeRelaxedOnceForSomeSteps) {
  const IntegratorOptions asked = with_rtol(1e-8);
  IntegratorOptions used = asked;
  const double tight = local(asked).rtol;
  LocalTolerances tolerances(asked, used);
  for (int round = 0; round < 2; ++round) {
    EXPECT_EQ(used.rtol, tight);
    EXPECT_TRUE(tolerances.relax());
    expect_tolerances(used, 1e-8, 1e-8);
    EXPECT_FALSE(tolerances.relax());
    for (int step = 0; step < 19; ++step) tolerances.go_on();
    expect_tolerances(used, 1e-8, 1e-8);
    tolerances.go_on();
  }
  const IntegratorOptions loose = with_rtol(1e-3);
  IntegratorOptions used_loose = loose;
  EXPECT_FALSE(LocalTolerances(loose, used_loose).relax());
}

TEST(LocalTolerances, AreThoseThatAreGiven) {
  IntegratorOptions options = with_rtol(1e-6);
  options.atol_position = 1e-5;
  options = local(options);
  EXPECT_EQ(options.rtol, 1e-6);
  EXPECT_EQ(options.atol_position, 1e-5);
  EXPECT_EQ(options.atol_velocity, 1e-6);
  options = with_rtol(1e-6);
  options.atol_velocity = 1e-3;
  options = local(options);
  EXPECT_EQ(options.rtol, 1e-6);
  EXPECT_EQ(options.atol_position, 1e-8);
  EXPECT_EQ(options.atol_velocity, 1e-3);
  options = with_rtol(0.0);
  options.atol_position = options.atol_velocity = 1e-6;
  EXPECT_EQ(local(options).rtol, 0.0);
}

}  // namespace
}  // namespace mfs::dae
