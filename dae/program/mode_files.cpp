#include "dae/program/mode_files.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <filesystem>

#include <fmt/format.h>

#include <mfs/error.hpp>
#include <mfs/matrix_market.hpp>

#include "dae/output/csv_table.hpp"
#include "dae/output/vtk_files.hpp"

namespace mfs::dae {
namespace {

constexpr int kMoments = 16;
constexpr double kLargest = 0.1;  // displacement, of what the bodies span
const double kPi = std::acos(-1.0);

/// All bodies as one grid: meshes, and rigid bodies as lines from their origin to where joints attach.
class Picture {
 public:
  explicit Picture(const MultibodyModel& model) : model_(model) {
    std::int32_t first = 0;
    for (const FlexibleBody& body : model.flexible_bodies) {
      const VtkCells cells = vtk_cells(body.solid->mesh());
      std::size_t begin = 0;
      for (std::size_t c = 0; c < cells.kind.size(); ++c) {
        std::vector<std::int32_t> points;
        for (std::size_t k = begin; k < static_cast<std::size_t>(cells.end[c]); ++k)
          points.push_back(first + cells.connectivity[k]);
        begin = static_cast<std::size_t>(cells.end[c]);
        cells_.add(cells.kind[c], points.data(), static_cast<int>(points.size()));
      }
      first += body.range.count / 3;
    }
    for (const RigidPart& body : model.rigid_bodies) {
      const std::int32_t origin = first++;
      cells_.add(VtkCell::vertex, &origin, 1);
      for (std::size_t k = 0; k < body.points.size(); ++k) {
        const std::int32_t ends[] = {origin, first++};
        cells_.add(VtkCell::line, ends, 2);
      }
    }
  }

  const VtkCells& cells() const { return cells_; }
  std::vector<double> points(const std::vector<double>& q) const {
    std::vector<double> points;
    for (const FlexibleBody& body : model_.flexible_bodies)
      points.insert(points.end(), q.begin() + body.range.first,
                    q.begin() + body.range.first + body.range.count);
    for (const RigidPart& body : model_.rigid_bodies) {
      const double* const frame = &q[static_cast<std::size_t>(body.frame.first)];
      const Eigen::Map<const Eigen::Vector3d> origin(frame);
      // A mode is a small change, drawn large.
      const Eigen::Quaterniond turn = Eigen::Quaterniond(frame[3], frame[4], frame[5], frame[6]).normalized();
      const auto add = [&](const Eigen::Vector3d& point) {
        const Eigen::Vector3d place = origin + turn * point;
        points.insert(points.end(), place.begin(), place.end());
      };
      add(Eigen::Vector3d::Zero());
      for (const Eigen::Vector3d& point : body.points) add(point);
    }
    return points;
  }

 private:
  const MultibodyModel& model_;
  VtkCells cells_;
};

std::vector<double> difference(std::vector<double> x, const std::vector<double>& y) {
  for (std::size_t i = 0; i < x.size(); ++i) x[i] -= y[i];
  return x;
}

double largest(const std::vector<double>& displacement) {
  double most = 0.0;
  for (std::size_t i = 0; i + 2 < displacement.size(); i += 3)
    most = std::max(most, std::hypot(displacement[i], displacement[i + 1], displacement[i + 2]));
  return most;
}

/// Of the box around all points, its longest edge; 1 of a single point.
double span(const std::vector<double>& points) {
  double longest = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (std::size_t i = axis; i < points.size(); i += 3) {
      low = std::min(low, points[i]);
      high = std::max(high, points[i]);
    }
    longest = std::max(longest, high - low);
  }
  return longest > 0 ? longest : 1.0;
}

std::vector<double> moved(const State& state, const Mode& mode, double amplitude, double phase) {
  std::vector<double> q = state.q;
  const std::complex<double> turn = std::polar(amplitude, phase);
  for (std::size_t i = 0; i < q.size(); ++i) q[i] += (turn * mode.x[i]).real();
  return q;
}

std::string list_of(int mode, const std::string& folder) {
  return folder + fmt::format("/mode_{:03}.pvd", mode);
}

/// What an earlier list of more modes would leave.
void remove_earlier(const std::string& folder) {
  for (int number = 1; std::filesystem::exists(list_of(number, folder)); ++number)
    remove_pvd(list_of(number, folder));
  remove_file(folder + "/modes.png");
}

void write_shape(const Picture& picture, const State& state, const Mode& mode, int number,
                 const std::string& folder) {
  const std::vector<double> rest = picture.points(state.q);
  // What a small amplitude moves tells what a large one has to be.
  constexpr double kSmall = 1e-4;
  double reach = 0.0;
  for (const double phase : {0.0, 0.5 * kPi})
    reach = std::max(reach, largest(difference(picture.points(moved(state, mode, kSmall, phase)), rest)));
  const double amplitude = reach > 0 ? kSmall * kLargest * span(rest) / reach : 0.0;
  PvdFile list(list_of(number, folder));
  for (int k = 0; k < kMoments; ++k) {
    VtkGrid grid;
    grid.cells = picture.cells();
    grid.points = picture.points(moved(state, mode, amplitude, 2 * kPi * k / kMoments));
    grid.point_fields = {{"displacement", 3, difference(grid.points, rest)}};
    const std::string file = fmt::format("vtu/mode_{:03}_{:02}.vtu", number, k);
    write_vtu(folder + "/" + file, grid);
    list.add(static_cast<double>(k) / kMoments, 0, file);
  }
}

/// A column for each mode, a row for each coordinate.
void write_coordinates(const std::vector<Mode>& modes, const std::string& path) {
  if (modes.empty()) return;
  std::vector<std::complex<double>> x;
  for (const Mode& mode : modes) x.insert(x.end(), mode.x.begin(), mode.x.end());
  const auto rows = static_cast<std::int64_t>(modes.front().x.size());
  write_matrix_market(path, x.data(), rows, static_cast<std::int64_t>(modes.size()), rows,
                      "shapes of modes in coordinates");
}

}  // namespace

void write_modes(const MultibodyModel& model, const State& state, const std::vector<Mode>& modes,
                 const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(folder) / "vtu", error);
  if (error) throw InvalidInput(folder, "cannot be made: " + error.message());
  remove_earlier(folder);
  CsvTable table(folder + "/modes.csv",
                 {"mode", "frequency [Hz]", "damping_ratio", "real [1/s]", "imaginary [1/s]"});
  write_coordinates(modes, folder + "/shapes.mtx");
  const Picture picture(model);
  int number = 0;
  for (const Mode& mode : modes) {
    ++number;
    table.add_row({static_cast<double>(number), natural_frequency(mode), damping_ratio(mode), mode.s.real(),
                   mode.s.imag()});
    write_shape(picture, state, mode, number, folder);
  }
}

}  // namespace mfs::dae
