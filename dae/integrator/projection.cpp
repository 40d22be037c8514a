#include "dae/integrator/projection.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <utility>

#include "dae/integrator/composition.hpp"
#include "dae/integrator/initial_conditions.hpp"

namespace mfs::dae {
namespace {

/// Changes of an entry of Phi_q, in parts of its constraint's largest, that are rounding.
constexpr double kUnchanged = 1e-10;
/// A tied coordinate's entry has to be this part of its constraint's largest, in the coordinates' scales.
constexpr double kStrong = 0.1;

/// Between -1/2 and 1/2, always the same for one index (splitmix64).
double random_number(std::uint64_t index) {
  std::uint64_t z = (index + 1) * 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53 - 0.5;
}

/// Phi_q at two states, with columns in the coordinates' scales.
class Gradients {
 public:
  Gradients(const ConstrainedSystem& system, double t, const std::vector<double>& q, double t_end)
      : pattern_(system.tangent_pattern()[Block::position_q]), here_(constraint_gradient(system, t, q)) {
    std::vector<double> elsewhere = q;
    for (std::size_t i = 0; i < q.size(); ++i) {
      scale_.push_back(system.coordinate_scale(static_cast<int>(i)));
      elsewhere[i] += scale_[i] * random_number(i);
    }
    try {
      there_ = constraint_gradient(system, t + 0.618 * (t_end - t), elsewhere);
    } catch (const std::exception&) {  // the motion need not come by there: then nothing is known to last
      there_.assign(here_.size(), std::nan(""));
    }
    for (int row = 0; row < pattern_.rows; ++row) {
      double most = 0.0;
      for (int k = pattern_.row_start[row]; k < pattern_.row_start[row + 1]; ++k)
        most = std::max({most, size(here_, k), size(there_, k)});
      largest_.push_back(most);
    }
  }
  const Pattern& pattern() const { return pattern_; }
  bool is_zero(int row, int k) const {
    const double rounding = kUnchanged * largest_[row];
    return size(here_, k) <= rounding && size(there_, k) <= rounding;
  }
  /// How much of its constraint's largest an entry has in every state; 0: it changes.
  double lasting(int row, int k) const {
    const double change = std::abs(there_[k] - here_[k]) * scale_[pattern_.column[k]];
    return change <= kUnchanged * largest_[row] ? size(here_, k) / largest_[row] : 0.0;
  }

 private:
  double size(const std::vector<double>& values, int k) const {
    return std::abs(values[k]) * scale_[pattern_.column[k]];
  }
  const Pattern& pattern_;
  std::vector<double> here_, there_, scale_, largest_;
};

/// For each constraint the entry of a coordinate that is tied to it, or -1: of one on velocities none, as it
/// leaves positions to the formula.
std::vector<int> find_tied(const ConstrainedSystem& system, const Gradients& gradients) {
  const Pattern& pattern = gradients.pattern();
  const auto for_entries = [&](const auto& visit) {
    for (int row = 0; row < pattern.rows; ++row)
      for (int k = pattern.row_start[row]; k < pattern.row_start[row + 1]; ++k)
        if (!gradients.is_zero(row, k)) visit(row, k);
  };
  std::vector<int> constraints_of(static_cast<std::size_t>(pattern.columns), 0);
  for_entries([&](int, int k) { ++constraints_of[pattern.column[k]]; });
  std::vector<int> tied(static_cast<std::size_t>(pattern.rows), -1);
  std::vector<double> strength(tied.size(), kStrong);
  for_entries([&](int row, int k) {
    if (constraints_of[pattern.column[k]] != 1 || gradients.lasting(row, k) <= strength[row] ||
        system.is_nonholonomic(row))
      return;
    strength[row] = gradients.lasting(row, k);
    tied[row] = k;
  });
  return tied;
}

}  // namespace

Projection no_projection(int coordinates) {
  const auto n = static_cast<std::size_t>(coordinates);
  return {std::vector<Role>(n, Role::free), {}, {}, {coordinates, 0, std::vector<int>(n + 1, 0), {}}, {}};
}

Projection find_projection(const ConstrainedSystem& system, double t, const std::vector<double>& q,
                           double t_end) {
  Projection projection = no_projection(system.coordinates());
  const Gradients gradients(system, t, q, t_end);
  const Pattern& gradient = gradients.pattern();
  projection.tied_entry = find_tied(system, gradients);
  Pattern columns{0, gradient.columns, {0}, {}};
  std::vector<int> source;
  for (int row = 0; row < gradient.rows; ++row) {
    if (const int tied = projection.tied_entry[row]; tied >= 0) {
      projection.role[gradient.column[tied]] = Role::tied;
      continue;
    }
    projection.rows.push_back(row);
    for (int k = gradient.row_start[row]; k < gradient.row_start[row + 1]; ++k) {
      if (gradients.is_zero(row, k)) continue;
      projection.role[gradient.column[k]] = Role::shared;
      columns.column.push_back(gradient.column[k]);
      source.push_back(k);
    }
    columns.row_start.push_back(static_cast<int>(source.size()));
    ++columns.rows;
  }
  TransposedPattern transposed(columns);
  projection.directions = std::move(transposed.pattern);
  for (const int k : transposed.source) projection.source.push_back(source[k]);
  return projection;
}

}  // namespace mfs::dae
