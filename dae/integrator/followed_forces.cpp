#include "dae/integrator/followed_forces.hpp"

#include <algorithm>

namespace mfs::dae {

std::vector<double> followed_forces(const ConstrainedSystem& system) {
  const Pattern& by_rate = system.tangent_pattern()[Block::force_v];
  std::vector<double> followed;
  for (int i = 0; i < by_rate.rows; ++i) {
    const auto begin = by_rate.column.begin();
    const bool is_pushed = std::any_of(begin + by_rate.row_start[i], begin + by_rate.row_start[i + 1],
                                       [&](int column) { return system.is_measure(column); });
    followed.push_back(is_pushed || system.is_measure(i) ? 1.0 : 0.0);
  }
  return followed;
}

}  // namespace mfs::dae
