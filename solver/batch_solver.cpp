#include <mfs/batch_solver.hpp>

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <new>
#include <string>
#include <utility>

#include <mfs/solver.hpp>

#include "kernels/dense/blas.hpp"
#include "kernels/runtime/engine.hpp"
#include "kernels/runtime/team.hpp"
#include "ordering/stopwatch.hpp"
#include "solver/backend.hpp"
#include "solver/common_plan.hpp"
#include "solver/matrix_factors.hpp"
#include "solver/memory_limit.hpp"
#include "solver/option_checks.hpp"

namespace mfs {

const char* status_name(SystemStatus status) {
  switch (status) {
    case SystemStatus::solved:
      return "solved";
    case SystemStatus::singular:
      return "singular";
    case SystemStatus::accuracy_not_reached:
      return "accuracy_not_reached";
    case SystemStatus::invalid_input:
      return "invalid_input";
    case SystemStatus::out_of_memory:
      return "out_of_memory";
    case SystemStatus::failed:
      return "failed";
  }
  return "unknown";
}

namespace {

Options checked(Options options) {
  check_options(options);
  if (rules_of(options.backend).uses_kokkos())
    throw InvalidInput("backend",
                       std::string("batches are solved on the host, by backend openmp or serial, not by ") +
                           backend_name(options.backend));
  if (!options.dump_prefix.empty())
    throw InvalidInput("dump_prefix", "systems of a batch are not left in files");
  return options;
}

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

/// With numbers in place of zeros. Throws InvalidInput.
template <class Scalar>
Batch<Scalar> completed(Batch<Scalar> batch, Offset n, Offset entries) {
  const auto at_least = [](const char* name, std::int64_t& number, Offset least) {
    if (number == 0) number = least;
    if (number < least) throw InvalidInput(name, "must be at least " + std::to_string(least));
  };
  if (batch.count < 0) throw InvalidInput("count", "must not be negative");
  if (batch.nrhs < 1) throw InvalidInput("nrhs", "must be at least 1");
  at_least("values_stride", batch.values_stride, entries);
  at_least("ldb", batch.ldb, n);
  at_least("ldx", batch.ldx, n);
  at_least("b_stride", batch.b_stride, batch.nrhs * batch.ldb);
  at_least("x_stride", batch.x_stride, batch.nrhs * batch.ldx);
  if (batch.count == 0) return batch;
  if (!batch.values) throw InvalidInput("values", "null pointer");
  if (!batch.b) throw InvalidInput("b", "null pointer");
  if (!batch.x) throw InvalidInput("x", "null pointer");
  const bool same = batch.b == batch.x && batch.ldb == batch.ldx && batch.b_stride == batch.x_stride;
  const std::less_equal<const Scalar*> before;
  const bool apart = before(batch.b + batch.count * batch.b_stride, batch.x) ||
                     before(batch.x + batch.count * batch.x_stride, batch.b);
  if (!same && !apart) throw InvalidInput("x", "overlaps b, but is not the same array");
  return batch;
}

}  // namespace

template <class Scalar>
struct BasicBatchSolver<Scalar>::Impl {
  explicit Impl(Options asked) : options(checked(std::move(asked))), alone(options_alone(options)) {}

  void analyze(const CsrView<Scalar>& a) {
    solvers.clear();
    systems.clear();
    model.analyze(a);
    if (a.values) model.factor(a);
    analyzed = true;
  }

  void solve(const Batch<Scalar>& asked) {
    if (!analyzed) throw StateError("solve: no matrix has been analysed");
    const Analysis& analysis = model.analysis();
    const Batch<Scalar> batch = completed(asked, analysis.pattern->n, analysis.pattern->num_entries);
    const Stopwatch watch;
    const int team = static_cast<int>(std::min<Offset>(threads(), batch.count));
    make_solvers(team);
    systems.assign(static_cast<std::size_t>(batch.count), SystemReport());
    next = 0;
    if (team > 0) {
      phases.run_threads("solve", team, [&] {
#pragma omp parallel num_threads(team)
        work(*solvers[static_cast<std::size_t>(omp_get_thread_num())], batch);
        phases.tell("solve", 1.0);
      });
    }
    report.time_solve = watch.seconds();
  }

