// A system as statics and modes see it: without those of its constraints that follow from the others where it
// begins.
#pragma once

#include <vector>

#include "dae/integrator/redundancy.hpp"

namespace mfs::dae {

class IndependentSystem : public Redundancy {
 public:
  /// `given` has to live as long.
  IndependentSystem(const ConstrainedSystem& given, double t, const std::vector<double>& q)
      : Redundancy(given, scales(given)) {
    leave_out(find(t, q));
  }

 private:
  static std::vector<double> scales(const ConstrainedSystem& system) {
    std::vector<double> scales;
    for (int i = 0; i < system.coordinates(); ++i) scales.push_back(system.coordinate_scale(i));
    return scales;
  }
};

}  // namespace mfs::dae
