// A beam without damping that is spun up and goes on turning (Simo and Vu-Quoc, "On the dynamics of flexible
// beams under large overall motions - the plane case", part II, Journal of Applied Mechanics 53 (1986)
// 855-863): the highest of its frequencies is 1e5 times that of the rotation, and BDF of order 3 to 5 is not
// stable for those between.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "dae/model/model.hpp"
#include "test/dae/integrator/recorder.hpp"

namespace mfs::dae {
namespace {

constexpr double kLength = 10.0, kSide = 0.0775, kYoung = 4.67e9, kDensity = 200.0;
constexpr double kSpeed = 6.0, kSpinUp = 15.0, kEnd = 20.0;  // rad/s, s

double angle(double t) {
  const double share = 2 * M_PI / kSpinUp;
  if (t > kSpinUp) return kSpeed * (t - 0.5 * kSpinUp);
  return kSpeed / kSpinUp * (0.5 * t * t + (std::cos(share * t) - 1) / (share * share));
}

Json model_file() {
  Json json = Json::parse(R"({
    "name": "spin_up", "outputs": 200,
    "materials": {"soft": {"law": "st_venant_kirchhoff", "poisson": 0.3}},
    "bodies": {
      "beam": {
        "type": "flexible", "material": "soft",
        "mesh": {"generator": "box", "element": "hex8", "refine": 1, "divisions": [10, 1, 1]}
      }
    },
    "joints": {"pin": {"type": "revolute", "a": "ground", "b": "beam:x0", "point": [0, 0, 0], "axis": [0, 0, 1]}},
    "motions": {"drive": {"type": "rotation", "joint": "pin", "angle": {"type": "spline"}}}
  })");
  json["end"] = kEnd;
  json["materials"]["soft"]["young"] = kYoung;
  json["materials"]["soft"]["density"] = kDensity;
  json["bodies"]["beam"]["position"] = {0, -0.5 * kSide, -0.5 * kSide};
  json["bodies"]["beam"]["mesh"]["size"] = {kLength, kSide, kSide};
  Json& drive = json["motions"]["drive"]["angle"];
  for (int k = 0; k <= 84; ++k) {
    drive["x"].push_back(0.25 * k);
    drive["y"].push_back(angle(0.25 * k));
  }
  return json;
}

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
    if (steps.size() == 10000) throw std::runtime_error("10 000 steps at t = " + std::to_string(report.t));
  }
};

class SpinUp : public testing::TestWithParam<Method> {};

TEST_P(SpinUp, StepsDoNotCollapseToTheHighestFrequency) {
  const MultibodyModel model = make_model(model_file(), "", 1, Backend::serial);
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

}  // namespace
}  // namespace mfs::dae
