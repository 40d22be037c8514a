#include "dae/mechanics/multibody.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <mfs/error.hpp>

#include "dae/mechanics/multibody_system.hpp"

namespace mfs::dae {
namespace {

/// Sizes from 2^-6 to 2^6 are taken as they are given.
constexpr double kOrdinary = 6.0;

/// Throws InvalidInput unless the coordinates of each element exist and differ.
void check_coordinates(const ElementGroup& group, int n) {
  std::vector<int> sorted(static_cast<std::size_t>(group.local_coordinates()));
  for (int e = 0; e < group.size(); ++e) {
    std::copy_n(group.coordinates(e), sorted.size(), sorted.begin());
    std::sort(sorted.begin(), sorted.end());
    if (!sorted.empty() && (sorted.front() < 0 || sorted.back() >= n))
      throw InvalidInput(group.name(e),
                         "coordinate " + std::to_string(sorted.front() < 0 ? sorted.front() : sorted.back()) +
                             " is not one of the " + std::to_string(n));
    const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
    if (twice != sorted.end())
      throw InvalidInput(group.name(e), "coordinate " + std::to_string(*twice) + " is named twice");
  }
}

}  // namespace

CoordinateRange MultibodyBuilder::add_coordinates(const std::string& body,
                                                  const std::vector<double>& initial_q,
                                                  const std::vector<double>& initial_v,
                                                  const std::vector<std::string>& components, int lengths) {
  if (initial_q.empty()) throw InvalidInput("body " + body, "it has no coordinates");
  if (initial_v.size() != initial_q.size())
    throw InvalidInput("body " + body, std::to_string(initial_q.size()) + " initial coordinates, but " +
                                           std::to_string(initial_v.size()) + " initial velocities");
  if (!components.empty() && initial_q.size() % components.size() != 0)
    throw InvalidInput("body " + body, std::to_string(initial_q.size()) + " coordinates are no multiple of " +
                                           std::to_string(components.size()) + " components");
  const auto finite = [](double x) { return std::isfinite(x); };
  if (!std::all_of(initial_q.begin(), initial_q.end(), finite) ||
      !std::all_of(initial_v.begin(), initial_v.end(), finite))
    throw InvalidInput("body " + body, "an initial coordinate or velocity is not finite");
  const CoordinateRange range{static_cast<int>(q_.size()), static_cast<int>(initial_q.size())};
  q_.insert(q_.end(), initial_q.begin(), initial_q.end());
  v_.insert(v_.end(), initial_v.begin(), initial_v.end());
  bodies_.push_back({body, range, components, lengths});
  if (components.size() == 3 && lengths == 3) note_length(range.first, extent(initial_q));
  return range;
}

int MultibodyBuilder::add_measure_coordinate(const std::string& name, double initial_q, double initial_v,
                                             bool is_length) {
  const int coordinate = add_coordinates(name, {initial_q}, {initial_v}, {"value"}, is_length ? 1 : 0).first;
  bodies_.back().is_measure = true;
  return coordinate;
}

void MultibodyBuilder::note_length(int body, double length) {
  if (length > 0 && std::isfinite(length)) size_[body] = std::max(size_[body], length);
}

double MultibodyBuilder::length_unit() const {
  double nearest = HUGE_VAL;  // its logarithm
  for (const auto& [body, size] : size_)
    if (std::abs(std::log2(size)) < std::abs(nearest)) nearest = std::log2(size);
  return std::abs(nearest) <= kOrdinary || size_.empty() ? 1.0 : std::exp2(std::round(nearest));
}

double MultibodyBuilder::largest_body() const {
  double largest = 0.0;
  for (const auto& [body, size] : size_) largest = std::max(largest, size);
  return largest > 0.0 ? largest : 1.0;
}

void MultibodyBuilder::add(std::shared_ptr<const ElementGroup> group) {
  if (!group) throw InvalidInput("group", "null pointer");
  if (group->size() == 0) return;
  constraints_ += group->size() * group->local_constraints();
  groups_.push_back(std::move(group));
}

std::unique_ptr<ConstrainedSystem> MultibodyBuilder::build(int threads, Backend backend) const {
  if (threads < 0) throw InvalidInput("threads", "negative");
  const int n = static_cast<int>(q_.size());
  if (n == 0) throw InvalidInput("bodies", "there are no coordinates");
  for (const auto& group : groups_) check_coordinates(*group, n);
  return std::make_unique<Multibody>(groups_, bodies_, length_unit(), largest_body(), n,
                                     threads > 0 ? threads : omp_get_max_threads(), backend);
}

}  // namespace mfs::dae
