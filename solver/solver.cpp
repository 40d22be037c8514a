#include <mfs/solver.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <new>
#include <optional>
#include <string>

#include "kernels/engine.hpp"
#include "kernels/factorization.hpp"
#include "ordering/matrix_check.hpp"
#include "ordering/merge_fronts.hpp"
#include "ordering/stopwatch.hpp"
#include "solver/analysis.hpp"
#include "solver/backend.hpp"
#include "solver/failing_system.hpp"
#include "solver/memory_limit.hpp"

namespace mfs {

namespace {

// Where a running phase is; written by the engine's thread, told to the caller's callback by the caller's
// thread.
struct ProgressState {
  std::atomic<const char*> phase{nullptr};
  std::atomic<double> fraction{0};
};

template <class Scalar>
double default_pivot_tolerance() {
  return std::sqrt(static_cast<double>(std::numeric_limits<RealOf<Scalar>>::epsilon()));
}

template <class Scalar>
double default_tolerance() {
  return std::is_same_v<RealOf<Scalar>, double> ? 1e-12 : 1e-6;
}

void check_options(const Options& options) {
  const auto refuse = [](const char* name, const char* what) { throw InvalidInput(name, what); };
  if (options.analysis.max_block_size < 1) refuse("max_block_size", "must be at least 1");
  if (options.analysis.leaf_size < 1) refuse("leaf_size", "must be at least 1");
  if (options.analysis.separator_trials < 1) refuse("separator_trials", "must be at least 1");
  if (options.analysis.separator_refinement < 1) refuse("separator_refinement", "must be at least 1");
  if (!(options.analysis.dense_row > 0)) refuse("dense_row", "must be positive");
  if (options.threads < 0) refuse("threads", "must not be negative");
  if (!(options.factor.pivot_tolerance >= 0 && options.factor.pivot_tolerance < 1)) {
    refuse("pivot_tolerance", "must be in [0, 1)");
  }
  if (options.factor.max_reanalyses < 0) refuse("max_reanalyses", "must not be negative");
  if (!(options.solve.tolerance >= 0)) refuse("tolerance", "must not be negative");
  if (options.solve.max_refinement_steps < 0) refuse("max_refinement_steps", "must not be negative");
  check_backend(options.backend);
}

// Memory that is not there comes out as one of our errors, be it missed for the text of another one.
template <class Call>
auto at_the_border(const Call& call) {
  try {
    return call();
  } catch (const std::bad_alloc&) {
    throw OutOfMemory(MemorySpace::host, 0, available_host_memory());
  }
}

}  // namespace

template <class Scalar>
class BasicSolver<Scalar>::Impl {
 public:
  explicit Impl(Options options) : options_(std::move(options)) {
    check_options(options_);
    tolerance_ = options_.solve.tolerance > 0 ? options_.solve.tolerance : default_tolerance<Scalar>();
    threads_ = options_.backend == Backend::serial ? 1
               : options_.threads                  ? options_.threads
                                                   : available_threads();
    report_.backend = options_.backend;
    report_.threads = threads_;
    report_.single_precision = mixed();
  }

  void analyze(const CsrView<Scalar>& a) {
    forget();
    run("matching", [&] {
      analysis_ = analyze_matrix(a, options_.analysis, threads_,
                                 [this](const char* phase, double fraction) { tell(phase, fraction); });
    });
    analyzed_with_values_ = a.values != nullptr;
    report_analysis();
  }

  // The first factorization also takes the memory; later ones only fill it.
  void factor(const CsrView<Scalar>& a) {
    if (!analysis_) {
      analyze(a);
    } else {
      check_same_pattern(*analysis_->pattern, a, threads_);
      if (!analyzed_with_values_) analyze(a);  // the values decide about matching and scaling
    }
    check_values(a, threads_);
    const Stopwatch watch;
    const bool first = !numeric_;
    if (first) {
      make_numeric();
      refactored_ = false;
      run_factor(a);
      const Stopwatch enlarging;
      enlarge_pivot_blocks();
      if (report_.reanalyses > 0) report_.time_reanalyses = enlarging.seconds();
    } else {
      factor_other_values(a);
    }
    report_.time_factor = watch.seconds();
  }

