#include "dae/program/result_files.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include <mfs/error.hpp>
#include <mfs/threads.hpp>

#include "dae/program/alignment.hpp"

namespace mfs::dae {
namespace {

/// Columns of time_series.csv beside the overview; spreadsheets end at some thousand.
constexpr std::size_t kMostColumns = 1000;

// Before the tables are opened in it. They are written over; other files of an earlier run would stay.
const std::string& made(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(folder) / "vtu", error);
  if (error) throw InvalidInput(folder, "cannot be made: " + error.message());
  remove_pvd(folder + "/result.pvd");
  for (const char* picture : {"time_series.png", "steps.png", "deformed.png"})
    remove_file(folder + "/" + picture);
  return folder;
}

std::size_t numbers_of(const std::vector<Quantity>& chosen) {
  std::size_t count = 0;
  for (const Quantity& quantity : chosen) count += quantity.size();
  return count;
}

std::vector<std::string> series_columns(const MultibodyModel& model, const std::vector<Quantity>& chosen,
                                        bool all) {
  std::vector<std::string> columns{"t [s]"};
  for (const FlexibleBody& body : model.flexible_bodies) {
    columns.push_back("von_mises " + body.name + " [Pa]");
    columns.push_back("von_mises_node " + body.name);
  }
  for (const ModelPoint& point : model.points) columns.push_back("acceleration " + point.name + " [m/s2]");
  for (const std::string& joint : model.reactions) columns.push_back("reaction " + joint + " [N]");
  if (!all) return columns;
  for (const Quantity& quantity : chosen) {
    const std::string unit = quantity.unit.empty() ? "" : " [" + quantity.unit + "]";
    if (quantity.components.empty()) columns.push_back(quantity.path() + unit);
    for (const std::string& component : quantity.components)
      columns.push_back(quantity.path() + "." + component + unit);
  }
  return columns;
}

std::vector<NpyField> fields(const std::vector<Quantity>& chosen) {
  std::vector<NpyField> fields{{"t", {}}};
  for (const Quantity& quantity : chosen) {
    fields.push_back({quantity.path(), {}});
    if (!quantity.components.empty()) fields.back().shape = {static_cast<int>(quantity.size())};
  }
  return fields;
}

const std::vector<std::string> kStepColumns{"t [s]",          "h [s]",      "order",    "newton",
                                            "factorizations", "rejections", "residual", "wall [s]"};

/// The largest of some changes, and whose it is.
struct Change {
  double size = 0;
  std::string body;

  void take(double candidate, const std::string& name) {
    if (!(candidate > size)) return;
    size = candidate;
    body = name;
  }
  std::string text(const char* unit) const { return fmt::format("{:.3g} {} (body {})", size, unit, body); }
};

std::string note(const char* what, const Change& length, const char* unit, const Change& angle,
                 const char* angle_unit) {
  constexpr double kRounding = 1e-5;  // well above what constraints may leave by default
  std::string sizes;
  if (length.size > kRounding) sizes = length.text(unit);
  if (angle.size > kRounding) sizes += (sizes.empty() ? "" : " and ") + angle.text(angle_unit);
  if (sizes.empty()) return "";
  return fmt::format("initial {} are corrected by up to {}, so that all constraints hold", what, sizes);
}

}  // namespace

std::vector<std::string> correction_notes(const MultibodyModel& model, const State& begin) {
  State given = begin;
  given.q = model.q0;
  given.v = model.v0;
  Change place, turn, velocity, spin;
  for (const RigidPart& body : model.rigid_bodies) {
    const FrameMotion is = frame_motion(body.frame, begin), was = frame_motion(body.frame, given);
    place.take((is.position - was.position).norm(), body.name);
    turn.take(Eigen::AngleAxisd(is.rotation * was.rotation.transpose()).angle(), body.name);
    velocity.take((is.velocity - was.velocity).norm(), body.name);
    spin.take((is.angular_velocity - was.angular_velocity).norm(), body.name);
  }
  for (const FlexibleBody& body : model.flexible_bodies)
    for (int i = body.range.first; i < body.range.first + body.range.count; i += 3) {
      const auto apart = [i](const std::vector<double>& x, const std::vector<double>& y) {
        return (Eigen::Map<const Eigen::Vector3d>(&x[static_cast<std::size_t>(i)]) -
                Eigen::Map<const Eigen::Vector3d>(&y[static_cast<std::size_t>(i)]))
            .norm();
      };
      place.take(apart(begin.q, given.q), body.name);
      velocity.take(apart(begin.v, given.v), body.name);
    }
  std::vector<std::string> notes{note("positions", place, "m", turn, "rad"),
                                 note("velocities", velocity, "m/s", spin, "rad/s")};
  notes.erase(std::remove(notes.begin(), notes.end(), ""), notes.end());
  return notes;
}

