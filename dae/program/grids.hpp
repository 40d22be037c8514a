// The pictures of a model for ParaView: a grid for each flexible body, and one for all rigid bodies and
// joints. A rigid body is the box with its mass and inertia, with lines from its centre of mass to where
// joints and forces attach; a joint is a vertex where it is, and lines along its axes, or the rim of what
// rolls.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dae/model/quantities.hpp"
#include "dae/output/vtk_files.hpp"

namespace mfs::dae {

class Grids {
 public:
  /// `model` has to live as long.
  explicit Grids(const MultibodyModel& model);

  /// Of flexible_bodies[body]: displacement, velocity, acceleration, von_mises, stress at the nodes.
  VtkGrid& flexible(std::size_t body, Measurement& measurement);
  bool has_rigid() const { return !rigid_.cells.kind.empty(); }
  /// Of the cells: the numbers of body and joint (-1: none) as in the arrays "bodies" and "joints" of names;
  /// orientation, velocity, angular_velocity of the body.
  VtkGrid& rigid(const State& state);

 private:
  void add_body(std::size_t body);
  void add_joint(std::size_t joint, double half_axis);
  void add_rims(const ModelJoint& joint, int number);
  void add_cell(VtkCell kind, const Frame& frame, const std::vector<Eigen::Vector3d>& points, int body,
                int joint);

  struct FramePoint {
    Frame frame;
    Eigen::Vector3d arm;  // in its axes
  };
  const MultibodyModel& model_;
  std::vector<VtkGrid> flexible_;
  VtkGrid rigid_;
  std::vector<FramePoint> rigid_points_;  // of rigid_
};

/// Edges (m) and axes (columns) of the box of even density with this mass and inertia; none thinner than a
/// hundredth of the longest.
struct InertiaBox {
  Eigen::Vector3d edges;
  Eigen::Matrix3d axes;
};
InertiaBox inertia_box(double mass, const Eigen::Matrix3d& inertia);

}  // namespace mfs::dae
