#include <stdexcept>

#include "perf/batch_entrant.hpp"

#ifndef MFS_CUDSS

namespace mfs::perf {

std::unique_ptr<BatchEntrant> make_cudss_batch(const BatchCase&, const std::string&, int) {
  throw std::runtime_error("built without cuDSS: configure with -DMFS_CUDSS_INCLUDE=<folder of cudss.h>");
}

}  // namespace mfs::perf

#else

#include "perf/cudss_library.hpp"
#include "perf/device_array.hpp"

namespace mfs::perf {

namespace {

using mfs::perf::check;
void check(cudssStatus_t status, const char* what) {
  if (status != CUDSS_STATUS_SUCCESS)
    throw std::runtime_error(std::string(what) + ": cuDSS status " + std::to_string(status));
}

/// A uniform batch: one pattern, the values and vectors of all systems one after the other.
class CudssBatch final : public BatchEntrant {
 public:
  CudssBatch(const BatchCase& batch, const std::string& folder, int refinements)
      : lib_(folder),
        n_(batch.a.n),
        offsets_(batch.a.offsets),
        columns_(batch.a.column_indices),
        values_(batch.values),
        b_(batch.b),
        x_(batch.b.size()),
        numbers_(batch.b.size()) {
    check(lib_.cudssCreate(&handle_), "cudssCreate");
    check(lib_.cudssConfigCreate(&config_), "cudssConfigCreate");
    check(lib_.cudssDataCreate(handle_, &data_), "cudssDataCreate");
    int size = static_cast<int>(batch.count), all = -1;
    check(lib_.cudssConfigSet(config_, CUDSS_CONFIG_UBATCH_SIZE, &size, sizeof size), "batch size");
    check(lib_.cudssConfigSet(config_, CUDSS_CONFIG_UBATCH_INDEX, &all, sizeof all), "batch index");
    check(lib_.cudssConfigSet(config_, CUDSS_CONFIG_IR_N_STEPS, &refinements, sizeof refinements),
          "refinement");
    check(lib_.cudssMatrixCreateCsr(&matrix_, n_, n_, batch.a.offsets.back(), offsets_.get(), nullptr,
                                    columns_.get(), values_.get(), CUDA_R_32I, CUDA_R_32I, CUDA_R_64F,
                                    CUDSS_MTYPE_GENERAL, CUDSS_MVIEW_FULL, CUDSS_BASE_ZERO),
          "cudssMatrixCreateCsr");
    vector(&rhs_, b_.get());
    vector(&solution_, x_.get());
    execute(CUDSS_PHASE_ANALYSIS, "analysis");
    execute(CUDSS_PHASE_FACTORIZATION, "factorization");
  }
  ~CudssBatch() override {
    for (cudssMatrix_t matrix : {matrix_, rhs_, solution_}) {
      if (matrix) lib_.cudssMatrixDestroy(matrix);
    }
    if (data_) lib_.cudssDataDestroy(handle_, data_);
    if (config_) lib_.cudssConfigDestroy(config_);
    if (handle_) lib_.cudssDestroy(handle_);
    cudaDeviceSynchronize();
  }
  CudssBatch(const CudssBatch&) = delete;
  CudssBatch& operator=(const CudssBatch&) = delete;

  std::int64_t solve() override {
    execute(CUDSS_PHASE_REFACTORIZATION, "refactorization");
    execute(CUDSS_PHASE_SOLVE, "solve");
    return 0;
  }
  void read(double* x) override {
    check(cudaMemcpy(x, x_.get(), numbers_ * sizeof(double), cudaMemcpyDeviceToHost), "cudaMemcpy");
  }

 private:
  void vector(cudssMatrix_t* made, double* values) {
    check(lib_.cudssMatrixCreateDn(made, n_, 1, n_, values, CUDA_R_64F, CUDSS_LAYOUT_COL_MAJOR),
          "cudssMatrixCreateDn");
  }
  void execute(int phase, const char* what) {
    check(lib_.cudssExecute(handle_, phase, config_, data_, matrix_, solution_, rhs_), what);
    check(cudaDeviceSynchronize(), what);
  }

  const CudssLibrary lib_;
  std::int64_t n_;
  DeviceArray<int> offsets_, columns_;
  DeviceArray<double> values_, b_, x_;
  std::size_t numbers_;
  cudssHandle_t handle_ = nullptr;
  cudssConfig_t config_ = nullptr;
  cudssData_t data_ = nullptr;
  cudssMatrix_t matrix_ = nullptr, rhs_ = nullptr, solution_ = nullptr;
};

}  // namespace

std::unique_ptr<BatchEntrant> make_cudss_batch(const BatchCase& batch, const std::string& folder,
                                               int refinements) {
  return std::make_unique<CudssBatch>(batch, folder, refinements);
}

}  // namespace mfs::perf

#endif