  void refactor(const CsrView<Scalar>& a) {
    if (!numeric_) throw StateError("refactor: the matrix has not been factored");
    const Stopwatch watch;
    check_same_pattern(*analysis_->pattern, a, threads_);
    refactor_known(a, watch);
  }

  void refactor(const Scalar* values) {
    if (!numeric_) throw StateError("refactor: the matrix has not been factored");
    refactor_known(caller_view(values), Stopwatch());
  }

  void solve(const Scalar* b, Scalar* x, Offset nrhs, Offset ldb, Offset ldx, bool transposed) {
    if (!factored_) throw StateError("solve: the matrix has not been factored");
    const Offset n = analysis_->pattern->n;
    if (ldb == 0) ldb = n;
    if (ldx == 0) ldx = n;
    check_places(b, x, nrhs, ldb, ldx);
    check_finite(b, nrhs, ldb);
    const Stopwatch watch;
    begin_solve();
    for (Offset first = 0; first < nrhs; first += kSolveColumns) {
      const Vertex columns = static_cast<Vertex>(std::min<Offset>(kSolveColumns, nrhs - first));
      // A failing block is left with its own right-hand sides: those before it may lie under their solutions.
      run_phase(
          options_.dump_prefix,
          [&] { solve_block(b + first * ldb, ldb, x + first * ldx, ldx, columns, transposed); },
          [&] {
            return System<Scalar>{factored_matrix(), b + first * ldb, columns, ldb, transposed};
          });
      tell("solve", static_cast<double>(first + columns) / static_cast<double>(nrhs));
    }
    watch_effort();
    report_.time_solve = watch.seconds();
  }

  void refactor_device(const Scalar* values, void* stream) {
    DeviceFactors<Scalar>& device = device_factors("refactor_device", numeric_ != nullptr);
    if (!values) throw InvalidInput("values", "null pointer");
    const Stopwatch watch;
    // Sums of repeated entries, a new matching, and what is wrong with the values are left to the host.
    bool taken = false;
    if (analysis_->pattern->slot_of_entry.empty() && !drifted_) {
      factored_ = false;
      run("factor", [&] { taken = device.take_values(values, stream); });
    }
    if (taken) {
      refactored_ = true;
      strengthened_ = 0;
      factor_values();
    } else {
      std::vector<Scalar> held(static_cast<std::size_t>(analysis_->pattern->num_entries));
      const Offset count = static_cast<Offset>(held.size());
      run("factor", [&] { device.download(values, count, count, 1, held.data(), stream); });
      refactor(held.data());
    }
    report_.time_refactor = watch.seconds();
  }

  void solve_device(const Scalar* b, Scalar* x, Offset nrhs, Offset ldb, Offset ldx, bool transposed,
                    void* stream) {
    device_factors("solve_device", factored_);
    const Offset n = analysis_->pattern->n;
    if (ldb == 0) ldb = n;
    if (ldx == 0) ldx = n;
    check_places(b, x, nrhs, ldb, ldx);
    const Stopwatch watch;
    begin_solve();
    for (Offset first = 0; first < nrhs; first += kSolveColumns) {
      const Vertex columns = static_cast<Vertex>(std::min<Offset>(kSolveColumns, nrhs - first));
      solve_device_block(b + first * ldb, ldb, x + first * ldx, ldx, columns, transposed, stream);
      tell("solve", static_cast<double>(first + columns) / static_cast<double>(nrhs));
    }
    watch_effort();
    report_.time_solve = watch.seconds();
  }

