// Outputs between the ends of steps where a flexible body turns: they are about as good as the ends, stretch
// of the body included, and leave the steps alone. The reference is the same model with tolerances a
// thousandth, whose error is that much smaller at either.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "dae/model/model.hpp"
#include "dae/model/model_library.hpp"
#include "test/dae/integrator/recorder.hpp"

namespace mfs::dae {
namespace {

/// A rod of steel that is swung about one end, from rest to rest.
Json swung_rod(const std::string& method, double rtol) {
  Json json = Json::parse(R"({
    "name": "rod", "end": 0.25, "outputs": 1, "gravity": [0, -9.81, 0],
    "materials": {"steel": {"law": "st_venant_kirchhoff", "young": 2e11, "poisson": 0.3, "density": 7870}},
    "bodies": {
      "rod": {
        "type": "flexible", "material": "steel", "damping": {"beta": 1e-4}, "position": [0, -0.01, -0.01],
        "mesh": {"generator": "box", "refine": 1, "size": [0.3, 0.02, 0.02], "element": "hex8",
                 "divisions": [6, 1, 1]}
      }
    },
    "joints": {
      "bearing": {"type": "revolute", "a": "ground", "b": "rod:x0", "point": [0, 0, 0], "axis": [0, 0, 1]}
    },
    "motions": {
      "drive": {
        "type": "rotation", "joint": "bearing",
        "angle": {"type": "smooth_step", "begin": 0, "end": 0.25, "after": 8}
      }
    },
    "integrator": {}
  })");
  json["integrator"]["method"] = method;
  json["integrator"]["rtol"] = rtol;
  json["integrator"]["atol_position"] = 1e-2 * rtol;
  json["integrator"]["atol_velocity"] = rtol;
  return json;
}

struct Solution {
  MultibodyModel model;
  test::Recorder recorder;
  State end;
};

Solution run(const Json& json, std::vector<double> outputs) {
  Solution result;
  result.model = make_model(json, "", 1, Backend::serial);
  Integrator integrator(*result.model.system, result.model.integrator);
  if (outputs.empty() || outputs.back() < result.model.end) outputs.push_back(result.model.end);
  result.end =
      integrator.run(0.0, result.model.q0, result.model.v0, result.model.end, outputs, result.recorder);
  return result;
}

std::vector<double> times(double end, int count) {
  std::vector<double> times;
  for (int k = 1; k < count; ++k) times.push_back(end * k / count);
  return times;
}

double apart(const std::vector<double>& x, const std::vector<double>& y) {
  double most = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) most = std::max(most, std::abs(x[i] - y[i]));
  return most;
}

/// From each node to the next, m.
std::vector<double> distances(const FlexibleBody& body, const State& state) {
  std::vector<double> all;
  for (int i = body.range.first + 3; i < body.range.first + body.range.count; i += 3) {
    const double* const x = &state.q[static_cast<std::size_t>(i)];
    all.push_back(std::hypot(x[0] - x[-3], x[1] - x[-2], x[2] - x[-1]));
  }
  return all;
}

/// Largest differences of q, v, a, multipliers and of distances of nodes.
using Errors = std::array<double, 5>;

Errors errors(const Solution& run, const std::vector<State>& states, const std::vector<State>& truth) {
  Errors largest{};
  const FlexibleBody& rod = run.model.flexible_bodies[0];
  for (const State& state : states) {
    const auto exact = std::lower_bound(truth.begin(), truth.end(), state.t,
                                        [](const State& s, double t) { return s.t < t; });
    EXPECT_EQ(exact->t, state.t);
    const Errors here{apart(state.q, exact->q), apart(state.v, exact->v), apart(state.a, exact->a),
                      apart(state.lambda, exact->lambda),
                      apart(distances(rod, state), distances(rod, *exact))};
    for (std::size_t k = 0; k < here.size(); ++k) largest[k] = std::max(largest[k], here[k]);
  }
  return largest;
}

class FlexibleOutputTest : public testing::TestWithParam<const char*> {};

