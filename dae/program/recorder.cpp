#include "dae/program/recorder.hpp"

#include <filesystem>

#include <fmt/format.h>

#include <mfs/error.hpp>

#include "dae/fem/nodal_stress.hpp"
#include "dae/program/measure.hpp"
#include "ordering/stopwatch.hpp"

namespace mfs::dae {
namespace {

// Before the tables are opened in it.
const std::string& made(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(folder) / "vtu", error);
  if (error) throw InvalidInput(folder, "cannot be made: " + error.message());
  return folder;
}

std::vector<std::string> series_columns(const MultibodyModel& model) {
  std::vector<std::string> columns{"t [s]"};
  for (const FlexibleBody& body : model.flexible_bodies) {
    columns.push_back("von_mises " + body.name + " [Pa]");
    columns.push_back("von_mises_node " + body.name);
  }
  for (const MeasuredPoint& point : model.points) columns.push_back("acceleration " + point.name + " [m/s2]");
  for (const MeasuredJoint& joint : model.joints) columns.push_back("reaction " + joint.name + " [N]");
  return columns;
}

const std::vector<std::string> kStepColumns{"t [s]",          "h [s]",      "order",    "newton",
                                            "factorizations", "rejections", "residual", "wall [s]"};

}  // namespace

Recorder::Recorder(const MultibodyModel& model, const std::string& folder, program::ProgressDisplay& display)
    : model_(model),
      folder_(made(folder)),
      display_(display),
      time_series_(folder + "/time_series.csv", series_columns(model)),
      steps_(folder + "/steps.csv", kStepColumns),
      list_(folder + "/result.pvd") {
  for (const FlexibleBody& body : model.flexible_bodies) cells_.push_back(vtk_cells(body.solid->mesh()));
}

void Recorder::step(const StepReport& step, const std::function<const State&()>& /*state*/) {
  steps_.add_row({step.t, step.h, static_cast<double>(step.order),
                  static_cast<double>(step.newton_iterations), static_cast<double>(step.factorizations),
                  static_cast<double>(step.rejections), step.residual, step.wall});
  display_.show(fmt::format("step {:<5}", step.number), step.t / model_.end);
}

void Recorder::output(const State& state) {
  const Stopwatch watch;
  std::vector<double> row{state.t};
  for (std::size_t i = 0; i < model_.flexible_bodies.size(); ++i) {
    const FlexibleBody& body = model_.flexible_bodies[i];
    const NodalStress stress = nodal_stress(*body.solid, &state.q[body.range.first]);
    row.push_back(stress.largest);
    row.push_back(stress.largest_node);
    write_flexible(state, i, stress.von_mises);
  }
  if (!model_.rigid_bodies.empty()) write_rigid(state);
  for (const MeasuredPoint& point : model_.points) row.push_back(point_acceleration(point, state).norm());
  for (const MeasuredJoint& joint : model_.joints) row.push_back(joint_force(joint, state));
  time_series_.add_row(row);
  ++outputs_;
  time_output_ += watch.seconds();
}

std::string Recorder::grid_file(const std::string& body) const {
  return fmt::format("vtu/{}_{:04}.vtu", body, outputs_);
}

void Recorder::write_flexible(const State& state, std::size_t body, const std::vector<double>& von_mises) {
  const auto& [name, solid, range] = model_.flexible_bodies[body];
  const auto part_of = [range = range](const std::vector<double>& x) {
    return std::vector<double>(x.begin() + range.first, x.begin() + range.first + range.count);
  };
  const std::vector<double> points = part_of(state.q);
  VtkField displacement{"displacement", 3, part_of(model_.q0)};
  for (std::size_t i = 0; i < points.size(); ++i) displacement.values[i] = points[i] - displacement.values[i];
  const std::string file = grid_file(name);
  write_vtu(folder_ + "/" + file, points, cells_[body],
            {displacement, {"von_mises", 1, von_mises}, {"acceleration", 3, part_of(state.a)}});
  list_.add(state.t, static_cast<int>(body), file);
}

// All rigid bodies in one file: their origins as points, lines from there to where joints attach.
void Recorder::write_rigid(const State& state) {
  std::vector<double> points;
  VtkCells cells;
  const auto add_point = [&](const Eigen::Vector3d& point) {
    points.insert(points.end(), point.begin(), point.end());
    return static_cast<std::int32_t>(points.size() / 3 - 1);
  };
  for (const RigidPart& body : model_.rigid_bodies) {
    const double* q = &state.q[body.frame.first];
    const std::int32_t origin = add_point(frame_point(q, Eigen::Vector3d::Zero()));
    cells.add(VtkCell::vertex, &origin, 1);
    for (const Eigen::Vector3d& point : body.points) {
      const std::int32_t ends[] = {origin, add_point(frame_point(q, point))};
      cells.add(VtkCell::line, ends, 2);
    }
  }
  const std::string file = grid_file("rigid.bodies");  // no body's name: those have no point
  write_vtu(folder_ + "/" + file, points, cells, {});
  list_.add(state.t, static_cast<int>(model_.flexible_bodies.size()), file);
}

}  // namespace mfs::dae