  double condition_estimate() {
    if (!factored_) throw StateError("condition_estimate: the matrix has not been factored");
    double condition = 0;
    run("solve", [&] {
      make_transposed();
      condition = numeric_->condition_estimate(*transposed_pattern_);
    });
    if (std::isnan(condition)) throw AccuracyNotReached(std::numeric_limits<double>::infinity(), tolerance_);
    return condition;
  }

  Determinant<Scalar> determinant() {
    if (!factored_) throw StateError("determinant: the matrix has not been factored");
    Determinant<Scalar> result{};
    bool known = false;
    run("solve", [&] { known = numeric_->determinant(result.phase, result.log_abs); });
    if (!known) throw AccuracyNotReached(std::numeric_limits<double>::infinity(), tolerance_);
    return result;
  }

  CsrView<Scalar> caller_view(const Scalar* values) const { return analysis_->caller_view(values); }
  bool analyzed() const { return analysis_.has_value(); }
  bool factored() const { return factored_; }
  const Report& report() const { return report_; }
  const Options& options() const { return options_; }

  std::vector<DepthSummary> depths() const {
    std::vector<DepthSummary> table;
    if (!analysis_) return table;
    const SymbolicPlan& plan = *analysis_->plan;
    for (Vertex depth = 0; depth < plan.num_depths; ++depth) {
      const Vertex step = plan.num_depths - 1 - depth;
      DepthSummary& row = table.emplace_back();
      row.depth = depth;
      for (Vertex f = plan.depth_begin[step]; f < plan.depth_begin[step + 1]; ++f) {
        const std::int64_t p = plan.pivots(f), border = plan.border_rows(f);
        const BlockFlops flops = plan.flops_of(f);
        ++row.fronts;
        row.pivots += p;
        row.max_front = std::max(row.max_front, p + border);
        row.factor_entries += p * p + 2 * p * border;
        row.contribution_entries += border * border;
        row.flops.getrf += flops.getrf;
        row.flops.trsm += flops.trsm;
        row.flops.gemm += flops.gemm;
      }
    }
    return table;
  }

 private:
  // Rows sorted, repeated entries summed.
  CsrView<Scalar> factored_matrix() const {
    if (!numeric_) throw StateError("its values are not held any more");
    const Pattern& pattern = *analysis_->pattern;
    return {pattern.n, pattern.n, pattern.offsets.data(), pattern.columns.data(), numeric_->matrix_values()};
  }

  DeviceFactors<Scalar>& device_factors(const char* call, bool factored) {
    if (!factored) throw StateError(std::string(call) + ": the matrix has not been factored");
    DeviceFactors<Scalar>* device = numeric_->device();
    if (!device) throw StateError(std::string(call) + ": the factors are not on a device");
    return *device;
  }

  // On the device, or where that is not enough by way of the host.
  void solve_device_block(const Scalar* b, Offset ldb, Scalar* x, Offset ldx, Vertex columns, bool transposed,
                          void* stream) {
    const SolveControls controls{tolerance_, options_.solve.max_refinement_steps};
    SolveOutcome outcome;
    bool solved = false;
    run("solve", [&] {
      if (transposed) make_transposed();
      solved = numeric_->device()->solve_resident(
          b, ldb, x, ldx, columns, transposed ? &*transposed_pattern_ : nullptr, controls, stream, outcome);
    });
    if (solved) {
      note_outcome(outcome);
      report_.time_ladder += outcome.time_ladder;
      report_.backward_error = std::max(report_.backward_error, outcome.backward_error);
      return;
    }
    const Offset n = analysis_->pattern->n;
    std::vector<Scalar> held(static_cast<std::size_t>(n) * columns);
    run("solve", [&] { numeric_->device()->download(b, ldb, n, columns, held.data(), stream); });
    check_finite(held.data(), columns, n);
    run_phase(
        options_.dump_prefix, [&] { solve_block(held.data(), n, held.data(), n, columns, transposed); },
        [&] {
          return System<Scalar>{factored_matrix(), held.data(), columns, n, transposed};
        });
    run("solve", [&] { numeric_->device()->upload(held.data(), n, columns, x, ldx, stream); });
  }