ResultFiles::ResultFiles(const MultibodyModel& model, const std::string& folder, int threads)
    : model_(model),
      folder_(made(folder)),
      threads_(threads > 0 ? threads : default_threads()),
      chosen_(chosen_quantities(model)),
      along_steps_(
          std::any_of(chosen_.begin(), chosen_.end(), [](const Quantity& q) { return q.along_steps; })),
      all_in_series_(numbers_of(chosen_) <= kMostColumns),
      time_series_(folder + "/time_series.csv", series_columns(model, chosen_, all_in_series_)),
      steps_(folder + "/steps.csv", kStepColumns),
      results_(folder + "/results.npy", fields(chosen_)),
      list_(folder + "/result.pvd"),
      account_(model, along_steps_) {
  if (!all_in_series_)
    notes_.push_back(
        fmt::format("time_series.csv has the overview alone; all {} numbers of an output are in results.npy",
                    numbers_of(chosen_)));
}

void ResultFiles::add_step(const StepReport& step, const State& state) {
  steps_.add_row({step.t, step.h, static_cast<double>(step.order),
                  static_cast<double>(step.newton_iterations), static_cast<double>(step.factorizations),
                  static_cast<double>(step.rejections), step.residual, step.wall});
  if (along_steps_) account_.follow(state);
}

void ResultFiles::look_at(const State& begin, const State& state) {
  for (std::string& text : correction_notes(model_, begin)) notes_.push_back(std::move(text));
  for (std::string& text : alignment_notes(model_, state.q)) notes_.push_back(std::move(text));
}

std::function<void()> ResultFiles::add_output(const std::shared_ptr<const State>& state) {
  const auto measurement = std::make_shared<Measurement>(model_, *state, account_, threads_);
  add_row(*measurement);
  // Its rows have taken all that the pictures show and another output would change.
  return [this, state, measurement, output = outputs_++] { draw(output, *measurement); };
}

std::unique_ptr<Grids> ResultFiles::take_grids() {
  {
    const std::lock_guard<std::mutex> lock(pictures_);
    if (!grids_.empty()) {
      std::unique_ptr<Grids> grids = std::move(grids_.back());
      grids_.pop_back();
      return grids;
    }
  }
  return std::make_unique<Grids>(model_);
}

void ResultFiles::draw(int output, Measurement& measurement) {
  std::unique_ptr<Grids> grids = take_grids();
  std::vector<Picture> pictures;
  const auto write = [&](const std::string& name, const VtkGrid& grid) {
    const std::string file = fmt::format("vtu/{}_{:04}.vtu", name, output);
    write_vtu(folder_ + "/" + file, grid);
    pictures.push_back({measurement.state().t, static_cast<int>(pictures.size()), file});
  };
  for (std::size_t i = 0; i < model_.flexible_bodies.size(); ++i)
    write(model_.flexible_bodies[i].name, grids->flexible(i, measurement));
  // No body has that name: those have no point.
  if (grids->has_rigid()) write("rigid.bodies", grids->rigid(measurement.state()));
  const std::lock_guard<std::mutex> lock(pictures_);
  grids_.push_back(std::move(grids));
  not_listed_[output] = std::move(pictures);
  for (auto next = not_listed_.find(listed_); next != not_listed_.end(); next = not_listed_.find(++listed_)) {
    for (const Picture& picture : next->second) list_.add(picture.t, picture.part, picture.file);
    not_listed_.erase(next);
  }
}

std::vector<double> ResultFiles::overview(Measurement& measurement) const {
  const State& state = measurement.state();
  std::vector<double> row{state.t};
  for (std::size_t i = 0; i < model_.flexible_bodies.size(); ++i) {
    row.push_back(measurement.stress(i).largest);
    row.push_back(measurement.stress(i).largest_node);
  }
  for (const ModelPoint& point : model_.points)
    row.push_back(motion_of(model_, point, state).acceleration.norm());
  for (const std::string& name : model_.reactions) {
    const auto joint = std::find_if(model_.joints.begin(), model_.joints.end(),
                                    [&](const ModelJoint& candidate) { return candidate.name == name; });
    row.push_back(wrench_on(joint->b, joint->a, joint->elements, state).force.norm());
  }
  return row;
}

void ResultFiles::add_row(Measurement& measurement) {
  std::vector<double> record(1 + numbers_of(chosen_)), row = overview(measurement);
  record[0] = measurement.state().t;
  double* to = &record[1];
  for (const Quantity& quantity : chosen_) {
    quantity.measure(measurement, to);
    to += quantity.size();
  }
  results_.add_row(record);
  if (all_in_series_) row.insert(row.end(), record.begin() + 1, record.end());
  time_series_.add_row(row);
}

}  // namespace mfs::dae
