#include "kernels/cuda/device_blas.hpp"

#include <cublas_v2.h>

#include <mfs/error.hpp>
#include "kernels/cuda/device_scalar.hpp"
#include "kernels/cuda/faults.hpp"

namespace mfs::cuda {

namespace {

// What cuBLAS takes by itself on most devices; on Hopper it recommends eight times as much, which is most of
// what a small system takes and makes no product faster that comes here.
constexpr Offset kWorkspace = Offset(4) << 20;

template <class Call>
void checked(const char* what, const Call& call) {
  const cublasStatus_t status = fails(CallKind::library) ? CUBLAS_STATUS_EXECUTION_FAILED : call();
  if (status != CUBLAS_STATUS_SUCCESS)
    throw BackendError("cuBLAS", status, std::string(what) + ": " + cublasGetStatusString(status));
}

cublasHandle_t blas(void* handle) {
  return static_cast<cublasHandle_t>(handle);
}

}  // namespace

DeviceBlas::DeviceBlas(const Stream& stream) : workspace_(kWorkspace) {
  cublasHandle_t handle = nullptr;
  checked("cublasCreate", [&] { return cublasCreate(&handle); });
  handle_.reset(handle);
  checked("cublasSetStream", [&] { return cublasSetStream(handle, stream.get()); });
  checked("cublasSetWorkspace",
          [&] { return cublasSetWorkspace(handle, workspace_.at<void>(0), kWorkspace); });
}
void DeviceBlas::Destroy::operator()(void* handle) const {
  cublasDestroy(blas(handle));
}

#define MFS_GEMM_MINUS(S, Number, gemm)                                                                 \
  template <>                                                                                           \
  void DeviceBlas::gemm_minus<S>(int m, int n, int k, const S* a, int lda, const S* b, int ldb, S* c,   \
                                 int ldc) const {                                                       \
    const S minus_one(-1), one(1);                                                                      \
    checked(#gemm, [&] {                                                                                \
      return gemm(blas(handle_.get()), CUBLAS_OP_N, CUBLAS_OP_N, m, n, k,                               \
                  reinterpret_cast<const Number*>(&minus_one), reinterpret_cast<const Number*>(a), lda, \
                  reinterpret_cast<const Number*>(b), ldb, reinterpret_cast<const Number*>(&one),       \
                  reinterpret_cast<Number*>(c), ldc);                                                   \
    });                                                                                                 \
  }
MFS_GEMM_MINUS(float, float, cublasSgemm)
MFS_GEMM_MINUS(double, double, cublasDgemm)
MFS_GEMM_MINUS(Kokkos::complex<float>, cuComplex, cublasCgemm)
MFS_GEMM_MINUS(Kokkos::complex<double>, cuDoubleComplex, cublasZgemm)

}  // namespace mfs::cuda