  // Kokkos' own loops, and a BLAS that only one thread may call, are for one system at a time.
  int threads() const {
    return kManyAtWork && blas::many_callers() ? phases.threads() : 1;
  }

  void make_solvers(int count) {
    const Analysis& analysis = model.analysis();
    const bool single = report.single_precision;
    while (solvers.size() < static_cast<std::size_t>(count)) {
      const auto planned =
          backend_for<Scalar>(options.backend).plan(single, analysis.plan, analysis.pattern, 1, MemoryRoom());
      const std::size_t missing = static_cast<std::size_t>(count) - solvers.size(),
                        needed = static_cast<std::size_t>(planned.bytes.total()) * missing;
      if (needed > available_host_memory())
        throw OutOfMemory(MemorySpace::host, needed, available_host_memory());
      solvers.push_back(std::make_unique<CommonPlan<Scalar>>(options, analysis, planned.make(), single));
    }
  }

  // One thread of the team: takes systems until none is left.
  void work(CommonPlan<Scalar>& factors, const Batch<Scalar>& batch) {
    const TeamScope one(1);
    for (Offset k = next++; k < batch.count; k = next++) {
      const BatchedSystem<Scalar> system{model.analysis().caller_view(batch.values + k * batch.values_stride),
                                         batch.b + k * batch.b_stride,
                                         batch.x + k * batch.x_stride,
                                         batch.nrhs,
                                         batch.ldb,
                                         batch.ldx};
      SystemReport& found = systems[static_cast<std::size_t>(k)];
      solve_or_note(found, [&] {
        BatchedOutcome outcome;
        if (factors.solve(system, outcome)) {
          found.backward_error = outcome.backward_error;
          found.rung = outcome.rung;
        } else {
          solve_alone(alone, system, found);
        }
      });
      const Offset taken = std::min<Offset>(next, batch.count);
      phases.tell("solve", static_cast<double>(taken) / static_cast<double>(batch.count));
    }
  }

  const Options options, alone;
  Report report;
  Phases phases{options, threads_of(options), analysis_threads_of(options), false};
  MatrixFactors<Scalar> model{options, phases, report};
  bool analyzed = false;
  std::vector<std::unique_ptr<CommonPlan<Scalar>>> solvers;  // one for each thread
  std::atomic<Offset> next{0};                               // system
  std::vector<SystemReport> systems;
};

template <class Scalar>
BasicBatchSolver<Scalar>::BasicBatchSolver(Options options)
    : impl_(told_as_out_of_memory([&] { return std::make_unique<Impl>(std::move(options)); })) {}
template <class Scalar>
BasicBatchSolver<Scalar>::~BasicBatchSolver() = default;
template <class Scalar>
BasicBatchSolver<Scalar>::BasicBatchSolver(BasicBatchSolver&&) noexcept = default;
template <class Scalar>
BasicBatchSolver<Scalar>& BasicBatchSolver<Scalar>::operator=(BasicBatchSolver&&) noexcept = default;

// The implementation, unless the object was moved from.
template <class Scalar>
typename BasicBatchSolver<Scalar>::Impl& BasicBatchSolver<Scalar>::impl() const {
  if (!impl_) throw StateError("the solver was moved from");
  return *impl_;
}
template <class Scalar>
void BasicBatchSolver<Scalar>::analyze(const CsrView<Scalar>& a) {
  told_as_out_of_memory([&] {
    impl().analyzed = false;
    impl().analyze(a);
  });
}
template <class Scalar>
void BasicBatchSolver<Scalar>::solve(const Batch<Scalar>& batch) {
  told_as_out_of_memory([&] { impl().solve(batch); });
}
template <class Scalar>
const std::vector<SystemReport>& BasicBatchSolver<Scalar>::systems() const {
  return impl().systems;
}
template <class Scalar>
std::int64_t BasicBatchSolver<Scalar>::failed() const {
  const std::vector<SystemReport>& all = impl().systems;
  return std::count_if(all.begin(), all.end(),
                       [](const SystemReport& one) { return one.status != SystemStatus::solved; });
}
template <class Scalar>
const Report& BasicBatchSolver<Scalar>::report() const {
  return impl().report;
}

template class BasicBatchSolver<float>;
template class BasicBatchSolver<double>;
template class BasicBatchSolver<std::complex<float>>;
template class BasicBatchSolver<std::complex<double>>;

}  // namespace mfs
