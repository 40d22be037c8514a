#include "kernels/dense/device_blas.hpp"

#include <cublasLt.h>

#include <cstdint>
#include <map>

#include <mfs/error.hpp>
#include "kernels/cuda/runtime/device_scalar.hpp"
#include "kernels/cuda/runtime/faults.hpp"

// By cublasLt, the part of cuBLAS that has the products: a handle of all of cuBLAS takes 64 MiB of the device
// for itself, whatever it is given to work in, which is much of what a small system takes.

namespace mfs::cuda {

namespace {

// As much as cuBLAS takes by itself on most devices; more makes no product faster that comes here.
constexpr Offset kWorkspace = Offset(4) << 20;

template <class Call>
void checked(const char* what, const Call& call) {
  const cublasStatus_t status = fails(CallKind::library) ? CUBLAS_STATUS_EXECUTION_FAILED : call();
  if (status != CUBLAS_STATUS_SUCCESS)
    throw BackendError("cuBLAS", status, std::string(what) + ": " + cublasLtGetStatusString(status));
}

cublasLtHandle_t library(void* handle) {
  return static_cast<cublasLtHandle_t>(handle);
}

struct NumberKind {
  cublasComputeType_t compute;
  cudaDataType_t type;
};
template <class S>
constexpr NumberKind kNumbers{};
template <>
constexpr NumberKind kNumbers<float>{CUBLAS_COMPUTE_32F, CUDA_R_32F};
template <>
constexpr NumberKind kNumbers<double>{CUBLAS_COMPUTE_64F, CUDA_R_64F};
template <>
constexpr NumberKind kNumbers<Kokkos::complex<float>>{CUBLAS_COMPUTE_32F, CUDA_C_32F};
template <>
constexpr NumberKind kNumbers<Kokkos::complex<double>>{CUBLAS_COMPUTE_64F, CUDA_C_64F};

struct Product : cublasLtMatmulDescOpaque_t {
  explicit Product(const NumberKind& numbers) {
    checked("cublasLtMatmulDescInit",
            [&] { return cublasLtMatmulDescInit(this, numbers.compute, numbers.type); });
  }
};
struct Matrix : cublasLtMatrixLayoutOpaque_t {
  Matrix(cudaDataType_t type, int rows, int columns, int ld) {
    checked("cublasLtMatrixLayoutInit", [&] {
      return cublasLtMatrixLayoutInit(this, type, static_cast<std::uint64_t>(rows),
                                      static_cast<std::uint64_t>(columns), ld);
    });
  }
};

// The largest power of two that an address is a multiple of, as far as it matters.
std::uint32_t alignment_of(const void* address) {
  const auto bits = reinterpret_cast<std::uintptr_t>(address) | 256;
  return static_cast<std::uint32_t>(bits & (~bits + 1));
}

// What the library must keep to: its working memory, where operands begin, and sums in one order.
struct Preference : cublasLtMatmulPreferenceOpaque_t {
  Preference(const void* a, const void* b, const void* c) {
    checked("cublasLtMatmulPreferenceInit", [&] { return cublasLtMatmulPreferenceInit(this); });
    set(CUBLASLT_MATMUL_PREF_MAX_WORKSPACE_BYTES, static_cast<std::uint64_t>(kWorkspace));
    set(CUBLASLT_MATMUL_PREF_MIN_ALIGNMENT_A_BYTES, alignment_of(a));
    set(CUBLASLT_MATMUL_PREF_MIN_ALIGNMENT_B_BYTES, alignment_of(b));
    set(CUBLASLT_MATMUL_PREF_MIN_ALIGNMENT_C_BYTES, alignment_of(c));
    set(CUBLASLT_MATMUL_PREF_MIN_ALIGNMENT_D_BYTES, alignment_of(c));
    set(CUBLASLT_MATMUL_PREF_REDUCTION_SCHEME_MASK,
        std::uint32_t(CUBLASLT_REDUCTION_SCHEME_COMPUTE_TYPE | CUBLASLT_REDUCTION_SCHEME_OUTPUT_TYPE));
  }

 private:
  template <class T>
  void set(cublasLtMatmulPreferenceAttributes_t attribute, T value) {
    checked("cublasLtMatmulPreferenceSetAttribute",
            [&] { return cublasLtMatmulPreferenceSetAttribute(this, attribute, &value, sizeof value); });
  }
};

}  // namespace

struct DeviceBlas::Algorithms : std::map<Shape, cublasLtMatmulAlgo_t> {};

DeviceBlas::DeviceBlas(const Stream& stream)
    : stream_(stream), workspace_(kWorkspace), chosen_(std::make_unique<Algorithms>()) {
  cublasLtHandle_t handle = nullptr;
  checked("cublasLtCreate", [&] { return cublasLtCreate(&handle); });
  handle_.reset(handle);
}
DeviceBlas::~DeviceBlas() = default;
void DeviceBlas::Destroy::operator()(void* handle) const {
  cublasLtDestroy(library(handle));
}

template <class S>
void DeviceBlas::gemm_minus(int m, int n, int k, const S* a, int lda, const S* b, int ldb, S* c,
                            int ldc) const {
  const S minus_one(-1), one(1);
  const NumberKind numbers = kNumbers<S>;
  Product product(numbers);
  Matrix left(numbers.type, m, k, lda), right(numbers.type, k, n, ldb), sum(numbers.type, m, n, ldc);
  const auto size = [](int value) { return static_cast<unsigned>(value); };
  const Shape shape{size(m),   size(n),         size(k),         size(lda),      size(ldb),
                    size(ldc), alignment_of(a), alignment_of(b), alignment_of(c)};
  auto chosen = chosen_->find(shape);
  if (chosen == chosen_->end()) {
    Preference preference(a, b, c);
    cublasLtMatmulHeuristicResult_t best{};
    checked("cublasLtMatmulAlgoGetHeuristic", [&] {
      int found = 0;
      return cublasLtMatmulAlgoGetHeuristic(library(handle_.get()), &product, &left, &right, &sum, &sum,
                                            &preference, 1, &best, &found);
    });
    chosen = chosen_->emplace(shape, best.algo).first;
  }
  checked("cublasLtMatmul", [&] {
    return cublasLtMatmul(library(handle_.get()), &product, &minus_one, a, &left, b, &right, &one, c, &sum, c,
                          &sum, &chosen->second, workspace_.at<void>(0), static_cast<std::size_t>(kWorkspace),
                          stream_.get());
  });
}

#define MFS_INSTANTIATE(S) \
  template void DeviceBlas::gemm_minus<S>(int, int, int, const S*, int, const S*, int, S*, int) const;
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(Kokkos::complex<float>)
MFS_INSTANTIATE(Kokkos::complex<double>)

}  // namespace mfs::cuda
