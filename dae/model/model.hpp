// A model: what a JSON file (docs/models.md) says, put together. Bodies, joints, motions and forces become
// one ConstrainedSystem; beside it stands what is needed to show its motion: meshes, frames, named points.
//
//   const MultibodyModel model = read_model("bell_crank.json");
//   Integrator integrator(*model.system, model.integrator);
//   integrator.run(0.0, model.q0, model.v0, model.end, output_times(model), observer);
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "dae/fem/solid_group.hpp"
#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/frame.hpp"
#include "dae/mechanics/joints.hpp"
#include "dae/model/json_object.hpp"

namespace mfs::dae {

/// A group of elements in the system; their constraints begin at this row.
struct ModelElement {
  std::shared_ptr<const ElementGroup> group;
  int first_row = 0;
};

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
  double mass = 0.0;                    ///< kg
  Eigen::Matrix3d inertia;              ///< about the origin of its frame, in its axes, kg m^2
  ModelElement element;
};

/// A point that is looked at: `point` of `frame`, or a node of a flexible body.
struct ModelPoint {
  std::string name;
  Frame frame;                                      ///< the ground: it is a node
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< in the frame's axes, m
  int body = -1, node = -1;                         ///< of flexible_bodies
};

struct ModelJoint {
  std::string name;
  JointKind kind = JointKind::fixed;
  Attachment a, b;
  double radius = 0.0;  ///< of what rolls, m
  std::vector<ModelElement> elements;
  std::array<double, 2>
      angle_begin{};  ///< of a universal joint: of b's axis about a's, of a's about b's, rad
};

/// The coordinate that measures how b of a joint is turned about its axis against a, or has moved along it.
struct JointCoordinate {
  int number = -1;  ///< none
  bool turns = false;
};

/// A motion or a force: its elements and what they hold on to, the last as b; no sides: nodes.
struct ModelAction {
  std::string name, type;  ///< as in the file
  std::vector<ModelElement> elements;
  std::vector<Attachment> sides;
  JointCoordinate along;  ///< where it acts on that alone
};

struct MultibodyModel {
  std::string name;
  double end = 0.0;             ///< s
  int outputs = 0;              ///< evenly spaced after t = 0
  bool starts_at_rest = false;  ///< in the static equilibrium near q0
  std::vector<FlexibleBody> flexible_bodies;
  std::vector<RigidPart> rigid_bodies;
  std::vector<ModelPoint> points;
  std::vector<ModelJoint> joints;
  std::vector<ModelAction> motions, forces;
  std::vector<std::string> reactions;  ///< joints whose forces are in the overview
  std::vector<std::string> record;     ///< which quantities are recorded (quantities.hpp); none: all
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
