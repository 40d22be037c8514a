// A slider crank with a rod of solid elements beside the same one with a beam (slider_crank.hpp), whose
// equations are tested against the published solution. Here the crank turns from rest to rest, so that little
// of what the rod does is free vibration, and so slowly that bending does not shorten it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "dae/model/model.hpp"
#include "test/dae/integrator/recorder.hpp"
#include "test/dae/integrator/slider_crank.hpp"

namespace mfs::dae {
namespace {

using test::SliderCrank;

constexpr double kTurn = 8.0, kViscosity = 1e-4;

Json model_file(const std::string& element, int cells) {
  Json json = Json::parse(R"({
    "name": "slider_crank", "end": 0.25, "outputs": 100,
    "materials": {"steel": {"law": "st_venant_kirchhoff", "young": 2e11, "poisson": 0.3, "density": 7870}},
    "bodies": {
      "crank": {"type": "rigid", "mass": 0.36, "inertia": [0.001364, 0.001364, 0.002727]},
      "rod": {
        "type": "flexible", "material": "steel", "damping": {"beta": 1e-4}, "position": [0.15, -0.004, -0.004],
        "mesh": {"generator": "box", "refine": 1, "size": [0.3, 0.008, 0.008]}
      },
      "slider": {"type": "rigid", "mass": 0.075552, "inertia": [1e-5, 1e-5, 1e-5], "position": [0.45, 0, 0]}
    },
    "joints": {
      "bearing": {"type": "revolute", "a": "ground", "b": "crank", "point": [0, 0, 0], "axis": [0, 0, 1]},
      "crank_pin": {"type": "revolute", "a": "crank", "b": "rod:x0", "point": [0.15, 0, 0], "axis": [0, 0, 1]},
      "slider_pin": {"type": "cylindrical", "a": "slider", "b": "rod:x1", "point": [0.45, 0, 0], "axis": [0, 0, 1]},
      "guide": {"type": "translational", "a": "ground", "b": "slider", "point": [0.45, 0, 0], "axis": [1, 0, 0]}
    },
    "motions": {
      "drive": {
        "type": "rotation", "joint": "bearing",
        "angle": {"type": "smooth_step", "begin": 0, "end": 0.25, "after": 8}
      }
    },
    "integrator": {"rtol": 1e-7, "atol_position": 1e-9, "atol_velocity": 1e-4}
  })");
  json["bodies"]["rod"]["mesh"]["element"] = element;
  json["bodies"]["rod"]["mesh"]["divisions"] = {cells, 1, 1};
  return json;
}

SliderCrank beam(double end) {
  SliderCrank beam;
  beam.duration = end;
  beam.turn = kTurn;
  beam.viscosity = kViscosity;
  return beam;
}

/// Mean of the nodes in the middle of the rod, in the plane of the mechanism.
Eigen::Vector2d middle(const FlexibleBody& rod, const State& state) {
  const Mesh& mesh = rod.solid->mesh();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    if (std::abs(mesh.nodes[i][0] - 0.5 * SliderCrank::l2) > 1e-9) continue;
    sum += Eigen::Map<const Eigen::Vector2d>(&state.q[rod.range.first + 3 * i]);
    ++count;
  }
  return sum / count;
}

/// Of the middle of the rod from the line between its pins, m.
std::vector<double> deflections(const MultibodyModel& model) {
  Integrator integrator(*model.system, model.integrator);
  test::Recorder recorder;
  integrator.run(0.0, model.q0, model.v0, model.end, output_times(model), recorder);
  const auto slider = std::find_if(model.rigid_bodies.begin(), model.rigid_bodies.end(),
                                   [](const RigidPart& part) { return part.name == "slider"; });
  std::vector<double> result;
  for (const State& state : recorder.outputs) {
    const double angle = beam(model.end).angle(state.t);
    const Eigen::Vector2d pin = SliderCrank::l1 * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d along =
        (Eigen::Map<const Eigen::Vector2d>(&state.q[slider->frame.first]) - pin).normalized();
    const Eigen::Vector2d from_pin = middle(model.flexible_bodies.front(), state) - pin;
    result.push_back(along.x() * from_pin.y() - along.y() * from_pin.x());
  }
  return result;
}

std::vector<double> beam_deflections(const MultibodyModel& model) {
  const test::DenseSystem<SliderCrank> system(beam(model.end));
  Integrator integrator(system, model.integrator);
  test::Recorder recorder;
  const double length = SliderCrank::l1 + SliderCrank::l2;
  integrator.run(0.0, {0, 0, length, 0, 0, 0, 0}, std::vector<double>(7, 0.0), model.end, output_times(model),
                 recorder);
  std::vector<double> result;
  for (const State& state : recorder.outputs) result.push_back(state.q[3]);
  return result;
}

/// Largest difference, over the largest value of b.
double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0.0, of_b = 0.0;
  for (std::size_t i = 0; i < b.size(); ++i) {
    most = std::max(most, std::abs(a[i] - b[i]));
    of_b = std::max(of_b, std::abs(b[i]));
  }
  return most / of_b;
}

// Of the beam, a third sine would be 0.4 %, shear 0.2 %, and what tension does to bending 0.7 %.
TEST(FlexibleSliderCrank, BendsAsABeamWhateverItsElements) {
  const auto model = [](const char* element, int cells) {
    return make_model(model_file(element, cells), "", 1, Backend::serial);
  };
  const MultibodyModel fine = model("hex20", 16);
  const std::vector<double> converged = deflections(fine), expected = beam_deflections(fine);
  ASSERT_EQ(converged.size(), 101U);
  ASSERT_EQ(expected.size(), 101U);
  EXPECT_LT(difference(converged, expected), 0.015);
  EXPECT_LT(difference(deflections(model("hex20", 8)), converged), 0.01);
  EXPECT_LT(difference(deflections(model("hex8", 32)), converged), 0.002);
  EXPECT_LT(difference(deflections(model("tet10", 16)), converged), 0.002);
}

}  // namespace
}  // namespace mfs::dae
