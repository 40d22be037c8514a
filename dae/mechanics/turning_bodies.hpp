// What a system may know of its coordinates beside a ConstrainedSystem: which of them are points of a body
// that turns as a whole, so that what it is at a time between two others can be found with the body in mind.
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
};

/// Those of a system, if it knows of any.
template <class System>
std::vector<PointRange> turning_bodies_of(const System& system) {
  const auto* const turning = dynamic_cast<const TurningBodies*>(&system);
  return turning != nullptr ? turning->turning_bodies() : std::vector<PointRange>();
}

}  // namespace mfs::dae
