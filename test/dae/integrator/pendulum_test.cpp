#include "test/dae/integrator/pendulum.hpp"

#include <gtest/gtest.h>

#include "dae/integrator/integrator.hpp"
#include "test/dae/integrator/recorder.hpp"

namespace mfs::dae::test {
namespace {

IntegratorOptions tight(Unknowns unknowns) {
  IntegratorOptions options;
  options.unknowns = unknowns;
  options.rtol = 1e-8;
  options.atol_position = options.atol_velocity = 1e-9;
  options.backend = Backend::serial;
  options.threads = 1;
  return options;
}

class PendulumTest : public testing::TestWithParam<Unknowns> {};

TEST_P(PendulumTest, PeriodAndEnergy) {
  const double angle = 2.0, period = pendulum_period(angle);
  const DenseSystem<Pendulum> system;
  Integrator integrator(system, tight(GetParam()));
  Recorder recorder;
  const State end =
      integrator.run(0.0, pendulum_at(angle), {0.0, 0.0}, 2.0 * period, {0.5 * period, period}, recorder);
  ASSERT_EQ(recorder.outputs.size(), 2u);
  // Half a period later it is at rest on the other side.
  EXPECT_NEAR(recorder.outputs[0].q[0], -std::sin(angle), 1e-6);
  EXPECT_NEAR(recorder.outputs[0].v[0], 0.0, 1e-5);
  EXPECT_NEAR(recorder.outputs[1].q[0], std::sin(angle), 1e-6);
  EXPECT_NEAR(end.v[0], 0.0, 1e-5);
  const double energy = -Pendulum::kGravity * std::cos(angle);
  for (const State& state : recorder.states) EXPECT_NEAR(pendulum_energy(state), energy, 5e-5);
}

INSTANTIATE_TEST_SUITE_P(Unknowns, PendulumTest, testing::Values(Unknowns::full, Unknowns::reduced));

}  // namespace
}  // namespace mfs::dae::test