  void begin_solve() {
    report_.rung = Rung::factors;
    report_.time_ladder = 0;
    report_.refinement_steps = 0;
    report_.krylov_steps = 0;
    report_.corrected_pivots = 0;
    report_.backward_error = 0;
  }

  void make_transposed() {
    if (!transposed_pattern_) transposed_pattern_ = transpose(*analysis_->pattern);
  }

  void refactor_known(const CsrView<Scalar>& a, const Stopwatch& watch) {
    check_values(a, threads_);
    factor_other_values(a);
    report_.time_refactor = watch.seconds();
  }

  // Runs work on the engine's thread. What it throws comes out here as one of ours.
  template <class Work>
  void run(const char* phase, Work&& work) {
    tell(phase, 0.0);
    log(1, phase);
    try {
      if (options_.progress) {
        Engine::instance().run(threads_, std::ref(work), [this] { report_progress(); });
        report_progress();
      } else {
        Engine::instance().run(threads_, std::ref(work));
      }
    } catch (const std::bad_alloc&) {
      throw OutOfMemory(MemorySpace::host, 0, available_host_memory());
    }
  }

  void tell(const char* phase, double fraction) {
    progress_.phase = phase;
    progress_.fraction = fraction;
  }
  void report_progress() { options_.progress(Progress{progress_.phase, progress_.fraction}); }

  bool logs(int level) const { return options_.log && options_.verbosity >= level; }
  void log(int level, const std::string& line) {
    if (logs(level)) options_.log(line);
  }

  void forget() {
    factored_ = refactored_ = drifted_ = false;
    usual_effort_ = 0;
    rematches_ = 0;
    numeric_.reset();
    transposed_pattern_.reset();
    analysis_.reset();
    const Report empty;
    report_ = empty;
    report_.backend = options_.backend;
    report_.threads = threads_;
    report_.single_precision = mixed();
  }

  bool mixed() const {
    return options_.factor.precision == Precision::single && !std::is_same_v<Scalar, Narrow<Scalar>>;
  }

  NumericBytes factor_bytes(const SymbolicPlan& plan) const {
    return numeric_bytes(plan, report_.single_precision ? sizeof(Narrow<Scalar>) : sizeof(Scalar),
                         sizeof(Scalar));
  }

  void make_numeric() {
    std::unique_ptr<Factorization<Scalar>> made;
    run("factor", [&] {
      made = make_numeric_factorization<Scalar>(options_.backend, report_.single_precision, analysis_->plan,
                                                analysis_->pattern, threads_);
      std::copy(analysis_->matched.row_scale.begin(), analysis_->matched.row_scale.end(), made->row_scale());
      std::copy(analysis_->matched.column_scale.begin(), analysis_->matched.column_scale.end(),
                made->column_scale());
    });
    numeric_ = std::move(made);
  }

  void run_factor(const CsrView<Scalar>& a) {
    take_values(a);
    factor_values();
  }

  // For an object that has been factored before.
  void factor_other_values(const CsrView<Scalar>& a) {
    refactored_ = true;
    if (drifted_) {
      take_values(a);
      rematch();
    } else {
      run_factor(a);
    }
  }

  void take_values(const CsrView<Scalar>& a) {
    factored_ = false;
    strengthened_ = 0;
    run("factor", [&] { sum_into_slots(*analysis_->pattern, a, numeric_->matrix_values(), threads_); });
  }

