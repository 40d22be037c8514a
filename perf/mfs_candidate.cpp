#include <algorithm>

#include <mfs/mfs.hpp>

#include "perf/candidate.hpp"
#ifdef MFS_CUDA
#include "perf/device_array.hpp"
#endif

namespace mfs::perf {
namespace {

Options options_for(Backend backend, int threads, std::int64_t memory_limit) {
  Options options;
  options.memory_limit = memory_limit;
  options.threads = threads;
  options.backend = backend;
  return options;
}

class MfsCandidate : public Candidate {
 public:
  MfsCandidate(const System& system, Backend backend, int threads, std::int64_t memory_limit)
      : system_(system), solver_(options_for(backend, threads, memory_limit)), x_(system.b.size()) {}

  AnalysisTime analyze() override {
    solver_.analyze(view());
    return {solver_.report().time_order, solver_.report().time_symbolic};
  }
  void factor() override { solver_.factor(view()); }
  void refactor() override { solver_.refactor(system_.a.values.data()); }
  void solve(int columns) override { solver_.solve(system_.b.data(), x_.data(), columns); }
  void read_solution(int columns, double* x) override { std::copy_n(x_.data(), system_.a.n * columns, x); }
  bool refine(int) override { return false; }
  std::int64_t caller_bytes(int) const override { return 0; }

  Facts facts() override {
    const Report& report = solver_.report();
    Facts facts;
    facts.version = version();
    facts.vectors = "host";
    facts.factor_entries = report.nnz_factor;
    facts.flops = report.flops.total();
    facts.device_bytes = report.bytes_used;
    facts.perturbed_pivots = report.perturbed_pivots;
    facts.refinement_steps = report.refinement_steps;
    facts.segments = report.segments;
    facts.bytes_out = report.bytes_out;
    facts.bytes_in = report.bytes_in;
    facts.bytes_back = report.bytes_back;
    return facts;
  }

 protected:
  Solver& solver() { return solver_; }

 private:
  CsrView<double> view() const {
    const FamilyMatrix& a = system_.a;
    return {a.n, a.n, a.offsets.data(), a.column_indices.data(), a.values.data()};
  }

  const System& system_;
  Solver solver_;
  std::vector<double> x_;
};

#ifdef MFS_CUDA
// Values, right-hand sides and solutions in the memory of the device, as for the others.
class MfsResident final : public MfsCandidate {
 public:
  MfsResident(const System& system, Backend backend, int threads, std::int64_t memory_limit)
      : MfsCandidate(system, backend, threads, memory_limit),
        values_(system.a.values),
        b_(system.b),
        x_(system.b.size()),
        n_(system.a.n),
        nnz_(system.a.offsets.back()) {}

  void factor() override { solver().refactor_device(values_.get()); }
  void refactor() override { solver().refactor_device(values_.get()); }
  void solve(int columns) override { solver().solve_device(b_.get(), x_.get(), columns); }
  void read_solution(int columns, double* x) override {
    check(cudaMemcpy(x, x_.get(), static_cast<std::size_t>(n_) * columns * sizeof(double),
                     cudaMemcpyDeviceToHost),
          "cudaMemcpy");
  }
  std::int64_t caller_bytes(int columns) const override {
    return (nnz_ + 2 * n_ * columns) * static_cast<std::int64_t>(sizeof(double));
  }
  Facts facts() override {
    Facts facts = MfsCandidate::facts();
    facts.vectors = "device";
    return facts;
  }

 private:
  DeviceArray<double> values_, b_, x_;
  std::int64_t n_, nnz_;
};
#endif

}  // namespace

std::unique_ptr<Candidate> make_mfs(const System& system, Backend backend, int threads,
                                    std::int64_t memory_limit) {
#ifdef MFS_CUDA
  if (backend_info(backend).memory == MemorySpace::device)
    return std::make_unique<MfsResident>(system, backend, threads, memory_limit);
#endif
  return std::make_unique<MfsCandidate>(system, backend, threads, memory_limit);
}

}  // namespace mfs::perf
