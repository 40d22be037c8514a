#include "kernels/cuda/device_blas.hpp"

#include <cublas_v2.h>

#include <mfs/error.hpp>
#include "kernels/cuda/device_scalar.hpp"

namespace mfs::cuda {

namespace {

constexpr Offset kWorkspace = Offset(32) << 20;  // what cuBLAS recommends for Hopper

void check_blas(cublasStatus_t status, const char* what) {
  if (status != CUBLAS_STATUS_SUCCESS)
    throw BackendError("cuBLAS", status, std::string(what) + ": " + cublasGetStatusString(status));
}

cublasHandle_t blas(void* handle) {
  return static_cast<cublasHandle_t>(handle);
}

}  // namespace

DeviceBlas::DeviceBlas(const Stream& stream) : workspace_(kWorkspace) {
  cublasHandle_t handle = nullptr;
  check_blas(cublasCreate(&handle), "cublasCreate");
  handle_ = handle;
  check_blas(cublasSetStream(handle, stream.get()), "cublasSetStream");
  check_blas(cublasSetWorkspace(handle, workspace_.at<void>(0), kWorkspace), "cublasSetWorkspace");
}
DeviceBlas::~DeviceBlas() {
  cublasDestroy(blas(handle_));
}

#define MFS_GEMM_MINUS(S, Number, gemm)                                                                     \
  template <>                                                                                               \
  void DeviceBlas::gemm_minus<S>(int m, int n, int k, const S* a, int lda, const S* b, int ldb, S* c,       \
                                 int ldc) const {                                                           \
    const S minus_one(-1), one(1);                                                                          \
    check_blas(                                                                                             \
        gemm(blas(handle_), CUBLAS_OP_N, CUBLAS_OP_N, m, n, k, reinterpret_cast<const Number*>(&minus_one), \
             reinterpret_cast<const Number*>(a), lda, reinterpret_cast<const Number*>(b), ldb,              \
             reinterpret_cast<const Number*>(&one), reinterpret_cast<Number*>(c), ldc),                     \
        #gemm);                                                                                             \
  }
MFS_GEMM_MINUS(float, float, cublasSgemm)
MFS_GEMM_MINUS(double, double, cublasDgemm)
MFS_GEMM_MINUS(Kokkos::complex<float>, cuComplex, cublasCgemm)
MFS_GEMM_MINUS(Kokkos::complex<double>, cuDoubleComplex, cublasZgemm)

}  // namespace mfs::cuda