  // Notes what solves need at first after an analysis. Where they need clearly more for later values, these
  // have drifted away from the matching and the scales, and the next refactor makes new ones: not for ever,
  // as values may go to and fro.
  void watch_effort() {
    constexpr std::int64_t kMore = 4;
    const std::int64_t effort = report_.refinement_steps + report_.krylov_steps + report_.corrected_pivots;
    if (!refactored_) {
      usual_effort_ = effort;
    } else if (effort > usual_effort_ + kMore && rematches_ < options_.factor.max_reanalyses) {
      drifted_ = true;
    }
  }

  double pivot_tolerance() const {
    return options_.factor.pivot_tolerance > 0 ? options_.factor.pivot_tolerance
           : report_.single_precision          ? default_pivot_tolerance<Narrow<Scalar>>()
                                               : default_pivot_tolerance<Scalar>();
  }

  void factor_values() { factor_values(pivot_tolerance()); }

  // Factors what is in matrix_values().
  void factor_values(double tolerance) {
    FactorStatus status{};
    const auto factor_progress = [this](double fraction) { tell("factor", fraction); };
    run("factor", [&] { status = numeric_->factor(tolerance, std::ref(factor_progress)); });
    factored_ = true;
    report_.flops_used = {status.getrf, status.trsm, status.gemm};
    report_.perturbed_pivots = static_cast<std::int64_t>(status.perturbed);
    report_.bytes_used = numeric_->bytes();
    nonfinite_ = status.nonfinite > 0;
    if (logs(2)) log(2, "factors: " + std::to_string(report_.perturbed_pivots) + " perturbed pivots");
  }

  // Merges fronts whose pivots failed into their parents while that helps and costs little.
  void enlarge_pivot_blocks() {
    constexpr double kGrowth = 1.5, kFree = 1e8;
    const double allowed = kGrowth * report_.flops.total() + kFree;
    for (int round = 0; round < options_.factor.max_reanalyses && report_.perturbed_pivots > 0; ++round) {
      if (!merge_failed_fronts(allowed)) break;
      replace_numeric();
    }
  }

  // Takes the plan in which the fronts with perturbed pivots are merged into their parents. False where that
  // changes nothing, or costs more operations than allowed or more memory than there is.
  bool merge_failed_fronts(double allowed_flops) {
    std::shared_ptr<const SymbolicPlan> plan;
    std::size_t available = 0;
    run("symbolic", [&] {
      const SeparatorTree tree =
          merge_into_parents(*analysis_->plan, numeric_->failed_fronts(*analysis_->plan));
      plan = std::make_shared<SymbolicPlan>(make_symbolic_plan(
          *analysis_->pattern, analysis_->matched.row_order, tree, options_.analysis.max_block_size));
      available = available_memory(options_.backend);
    });
    const double flops = plan->flops.getrf + plan->flops.trsm + plan->flops.gemm;
    if (plan->num_fronts == analysis_->plan->num_fronts || flops > allowed_flops) return false;
    if (static_cast<std::size_t>(factor_bytes(*plan).total()) > available) return false;
    analysis_->plan = std::move(plan);
    ++report_.reanalyses;
    return true;
  }

  // Pivots large enough to pass can still be small beside their border, and then the factors grow. Factors
  // once with every pivot judged by its border, as threshold pivoting does (tolerance 1: the largest entry),
  // and merges the fronts that have no better ones. False where nothing is left to merge.
  bool strengthen() {
    constexpr double kGrowth = 4, kFree = 2e10;  // a second, against a refusal
    if (strengthened_ >= options_.factor.max_reanalyses) return false;
    ++strengthened_;
    const double allowed = kGrowth * report_.flops.total() + kFree;
    factor_values(1.0);
    if (report_.perturbed_pivots > 0 && merge_failed_fronts(allowed)) {
      replace_numeric();
      return true;
    }
    strengthened_ = options_.factor.max_reanalyses;
    factor_values();
    return false;
  }

