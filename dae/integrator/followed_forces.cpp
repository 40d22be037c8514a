#include "dae/integrator/followed_forces.hpp"

#include <algorithm>

namespace mfs::dae {

std::vector<double> followed_forces(const ConstrainedSystem& system) {
  const Pattern& by_rate = system.tangent_pattern()[Block::force_v];
  std::vector<char> is_measure;  // meshes have so many entries that it counts to ask for each
  for (int i = 0; i < by_rate.rows; ++i) is_measure.push_back(system.is_measure(i) ? 1 : 0);
  std::vector<double> followed;
  for (int i = 0; i < by_rate.rows; ++i) {
    const auto begin = by_rate.column.begin();
    const bool is_pushed = std::any_of(begin + by_rate.row_start[i], begin + by_rate.row_start[i + 1],
                                       [&](int column) { return is_measure[column] != 0; });
    followed.push_back(is_pushed || is_measure[i] != 0 ? 1.0 : 0.0);
  }
  return followed;
}

}  // namespace mfs::dae
