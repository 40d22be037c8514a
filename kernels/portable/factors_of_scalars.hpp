// The seam between what chooses a pair of scalars and the files that compile the kernels for it, one pair
// each: factors_<scalars>.cpp.
#pragma once

#include <functional>
#include <memory>

#include "kernels/factors.hpp"

namespace mfs::portable {

/// Factors of Scalar for matrices and vectors of Value in Kokkos' default space (portable_factors.hpp).
template <class Value, class Scalar>
std::unique_ptr<Factors<Value>> make_factors(std::shared_ptr<const SymbolicPlan> plan,
                                             std::shared_ptr<const Pattern> pattern, int threads,
                                             const std::function<void(Offset)>& check);
template <class Value, class Scalar>
Offset bytes_of_factors(const SymbolicPlan& plan, const Pattern& pattern, int threads);

}  // namespace mfs::portable
