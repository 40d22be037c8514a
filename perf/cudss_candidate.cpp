#include "perf/cudss_candidate.hpp"

#include "perf/cudss_library.hpp"

#ifndef MFS_CUDSS

namespace mfs::perf {

std::function<std::unique_ptr<Candidate>(const System&)> load_cudss(const std::string&, int, std::int64_t) {
  refuse_cudss();
}

}  // namespace mfs::perf

#else

#include <algorithm>
#include <limits>

#include "ordering/stopwatch.hpp"

namespace mfs::perf {
namespace {

class CudssCandidate final : public Candidate {
 public:
  CudssCandidate(const CudssLibrary& library, const System& system, int threads, std::int64_t memory_limit)
      : lib_(library),
        n_(system.a.n),
        nnz_(system.a.offsets.back()),
        offsets_(offsets_of(system.a)),
        columns_(system.a.column_indices),
        values_(system.a.values),
        b_(system.b),
        x_(system.b.size()),
        system_(lib_, lib_.threading_layer.c_str(), n_, nnz_, offsets_.get(), columns_.get(), values_.get()) {
    system_.set(CUDSS_CONFIG_HOST_NTHREADS, threads, "host threads");
    if (memory_limit > 0) {
      system_.set(CUDSS_CONFIG_HYBRID_MEMORY_MODE, 1, "hybrid memory mode");
      system_.set(CUDSS_CONFIG_HYBRID_DEVICE_MEMORY_LIMIT, memory_limit, "limit of the device's memory");
    }
    refine(0);
    for (int many = 0; many < 2; ++many) {
      rhs_[many] = system_.vectors(b_.get(), many ? kColumns : 1);
      solution_[many] = system_.vectors(x_.get(), many ? kColumns : 1);
    }
  }

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
    system_.set(CUDSS_CONFIG_IR_N_STEPS, steps, "refinement steps");
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
    facts.factor_entries = system_.get<std::int64_t>(CUDSS_DATA_LU_NNZ);
    facts.flops = static_cast<double>(system_.get<std::int64_t>(CUDSS_DATA_FLOPS));
    facts.perturbed_pivots = system_.get<int>(CUDSS_DATA_NPIVOTS);
    facts.refinement_steps = refinement_steps_;
    // Permanent and peak bytes of the device, then of the host.
    struct Estimates {
      std::int64_t bytes[16];
    };
    facts.device_bytes = system_.get<Estimates>(CUDSS_DATA_MEMORY_ESTIMATES).bytes[1];
    return facts;
  }

 private:
  static const std::vector<std::int64_t>& offsets_of(const FamilyMatrix& a) {
    if (a.offsets.back() > std::numeric_limits<int>::max())
      throw std::runtime_error("more entries than 32-bit offsets count");
    return a.offsets;
  }
  void execute(int phase, int columns, const char* what) {
    const int many = columns > 1;
    system_.execute(phase, solution_[many], rhs_[many], what);
  }

  const CudssLibrary& lib_;
  std::int64_t n_, nnz_;
  DeviceArray<int> offsets_, columns_;
  DeviceArray<double> values_, b_, x_;
  CudssSystem system_;
  cudssMatrix_t rhs_[2] = {}, solution_[2] = {};
  int refinement_steps_ = 0;
};

}  // namespace

std::function<std::unique_ptr<Candidate>(const System&)> load_cudss(const std::string& folder, int threads,
                                                                    std::int64_t memory_limit) {
  const auto library = std::make_shared<const CudssLibrary>(folder);
  return [library, threads, memory_limit](const System& system) -> std::unique_ptr<Candidate> {
    return std::make_unique<CudssCandidate>(*library, system, threads, memory_limit);
  };
}

}  // namespace mfs::perf

#endif
