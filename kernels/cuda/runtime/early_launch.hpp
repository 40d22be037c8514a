// Kernels that begin while the one ahead of them in their stream still runs, and do until it has ended what
// they can do without it (programmatic dependent launches: CUDA C++ Programming Guide, section 4.5).
#pragma once

#include "kernels/cuda/runtime/device.hpp"

namespace mfs::cuda {

/// What the kernel ahead has written may be read from here on.
__device__ inline void wait_for_kernel_ahead() {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 900
  asm volatile("griddepcontrol.wait;" ::: "memory");
#endif
}
/// The one behind may begin once all blocks are here.
__device__ inline void let_kernel_behind_begin() {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 900
  asm volatile("griddepcontrol.launch_dependents;");
#endif
}

/// Launches a kernel that calls wait_for_kernel_ahead in each thread; early where begins_early(kernel).
template <class... Parameters, class... Arguments>
void launch_early(bool early, const Stream& stream, unsigned blocks, unsigned threads, std::size_t bytes,
                  void (*kernel)(Parameters...), const Arguments&... arguments) {
  cudaLaunchAttribute attribute{};
  attribute.id = cudaLaunchAttributeProgrammaticStreamSerialization;
  attribute.val.programmaticStreamSerializationAllowed = 1;
  cudaLaunchConfig_t config{};
  config.gridDim = dim3(blocks);
  config.blockDim = dim3(threads);
  config.dynamicSmemBytes = bytes;
  config.stream = stream.get();
  config.attrs = &attribute;
  config.numAttrs = early ? 1 : 0;
  check(cudaLaunchKernelEx(&config, kernel, static_cast<Parameters>(arguments)...), "cudaLaunchKernelEx");
}

}  // namespace mfs::cuda
