// Analyses whose steps stay on a device beside the same ones on the host.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "dae/integrator/bdf.hpp"
#include "dae/integrator/integrator.hpp"
#include "dae/model/model.hpp"
#include "dae/model/model_library.hpp"
#include "test/solver/on_device.hpp"

namespace mfs::dae {
namespace {

constexpr double kEnd = 0.01;  // s

struct Analysis {
  std::vector<State> outputs;
  std::vector<double> times;  ///< of all steps
  IntegrationReport report;
};

class Keep : public Observer {
 public:
  explicit Keep(Analysis& analysis) : analysis_(analysis) {}
  void step(const StepReport& report, const std::function<const State&()>& state) override {
    analysis_.times.push_back(report.t);
    EXPECT_EQ(state().t, report.t);
  }
  void output(const State& state) override { analysis_.outputs.push_back(state); }

 private:
  Analysis& analysis_;
};

Json library_model(const std::string& name) {
  const auto& library = model_library();
  const auto found =
      std::find_if(library.begin(), library.end(), [&](const LibraryModel& m) { return m.name == name; });
  return Json::parse(found->text);
}

Analysis run(const Json& json, Backend backend, const std::function<void(IntegratorOptions&)>& change) {
  MultibodyModel model = make_model(json, "", 2, backend);
  change(model.integrator);
  Integrator integrator(*model.system, model.integrator);
  Analysis analysis;
  Keep keep(analysis);
  integrator.run(0.0, model.q0, model.v0, kEnd, {0.0, 0.5 * kEnd, kEnd}, keep);
  analysis.report = integrator.report();
  return analysis;
}

/// |a - b| / |b|, Eq. (9) of Jung and Bae.
double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double of_difference = 0.0, of_b = 0.0;
  for (std::size_t i = 0; i < b.size(); ++i) {
    of_difference += (a[i] - b[i]) * (a[i] - b[i]);
    of_b += b[i] * b[i];
  }
  return std::sqrt(of_difference / std::max(of_b, 1e-300));
}

void expect_same(const Json& json, const std::function<void(IntegratorOptions&)>& change) {
  const Analysis host = run(json, Backend::openmp, change), device = run(json, Backend::cuda, change);
  EXPECT_EQ(device.report.steps, host.report.steps);
  EXPECT_EQ(device.report.newton_iterations, host.report.newton_iterations);
  EXPECT_EQ(device.report.jacobians, host.report.jacobians);
  EXPECT_EQ(device.report.redundant, host.report.redundant);
  ASSERT_EQ(device.outputs.size(), host.outputs.size());
  for (std::size_t k = 0; k < host.outputs.size(); ++k) {
    SCOPED_TRACE("output " + std::to_string(k));
    const State &actual = device.outputs[k], &expected = host.outputs[k];
    EXPECT_EQ(actual.t, expected.t);
    EXPECT_LT(difference(actual.q, expected.q), 1e-10);
    EXPECT_LT(difference(actual.v, expected.v), 1e-7);
    EXPECT_LT(difference(actual.a, expected.a), 1e-5);
    EXPECT_LT(difference(actual.lambda, expected.lambda), 1e-5);
  }
  // What is left of the accelerations' is near their rounding: on the host alone gravity times 1 + 1e-15
  // moves the suspension's 9.86e-5 m/s^2 by 3e-9.
  constexpr double kRelative[3] = {1e-6, 1e-6, 1e-4};
  for (int level = 0; level < 3; ++level)
    EXPECT_NEAR(device.report.violation[level], host.report.violation[level],
                kRelative[level] * host.report.violation[level] + 1e-9);
}

class DeviceIntegrator : public mfs::test::OnDevice, public testing::WithParamInterface<const char*> {
 protected:
  const Json model_ = library_model(GetParam());
};

TEST_P(DeviceIntegrator, IsTheHosts) {
  expect_same(model_, [](IntegratorOptions&) {});
}

TEST_P(DeviceIntegrator, IsTheHostsWithAllUnknowns) {
  expect_same(model_, [](IntegratorOptions& options) { options.unknowns = Unknowns::full; });
}

TEST_P(DeviceIntegrator, IsTheHostsWithGeneralizedAlpha) {
  expect_same(model_, [](IntegratorOptions& options) {
    options.method = Method::generalized_alpha;
    options.fixed_step = kEnd / 16;
  });
}

TEST_P(DeviceIntegrator, RepeatsToTheBit) {
  const auto as_it_is = [](IntegratorOptions&) {};
  const Analysis first = run(model_, Backend::cuda, as_it_is), again = run(model_, Backend::cuda, as_it_is);
  EXPECT_EQ(first.times, again.times);
  EXPECT_EQ(first.outputs.back().q, again.outputs.back().q);
  EXPECT_EQ(first.outputs.back().lambda, again.outputs.back().lambda);
}

INSTANTIATE_TEST_SUITE_P(Models, DeviceIntegrator,
                         testing::Values("bell_crank", "suspension", "crank_piston"),
                         [](const auto& each) { return std::string(each.param); });

using DeviceIntegratorCases = mfs::test::OnDevice;

// Where constraints follow from others, and are left out, states stay on the host.
TEST_F(DeviceIntegratorCases, RedundantConstraints) {
  Json json = library_model("suspension");
  json["joints"]["rack_guide_again"] = Json(json["joints"]["rack_guide"]);
  const auto as_it_is = [](IntegratorOptions&) {};
  EXPECT_EQ(run(json, Backend::cuda, as_it_is).report.redundant.size(), 5U);
  expect_same(json, as_it_is);
}

// A second analysis by the same integrator begins anew.
TEST_F(DeviceIntegratorCases, AgainByTheSameIntegrator) {
  const MultibodyModel model = make_model(library_model("bell_crank"), "", 2, Backend::cuda);
  Integrator integrator(*model.system, model.integrator);
  Observer nobody;
  const State first = integrator.run(0.0, model.q0, model.v0, kEnd, {}, nobody);
  const State again = integrator.run(0.0, model.q0, model.v0, kEnd, {}, nobody);
  EXPECT_EQ(first.q, again.q);
  EXPECT_EQ(first.lambda, again.lambda);
}

// What is asked for after many steps of order 1.
std::vector<double> correction_above(Executor::Place place, std::size_t length) {
  const Executor executor(place, 2);
  const auto waves = [&](double frequency) {
    std::vector<double> values(length);
    for (std::size_t i = 0; i < length; ++i) values[i] = std::sin(frequency * static_cast<double>(i + 1));
    return make_array(executor, values);
  };
  Bdf bdf(5, false, executor);
  bdf.start(waves(0.1), waves(0.2), 0.5, 0.5);
  Array<double> y, dy, above;
  bdf.predict(0.5, y, dy);
  bdf.local_error(waves(0.3), waves(0.5));
  bdf.accept(waves(0.3), waves(0.5));
  bdf.predict(0.5, y, dy);
  bdf.correction_above(waves(0.4), above);
  return above.on_host(executor);
}

TEST_F(DeviceIntegratorCases, CorrectionOfTheOrderAbove) {
  for (const std::size_t length : {1, 31, 32, 33, 257, 70000}) {
    const std::vector<double> actual = correction_above(Executor::Place::device, length),
                              expected = correction_above(Executor::Place::host, length);
    ASSERT_EQ(actual.size(), length);
    for (std::size_t i = 0; i < length; ++i)
      ASSERT_NEAR(actual[i], expected[i], 1e-13) << length << ", " << i;
  }
}

}  // namespace
}  // namespace mfs::dae
