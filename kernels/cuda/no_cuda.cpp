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
std::unique_ptr<Factors<Value>> make_cuda_factors(bool, std::shared_ptr<const SymbolicPlan>,
                                                  std::shared_ptr<const Pattern>) {
  require_device();
  return nullptr;
}

template <class Value>
Offset device_bytes(bool, const SymbolicPlan&, const Pattern&) {
  require_device();
  return 0;
}

#define MFS_INSTANTIATE(Value)                                                    \
  template Offset device_bytes<Value>(bool, const SymbolicPlan&, const Pattern&); \
  template std::future<void> load_library<Value>(bool, const Pattern&);           \
  template std::unique_ptr<Factors<Value>> make_cuda_factors<Value>(              \
      bool, std::shared_ptr<const SymbolicPlan>, std::shared_ptr<const Pattern>);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs::cuda