TEST_P(FlexibleOutputTest, IsAboutAsGoodAsTheEndsOfSteps) {
  const double rtol = 1e-4;
  const Solution coarse = run(swung_rod(GetParam(), rtol), times(0.25, 397));
  std::vector<double> all = times(0.25, 397);
  for (const StepReport& step : coarse.recorder.steps) all.push_back(step.t);
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  const Solution fine = run(swung_rod(GetParam(), 1e-3 * rtol), all);
  ASSERT_LT(coarse.recorder.steps.size(), 390U);  // outputs are between their ends
  const Errors at_ends = errors(coarse, coarse.recorder.states, fine.recorder.outputs);
  const Errors between = errors(coarse, coarse.recorder.outputs, fine.recorder.outputs);
  for (std::size_t k = 0; k < between.size(); ++k) EXPECT_LT(between[k], 1.5 * at_ends[k]) << "number " << k;
}

// Where the motion is prescribed, positions at the ends are far better than the tolerance, and between them
// all that is left of that is by the degree of the polynomials.
TEST(CrankPistonOutputTest, PrescribedPositionsAreBetterThanAskedFor) {
  Json json = Json::parse(find_library_model("crank_piston")->text);
  json["end"] = 0.4;
  const Solution coarse = run(json, times(0.4, 97));
  json["integrator"] = {{"rtol", 1e-8}, {"atol_position", 1e-9}, {"atol_velocity", 1e-6}};
  const Solution fine = run(json, times(0.4, 97));
  double most = 0.0;
  for (std::size_t k = 0; k < fine.recorder.outputs.size(); ++k)
    most = std::max(most, apart(coarse.recorder.outputs[k].q, fine.recorder.outputs[k].q));
  EXPECT_LT(most, 1e-7);
}

TEST_P(FlexibleOutputTest, ConstraintsHoldAsWellAsPositions) {
  for (const double rtol : {1e-4, 1e-5}) {
    const Solution swung = run(swung_rod(GetParam(), rtol), times(0.25, 397));
    Residual residual = make_residual(*swung.model.system);
    for (const State& state : swung.recorder.outputs) {
      swung.model.system->evaluate(
          {state.t, state.q.data(), state.v.data(), state.a.data(), state.lambda.data()}, residual);
      double of_position = 0;
      for (const double entry : residual.position) of_position = std::max(of_position, std::abs(entry));
      EXPECT_LT(of_position, rtol) << state.t;
    }
  }
}

TEST_P(FlexibleOutputTest, LeavesTheStepsAlone) {
  const Solution few = run(swung_rod(GetParam(), 1e-4), {}),
                 many = run(swung_rod(GetParam(), 1e-4), times(0.25, 397));
  EXPECT_EQ(few.recorder.steps.size(), many.recorder.steps.size());
  EXPECT_EQ(few.end.q, many.end.q);
  EXPECT_EQ(few.end.lambda, many.end.lambda);
  EXPECT_EQ(many.recorder.outputs.back().q, many.end.q);
}

INSTANTIATE_TEST_SUITE_P(Methods, FlexibleOutputTest, testing::Values("bdf", "generalized_alpha"));

// A disc that rolls: accelerations and multipliers are what its equations ask for, and all constraints hold
// as they do at the ends of steps.
TEST(RollingOutputTest, FulfilsTheEquations) {
  const Json json = Json::parse(find_library_model("rolling_disc")->text);
  const Solution few = run(json, {}), many = run(json, times(make_model(json, "", 1).end, 997));
  EXPECT_EQ(few.recorder.steps.size(), many.recorder.steps.size());
  EXPECT_EQ(few.end.q, many.end.q);
  Residual residual = make_residual(*many.model.system);
  const auto largest = [](const std::vector<double>& x) {
    double most = 0.0;
    for (const double value : x) most = std::max(most, std::abs(value));
    return most;
  };
  for (const State& state : many.recorder.outputs) {
    many.model.system->evaluate(
        {state.t, state.q.data(), state.v.data(), state.a.data(), state.lambda.data()}, residual);
    EXPECT_LT(largest(residual.position), 1e-8) << state.t;
    EXPECT_LT(largest(residual.velocity), 1e-6) << state.t;
    EXPECT_LT(largest(residual.acceleration), 1e-4) << state.t;
    EXPECT_LT(largest(residual.force), 1e-6) << state.t;
  }
}

}  // namespace
}  // namespace mfs::dae
