// What a system may know of its coordinates beside a ConstrainedSystem: which of them are points of a body
// that turns as a whole, so that what it is at a time between two others can be found with the body in mind,
// and what is a length, so that moments can be weighed against forces.
#pragma once

#include <vector>

namespace mfs::dae {

/// x, y and z of `count` points, from coordinate `first` on.
struct PointRange {
  int first = 0, count = 0;
};

class TurningBodies {
 public:
  virtual ~TurningBodies() = default;
  /// One range of a body, ascending.
  virtual std::vector<PointRange> turning_bodies() const = 0;
  /// Whether a coordinate is a length.
  virtual bool is_length(int /*coordinate*/) const { return true; }
  /// The largest size of a body, in the unit of lengths of the model; 1 where none has one.
  virtual double largest_body() const { return 1.0; }
};

/// Those of a system, if it knows of any.
template <class System>
std::vector<PointRange> turning_bodies_of(const System& system) {
  const auto* const turning = dynamic_cast<const TurningBodies*>(&system);
  return turning != nullptr ? turning->turning_bodies() : std::vector<PointRange>();
}

/// The same; without such knowledge all are lengths, and what has an effect on them is a force.
template <class System>
bool is_length_of(const System& system, int coordinate) {
  const auto* const turning = dynamic_cast<const TurningBodies*>(&system);
  return turning == nullptr || turning->is_length(coordinate);
}
template <class System>
double largest_body_of(const System& system) {
  const auto* const turning = dynamic_cast<const TurningBodies*>(&system);
  return turning != nullptr ? turning->largest_body() : 1.0;
}

}  // namespace mfs::dae
