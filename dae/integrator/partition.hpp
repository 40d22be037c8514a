// Which constraints say something new: a sparse LU of Phi_q^T (n x m, UMFPACK) picks for each a coordinate in
// which it is strong, its pivot row. Constraints for which no pivot is left depend on the others.
#pragma once

#include <vector>

#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae {

/// Rows of Phi_q that depend on the others, ascending. `values`: of `position_q`; `scale`: per coordinate.
std::vector<int> redundant_rows(const Pattern& position_q, const std::vector<double>& values,
                                const std::vector<double>& scale);

}  // namespace mfs::dae
