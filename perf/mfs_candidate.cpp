#include <algorithm>

#include <mfs/mfs.hpp>

#include "perf/candidate.hpp"

namespace mfs::perf {
namespace {

Options options_for(Place place, int threads) {
  Options options;
  options.backend = place == Place::device ? Backend::cuda : Backend::openmp;
  options.threads = threads;
  return options;
}

class MfsCandidate final : public Candidate {
 public:
  MfsCandidate(const System& system, Place place, int threads)
      : system_(system), solver_(options_for(place, threads)), x_(system.b.size()) {}

  AnalysisTime analyze() override {
    solver_.analyze(view());
    return {solver_.report().time_order, solver_.report().time_symbolic};
  }
  void factor() override { solver_.factor(view()); }
  void refactor() override { solver_.refactor(system_.a.values.data()); }
  void solve(int columns) override { solver_.solve(system_.b.data(), x_.data(), columns); }
  void read_solution(int columns, double* x) override { std::copy_n(x_.data(), system_.a.n * columns, x); }
  bool refine(int) override { return false; }

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
    return facts;
  }

 private:
  CsrView<double> view() const {
    const FamilyMatrix& a = system_.a;
    return {a.n, a.n, a.offsets.data(), a.column_indices.data(), a.values.data()};
  }

  const System& system_;
  Solver solver_;
  std::vector<double> x_;
};

}  // namespace

std::unique_ptr<Candidate> make_mfs(const System& system, Place place, int threads) {
  return std::make_unique<MfsCandidate>(system, place, threads);
}

}  // namespace mfs::perf
