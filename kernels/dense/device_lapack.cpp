#include "kernels/dense/device_lapack.hpp"

#include <cusolverDn.h>

#include <mfs/error.hpp>
#include "kernels/cuda/runtime/device_scalar.hpp"
#include "kernels/cuda/runtime/faults.hpp"

namespace mfs::cuda {

namespace {

template <class Call>
void checked(const char* what, const Call& call) {
  const cusolverStatus_t status = fails(CallKind::library) ? CUSOLVER_STATUS_EXECUTION_FAILED : call();
  if (status != CUSOLVER_STATUS_SUCCESS) throw BackendError("cuSOLVER", status, what);
}

cusolverDnHandle_t library(void* handle) {
  return static_cast<cusolverDnHandle_t>(handle);
}
cusolverDnParams_t parameters(void* parameters) {
  return static_cast<cusolverDnParams_t>(parameters);
}

template <class S>
constexpr cudaDataType_t kType{};
template <>
constexpr cudaDataType_t kType<float> = CUDA_R_32F;
template <>
constexpr cudaDataType_t kType<double> = CUDA_R_64F;
template <>
constexpr cudaDataType_t kType<Kokkos::complex<float>> = CUDA_C_32F;
template <>
constexpr cudaDataType_t kType<Kokkos::complex<double>> = CUDA_C_64F;

constexpr Offset kInfoBytes = 256;  // so that working memory begins where memory of its own would

}  // namespace

DeviceLapack::DeviceLapack(const Stream& stream) {
  const Offset available = free_memory();
  if (available < kHandleBytes)
    throw OutOfMemory(MemorySpace::device, static_cast<std::size_t>(kHandleBytes),
                      static_cast<std::size_t>(available));
  cusolverDnHandle_t handle = nullptr;
  checked("cusolverDnCreate", [&] { return cusolverDnCreate(&handle); });
  handle_.reset(handle);
  cusolverDnParams_t parameters = nullptr;
  checked("cusolverDnCreateParams", [&] { return cusolverDnCreateParams(&parameters); });
  parameters_.reset(parameters);
  checked("cusolverDnSetStream", [&] { return cusolverDnSetStream(handle, stream.get()); });
}
void DeviceLapack::DestroyHandle::operator()(void* handle) const {
  cusolverDnDestroy(library(handle));
}
void DeviceLapack::DestroyParameters::operator()(void* of_calls) const {
  cusolverDnDestroyParams(parameters(of_calls));
}

template <class S>
void DeviceLapack::reserve(int n, const S* a, int lda) {
  std::size_t device = 0, host = 0;
  checked("cusolverDnXgetrf_bufferSize", [&] {
    return cusolverDnXgetrf_bufferSize(library(handle_.get()), parameters(parameters_.get()), n, n, kType<S>,
                                       a, lda, kType<S>, &device, &host);
  });
  const Offset bytes = kInfoBytes + static_cast<Offset>(device);
  if (!workspace_ || workspace_->bytes() < bytes) workspace_ = std::make_unique<DeviceArena>(bytes);
  if (host_workspace_.size() < host) host_workspace_.resize(host);
}

template <class S>
void DeviceLapack::getrf(int n, S* a, int lda) {
  checked("cusolverDnXgetrf", [&] {
    return cusolverDnXgetrf(library(handle_.get()), parameters(parameters_.get()), n, n, kType<S>, a, lda,
                            nullptr, kType<S>, workspace_->at<void>(kInfoBytes),
                            static_cast<std::size_t>(workspace_->bytes() - kInfoBytes),
                            host_workspace_.data(), host_workspace_.size(), workspace_->at<int>(0));
  });
}

#define MFS_INSTANTIATE(S)                                    \
  template void DeviceLapack::reserve<S>(int, const S*, int); \
  template void DeviceLapack::getrf<S>(int, S*, int);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(Kokkos::complex<float>)
MFS_INSTANTIATE(Kokkos::complex<double>)

}  // namespace mfs::cuda
