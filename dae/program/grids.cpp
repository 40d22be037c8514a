#include "dae/program/grids.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

namespace mfs::dae {
namespace {

using Eigen::Vector3d;

// VTK's order of the corners of a hexahedron.
constexpr int kCorners[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};

std::vector<double> part(const std::vector<double>& x, const CoordinateRange& range) {
  return {x.begin() + range.first, x.begin() + range.first + range.count};
}

// How far it reaches when time begins, m.
double extent(const MultibodyModel& model) {
  Vector3d low = Vector3d::Constant(HUGE_VAL), high = -low;
  const auto take = [&](const double* x) {
    low = low.cwiseMin(Eigen::Map<const Vector3d>(x));
    high = high.cwiseMax(Eigen::Map<const Vector3d>(x));
  };
  State begin;
  begin.q = model.q0;
  begin.v = begin.a = std::vector<double>(model.q0.size());
  for (const RigidPart& body : model.rigid_bodies) {
    const FrameMotion frame = frame_motion(body.frame, begin);
    take(frame.position.data());
    for (const Vector3d& arm : body.points) take(point_motion(frame, arm).position.data());
  }
  for (const FlexibleBody& body : model.flexible_bodies)
    for (int i = body.range.first; i < body.range.first + body.range.count; i += 3)
      take(&model.q0[static_cast<std::size_t>(i)]);
  return (high - low).norm();
}

std::vector<Vector3d> corners(const InertiaBox& box) {
  std::vector<Vector3d> points;
  for (const auto& corner : kCorners)
    points.emplace_back(
        box.axes * (0.5 * box.edges.array() * Vector3d(corner[0], corner[1], corner[2]).array()).matrix());
  return points;
}

}  // namespace

InertiaBox inertia_box(double mass, const Eigen::Matrix3d& inertia) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(inertia);
  const Vector3d j = principal.eigenvalues();
  InertiaBox box;
  box.axes = principal.eigenvectors();
  if (box.axes.determinant() < 0) box.axes.col(2) *= -1;
  for (int k = 0; k < 3; ++k) box.edges[k] = std::sqrt(std::max(0.0, 6 / mass * (j.sum() - 2 * j[k])));
  box.edges = box.edges.cwiseMax(0.01 * box.edges.maxCoeff());
  return box;
}

Grids::Grids(const MultibodyModel& model) : model_(model) {
  for (const FlexibleBody& body : model.flexible_bodies) {
    flexible_.emplace_back();
    flexible_.back().cells = vtk_cells(body.solid->mesh());
  }
  rigid_.cell_ids = {{"body", {}}, {"joint", {}}};
  rigid_.names = {{"bodies", {}}, {"joints", {}}};
  for (std::size_t i = 0; i < model.rigid_bodies.size(); ++i) add_body(i);
  constexpr double kAxis = 0.04;  // half an axis, in parts of the model
  for (std::size_t i = 0; i < model.joints.size(); ++i) add_joint(i, kAxis * extent(model));
}

void Grids::add_cell(VtkCell kind, const Frame& frame, const std::vector<Vector3d>& points, int body,
                     int joint) {
  std::vector<std::int32_t> numbers;
  for (const Vector3d& arm : points) {
    numbers.push_back(static_cast<std::int32_t>(rigid_points_.size()));
    rigid_points_.push_back({frame, arm});
  }
  rigid_.cells.add(kind, numbers.data(), static_cast<int>(numbers.size()));
  rigid_.cell_ids[0].values.push_back(body);
  rigid_.cell_ids[1].values.push_back(joint);
}

void Grids::add_body(std::size_t i) {
  const RigidPart& body = model_.rigid_bodies[i];
  const auto number = static_cast<int>(i);
  rigid_.names[0].values.push_back(body.name);
  add_cell(VtkCell::hexahedron, body.frame, corners(inertia_box(body.mass, body.inertia)), number, -1);
  add_cell(VtkCell::vertex, body.frame, {Vector3d::Zero()}, number, -1);
  for (const Vector3d& point : body.points)
    add_cell(VtkCell::line, body.frame, {Vector3d::Zero(), point}, number, -1);
}

