#include "perf/batch_entrant.hpp"
#include "perf/cudss_library.hpp"

namespace mfs::perf {

#ifndef MFS_CUDSS

std::unique_ptr<BatchEntrant> make_cudss_batch(const BatchCase&, const std::string&, int) {
  refuse_cudss();
}

#else

namespace {

/// A uniform batch: one pattern, the values and vectors of all systems one after the other.
class CudssBatch final : public BatchEntrant {
 public:
  CudssBatch(const BatchCase& batch, const std::string& folder, int refinements)
      : lib_(folder),
        offsets_(batch.a.offsets),
        columns_(batch.a.column_indices),
        values_(batch.values),
        b_(batch.b),
        x_(batch.b.size()),
        numbers_(batch.b.size()),
        system_(lib_, nullptr, batch.a.n, batch.a.offsets.back(), offsets_.get(), columns_.get(),
                values_.get()),
        rhs_(system_.vectors(b_.get(), 1)),
        solution_(system_.vectors(x_.get(), 1)) {
    system_.set(CUDSS_CONFIG_UBATCH_SIZE, static_cast<int>(batch.count), "batch size");
    system_.set(CUDSS_CONFIG_UBATCH_INDEX, -1, "batch index");  // all
    system_.set(CUDSS_CONFIG_IR_N_STEPS, refinements, "refinement");
    analyze([&] {
      execute(CUDSS_PHASE_ANALYSIS, "analysis");
      execute(CUDSS_PHASE_FACTORIZATION, "factorization");
    });
  }

  std::int64_t solve() override {
    execute(CUDSS_PHASE_REFACTORIZATION, "refactorization");
    execute(CUDSS_PHASE_SOLVE, "solve");
    return 0;
  }
  void read(double* x) override {
    check(cudaMemcpy(x, x_.get(), numbers_ * sizeof(double), cudaMemcpyDeviceToHost), "cudaMemcpy");
  }

 private:
  void execute(int phase, const char* what) { system_.execute(phase, solution_, rhs_, what); }

  const CudssLibrary lib_;
  DeviceArray<int> offsets_, columns_;
  DeviceArray<double> values_, b_, x_;
  const std::size_t numbers_;
  CudssSystem system_;
  const cudssMatrix_t rhs_, solution_;
};

}  // namespace

std::unique_ptr<BatchEntrant> make_cudss_batch(const BatchCase& batch, const std::string& folder,
                                               int refinements) {
  return std::make_unique<CudssBatch>(batch, folder, refinements);
}

#endif

}  // namespace mfs::perf