  // Makes the factorization anew for the same values, after the plan or the precision has changed.
  void replace_numeric() {
    std::unique_ptr<Factorization<Scalar>> old = std::move(numeric_);  // does not fit any more, come what may
    factored_ = false;
    std::vector<Scalar> values;
    run("factor", [&] {
      values.assign(old->matrix_values(), old->matrix_values() + analysis_->plan->nnz);
      old.reset();
    });
    report_analysis();
    make_numeric();
    std::copy(values.begin(), values.end(), numeric_->matrix_values());
    factor_values();
  }

  // The next rung after all that can be done with the present factors: full precision, then a new matching
  // and tree for values that have changed since the analysis, then larger pivot blocks wherever the factors
  // grow (no help to a singular matrix). False when there is none.
  bool climb(bool singular) {
    if (report_.single_precision) {
      report_.rung = Rung::full_precision;
      report_.single_precision = false;
      replace_numeric();
      return true;
    }
    if (refactored_) {
      report_.rung = Rung::reanalysis;
      rematch();
      return true;
    }
    if (singular) return false;
    report_.rung = Rung::larger_blocks;
    return strengthen();
  }

  // Matching, scaling, ordering and factors anew for the present values.
  void rematch() {
    refactored_ = drifted_ = false;
    ++rematches_;
    run("ordering", [&] {
      reanalyze(*analysis_, numeric_->matrix_values(), options_.analysis, threads_,
                [this](const char* phase, double fraction) { tell(phase, fraction); });
    });
    ++report_.reanalyses;
    replace_numeric();
    enlarge_pivot_blocks();
  }

  // One pass over the present factors, and what can be made of it with them.
  SolveOutcome solve_with_factors(const Scalar* b, Offset ldb, Vertex columns, bool transposed) {
    const Offset n = analysis_->pattern->n;
    const SolveControls controls{tolerance_, options_.solve.max_refinement_steps};
    SolveOutcome outcome;
    run("solve", [&] {
      if (transposed) make_transposed();
      Scalar* rhs = numeric_->rhs(columns);
      for (Vertex j = 0; j < columns; ++j) std::copy(b + j * ldb, b + j * ldb + n, rhs + j * n);
      outcome = numeric_->solve(columns, transposed ? &*transposed_pattern_ : nullptr, controls);
    });
    note_outcome(outcome);
    return outcome;
  }

  void note_outcome(const SolveOutcome& outcome) {
    report_.refinement_steps = std::max(report_.refinement_steps, outcome.refinement_steps);
    report_.krylov_steps = std::max(report_.krylov_steps, outcome.krylov_steps);
    report_.corrected_pivots = std::max<std::int64_t>(report_.corrected_pivots, outcome.corrected_pivots);
    const Rung used = outcome.krylov_steps > 0       ? Rung::krylov
                      : outcome.refinement_steps > 0 ? Rung::refinement
                      : outcome.corrected_pivots > 0 ? Rung::correction
                                                     : Rung::factors;
    report_.rung = std::max(report_.rung, used);
  }

  void solve_block(const Scalar* b, Offset ldb, Scalar* x, Offset ldx, Vertex columns, bool transposed) {
    const Offset n = analysis_->pattern->n;
    SolveOutcome outcome = solve_with_factors(b, ldb, columns, transposed);
    report_.time_ladder += outcome.time_ladder;
    const Stopwatch other_factors;
    bool climbed = false;
    while (!(outcome.backward_error <= tolerance_) && climb(outcome.dependent_rows > 0)) {
      climbed = true;
      outcome = solve_with_factors(b, ldb, columns, transposed);
    }
    if (climbed) report_.time_ladder += other_factors.seconds();
    report_.bytes_used = numeric_->bytes();
    if (!(outcome.backward_error <= tolerance_)) refuse(outcome);
    report_.backward_error = std::max(report_.backward_error, outcome.backward_error);
    const Scalar* solution = numeric_->solution();
    for (Vertex j = 0; j < columns; ++j) std::copy(solution + j * n, solution + (j + 1) * n, x + j * ldx);
  }

