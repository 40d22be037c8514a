// Dry friction as steep as the tolerance where flexible bodies are in the model: 3 kg on a slide, on a spring
// of 30 N/m, over a belt of 0.5 m/s that pulls by 15 to 9 N. It sticks to the belt and slips four times in 10
// s.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "test/dae/model/mechanism.hpp"

namespace mfs::dae::test {
namespace {

/// Of one body: where it is at 1, 2, ..., 10 s. By SciPy 1.17, solve_ivp Radau, rtol 1e-11, steps of at most
/// 1 ms.
const std::vector<double> kTravel{0.468707, 0.278527, 0.251391, 0.611177, 0.034074,
                                  0.533780, 0.156562, 0.316750, 0.547059, 0.099432};

Json on_a_belt() {
  Json json = mechanism(10, 10, {0, 0, 0});
  json["materials"]["steel"] = {
      {"law", "st_venant_kirchhoff"}, {"young", 2e11}, {"poisson", 0.3}, {"density", 3000}};
  json["forces"]["belt"] = {{"type", "actuator"},
                            {"joint", "guide"},
                            {"force",
                             "-30 * guide.travel - 15 * tanh((guide.travel_rate - 0.5) / 1e-5) * "
                             "(0.6 + 0.4 * exp(-abs(guide.travel_rate - 0.5) / 0.5))"}};
  return json;
}

Json box(const Vector3d& size, const std::vector<int>& divisions, const Vector3d& at) {
  Json json{{"type", "flexible"}, {"material", "steel"}, {"position", triple(at)}};
  json["mesh"] = {{"generator", "box"}, {"element", "hex8"}, {"refine", 1}};
  json["mesh"]["size"] = triple(size);
  json["mesh"]["divisions"] = divisions;
  return json;
}

double largest_error(Json json, const std::string& method, double rtol) {
  json["integrator"] = {{"method", method}, {"rtol", rtol}};
  const MotionRun result = run(json);
  int travel = 0;
  while (result.model.system->coordinate_name(travel) != "quantity guide.travel.value") ++travel;
  double error = 0.0;
  for (std::size_t k = 0; k < kTravel.size(); ++k)
    error = std::max(
        error, std::abs(result.outputs[result.outputs.size() - kTravel.size() + k].q[travel] - kTravel[k]));
  return error;
}

/// A beam that has nothing to do with it made the body stick for up to a fifth of a second longer: forces of
/// stiff bodies, and residuals of all coordinates together, do not tell that friction is overcome.
TEST(Friction, HoldsNoMoreThanItCanBesideAFlexibleBody) {
  Json json = on_a_belt();
  json["bodies"]["body"] = {{"type", "rigid"}, {"mass", 3}, {"inertia", {1, 1, 1}}};
  json["bodies"]["beam"] = box({1, 0.02, 0.02}, {8, 1, 1}, {0, 3, 0});
  json["bodies"]["beam"]["damping"]["beta"] = 1e-4;
  json["joints"]["guide"] = joint("translational", "ground", "body", {0, 0, 0}, {1, 0, 0});
  json["joints"]["clamp"] = joint("fixed", "ground", "beam:x0", {0, 3.01, 0.01});
  for (const double rtol : {1e-4, 1e-5})
    for (const char* method : {"bdf", "generalized_alpha"})
      EXPECT_LT(largest_error(json, method, rtol), 400 * rtol + 0.01) << method << " " << rtol;
}

/// The same of a body that is flexible itself.
TEST(Friction, HoldsNoMoreOfAFlexibleBodyThanItCan) {
  Json json = on_a_belt();
  json["bodies"]["body"] = box({0.1, 0.1, 0.1}, {1, 1, 1}, {0, 0, 0});
  json["joints"]["guide"] = joint("translational", "ground", "body:x0", {0, 0.05, 0.05}, {1, 0, 0});
  for (const double rtol : {3e-5, 1e-5})
    for (const char* method : {"bdf", "generalized_alpha"})
      EXPECT_LT(largest_error(json, method, rtol), 400 * rtol + 0.01) << method << " " << rtol;
}

}  // namespace
}  // namespace mfs::dae::test
