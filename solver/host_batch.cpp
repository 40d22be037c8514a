#include "solver/host_batch.hpp"

#include <omp.h>

#include <algorithm>
#include <complex>
#include <new>

#include "kernels/dense/blas.hpp"
#include "kernels/runtime/engine.hpp"
#include "kernels/runtime/team.hpp"
#include "solver/backend.hpp"
#include "solver/lane_plan.hpp"
#include "solver/memory_limit.hpp"

namespace mfs {

namespace {

/// What a system that is solved by itself is solved with.
Options options_alone(Options options) {
  options.threads = options.analysis.threads = 1;
  options.progress = nullptr;
  options.log = nullptr;
  return options;
}

void note(SystemReport& report, SystemStatus status, const char* text, std::int64_t row = -1,
          std::int64_t column = -1) {
  report = SystemReport();
  report.status = status;
  report.row = row;
  report.column = column;
  try {
    report.error = text;
  } catch (const std::bad_alloc&) {  // the status says enough
  }
}

/// Calls `solve`; what it throws becomes the report of the system.
template <class Solve>
void solve_or_note(SystemReport& report, const Solve& solve) noexcept {
  try {
    solve();
  } catch (const SingularMatrix& error) {
    note(report, SystemStatus::singular, error.what(), error.row(), error.column());
  } catch (const AccuracyNotReached& error) {
    note(report, SystemStatus::accuracy_not_reached, error.what());
  } catch (const InvalidInput& error) {
    note(report, SystemStatus::invalid_input, error.what(), error.row(), error.column());
  } catch (const OutOfMemory& error) {
    note(report, SystemStatus::out_of_memory, error.what());
  } catch (const std::bad_alloc&) {
    note(report, SystemStatus::out_of_memory, "no memory");
  } catch (const std::exception& error) {
    note(report, SystemStatus::failed, error.what());
  }
}

/// With an analysis of its own.
template <class Scalar>
void solve_alone(const Options& options, const BatchedSystem<Scalar>& system, SystemReport& report) {
  const Offset n = system.a.rows;
  BasicSolver<Scalar> solver(options);
  solver.factor(system.a);
  std::vector<Scalar> x(
      static_cast<std::size_t>(n * system.nrhs));  // written only when all columns are there
  solver.solve(system.b, x.data(), system.nrhs, system.ldb, n);
  for (Offset j = 0; j < system.nrhs; ++j)
    std::copy(x.data() + j * n, x.data() + (j + 1) * n, system.x + j * system.ldx);
  report.backward_error = solver.report().backward_error;
  report.rung = std::max(Rung::reanalysis, solver.report().rung);
}

void check_room(Offset bytes_of_one, std::size_t count) {
  const auto needed = static_cast<std::size_t>(bytes_of_one) * count;
  if (needed > available_host_memory()) throw OutOfMemory(MemorySpace::host, needed, available_host_memory());
}

}  // namespace

template <class Scalar>
HostBatch<Scalar>::HostBatch(const Options& options, Phases& phases, bool single_precision,
                             const Analysis& analysis, const lanes::LaneProgram* program)
    : options_(options),
      alone_(options_alone(options)),
      phases_(phases),
      single_precision_(single_precision),
      analysis_(analysis),
      program_(program) {}

template <class Scalar>
void HostBatch<Scalar>::solve(const Batch<Scalar>& batch, std::vector<SystemReport>& reports) {
  if (program_) {
    share_out(batch.count, lanes::kHostLanes, [&](int team) {
      make_fronts(team);
      make_lanes(team, batch.nrhs);
      return [&](std::size_t thread, Offset first, Offset count) {
        solve_piece(thread, batch, first, count, reports);
      };
    });
  } else {
    share_out(batch.count, 1, [&](int team) {
      make_fronts(team);
      return [&](std::size_t thread, Offset k, Offset) {
        solve_one(thread, batch, k, reports[static_cast<std::size_t>(k)]);
      };
    });
  }
}

template <class Scalar>
void HostBatch<Scalar>::solve(const Batch<Scalar>& batch, const std::vector<Offset>& which,
                              std::vector<SystemReport>& reports) {
  share_out(static_cast<Offset>(which.size()), 1, [&](int team) {
    make_fronts(team);
    return [&](std::size_t thread, Offset place, Offset) {
      const Offset k = which[static_cast<std::size_t>(place)];
      solve_one(thread, batch, k, reports[static_cast<std::size_t>(k)]);
    };
  });
}

// Kokkos' own loops, and a BLAS that only one thread may call, are for one system at a time.
template <class Scalar>
int HostBatch<Scalar>::threads() const {
  return kManyAtWork && blas::many_callers() ? phases_.threads() : 1;
}

template <class Scalar>
void HostBatch<Scalar>::make_fronts(int count) {
  while (fronts_.size() < static_cast<std::size_t>(count)) {
    const auto planned = backend_for<Scalar>(options_.backend)
                             .plan(single_precision_, analysis_.plan, analysis_.pattern, 1, MemoryRoom());
    check_room(planned.bytes.total(), static_cast<std::size_t>(count) - fronts_.size());
    fronts_.push_back(
        std::make_unique<CommonPlan<Scalar>>(options_, analysis_, planned.make(), single_precision_));
  }
}

template <class Scalar>
void HostBatch<Scalar>::make_lanes(int count, Offset nrhs) {
  const lanes::ProgramView program = program_->view();
  if (!lanes_.empty() && lanes_.front()->nrhs() != nrhs) lanes_.clear();
  while (lanes_.size() < static_cast<std::size_t>(count)) {
    check_room(lanes::lane_bytes(program, static_cast<Offset>(sizeof(Scalar)), nrhs),
               static_cast<std::size_t>(count) - lanes_.size());
    lanes_.push_back(std::make_unique<lanes::HostLanes<Scalar>>(program, lane_rules<Scalar>(options_), nrhs));
  }
}

// prepare(team) makes room for so many threads and returns the work: work(thread, first, count) is called for
// pieces of that many systems until none is left.
template <class Scalar>
template <class Prepare>
void HostBatch<Scalar>::share_out(Offset count, Offset piece, const Prepare& prepare) {
  const int team = static_cast<int>(std::min<Offset>(threads(), (count + piece - 1) / piece));
  if (team == 0) return;
  const auto work = prepare(team);
  next_ = 0;
  const auto in_thread = [&] {
    const TeamScope one(1);
    for (Offset first = next_.fetch_add(piece); first < count; first = next_.fetch_add(piece)) {
      work(static_cast<std::size_t>(omp_get_thread_num()), first, std::min(piece, count - first));
      const Offset taken = std::min<Offset>(next_, count);
      phases_.tell("solve", static_cast<double>(taken) / static_cast<double>(count));
    }
  };
  phases_.run_threads("solve", team, [&] {
#pragma omp parallel num_threads(team)
    in_thread();
    phases_.tell("solve", 1.0);
  });
}

template <class Scalar>
void HostBatch<Scalar>::solve_piece(std::size_t thread, const Batch<Scalar>& batch, Offset first,
                                    Offset count, std::vector<SystemReport>& reports) {
  lanes::LaneOutcome outcome[lanes::kHostLanes];
  lanes_[thread]->solve(lane_systems(batch, first, count), outcome);
  for (Offset lane = 0; lane < count; ++lane) {
    SystemReport& report = reports[static_cast<std::size_t>(first + lane)];
    if (!take_outcome(outcome[lane], report)) solve_one(thread, batch, first + lane, report);
  }
}

template <class Scalar>
void HostBatch<Scalar>::solve_one(std::size_t thread, const Batch<Scalar>& batch, Offset k,
                                  SystemReport& report) {
  const BatchedSystem<Scalar> system{analysis_.caller_view(batch.values + k * batch.values_stride),
                                     batch.b + k * batch.b_stride,
                                     batch.x + k * batch.x_stride,
                                     batch.nrhs,
                                     batch.ldb,
                                     batch.ldx};
  solve_or_note(report, [&] {
    BatchedOutcome outcome;
    if (fronts_[thread]->solve(system, outcome)) {
      report.backward_error = outcome.backward_error;
      report.rung = outcome.rung;
    } else {
      solve_alone(alone_, system, report);
    }
  });
}

template class HostBatch<float>;
template class HostBatch<double>;
template class HostBatch<std::complex<float>>;
template class HostBatch<std::complex<double>>;

}  // namespace mfs
