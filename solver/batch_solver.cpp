#include <mfs/batch_solver.hpp>

#include <algorithm>
#include <functional>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "kernels/lanes/space_lanes.hpp"
#include "ordering/stopwatch.hpp"
#include "solver/backend.hpp"
#include "solver/host_batch.hpp"
#include "solver/lane_plan.hpp"
#include "solver/matrix_factors.hpp"
#include "solver/memory_limit.hpp"
#include "solver/option_checks.hpp"
#include "solver/solve_rules.hpp"

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
  if (options.memory_limit > 0 && rules_of(options.backend).info().memory == MemorySpace::host)
    throw InvalidInput("memory_limit",
                       "batches on the host obey none: each thread has the factors of a system");
  if (!options.out_of_core_dir.empty())
    throw InvalidInput("out_of_core_dir", "factors of a batch do not go to files");
  if (!options.dump_prefix.empty())
    throw InvalidInput("dump_prefix", "systems of a batch are not left in files");
  return options;
}

/// What is analysed, and solved where lanes do not do, whatever the backend.
Options host_options(Options options) {
  if (!rules_of(options.backend).uses_kokkos()) return options;
  options.backend = Backend::openmp;
  options.memory_limit = 0;
  return options;
}

std::vector<Offset> all_of(Offset count) {
  std::vector<Offset> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), Offset{0});
  return all;
}

/// Whether some X_k shares memory with some B_k. With one stride for both they may lie between each other.
template <class Scalar>
bool overlap(const Batch<Scalar>& batch, Offset n) {
  const Offset b_extent = (batch.nrhs - 1) * batch.ldb + n, x_extent = (batch.nrhs - 1) * batch.ldx + n;
  const std::less_equal<const Scalar*> before;
  if (before(batch.b + (batch.count - 1) * batch.b_stride + b_extent, batch.x) ||
      before(batch.x + (batch.count - 1) * batch.x_stride + x_extent, batch.b))
    return false;
  if (batch.b_stride != batch.x_stride) return true;
  const auto size = static_cast<std::intptr_t>(sizeof(Scalar));
  const auto stride = static_cast<std::intptr_t>(batch.b_stride) * size;
  const std::intptr_t apart =
      reinterpret_cast<std::intptr_t>(batch.x) - reinterpret_cast<std::intptr_t>(batch.b);
  const std::intptr_t within = (apart % stride + stride) % stride;
  return within < b_extent * size || within + x_extent * size > stride;
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
  at_least("b_stride", batch.b_stride, addressed("ldb", batch.nrhs, batch.ldb, sizeof(Scalar)));
  at_least("x_stride", batch.x_stride, addressed("ldx", batch.nrhs, batch.ldx, sizeof(Scalar)));
  if (batch.count > 0) {
    addressed("values_stride", batch.count, batch.values_stride, sizeof(Scalar));
    addressed("b_stride", batch.count, batch.b_stride, sizeof(Scalar));
    addressed("x_stride", batch.count, batch.x_stride, sizeof(Scalar));
  }
  if (batch.count == 0) return batch;
  if (!batch.values) throw InvalidInput("values", "null pointer");
  if (!batch.b) throw InvalidInput("b", "null pointer");
  if (!batch.x) throw InvalidInput("x", "null pointer");
  const bool same = batch.b == batch.x && batch.ldb == batch.ldx && batch.b_stride == batch.x_stride;
  if (!same && overlap(batch, n)) throw InvalidInput("x", "overlaps b, but is not the same array");
  return batch;
}

}  // namespace

template <class Scalar>
struct BasicBatchSolver<Scalar>::Impl {
  explicit Impl(Options asked)
      : options(checked(std::move(asked))),
        on_host(host_options(options)),
        in_space(rules_of(options.backend).info().memory == MemorySpace::device),
        model(on_host, phases, report) {}

  void analyze(const CsrView<Scalar>& a) {
    host.reset();
    space.reset();
    program.reset();
    levels.reset();
    systems.clear();
    phases.work_with_one_thread(true);  // each system has one
    const std::optional<ListCost> cost = lane_cost(on_host, report, in_space);
    model.analyze(a, a.values && cost ? &*cost : nullptr);
    if (a.values) {
      model.factor(a);
      program = plan_lanes(on_host, report, model.analysis(), model.numeric());
      if (program && in_space) levels = make_level_schedule(program->program);
      if (program && phases.logs(2)) phases.log(2, described(program->program));
    }
    host = std::make_unique<HostBatch<Scalar>>(on_host, phases, report.single_precision, model.analysis(),
                                               program ? &*program : nullptr);
    report.backend = options.backend;
    analyzed = true;
  }

  std::string described(const ScalarProgram& list) const {
    const std::string text = "list: " + std::to_string(list.products) + " products, " +
                             std::to_string(list.entries()) + " factor entries";
    return levels ? text + ", " + std::to_string(levels->levels) + " levels" : text;
  }

