// The seam between what chooses a pair of scalars and the files that compile the device code for it, one pair
// each: factors_<scalars>.cpp.
#pragma once

#include <memory>

#include "kernels/factors.hpp"

namespace mfs::cuda {

/// As plan_cuda_factors: factors of Scalar, on the device, for matrices and vectors of Value.
template <class Value, class Scalar>
Planned<Factors<Value>> plan_factors(std::shared_ptr<const SymbolicPlan> plan,
                                     std::shared_ptr<const Pattern> pattern);

}  // namespace mfs::cuda