  // The tolerance was missed: because A is singular, or in spite of a regular A.
  [[noreturn]] void refuse(const SolveOutcome& outcome) const {
    if (outcome.dependent_rows == 0 || nonfinite_ || analysis_->matched.beyond_range) {
      throw AccuracyNotReached(outcome.backward_error, tolerance_);
    }
    throw SingularMatrix(SingularMatrix::Kind::numerical, outcome.row, outcome.column, outcome.dependent_rows,
                         "the matrix is singular to working precision");
  }

  void check_places(const Scalar* b, const Scalar* x, Offset nrhs, Offset ldb, Offset ldx) const {
    const Offset n = analysis_->pattern->n;
    if (nrhs < 1) throw InvalidInput("nrhs", "must be at least 1");
    if (!b) throw InvalidInput("b", "null pointer");
    if (!x) throw InvalidInput("x", "null pointer");
    if (ldb < n) throw InvalidInput("ldb", "must be at least the number of rows");
    if (ldx < n) throw InvalidInput("ldx", "must be at least the number of rows");
  }

  void check_finite(const Scalar* b, Offset nrhs, Offset ldb) const {
    const Offset n = analysis_->pattern->n;
    for (Offset j = 0; j < nrhs; ++j) {
      for (Offset i = 0; i < n; ++i) {
        if (!std::isfinite(std::abs(b[i + j * ldb]))) throw InvalidInput("b", "NaN or infinity", i, j);
      }
    }
  }

  void report_analysis() {
    const SymbolicPlan& plan = *analysis_->plan;
    const NumericBytes bytes = factor_bytes(plan);
    report_.n = plan.n;
    report_.nnz = plan.nnz;
    report_.matched = analysis_->matched.matched;
    report_.nnz_factor = plan.nnz_factor;
    report_.flops = {plan.flops.getrf, plan.flops.trsm, plan.flops.gemm};
    report_.fronts = plan.num_fronts;
    report_.depths = plan.num_depths;
    report_.max_front = plan.max_front;
    report_.bytes_factor = bytes.factor;
    report_.bytes_peak = bytes.total();
    report_.time_order = analysis_->time_order;
    report_.time_symbolic = analysis_->time_symbolic;
    if (logs(2)) {
      log(2, "plan: " + std::to_string(report_.fronts) + " fronts in " + std::to_string(report_.depths) +
                 " depths, " + std::to_string(report_.nnz_factor) + " factor entries, " +
                 std::to_string(report_.bytes_peak) + " bytes");
    }
  }

