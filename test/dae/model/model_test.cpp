// What a model file says arrives in the system and in the options.
#include <cmath>

#include <gmock/gmock.h>

#include "dae/model/model_library.hpp"
#include "dae/model/model_parts.hpp"
#include "test/dae/model/small_model.hpp"

namespace {

using mfs::dae::Function;
using mfs::dae::Json;
using mfs::dae::MultibodyModel;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::IsSupersetOf;
using testing::Pointwise;

std::vector<double> part(const std::vector<double>& x, int first, int count) {
  return {x.begin() + first, x.begin() + first + count};
}

// F where the system begins, with a and lambda zero: minus the forces on it.
std::vector<double> initial_force(const MultibodyModel& model) {
  const std::vector<double> a(model.q0.size()), lambda(static_cast<std::size_t>(model.system->constraints()));
  mfs::dae::Residual residual = mfs::dae::make_residual(*model.system);
  model.system->evaluate({0.0, model.q0.data(), model.v0.data(), a.data(), lambda.data()}, residual);
  return residual.force;
}

// The sums along x, y, z over the nodes of the bar.
std::vector<double> total(const std::vector<double>& nodes) {
  std::vector<double> sums(3);
  for (std::size_t i = 0; i < nodes.size(); ++i) sums[i % 3] += nodes[i];
  return sums;
}

TEST(Model, IsPutTogether) {
  const MultibodyModel model = mfs::dae::make_model(small_model(), "", 1);
  EXPECT_EQ(model.name, "small");
  EXPECT_THAT(mfs::dae::output_times(model), Pointwise(DoubleNear(1e-15), {0.0, 0.1, 0.2, 0.3, 0.4, 0.5}));
  ASSERT_EQ(model.flexible_bodies.size(), 1U);
  const int nodes = 9 * 3 * 3;
  EXPECT_EQ(model.flexible_bodies[0].range.count, 3 * nodes);
  // The block and the interfaces of both ends have 7 coordinates and p.p = 1 each.
  EXPECT_EQ(model.system->coordinates(), 3 * nodes + 3 * 7);
  EXPECT_EQ(model.system->constraints(), 3 + 2 * 3 * 9 + 5 + 3 + 1);
}

// 0.1 * 3 / 3 is more than 0.1, 0.11 * 49 / 49 less.
TEST(Model, TheLastOutputIsAtTheEnd) {
  Json json = small_model();
  for (const auto& [end, outputs] : {std::pair{0.1, 3}, {0.2, 3}, {0.11, 49}, {0.5, 5}}) {
    json["end"] = end;
    json["outputs"] = outputs;
    EXPECT_EQ(mfs::dae::output_times(mfs::dae::make_model(json, "", 1)).back(), end);
  }
}

TEST(Model, BodiesArePlacedAndMove) {
  const MultibodyModel model = mfs::dae::make_model(small_model(), "", 1);
  const auto& bar = model.flexible_bodies[0];
  const auto& mesh_nodes = bar.solid->mesh().nodes;
  for (std::size_t i = 0; i < mesh_nodes.size(); ++i) {
    const auto& [x, y, z] = mesh_nodes[i];
    const int first = bar.range.first + 3 * static_cast<int>(i);
    ASSERT_THAT(part(model.q0, first, 3), Pointwise(DoubleNear(1e-14), {-y, 2 + x, z}));
    ASSERT_THAT(part(model.v0, first, 3), Pointwise(DoubleNear(1e-14), {-3 * x, -3 * y, 1.0}));
  }
  const int block = model.rigid_bodies.at(0).frame.first;
  EXPECT_THAT(part(model.q0, block, 7), Pointwise(DoubleNear(1e-15), {0.0, 3.5, 0.1, 1.0, 0.0, 0.0, 0.0}));
}

TEST(Model, AxesMayHaveAnyLength) {
  Json json = small_model();
  const MultibodyModel model = mfs::dae::make_model(json, "", 1);
  for (const double length : {1e-300, 1e300}) {
    json["joints"]["hinge"]["axis"] = json["bodies"]["bar"]["rotation"]["axis"] = {0, 0, length};
    const MultibodyModel same = mfs::dae::make_model(json, "", 1);
    EXPECT_EQ(same.q0, model.q0);
    EXPECT_EQ(same.v0, model.v0);
  }
}

TEST(Model, MaterialMassAndForcesCount) {
  Json json = small_model();
  const auto force = [&json] {
    const MultibodyModel model = mfs::dae::make_model(json, "", 1);
    const auto& bar = model.flexible_bodies[0].range;
    std::vector<double> sums = total(part(initial_force(model), bar.first, bar.count));
    const std::vector<double> block = part(initial_force(model), model.rigid_bodies[0].frame.first, 3);
    sums.insert(sums.end(), block.begin(), block.end());
    return sums;
  };
  // The bar: 160 kg with their weight, the drag alpha m v of its centre's velocity, the wind. The block: its
  // weight and the push.
  EXPECT_THAT(force(),
              Pointwise(DoubleNear(1e-9), {-5 + 16 * -1.5, 1600 + 16 * -0.15, 16.0, -7.0, 30.0, 0.0}));
  json["materials"]["steel"]["density"] = 4000;
  json["bodies"]["bar"]["damping"] = {{"beta", 0.0}};
  json["forces"].erase("push");
  EXPECT_THAT(force(), Pointwise(DoubleNear(1e-9), {-5.0, 800.0, 0.0, 0.0, 30.0, 0.0}));
}

TEST(Model, PointsAndReactions) {
  const MultibodyModel model = mfs::dae::make_model(small_model(), "", 1);
  ASSERT_EQ(model.points.size(), 2U);
  EXPECT_EQ(model.points[0].frame.first, model.rigid_bodies[0].frame.first);
  EXPECT_THAT(model.points[0].point, ElementsAre(0, 0.5, 0));
  const int node = model.points[1].node;
  ASSERT_GE(node, 0);
  EXPECT_THAT(part(model.q0, model.flexible_bodies[0].range.first + 3 * node, 3),
              Pointwise(DoubleNear(1e-14), {0.0, 3.0, 0.2}));
  EXPECT_THAT(model.reactions, ElementsAre("tip"));
  ASSERT_EQ(model.joints.size(), 2U);
  ASSERT_EQ(model.joints[1].elements.size(), 1U);
  const int row = model.joints[1].elements[0].first_row;
  EXPECT_EQ(model.system->constraint_name(row).substr(0, 26), "joint tip, equation 1 of 3");
  // The block hangs on what attaches to it: tip, cushion, strut, push.
  EXPECT_EQ(model.rigid_bodies[0].points.size(), 4U);
}

TEST(Model, OptionsOfTheIntegrator) {
  const mfs::dae::IntegratorOptions options = mfs::dae::make_model(small_model(), "", 3).integrator;
  const mfs::dae::IntegratorOptions defaults;
  EXPECT_EQ(options.method, mfs::dae::Method::bdf);
  EXPECT_EQ(options.unknowns, mfs::dae::Unknowns::full);
  EXPECT_EQ(options.rtol, 1e-5);
  EXPECT_EQ(options.atol_velocity, defaults.atol_velocity);
  EXPECT_EQ(options.max_order, 3);
  EXPECT_FALSE(options.keep_factors);
  EXPECT_EQ(options.threads, 3);
}

TEST(Model, Functions) {
  const auto at = [](const char* text, double x) {
    const Json json = Json::parse(text);
    const mfs::dae::Jet jet = mfs::dae::read_function(mfs::dae::JsonObject(json, "f"))->at(x);
    return std::vector<double>{jet.value, jet.first};
  };
  EXPECT_THAT(at(R"({"type": "constant", "value": 4})", 2), ElementsAre(4, 0));
  EXPECT_THAT(at(R"({"type": "linear", "value": 1, "slope": 3})", 2), ElementsAre(7, 3));
  const double pi = std::acos(-1.0);
  EXPECT_THAT(at(R"({"type": "harmonic", "offset": 1, "amplitude": 2, "frequency": 0.5, "phase": 1})", 0.25),
              Pointwise(DoubleNear(1e-14), {1 + 2 * std::sin(pi / 4 + 1), 2 * pi * std::cos(pi / 4 + 1)}));
  EXPECT_THAT(at(R"({"type": "smooth_step", "begin": 1, "end": 3, "before": 2, "after": 6})", 2),
              Pointwise(DoubleNear(1e-14), {4.0, 15.0 / 8 * 4 / 2}));
  EXPECT_THAT(at(R"({"type": "spline", "x": [0, 1, 2], "y": [0, 1, 4]})", 3),
              Pointwise(DoubleNear(1e-14), {7.5, 3.5}));
}

TEST(Model, RefinesMeshesOfGenerators) {
  Json json = small_model();
  mfs::dae::refine_meshes(json, 1);
  EXPECT_EQ(mfs::dae::make_model(json, "", 1).flexible_bodies[0].range.count, 3 * 5 * 2 * 2);
}

TEST(ModelLibrary, HasModelsThatCanBeMade) {
  std::vector<std::string> names;
  for (const mfs::dae::LibraryModel& each : mfs::dae::model_library()) {
    names.push_back(each.name);
    const Json json = Json::parse(each.text);
    const MultibodyModel model = mfs::dae::make_model(json, "", 1);
    EXPECT_EQ(model.name, each.name);
    EXPECT_FALSE(json["description"].get<std::string>().empty());
    EXPECT_EQ(mfs::dae::find_library_model(each.name), &each);
  }
  EXPECT_THAT(names, IsSupersetOf({"crank_piston", "suspension", "bell_crank", "four_bar"}));
  EXPECT_EQ(mfs::dae::find_library_model("perpetuum_mobile"), nullptr);
}

}  // namespace
