// The seam between what chooses a pair of scalars and the files that compile the device code for it, one pair
// each: factors_<scalars>.cpp.
#pragma once

#include <memory>

#include "kernels/factors.hpp"

namespace mfs::cuda {

/// Factors of Scalar, on the device, for matrices and vectors of Value. Throws OutOfMemory, BackendError.
template <class Value, class Scalar>
std::unique_ptr<Factors<Value>> make_factors(std::shared_ptr<const SymbolicPlan> plan,
                                             std::shared_ptr<const Pattern> pattern);

/// Bytes of device memory that these will take, those of the vendor's libraries left out.
template <class Value, class Scalar>
Offset bytes_of_factors(const SymbolicPlan& plan, const Pattern& pattern);

}  // namespace mfs::cuda