  Options options_;
  int threads_ = 1;
  double tolerance_ = 0;
  Report report_;
  std::optional<Analysis> analysis_;
  bool analyzed_with_values_ = false;
  std::unique_ptr<Factorization<Scalar>> numeric_;
  std::optional<TransposedPattern> transposed_pattern_;
  bool factored_ = false;
  bool refactored_ = false;        // the values are not those of the analysis any more
  bool drifted_ = false;           // solves have become dearer: the next refactor matches anew
  std::int64_t usual_effort_ = 0;  // steps that a solve took for the values of the analysis
  int rematches_ = 0;
  int strengthened_ = 0;  // rounds of strengthen() for the present values
  bool nonfinite_ = false;
  ProgressState progress_;
};

template <class Scalar>
BasicSolver<Scalar>::BasicSolver(Options options) try : impl_(std::make_unique<Impl>(std::move(options))) {
} catch (const std::bad_alloc&) {
  throw OutOfMemory(MemorySpace::host, 0, available_host_memory());
}
template <class Scalar>
BasicSolver<Scalar>::~BasicSolver() = default;
template <class Scalar>
BasicSolver<Scalar>::BasicSolver(BasicSolver&&) noexcept = default;
template <class Scalar>
BasicSolver<Scalar>& BasicSolver<Scalar>::operator=(BasicSolver&&) noexcept = default;

// The implementation, unless the object was moved from.
template <class Scalar>
typename BasicSolver<Scalar>::Impl& BasicSolver<Scalar>::impl() const {
  if (!impl_) throw StateError("the solver was moved from");
  return *impl_;
}
template <class Scalar>
void BasicSolver<Scalar>::analyze(const CsrView<Scalar>& a) {
  at_the_border([&] {
    run_phase(
        impl().options().dump_prefix, [&] { impl().analyze(a); }, [&] { return System<Scalar>{a}; });
  });
}
template <class Scalar>
void BasicSolver<Scalar>::factor(const CsrView<Scalar>& a) {
  at_the_border([&] {
    run_phase(
        impl().options().dump_prefix, [&] { impl().factor(a); }, [&] { return System<Scalar>{a}; });
  });
}
template <class Scalar>
void BasicSolver<Scalar>::refactor(const CsrView<Scalar>& a) {
  at_the_border([&] {
    run_phase(
        impl().options().dump_prefix, [&] { impl().refactor(a); }, [&] { return System<Scalar>{a}; });
  });
}
template <class Scalar>
void BasicSolver<Scalar>::refactor(const Scalar* values) {
  at_the_border([&] {
    run_phase(
        impl().options().dump_prefix, [&] { impl().refactor(values); },
        [&] { return System<Scalar>{impl().caller_view(values)}; });
  });
}
template <class Scalar>
void BasicSolver<Scalar>::refactor_device(const Scalar* values, void* stream) {
  at_the_border([&] { impl().refactor_device(values, stream); });
}
template <class Scalar>
void BasicSolver<Scalar>::solve_device(const Scalar* b, Scalar* x, std::int64_t nrhs, std::int64_t ldb,
                                       std::int64_t ldx, void* stream) {
  at_the_border([&] { impl().solve_device(b, x, nrhs, ldb, ldx, false, stream); });
}
template <class Scalar>
void BasicSolver<Scalar>::solve_transpose_device(const Scalar* b, Scalar* x, std::int64_t nrhs,
                                                 std::int64_t ldb, std::int64_t ldx, void* stream) {
  at_the_border([&] { impl().solve_device(b, x, nrhs, ldb, ldx, true, stream); });
}
template <class Scalar>
void BasicSolver<Scalar>::solve(const Scalar* b, Scalar* x, std::int64_t nrhs, std::int64_t ldb,
                                std::int64_t ldx) {
  at_the_border([&] { impl().solve(b, x, nrhs, ldb, ldx, false); });
}
template <class Scalar>
void BasicSolver<Scalar>::solve_transpose(const Scalar* b, Scalar* x, std::int64_t nrhs, std::int64_t ldb,
                                          std::int64_t ldx) {
  at_the_border([&] { impl().solve(b, x, nrhs, ldb, ldx, true); });
}
template <class Scalar>
double BasicSolver<Scalar>::condition_estimate() {
  return at_the_border([&] { return impl().condition_estimate(); });
}
template <class Scalar>
Determinant<Scalar> BasicSolver<Scalar>::determinant() {
  return at_the_border([&] { return impl().determinant(); });
}
template <class Scalar>
bool BasicSolver<Scalar>::analyzed() const {
  return impl_ && impl_->analyzed();
}
template <class Scalar>
bool BasicSolver<Scalar>::factored() const {
  return impl_ && impl_->factored();
}
template <class Scalar>
const Report& BasicSolver<Scalar>::report() const {
  return impl().report();
}
template <class Scalar>
const Options& BasicSolver<Scalar>::options() const {
  return impl().options();
}
template <class Scalar>
std::vector<DepthSummary> BasicSolver<Scalar>::depths() const {
  return impl().depths();
}

template class BasicSolver<float>;
template class BasicSolver<double>;
template class BasicSolver<std::complex<float>>;
template class BasicSolver<std::complex<double>>;

}  // namespace mfs