void Grids::add_joint(std::size_t i, double half_axis) {
  const ModelJoint& joint = model_.joints[i];
  const auto number = static_cast<int>(i);
  rigid_.names[1].values.push_back(joint.name);
  add_cell(VtkCell::vertex, joint.b.frame, {joint.b.point}, -1, number);
  const auto add_axis = [&](const Attachment& side) {
    const Vector3d half = half_axis * side.axes.col(2);
    add_cell(VtkCell::line, side.frame, {side.point - half, side.point + half}, -1, number);
  };
  if (rolls(joint.kind)) return add_rims(joint, number);
  if (joint.kind != JointKind::fixed && joint.kind != JointKind::spherical) add_axis(joint.a);
  if (joint.kind == JointKind::universal) add_axis(joint.b);
}

/// A wheel's circle, a ball's three, fixed in b.
void Grids::add_rims(const ModelJoint& joint, int number) {
  constexpr int kSides = 24;
  for (int normal = roller_of(joint.kind) == Roller::wheel ? 2 : 0; normal < 3; ++normal) {
    std::vector<Vector3d> rim;
    for (int k = 0; k <= kSides; ++k) {
      const double angle = 2 * std::acos(-1.0) * k / kSides;
      rim.push_back(joint.b.point + joint.radius * (std::cos(angle) * joint.b.axes.col((normal + 1) % 3) +
                                                    std::sin(angle) * joint.b.axes.col((normal + 2) % 3)));
      if (k > 0) add_cell(VtkCell::line, joint.b.frame, {rim[rim.size() - 2], rim.back()}, -1, number);
    }
  }
}

VtkGrid& Grids::flexible(std::size_t i, Measurement& measurement) {
  const CoordinateRange& range = model_.flexible_bodies[i].range;
  const State& state = measurement.state();
  VtkGrid& grid = flexible_[i];
  grid.points = part(state.q, range);
  VtkField displacement{"displacement", 3, part(model_.q0, range)}, stress{"stress", 6, {}};
  for (std::size_t k = 0; k < grid.points.size(); ++k)
    displacement.values[k] = grid.points[k] - displacement.values[k];
  // VTK's order of a symmetric tensor is this one: xx, yy, zz, xy, yz, xz.
  for (const std::array<double, 6>& tensor : measurement.stress(i).cauchy)
    stress.values.insert(stress.values.end(), tensor.begin(), tensor.end());
  grid.point_fields = {std::move(displacement),
                       {"velocity", 3, part(state.v, range)},
                       {"acceleration", 3, part(state.a, range)},
                       {"von_mises", 1, measurement.stress(i).von_mises},
                       std::move(stress)};
  return grid;
}

VtkGrid& Grids::rigid(const State& state) {
  rigid_.points.clear();
  for (const auto& [frame, arm] : rigid_points_) {
    const Vector3d point = point_motion(frame_motion(frame, state), arm).position;
    rigid_.points.insert(rigid_.points.end(), point.begin(), point.end());
  }
  VtkField orientation{"orientation", 4, {}}, velocity{"velocity", 3, {}}, angular{"angular_velocity", 3, {}};
  for (const std::int32_t body : rigid_.cell_ids[0].values) {
    const Frame frame = body < 0 ? Frame() : model_.rigid_bodies[static_cast<std::size_t>(body)].frame;
    const FrameMotion motion = frame_motion(frame, state);
    const Eigen::Vector4d p = quaternion(motion.rotation);
    orientation.values.insert(orientation.values.end(), p.begin(), p.end());
    velocity.values.insert(velocity.values.end(), motion.velocity.begin(), motion.velocity.end());
    angular.values.insert(angular.values.end(), motion.angular_velocity.begin(),
                          motion.angular_velocity.end());
  }
  rigid_.cell_fields = {std::move(orientation), std::move(velocity), std::move(angular)};
  return rigid_;
}

}  // namespace mfs::dae
