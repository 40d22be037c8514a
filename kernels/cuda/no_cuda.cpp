// In place of kernels/cuda where MFS is built without it.
#include <mfs/error.hpp>

#include "kernels/cuda/cuda_factors.hpp"

namespace mfs::cuda {

bool device_found() {
  return false;
}
void require_device() {
  throw BackendError("CUDA", 0, "this build of MFS has no CUDA backend");
}
std::vector<DeviceFacts> devices() {
  return {};
}
int speed_of_single() {
  return 1;
}
std::size_t available_device_memory() {
  return 0;
}

template <class Value>
std::future<void> load_library(bool, const Pattern&) {
  return {};
}

template <class Value>
Planned<Factors<Value>> plan_cuda_factors(bool, std::shared_ptr<const SymbolicPlan>,
                                          std::shared_ptr<const Pattern>, const DeviceRoom&) {
  require_device();
  return {};
}

#define MFS_INSTANTIATE(Value)                                          \
  template std::future<void> load_library<Value>(bool, const Pattern&); \
  template Planned<Factors<Value>> plan_cuda_factors<Value>(            \
      bool, std::shared_ptr<const SymbolicPlan>, std::shared_ptr<const Pattern>, const DeviceRoom&);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs::cuda
