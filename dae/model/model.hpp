// A model: what a JSON file (docs/models.md) says, put together. Bodies, joints, motions and forces become
// one ConstrainedSystem; beside it stands what is needed to show its motion: meshes, frames, named points.
//
//   const MultibodyModel model = read_model("bell_crank.json");
//   Integrator integrator(*model.system, model.integrator);
//   integrator.run(0.0, model.q0, model.v0, model.end, output_times(model), observer);
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "dae/fem/solid_group.hpp"
#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/frame.hpp"
#include "dae/model/json_object.hpp"

namespace mfs::dae {

struct FlexibleBody {
  std::string name;
  std::shared_ptr<const SolidGroup> solid;
  CoordinateRange range;  ///< three coordinates per node
};

/// A frame with mass, and the points fixed in it to which joints and forces attach: its picture.
struct RigidPart {
  std::string name;
  Frame frame;
  std::vector<Eigen::Vector3d> points;  ///< in its own axes, m
};

/// A point whose motion is recorded: `point` of the frame at coordinate `first`, or the node that begins
/// there.
struct MeasuredPoint {
  std::string name;
  int first = 0;
  bool on_frame = false;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< in the frame's axes, m
};

/// A joint whose force is recorded: the multipliers of these rows are its components, N.
struct MeasuredJoint {
  std::string name;
  int first_row = 0, rows = 0;
};

struct MultibodyModel {
  std::string name;
  double end = 0.0;             ///< s
  int outputs = 0;              ///< evenly spaced after t = 0
  bool starts_at_rest = false;  ///< in the static equilibrium near q0
  std::vector<FlexibleBody> flexible_bodies;
  std::vector<RigidPart> rigid_bodies;
  std::vector<MeasuredPoint> points;
  std::vector<MeasuredJoint> joints;
  IntegratorOptions integrator;

  std::unique_ptr<const ConstrainedSystem> system;
  std::vector<double> q0, v0;  ///< as the file has them; the integrator makes them consistent
};

/// `folder`: what paths in the file start from. `threads`: of the assembly and the solver; 0: all. `backend`:
/// of both. Throws InvalidInput with the place in the file and the name of the body or joint, and what
/// MultibodyBuilder::build throws.
MultibodyModel make_model(const Json& json, const std::string& folder, int threads = 0,
                          Backend backend = Backend::openmp);

/// Sets "refine" of every mesh that a generator makes. Throws InvalidInput where there is none.
void refine_meshes(Json& json, int refine);

/// 0 and the times of the outputs, s.
std::vector<double> output_times(const MultibodyModel& model);

}  // namespace mfs::dae
