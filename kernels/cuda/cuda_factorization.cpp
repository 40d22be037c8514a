#include "kernels/cuda/cuda_factorization.hpp"

#include <mfs/error.hpp>

#include "kernels/cuda/device.hpp"
#include "kernels/cuda/factors.hpp"
#include "kernels/engine.hpp"

namespace mfs::cuda {

namespace {

template <class Value, class Scalar>
std::unique_ptr<Factorization<Value>> make(std::shared_ptr<const SymbolicPlan> plan,
                                           std::shared_ptr<const Pattern> pattern) {
  Engine::use_cuda();
  return make_factors<Value, Scalar>(std::move(plan), std::move(pattern));
}

}  // namespace

bool device_found() {
  int count = 0;
  const bool found = cudaGetDeviceCount(&count) == cudaSuccess && count > 0;
  if (!found) cudaGetLastError();
  return found;
}
void require_device() {
  if (!device_found()) throw BackendError("CUDA", 0, "no CUDA device was found");
}

std::size_t available_device_memory() {
  return static_cast<std::size_t>(free_memory());
}

template <class Value>
std::unique_ptr<Factorization<Value>> make_cuda_factorization(bool single_precision,
                                                              std::shared_ptr<const SymbolicPlan> plan,
                                                              std::shared_ptr<const Pattern> pattern) {
  if (single_precision) return make<Value, Narrow<Value>>(std::move(plan), std::move(pattern));
  return make<Value, Value>(std::move(plan), std::move(pattern));
}

#define MFS_INSTANTIATE(Value)                                                   \
  template std::unique_ptr<Factorization<Value>> make_cuda_factorization<Value>( \
      bool, std::shared_ptr<const SymbolicPlan>, std::shared_ptr<const Pattern>);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs::cuda
