// Models for statics and modes.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "dae/model/model.hpp"

namespace mfs::test {

/// A bar of 2 kg, 1.2 m long, on a hinge about z at the origin, its centre at 0.6 m from there at `angle`
/// from the x axis; gravity along -y. Its moment of inertia about the hinge is 0.96.
inline dae::Json pendulum(double angle) {
  dae::Json json = dae::Json::parse(R"({
    "name": "pendulum", "end": 1, "outputs": 1, "gravity": [0, -9.81, 0],
    "bodies": {"bar": {"type": "rigid", "mass": 2, "inertia": [0.1, 0.24, 0.24]}},
    "joints": {"hinge": {"type": "revolute", "a": "ground", "b": "bar", "point": [0, 0, 0], "axis": [0, 0, 1]}},
    "forces": {}
  })");
  json["bodies"]["bar"]["position"] = {0.6 * std::cos(angle), 0.6 * std::sin(angle), 0};
  json["bodies"]["bar"]["rotation"] = {{"axis", {0, 0, 1}}, {"angle", angle}};
  return json;
}

/// Rods of 1 m and 1 kg on hinges about z, the first at the origin, each at its angle from the x axis;
/// gravity along -y.
inline dae::Json chain(const std::vector<double>& angles) {
  dae::Json json = dae::Json::parse(
      R"({"name": "chain", "end": 1, "outputs": 1, "gravity": [0, -9.81, 0], "bodies": {}, "joints": {}, "forces": {}})");
  double x = 0.0, y = 0.0;
  std::string before = "ground";
  for (std::size_t k = 0; k < angles.size(); ++k) {
    const double along_x = std::cos(angles[k]), along_y = std::sin(angles[k]);
    const std::string rod = "rod" + std::to_string(k);
    json["bodies"][rod] = {{"type", "rigid"},
                           {"mass", 1},
                           {"inertia", {0.01, 1.0 / 12, 1.0 / 12}},
                           {"position", {x + 0.5 * along_x, y + 0.5 * along_y, 0}},
                           {"rotation", {{"axis", {0, 0, 1}}, {"angle", angles[k]}}}};
    json["joints"]["hinge" + std::to_string(k)] = {
        {"type", "revolute"}, {"a", before}, {"b", rod}, {"point", {x, y, 0}}, {"axis", {0, 0, 1}}};
    x += along_x;
    y += along_y;
    before = rod;
  }
  return json;
}

/// A beam along x, from 0 to 1 m, `height` x `width`, its nodes at x = 0 held.
inline dae::Json cantilever(double height, double width, int cells) {
  dae::Json json = dae::Json::parse(R"({
    "name": "cantilever", "end": 1, "outputs": 1,
    "materials": {"steel": {"law": "st_venant_kirchhoff", "young": 2e11, "poisson": 0.3, "density": 8000}},
    "bodies": {"beam": {"type": "flexible", "material": "steel",
      "mesh": {"generator": "box", "element": "hex20", "refine": 1}}},
    "motions": {"wall": {"type": "nodes", "side": "beam:x0", "x": "0", "y": "0", "z": "0"}},
    "points": {},
    "forces": {}
  })");
  dae::Json& mesh = json["bodies"]["beam"]["mesh"];
  mesh["size"] = {1, height, width};
  mesh["divisions"] = {cells, 1, 1};
  json["bodies"]["beam"]["position"] = {0, -0.5 * height, -0.5 * width};
  return json;
}

inline int coordinate(const dae::ConstrainedSystem& system, const std::string& name) {
  for (int i = 0; i < system.coordinates(); ++i)
    if (system.coordinate_name(i) == name) return i;
  throw std::out_of_range(name);
}

}  // namespace mfs::test
