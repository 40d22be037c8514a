#include "perf/cudss_candidate.hpp"

#ifndef MFS_CUDSS

#include <stdexcept>

namespace mfs::perf {

std::function<std::unique_ptr<Candidate>(const System&)> load_cudss(const std::string&, int) {
  throw std::runtime_error("built without cuDSS: configure with -DMFS_CUDSS_INCLUDE=<folder of cudss.h>");
}

}  // namespace mfs::perf

#else

#include <cuda_runtime.h>

#include <algorithm>
#include <limits>

#include "ordering/stopwatch.hpp"
#include "perf/cudss_library.hpp"
#include "perf/device_array.hpp"

namespace mfs::perf {
namespace {

using mfs::perf::check;
void check(cudssStatus_t status, const char* what) {
  if (status != CUDSS_STATUS_SUCCESS)
    throw std::runtime_error(std::string(what) + ": cuDSS status " + std::to_string(status));
}

class CudssCandidate final : public Candidate {
 public:
  CudssCandidate(const CudssLibrary& library, const System& system, int threads)
      : lib_(library),
        n_(system.a.n),
        nnz_(system.a.offsets.back()),
        offsets_(offsets_of(system.a)),
        columns_(system.a.column_indices),
        values_(system.a.values),
        b_(system.b),
        x_(system.b.size()) {
    check(lib_.cudssCreate(&handle_), "cudssCreate");
    check(lib_.cudssSetThreadingLayer(handle_, lib_.threading_layer.c_str()), "cudssSetThreadingLayer");
    check(lib_.cudssConfigCreate(&config_), "cudssConfigCreate");
    check(lib_.cudssDataCreate(handle_, &data_), "cudssDataCreate");
    set(CUDSS_CONFIG_HOST_NTHREADS, threads, "host threads");
    refine(0);
    check(lib_.cudssMatrixCreateCsr(&matrix_, n_, n_, system.a.offsets.back(), offsets_.get(), nullptr,
                                    columns_.get(), values_.get(), CUDA_R_32I, CUDA_R_32I, CUDA_R_64F,
                                    CUDSS_MTYPE_GENERAL, CUDSS_MVIEW_FULL, CUDSS_BASE_ZERO),
          "cudssMatrixCreateCsr");
    for (int many = 0; many < 2; ++many) {
      dense(&rhs_[many], b_.get(), many ? kColumns : 1);
      dense(&solution_[many], x_.get(), many ? kColumns : 1);
    }
  }

  ~CudssCandidate() override {
    for (cudssMatrix_t matrix : {matrix_, rhs_[0], rhs_[1], solution_[0], solution_[1]}) {
      if (matrix) lib_.cudssMatrixDestroy(matrix);
    }
    if (data_) lib_.cudssDataDestroy(handle_, data_);
    if (config_) lib_.cudssConfigDestroy(config_);
    if (handle_) lib_.cudssDestroy(handle_);
    cudaDeviceSynchronize();
  }
  CudssCandidate(const CudssCandidate&) = delete;
  CudssCandidate& operator=(const CudssCandidate&) = delete;

  AnalysisTime analyze() override {
    const Stopwatch reordering_watch;
    execute(CUDSS_PHASE_REORDERING, 1, "reordering");
    const double reordering = reordering_watch.seconds();
    const Stopwatch symbolic_watch;
    execute(CUDSS_PHASE_SYMBOLIC_FACTORIZATION, 1, "symbolic factorization");
    return {reordering, symbolic_watch.seconds()};
  }
  void factor() override { execute(CUDSS_PHASE_FACTORIZATION, 1, "factorization"); }
  void refactor() override { execute(CUDSS_PHASE_REFACTORIZATION, 1, "refactorization"); }
  void solve(int columns) override { execute(CUDSS_PHASE_SOLVE, columns, "solve"); }

  void read_solution(int columns, double* x) override {
    const std::size_t bytes = static_cast<std::size_t>(n_ * columns) * sizeof(double);
    check(cudaMemcpy(x, x_.get(), bytes, cudaMemcpyDeviceToHost), "cudaMemcpy");
  }
  bool refine(int steps) override {
    set(CUDSS_CONFIG_IR_N_STEPS, steps, "refinement steps");
    refinement_steps_ = steps;
    return true;
  }

  std::int64_t caller_bytes(int columns) const override {
    return (nnz_ + 2 * n_ * columns) * static_cast<std::int64_t>(sizeof(double)) +
           (nnz_ + n_ + 1) * static_cast<std::int64_t>(sizeof(int));
  }
  Facts facts() override {
    Facts facts;
    int major = 0, minor = 0, patch = 0;
    lib_.cudssGetProperty(MAJOR_VERSION, &major);
    lib_.cudssGetProperty(MINOR_VERSION, &minor);
    lib_.cudssGetProperty(PATCH_LEVEL, &patch);
    facts.version = std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch);
    facts.vectors = "device";
    facts.factor_entries = get<std::int64_t>(CUDSS_DATA_LU_NNZ);
    facts.flops = static_cast<double>(get<std::int64_t>(CUDSS_DATA_FLOPS));
    facts.perturbed_pivots = get<int>(CUDSS_DATA_NPIVOTS);
    facts.refinement_steps = refinement_steps_;
    // Permanent and peak bytes of the device, then of the host.
    struct Estimates {
      std::int64_t bytes[16];
    };
    facts.device_bytes = get<Estimates>(CUDSS_DATA_MEMORY_ESTIMATES).bytes[1];
    return facts;
  }

 private:
  static const std::vector<std::int64_t>& offsets_of(const FamilyMatrix& a) {
    if (a.offsets.back() > std::numeric_limits<int>::max())
      throw std::runtime_error("more entries than 32-bit offsets count");
    return a.offsets;
  }
  void dense(cudssMatrix_t* matrix, double* values, int columns) {
    check(lib_.cudssMatrixCreateDn(matrix, n_, columns, n_, values, CUDA_R_64F, CUDSS_LAYOUT_COL_MAJOR),
          "cudssMatrixCreateDn");
  }
  void set(cudssConfigParam_t parameter, int value, const char* what) {
    check(lib_.cudssConfigSet(config_, parameter, &value, sizeof value), what);
  }
  // What this cuDSS does not know stays zero.
  template <class T>
  T get(cudssDataParam_t parameter) const {
    T value{};
    std::size_t written = 0;
    lib_.cudssDataGet(handle_, data_, parameter, &value, sizeof value, &written);
    return value;
  }
  void execute(int phase, int columns, const char* what) {
    const int many = columns > 1;
    check(lib_.cudssExecute(handle_, phase, config_, data_, matrix_, solution_[many], rhs_[many]), what);
    check(cudaDeviceSynchronize(), what);
  }

  const CudssLibrary& lib_;
  std::int64_t n_, nnz_;
  DeviceArray<int> offsets_, columns_;
  DeviceArray<double> values_, b_, x_;
  cudssHandle_t handle_ = nullptr;
  cudssConfig_t config_ = nullptr;
  cudssData_t data_ = nullptr;
  cudssMatrix_t matrix_ = nullptr, rhs_[2] = {}, solution_[2] = {};
  int refinement_steps_ = 0;
};

}  // namespace

std::function<std::unique_ptr<Candidate>(const System&)> load_cudss(const std::string& folder, int threads) {
  const auto library = std::make_shared<const CudssLibrary>(folder);
  return [library, threads](const System& system) -> std::unique_ptr<Candidate> {
    return std::make_unique<CudssCandidate>(*library, system, threads);
  };
}

}  // namespace mfs::perf

#endif
