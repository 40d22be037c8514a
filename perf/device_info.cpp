#include "perf/device_info.hpp"

#ifdef MFS_CUDA
#include <cuda_runtime.h>

namespace mfs::perf {

std::string device_name() {
  int device = 0;
  cudaDeviceProp properties;
  if (cudaGetDevice(&device) != cudaSuccess || cudaGetDeviceProperties(&properties, device) != cudaSuccess)
    return "";
  return properties.name;
}

std::int64_t device_bytes_in_use() {
  std::size_t free = 0, total = 0;
  if (cudaDeviceSynchronize() != cudaSuccess || cudaMemGetInfo(&free, &total) != cudaSuccess) return 0;
  return static_cast<std::int64_t>(total - free);
}

}  // namespace mfs::perf
#else
namespace mfs::perf {

std::string device_name() {
  return "";
}
std::int64_t device_bytes_in_use() {
  return 0;
}

}  // namespace mfs::perf
#endif
