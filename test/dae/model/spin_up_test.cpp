// A beam without damping that is spun up and goes on turning (Simo and Vu-Quoc, "On the dynamics of flexible
// beams under large overall motions - the plane case", part II, Journal of Applied Mechanics 53 (1986)
// 855-863): the highest of its frequencies is 1e5 times that of the rotation, and BDF of order 3 to 5 is not
// stable for those between.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "dae/model/model.hpp"
#include "dae/model/model_library.hpp"
#include "test/dae/integrator/recorder.hpp"

namespace mfs::dae {
namespace {

constexpr double kLength = 10.0, kYoung = 4.67e9, kDensity = 200.0, kSpeed = 6.0;  // rad/s

/// Mean distance of the tip's nodes from the axis of rotation, m.
double reach(const FlexibleBody& beam, const State& state) {
  const Mesh& mesh = beam.solid->mesh();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    if (mesh.nodes[i][0] < kLength - 1e-9) continue;
    sum += Eigen::Map<const Eigen::Vector2d>(&state.q[beam.range.first + 3 * i]);
    ++count;
  }
  return (sum / count).norm();
}

/// Ends a run whose steps have collapsed.
struct Limited : test::Recorder {
  void step(const StepReport& report, const std::function<const State&()>& state) override {
    Recorder::step(report, state);
    if (steps.size() == most)
      throw std::runtime_error(std::to_string(most) + " steps at t = " + std::to_string(report.t));
  }
  std::size_t most = 10000;
};

class SpinUp : public testing::TestWithParam<Method> {};

TEST_P(SpinUp, StepsDoNotCollapseToTheHighestFrequency) {
  const MultibodyModel model =
      make_model(Json::parse(find_library_model("spin_up_beam")->text), "", 1, Backend::serial);
  IntegratorOptions options = model.integrator;
  options.method = GetParam();
  options.rho_inf = 0.0;
  Integrator integrator(*model.system, options);
  Limited recorder;
  integrator.run(0.0, model.q0, model.v0, model.end, output_times(model), recorder);
  int low = 0;
  for (const StepReport& step : recorder.steps) {
    low = step.order == 1 ? low + 1 : 0;
    EXPECT_LE(low, 50) << step.t;
    EXPECT_TRUE(step.h > 1e-6 || step.t < 0.1) << step.t;
  }
  // Once it turns evenly, the centrifugal force stretches it as a bar: L (tan x / x - 1).
  const double x = kSpeed * kLength * std::sqrt(kDensity / kYoung);
  const double expected = kLength * (std::tan(x) / x - 1);
  double sum = 0.0;
  int count = 0;
  for (const State& state : recorder.outputs) {
    if (state.t < 16.0) continue;
    sum += reach(model.flexible_bodies.front(), state) - kLength;
    ++count;
  }
  EXPECT_NEAR(sum / count, expected, 0.02 * expected);
}

INSTANTIATE_TEST_SUITE_P(Methods, SpinUp, testing::Values(Method::bdf, Method::generalized_alpha));

// What Newton's method may leave is no more than by the default tolerances: a tenth of these loose ones is a
// vibration of all frequencies, and steps fell to 2e-6 s.
TEST(SpinUpBeam, StepsDoNotCollapseByLooseTolerances) {
  const Json loose[] = {{{"rtol", 1e-2}},
                        {{"rtol", 5e-3}},
                        {{"rtol", 1e-2}, {"method", "generalized_alpha"}, {"rho_inf", 0.0}},
                        {{"atol_position", 1e-3}, {"atol_velocity", 0.1}}};
  for (const Json& integrator : loose) {
    SCOPED_TRACE(integrator.dump());
    Json json = Json::parse(find_library_model("spin_up_beam")->text);
    json["integrator"] = integrator;
    const MultibodyModel model = make_model(json, "", 1, Backend::serial);
    Limited recorder;
    recorder.most = 3000;
    Integrator(*model.system, model.integrator).run(0.0, model.q0, model.v0, model.end, {}, recorder);
  }
}

// A force that Newton's method leaves in a stiff direction is a vibration, however short the way is that it
// would push: 1e-7 m along this beam of steel make 1e-3 m/s of it, ten times what a step may be off. Without
// damping it stays, and steps follow it: 17 000 of them. Those of the bending that is there are 2200, which
// is what the same tolerances take once next to nothing is left (a ten-thousandth); this is twice to three
// times that.
TEST(SpinUpBeam, OfThinSteelIsNotMadeToVibrateByWhatNewtonsMethodLeaves) {
  Json json = Json::parse(find_library_model("spin_up_beam")->text);
  json["materials"]["soft"]["young"] = 2.1e11;
  json["materials"]["soft"]["density"] = 7850.0;
  json["bodies"]["beam"]["position"] = {0.0, -0.01, -0.01};
  json["bodies"]["beam"]["mesh"]["size"] = {10.0, 0.02, 0.02};
  json.erase("points");
  const MultibodyModel model = make_model(json, "", 1, Backend::serial);
  Limited recorder;
  recorder.most = 7000;
  Integrator(*model.system, model.integrator).run(0.0, model.q0, model.v0, model.end, {}, recorder);
}

}  // namespace
}  // namespace mfs::dae
