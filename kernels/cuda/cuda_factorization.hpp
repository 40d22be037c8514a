// The factorization on a CUDA device. A first factorization launches its stages one by one; further ones
// replay them from a graph. The host waits once per factorization, for the status. Nothing here names CUDA
// itself: in a build without it, kernels/no_cuda.cpp stands in.
#pragma once

#include <memory>

#include "kernels/factorization.hpp"

namespace mfs::cuda {

bool device_found();
/// Throws BackendError where this build has no CUDA backend, or this process no device.
void require_device();
/// Bytes free on the device; inside Engine::run.
std::size_t available_device_memory();

/// As make_factorization; throws OutOfMemory(device) and BackendError as well.
template <class Value>
std::unique_ptr<Factorization<Value>> make_cuda_factorization(bool single_precision,
                                                              std::shared_ptr<const SymbolicPlan> plan,
                                                              std::shared_ptr<const Pattern> pattern);

}  // namespace mfs::cuda
