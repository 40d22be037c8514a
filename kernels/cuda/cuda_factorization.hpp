// The factorization on a CUDA device. A first factorization launches its stages one by one; further ones replay
// them from a graph. The host waits once per factorization, for the status.
#pragma once

#include <memory>

#include "kernels/factorization.hpp"

namespace mfs::cuda {

/// Whether this process can use a device.
bool device_found();

/// As make_factorization; throws OutOfMemory(device) and BackendError as well.
template <class Value>
std::unique_ptr<Factorization<Value>> make_cuda_factorization(bool single_precision,
                                                              std::shared_ptr<const SymbolicPlan> plan,
                                                              std::shared_ptr<const Pattern> pattern);

}  // namespace mfs::cuda
