// All models that come with the program: no run stays at order 1.
#include <gtest/gtest.h>

#include <cstdint>
#include <string>

#include "dae/model/model.hpp"
#include "dae/model/model_library.hpp"
#include "dae/statics/equilibrium.hpp"

namespace mfs::dae {
namespace {

/// The longest stretch of order 1 from one step to the next, and where it ends.
struct LowOrders : Observer {
  void step(const StepReport& report, const std::function<const State&()>&) override {
    stretch = report.order == 1 ? stretch + 1 : 0;
    if (stretch <= longest) return;
    longest = stretch;
    t = report.t;
  }
  int stretch = 0, longest = 0;
  double t = 0.0;
};

class LibraryModels : public testing::TestWithParam<std::string> {};

// Starts and what a motion meets on its way included, none of which takes as long.
TEST_P(LibraryModels, HasNoLongStretchOfOrderOne) {
  MultibodyModel model =
      make_model(Json::parse(find_library_model(GetParam())->text), "", 1, Backend::serial);
  if (model.starts_at_rest)
    model.q0 = find_equilibrium(*model.system, model.integrator, {0.0, model.q0, model.v0, {}, {}}).q;
  Integrator integrator(*model.system, model.integrator);
  LowOrders orders;
  integrator.run(0.0, model.q0, model.v0, model.end, output_times(model), orders);
  EXPECT_LE(orders.longest, 50) << "until t = " << orders.t;
}

/// Steps of a model of the library to `end` by tolerances that follow from `rtol` alone.
void expect_few_steps(const char* name, double rtol, double end, std::int64_t most) {
  SCOPED_TRACE(name);
  Json json = Json::parse(find_library_model(name)->text);
  json["integrator"] = {{"rtol", rtol}};
  json["end"] = end;
  const MultibodyModel model = make_model(json, "", 1, Backend::serial);
  Integrator integrator(*model.system, model.integrator);
  LowOrders orders;
  integrator.run(0.0, model.q0, model.v0, model.end, {}, orders);
  EXPECT_LE(orders.longest, 50) << "until t = " << orders.t;
  EXPECT_LT(integrator.report().steps, most);
}

// What order 1 leaves of a stiff damped body's velocities is not in the way of order 2: these were 833 and
// 795 steps.
TEST(Library, TurnsDampedFlexibleBodiesInFewSteps) {
  expect_few_steps("crank_piston", 1e-4, 0.2, 100);
  expect_few_steps("suspension", 3e-5, 1.0, 400);
}

std::vector<std::string> names() {
  std::vector<std::string> names;
  for (const LibraryModel& model : model_library()) names.push_back(model.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Models, LibraryModels, testing::ValuesIn(names()),
                         [](const auto& name) { return name.param; });

}  // namespace
}  // namespace mfs::dae