  void solve(const Batch<Scalar>& asked, bool resident, void* stream) {
    const char* const call = resident ? "solve_device" : "solve";
    if (!analyzed) throw StateError(std::string(call) + ": no matrix has been analysed");
    if (resident && !in_space) throw StateError("solve_device: systems are not solved on a device");
    const Analysis& analysis = model.analysis();
    const Batch<Scalar> batch = completed(asked, analysis.pattern->n, analysis.pattern->num_entries);
    const Stopwatch watch;
    systems.assign(static_cast<std::size_t>(batch.count), SystemReport());
    if (batch.count > 0 && in_space) {
      solve_in_space(batch, resident, stream);
    } else if (batch.count > 0) {
      host->solve(batch, systems);
    }
    report.time_solve = watch.seconds();
  }

  // What lanes do not solve, and what they are not for, is left to the host.
  void solve_in_space(const Batch<Scalar>& batch, bool resident, void* stream) {
    std::vector<Offset> left = all_of(batch.count);
    if (program) {
      space_phases.run("solve", [&] {
        make_space(batch);
        std::vector<lanes::LaneOutcome> outcome(left.size());
        space->solve(lane_systems(batch, 0, batch.count), resident, stream, outcome.data());
        left.clear();
        for (Offset k = 0; k < batch.count; ++k) {
          const auto place = static_cast<std::size_t>(k);
          if (!take_outcome(outcome[place], systems[place])) left.push_back(k);
        }
        space_phases.tell("solve", 1.0);
      });
    }
    if (left.empty()) return;
    if (resident) {
      solve_copies(batch, left, stream);
    } else {
      host->solve(batch, left, systems);
    }
  }

  void make_space(const Batch<Scalar>& batch) {
    if (space && space->nrhs() == batch.nrhs && space_for >= batch.count) return;
    space.reset();
    const std::size_t available = rules_of(options.backend).available_memory() / 10 * 9;
    const auto most = static_cast<Offset>(std::min<std::size_t>(available, std::size_t{1} << 40));
    const auto limit = static_cast<Offset>(options.memory_limit);
    space = lanes::make_space_lanes<Scalar>(*program, *levels, lane_rules<Scalar>(on_host), batch.nrhs,
                                            batch.count, limit > 0 ? std::min(limit, most) : most);
    space_for = batch.count;
  }

  // Systems on a device, by way of copies of them without gaps on the host.
  void solve_copies(const Batch<Scalar>& batch, const std::vector<Offset>& left, void* stream) {
    const Offset n = model.analysis().pattern->n, entries = model.analysis().pattern->num_entries;
    const Offset vectors = n * batch.nrhs, count = static_cast<Offset>(left.size());
    std::vector<Scalar> values(static_cast<std::size_t>(count * entries)),
        b(static_cast<std::size_t>(count * vectors)), x(b.size());
    std::vector<lanes::SpaceCopy> copies;
    const auto copy = [&](const Scalar* from, Scalar* to, Offset length) {
      copies.push_back({from, to, length * static_cast<Offset>(sizeof(Scalar))});
    };
    for (Offset i = 0; i < count; ++i) {
      const Offset k = left[static_cast<std::size_t>(i)];
      copy(batch.values + k * batch.values_stride, values.data() + i * entries, entries);
      for (Offset j = 0; j < batch.nrhs; ++j)
        copy(batch.b + k * batch.b_stride + j * batch.ldb, b.data() + i * vectors + j * n, n);
    }
    space_phases.run("solve", [&] { lanes::copy_to_host(copies, stream); });
    std::vector<SystemReport> reports(left.size());
    const Batch<Scalar> copied{count, values.data(), entries, b.data(), x.data(), batch.nrhs, n,
                               n,     vectors,       vectors};
    host->solve(copied, all_of(count), reports);
    copies.clear();
    for (Offset i = 0; i < count; ++i) {
      const Offset k = left[static_cast<std::size_t>(i)];
      systems[static_cast<std::size_t>(k)] = std::move(reports[static_cast<std::size_t>(i)]);
      if (systems[static_cast<std::size_t>(k)].status != SystemStatus::solved) continue;
      for (Offset j = 0; j < batch.nrhs; ++j)
        copy(x.data() + i * vectors + j * n, batch.x + k * batch.x_stride + j * batch.ldx, n);
    }
    space_phases.run("solve", [&] { lanes::copy_to_space(copies, stream); });
  }

  const Options options, on_host;
  const bool in_space;
  Report report;
  Phases phases{on_host, threads_of(on_host), analysis_threads_of(on_host), false};
  Phases space_phases{options, threads_of(options), analysis_threads_of(options), true};
  MatrixFactors<Scalar> model;
  bool analyzed = false;
  std::optional<lanes::LaneProgram> program;  // where it pays
  std::optional<LevelSchedule> levels;        // of the program, for a space
  std::unique_ptr<HostBatch<Scalar>> host;
  std::unique_ptr<lanes::SpaceLanes<Scalar>> space;
  Offset space_for = 0;  // systems, of which there may be room for fewer at a time
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
  told_as_out_of_memory([&] { impl().solve(batch, false, nullptr); });
}
template <class Scalar>
void BasicBatchSolver<Scalar>::solve_device(const Batch<Scalar>& batch, void* stream) {
  told_as_out_of_memory([&] { impl().solve(batch, true, stream); });
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
