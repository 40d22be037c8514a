// Mechanisms of thin rods, spheres and joints as model files, those of the library among them, and their
// runs.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "dae/model/model.hpp"
#include "dae/model/model_library.hpp"
#include "test/dae/integrator/recorder.hpp"

namespace mfs::dae::test {

using Eigen::Vector3d;

inline Json triple(const Vector3d& x) {
  return {x[0], x[1], x[2]};
}

/// A rod of 1 kg between two points: J across it is l^2 / 12, along it a thousandth of that of 1 m.
inline Json rod(const Vector3d& p, const Vector3d& q) {
  const Vector3d along = q - p;
  const double across = along.squaredNorm() / 12.0;
  const Eigen::AngleAxisd turn(Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitX(), along));
  return {{"type", "rigid"},
          {"mass", 1.0},
          {"inertia", {1e-3 / 12.0, across, across}},
          {"position", triple(0.5 * (p + q))},
          {"rotation", {{"axis", triple(turn.axis())}, {"angle", turn.angle()}}}};
}

inline Json joint(const std::string& type, const std::string& a, const std::string& b, const Vector3d& point,
                  const Vector3d& axis = Vector3d::UnitZ()) {
  Json json{{"type", type}, {"a", a}, {"b", b}, {"point", triple(point)}};
  if (type != "spherical" && type != "fixed") json["axis"] = triple(axis);
  return json;
}

inline Json drive(const std::string& joint, double value, double slope) {
  return {{"type", "rotation"},
          {"joint", joint},
          {"angle", {{"type", "linear"}, {"value", value}, {"slope", slope}}}};
}

inline Json mechanism(double end, int outputs, const Vector3d& gravity) {
  return {{"name", "mechanism"}, {"end", end}, {"outputs", outputs}, {"gravity", triple(gravity)}};
}

/// A model of the library, with another end or number of outputs.
inline Json of_library(const std::string& name) {
  return Json::parse(find_library_model(name)->text);
}
inline Json of_library(const std::string& name, double end, int outputs) {
  Json json = of_library(name);
  json["end"] = end;
  json["outputs"] = outputs;
  return json;
}

struct MotionRun {
  MultibodyModel model;
  IntegrationReport report;
  std::vector<State> outputs;

  /// The 7 coordinates of a rigid body are at + 0 ... 6.
  int at(const std::string& body) const {
    for (const RigidPart& part : model.rigid_bodies)
      if (part.name == body) return part.frame.first;
    return -1;
  }
  Vector3d position(const State& state, const std::string& body) const {
    return Eigen::Map<const Vector3d>(&state.q[at(body)]);
  }
  /// Multiplier of equation `k` (0-based) of a joint or motion.
  double multiplier(const State& state, const std::string& owner, int k) const {
    int row = 0;
    while (model.system->constraint_owner(row) != owner) ++row;
    return state.lambda[row + k];
  }
};

inline MotionRun run(const Json& json) {
  MotionRun result;
  result.model = make_model(json, "", 1);
  Integrator integrator(*result.model.system, result.model.integrator);
  Recorder recorder;
  integrator.run(0.0, result.model.q0, result.model.v0, result.model.end, output_times(result.model),
                 recorder);
  result.report = integrator.report();
  result.outputs = std::move(recorder.outputs);
  return result;
}

inline MotionRun run(Json json, double tolerance) {
  for (const char* key : {"rtol", "atol_position", "atol_velocity"}) json["integrator"][key] = tolerance;
  return run(json);
}

/// y' = f(t, y) by the classical Runge-Kutta method with equal steps.
template <class Y, class F>
Y runge_kutta(Y y, double t, double end, int steps, const F& f) {
  const double h = (end - t) / steps;
  for (int i = 0; i < steps; ++i, t += h) {
    const Y a = f(t, y), b = f(t + h / 2, Y(y + h / 2 * a)), c = f(t + h / 2, Y(y + h / 2 * b)),
            d = f(t + h, Y(y + h * c));
    y += h / 6 * (a + 2 * b + 2 * c + d);
  }
  return y;
}

}  // namespace mfs::dae::test
