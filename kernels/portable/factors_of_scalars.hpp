// The seam between what chooses a pair of scalars and the files that compile the kernels for it, one pair
// each: factors_<scalars>.cpp.
#pragma once

#include <memory>

#include "kernels/factors.hpp"

namespace mfs::portable {

/// As plan_portable_factors: factors of Scalar for matrices and vectors of Value.
template <class Value, class Scalar>
Planned<Factors<Value>> plan_factors(std::shared_ptr<const SymbolicPlan> plan,
                                     std::shared_ptr<const Pattern> pattern, int threads);

}  // namespace mfs::portable
