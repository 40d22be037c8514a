// The seam between what chooses a pair of scalars and the files that compile the device code for it, one pair
// each: factors_<scalars>.cpp.
#pragma once

#include <memory>

#include "kernels/cuda/cuda_factors.hpp"
#include "plan/device_plan.hpp"

namespace mfs::cuda {

/// As plan_cuda_factors: factors of Scalar, on the device, for matrices and vectors of Value.
template <class Value, class Scalar>
Planned<Factors<Value>> plan_factors(std::shared_ptr<const SymbolicPlan> plan,
                                     std::shared_ptr<const Pattern> pattern, const DeviceRoom& room);

/// How work in Scalar is cut for a device of so many multiprocessors, a block of which may have `memory`
/// bytes of shared memory. Throws BackendError where that is too little.
template <class Scalar>
DeviceLimits limits_for(int multiprocessors, std::size_t memory);
/// Compute capability of the code that this device runs, 10 major + minor, and whether its products of double
/// precision are made by tensor cores.
struct DeviceCode {
  int compute_capability;
  bool tensor_cores;
};
DeviceCode device_code();

}  // namespace mfs::cuda
