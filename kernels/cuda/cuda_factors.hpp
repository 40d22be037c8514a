// The factors on a CUDA device. A first factorization launches its stages one by one; further ones
// replay them from a graph. The host waits once per factorization, for the status. Nothing here names CUDA
// itself: in a build without it, kernels/cuda/no_cuda.cpp stands in.
#pragma once

#include <cstddef>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "kernels/factors.hpp"

namespace mfs::cuda {

bool device_found();
/// Throws BackendError where this build has no CUDA backend, this process no device, or factors on another
/// than is current.
void require_device();
/// What the devices of this machine are, and what the kernels for double precision make of them.
struct DeviceFacts {
  std::string name;
  int compute_capability, code, multiprocessors;  // 10 major + minor; of the device, of the kernels' code
  Offset bytes, shared_memory;                    // of memory; of a block
  bool tensor_cores;
  int single_to_double;  // speed of single precision in that of double
  int tile, small_rows;
};
/// Empty where this build has no CUDA backend.
std::vector<DeviceFacts> devices();
/// DeviceFacts::single_to_double of the current device, 1 where there is none.
int speed_of_single();
/// Bytes free on the device; inside Engine::run.
std::size_t available_device_memory();

/// The first large product and LU of a process take the libraries tens of milliseconds, in which they find
/// and load their kernels. This makes one of each by another thread, beside the analysis of a matrix that is
/// large enough to need them; what fails is left to the factorization to find. The future's end waits for it.
template <class Value>
std::future<void> load_library(bool single_precision, const Pattern& pattern);

/// Bytes of the device that factors may have: `limit` at most (0: all that are free), and `held` more than
/// are free now.
struct DeviceRoom {
  Offset limit = 0, held = 0;
};

/// The launches for the factors of this plan on the present device; by segments, if they do not fit there.
/// What the vendor's libraries take is left out of the bytes. `make` is as make_host_factors, and throws
/// OutOfMemory(device) and BackendError as well: where not even segments fit, before any work, with bytes
/// that would do. Where there is less memory then than now, it plans anew.
template <class Value>
Planned<Factors<Value>> plan_cuda_factors(bool single_precision, std::shared_ptr<const SymbolicPlan> plan,
                                          std::shared_ptr<const Pattern> pattern, const DeviceRoom& room);

}  // namespace mfs::cuda
