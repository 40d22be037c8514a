#include <dmumps_c.h>
#include <mpi.h>

#include <cstdlib>
#include <stdexcept>
#include <string>

#include "perf/host_peer.hpp"
#include "perf/peers.hpp"

namespace mfs::perf {

namespace {

/// MPI is there as long as the program is.
void start_mpi() {
  int started = 0;
  MPI_Initialized(&started);
  if (started) return;
  MPI_Init(nullptr, nullptr);
  std::atexit([] { MPI_Finalize(); });
}

/// On one rank, under METIS where it has that. Names of its manual: icntl(7) is parameter(7) here.
class Mumps final : public HostPeer<int> {
 public:
  explicit Mumps(const System& system) : HostPeer(system) {
    start_mpi();
    rows_.reserve(indices_.size());
    for (int row = 0; row < n(); ++row)
      rows_.insert(rows_.end(), static_cast<std::size_t>(offsets_[row + 1] - offsets_[row]), row + 1);
    for (int& column : indices_) ++column;
    constexpr int kWorld = -987654;  // USE_COMM_WORLD
    mumps_.comm_fortran = kWorld;
    mumps_.par = 1;
    mumps_.sym = 0;
    call(-1);
    for (const int stream : {1, 2, 3}) parameter(stream) = -1;
    parameter(4) = 0;
    parameter(7) = 5;
    parameter(14) = 20;
    mumps_.n = n();
    mumps_.nnz = static_cast<MUMPS_INT8>(indices_.size());
    mumps_.irn = rows_.data();
    mumps_.jcn = indices_.data();
    mumps_.a = values();
  }
  ~Mumps() override {
    mumps_.job = -2;
    dmumps_c(&mumps_);
  }
  Mumps(const Mumps&) = delete;
  Mumps& operator=(const Mumps&) = delete;

  AnalysisTime analyze() override {
    call(1);
    return {};
  }
  // What its estimate of memory was short of is given from then on.
  void factor() override {
    constexpr int kWorkspaceTooSmall = -9, kMostPercent = 1000;
    mumps_.job = 2;
    dmumps_c(&mumps_);
    while (mumps_.infog[0] == kWorkspaceTooSmall && parameter(14) < kMostPercent) {
      parameter(14) *= 2;
      dmumps_c(&mumps_);
    }
    check();
  }
  void refactor() override { factor(); }
  void solve(int columns) override {
    std::copy_n(system_.b.data(), system_.a.n * columns, x_.data());
    mumps_.lrhs = n();
    // It refines single right-hand sides alone.
    const int at_once = parameter(10) == 0 ? columns : 1;
    for (int column = 0; column < columns; column += at_once) {
      mumps_.rhs = x_.data() + static_cast<std::ptrdiff_t>(column) * n();
      mumps_.nrhs = at_once;
      call(3);
    }
  }
  bool refine(int steps) override {
    parameter(10) = -steps;
    return true;
  }
  Facts facts() override {
    Facts facts = facts_of(mumps_.version_number);
    const auto entries = static_cast<std::int64_t>(mumps_.infog[28]);
    facts.factor_entries = entries < 0 ? -entries * 1000000 : entries;
    facts.flops = mumps_.rinfog[2];
    facts.device_bytes = static_cast<std::int64_t>(mumps_.infog[21]) * 1000000;
    facts.perturbed_pivots = mumps_.infog[24];
    facts.refinement_steps = mumps_.infog[14];
    return facts;
  }

 private:
  MUMPS_INT& parameter(int number) { return mumps_.icntl[number - 1]; }
  void call(int job) {
    mumps_.job = job;
    dmumps_c(&mumps_);
    check();
  }
  void check() const {
    if (mumps_.infog[0] < 0)
      throw std::runtime_error("MUMPS: infog(1) = " + std::to_string(mumps_.infog[0]) +
                               ", infog(2) = " + std::to_string(mumps_.infog[1]));
  }

  DMUMPS_STRUC_C mumps_{};
  std::vector<int> rows_;
};

}  // namespace

std::unique_ptr<Candidate> make_mumps(const System& system) {
  return std::make_unique<Mumps>(system);
}

}  // namespace mfs::perf
