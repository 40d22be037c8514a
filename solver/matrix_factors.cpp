#include "solver/matrix_factors.hpp"

#include <algorithm>
#include <complex>
#include <future>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <mfs/error.hpp>

#include "ordering/definite.hpp"
#include "ordering/matrix_check.hpp"
#include "ordering/size_scaling.hpp"
#include "plan/delay_pivots.hpp"
#include "solver/plan_report.hpp"
#include "solver/solve_rules.hpp"

namespace mfs {

namespace {

// By which a pivot that failed moves up the tree, first and at most.
constexpr Vertex kLevels = 3, kMostLevels = 96;
/// Solves with more steps than those of the first values before the tree changes for later ones. Each costs a
/// solve more, and a change of the tree 15 (small factors on the host) to 50 of them (on a device).
constexpr int kPatience = 32;
/// Failed pivots that are delayed at most as noise. More are data, of which fewer fail.
constexpr std::size_t kMostDelayed = 128;
/// Operations per unknown up to which the analysis tries its values: 0.2 us on a card, where it takes 1 to 4.
constexpr double kTrialFlops = 4e6;

}  // namespace

template <class Scalar>
MatrixFactors<Scalar>::MatrixFactors(const Options& options, Phases& phases, Report& report)
    : options_(options), backend_(backend_for<Scalar>(options.backend)), phases_(phases), report_(report) {
  reset_report();
}

template <class Scalar>
void MatrixFactors<Scalar>::make_analysis(const CsrView<Scalar>& a, const ListCost* list) {
  forget();
  std::future<void> loading;
  const auto begin_loading = [&](const Pattern& pattern) {
    loading = backend_.load_beside(report_.single_precision, pattern);
  };
  phases_.run_analysis("matching", [&] {
    Analysis analysis = analyze_matrix(a, options_.analysis, plan_needs(), phases_.analysis_threads(),
                                       progress(), begin_loading, list);
    plan_numeric(analysis);
    analysis_ = std::move(analysis);
  });
  report_analysis();
  usual_flops_ = report_.flops.total();
  if (loading.valid()) loading.wait();
}

// A first factorization then takes as long as others: its memory is there, and pivots that fail have moved.
template <class Scalar>
void MatrixFactors<Scalar>::make_early(const CsrView<Scalar>& a) {
  const Stopwatch watch;
  make_numeric();
  if (report_.flops.total() <= kTrialFlops * static_cast<double>(report_.n)) {
    given_values_ = *analysis_->values;
    factor_first_values(a);
    factor_values();  // records what a device has to do
    tried_ = true;
    report_.perturbed_pivots = report_.bytes_used = 0;
    report_.flops_used = {};
  }
  analysis_->time_symbolic += watch.seconds();
  report_.time_symbolic = analysis_->time_symbolic;
}

// The first factorization also takes the memory where the analysis has not; later ones only fill it.
template <class Scalar>
void MatrixFactors<Scalar>::factor(const CsrView<Scalar>& a) {
  const bool known_pattern = analysis_.has_value();
  if (known_pattern) check(a, true);
  if (!known_pattern || !analysis_->values) make_analysis(a);  // the values decide about matching and scaling
  if (!known_pattern) check(a, false);
  const Stopwatch watch;
  if (was_given_values()) {
    factor_other_values(a);
  } else {
    if (!numeric_) make_numeric();
    factored_ = false;
    known_ = true;
    factor_first_values(a);
  }
  report_.time_factor = watch.seconds();
}

template <class Scalar>
void MatrixFactors<Scalar>::refactor_device(const Scalar* values, void* stream) {
  if (!analysis_ || !analysis_->values) throw StateError("refactor_device: no values have been analysed");
  const Stopwatch watch;
  const bool first = !was_given_values();
  if (!numeric_ && on_device()) make_numeric();
  ResidentFactors<Scalar>& factors = resident("refactor_device");
  if (!values) throw InvalidInput("values", "null pointer");
  // Sums of repeated entries, a new matching or tree, and what is wrong with the values are left to the host.
  const bool takes = analysis_->pattern->slot_of_entry.empty() && !drifted_ && !tree_is_outdated();
  bool taken = false;
  phases_.run("factor", [&] {
    factors.require_reachable(values, "values");
    if (!takes) return;
    factored_ = false;
    taken = factors.take_values(values, stream);
  });
  if (taken) {
    known_ = true;
    refactored_ = !first;
    begin_values();
    uncompared_ = first;
    first && !tried_ ? factor_untried_values() : factor_values();
  } else {
    RawVector<Scalar> held(static_cast<std::size_t>(analysis_->pattern->num_entries));
    const Offset count = static_cast<Offset>(held.size());
    phases_.run("factor", [&] { factors.download(values, count, count, 1, held.data(), stream); });
    const CsrView<Scalar> a = analysis_->caller_view(held.data());
    first ? factor(a) : refactor_checked(a, false);
  }
  (first ? report_.time_factor : report_.time_refactor) = watch.seconds();
}

template <class Scalar>
const TransposedPattern& MatrixFactors<Scalar>::transposed_pattern() {
  if (!transposed_pattern_) transposed_pattern_ = transpose(*analysis_->pattern, phases_.threads_at_work());
  return *transposed_pattern_;
}

template <class Scalar>
CsrView<Scalar> MatrixFactors<Scalar>::factored_matrix() const {
  if (!numeric_) throw StateError("its values are not held any more");
  const Pattern& pattern = *analysis_->pattern;
  return {pattern.n, pattern.n, pattern.offsets.data(), pattern.columns.data(),
          numeric_->factors().matrix().values};
}

// The analysis of a matrix that has been factored; not necessarily for the present values.
template <class Scalar>
const Analysis& MatrixFactors<Scalar>::known(const char* call) const {
  if (!was_given_values()) throw StateError(std::string(call) + ": the matrix has not been factored");
  return *analysis_;
}

template <class Scalar>
Factorization<Scalar>& MatrixFactors<Scalar>::numeric(const char* call) const {
  if (!factored()) throw StateError(std::string(call) + ": the matrix has not been factored");
  return *numeric_;
}

template <class Scalar>
ResidentFactors<Scalar>& MatrixFactors<Scalar>::resident(const char* call) const {
  ResidentFactors<Scalar>* resident = numeric_ ? numeric_->factors().resident() : nullptr;
  if (!resident) throw StateError(std::string(call) + ": the factors are not on a device");
  return *resident;
}

template <class Scalar>
void MatrixFactors<Scalar>::forget() {
  factored_ = known_ = tried_ = refactored_ = drifted_ = false;
  low_tree_ = false;
  usual_effort_ = 0;
  rematches_ = 0;
  stays_corrected_ = false;
  dear_solves_ = later_delays_ = 0;
  forget_tiny_pivots();
  ++analyses_;
  planned_ = {};
  numeric_.reset();
  transposed_pattern_.reset();
  analysis_.reset();
  reset_report();
}

template <class Scalar>
void MatrixFactors<Scalar>::reset_report() {
  report_ = Report();
  report_.backend = options_.backend;
  report_.threads = phases_.threads();
  report_.single_precision = mixed_precision<Scalar>(options_.factor, backend_.automatic_precision());
}

template <class Scalar>
void MatrixFactors<Scalar>::report_analysis() {
  report_.matched = analysis_->matched.matched;
  report_plan(*analysis_->plan, planned_.bytes, planned_.flops, report_);
  step_flops_ = planned_.step_flops;
  movement_ = planned_.movement;
  report_movement(movement_, report_);
  report_.time_order = analysis_->time_order;
  report_.time_symbolic = analysis_->time_symbolic;
  if (phases_.logs(2)) phases_.log(2, plan_line(report_));
}

template <class Scalar>
Planned<Factorization<Scalar>> MatrixFactors<Scalar>::planned_for(
    std::shared_ptr<const SymbolicPlan> plan, std::shared_ptr<const Pattern> pattern) const {
  const MemoryRoom room{static_cast<Offset>(options_.memory_limit), numeric_ ? numeric_->bytes() : 0,
                        options_.out_of_core_dir};
  return backend_.plan(report_.single_precision, std::move(plan), std::move(pattern), phases_.threads(),
                       room);
}

// What the executor makes of the plan counts as a part of the symbolic phase.
template <class Scalar>
void MatrixFactors<Scalar>::plan_numeric(Analysis& analysis) {
  const Stopwatch watch;
  planned_ = planned_for(analysis.plan, analysis.pattern);
  analysis.time_symbolic += watch.seconds();
}

template <class Scalar>
void MatrixFactors<Scalar>::make_numeric() {
  std::unique_ptr<Factorization<Scalar>> made;
  bool one_thread = false;
  phases_.run("factor", [&] {
    if (!planned_.make) planned_ = planned_for(analysis_->plan, analysis_->pattern);
    const auto planned = std::exchange(planned_, {});  // good once
    one_thread = planned.one_thread;
    made = planned.make();
  });
  numeric_ = std::move(made);
  phases_.work_with_one_thread(one_thread);
  movement_ = numeric_->factors().movement();  // of a plan for less memory, perhaps
  report_movement(movement_, report_);
  use_scales(analysis_->matched.row_scale, analysis_->matched.column_scale);
}

template <class Scalar>
void MatrixFactors<Scalar>::use_scales(const std::vector<double>& row, const std::vector<double>& column) {
  const Offset n = analysis_->pattern->n;
  phases_.run("factor", [&] {
    const int threads = phases_.threads_at_work();
    copy_columns(n, 1, row.data(), n, numeric_->factors().row_scale(), n, threads);
    copy_columns(n, 1, column.data(), n, numeric_->factors().column_scale(), n, threads);
  });
}

template <class Scalar>
void MatrixFactors<Scalar>::rescale(const Scalar* b, bool transposed) {
  report_.rung = Rung::rescaling;
  std::vector<double> row, column;
  phases_.run("factor", [&] {
    const PowerScaling scaling = scaling_by_size(*analysis_->pattern, numeric_->factors().matrix().values, b,
                                                 transposed, phases_.threads_at_work());
    row = powers_of_two(scaling.row, phases_.threads_at_work());
    column = powers_of_two(scaling.column, phases_.threads_at_work());
  });
  use_scales(row, column);
  rescaled_ = true;
  factor_values();
}

// Also of the pattern, unless it is the analysed one by construction.
template <class Scalar>
void MatrixFactors<Scalar>::check(const CsrView<Scalar>& a, bool pattern) {
  phases_.run("factor", [&] {
    if (pattern) check_same_pattern(*analysis_->pattern, a, phases_.threads_at_work());
    check_values(a, phases_.threads_at_work(), was_given_values() ? nullptr : &given_values_);
  });
}

template <class Scalar>
void MatrixFactors<Scalar>::refactor_checked(const CsrView<Scalar>& a, bool pattern) {
  const Stopwatch watch;
  check(a, pattern);
  factor_other_values(a);
  report_.time_refactor = watch.seconds();
}

// The first since the analysis, whose values they need not be.
template <class Scalar>
void MatrixFactors<Scalar>::factor_first_values(const CsrView<Scalar>& a) {
  refactored_ = given_values_ != analysis_->values;
  take_values(a);
  tried_ && !refactored_ ? factor_values() : factor_untried_values();
}

// Nothing is known of the pivots of what is in matrix_values().
template <class Scalar>
void MatrixFactors<Scalar>::factor_untried_values() {
  forget_tiny_pivots();
  look_at_diagonal();
  factor_values(kMostDelayed);
  const Stopwatch delaying;
  if (delay_first_pivots()) report_.time_reanalyses = delaying.seconds();
}

// For an object that has been factored before.
template <class Scalar>
void MatrixFactors<Scalar>::factor_other_values(const CsrView<Scalar>& a) {
  refactored_ = true;
  take_values(a);
  if (drifted_) {
    rematch();
  } else if (tree_is_outdated()) {
    delay_later_pivots();
  } else {
    factor_values();
  }
}

// What rungs of the ladder did for the values before is forgotten.
template <class Scalar>
void MatrixFactors<Scalar>::begin_values() {
  factored_ = false;
  ++value_sets_;
  strengthened_ = 0;
  uncompared_ = false;
  take_scales_of_analysis();
}

template <class Scalar>
void MatrixFactors<Scalar>::take_values(const CsrView<Scalar>& a) {
  begin_values();
  phases_.run("factor", [&] {
    sum_into_slots(*analysis_->pattern, a, numeric_->factors().matrix_values(), phases_.threads_at_work());
  });
}

// Factors what is in matrix_values().
template <class Scalar>
void MatrixFactors<Scalar>::factor_values(std::size_t most_perturbed) {
  const bool proved = std::exchange(pivots_proved_, false);
  if (proved) {
    divide_by_tiny_pivots();
    divides_proved_ = true;
  }
  PivotPolicy present = policy();
  if (pivots_.tiny == TinyPivots::noise) present.most_perturbed = most_perturbed;
  factor_values(present);
  divide_if_more_fail_than(most_perturbed);
  if (proved) delay_while_pivots_fail(allowed_flops());  // what is too small even to be divided by
}

template <class Scalar>
void MatrixFactors<Scalar>::divide_if_more_fail_than(std::size_t most) {
  if (pivots_.tiny == TinyPivots::data || report_.perturbed_pivots <= static_cast<std::int64_t>(most)) return;
  divide_by_tiny_pivots();
  factor_values(policy());
}

template <class Scalar>
void MatrixFactors<Scalar>::divide_by_tiny_pivots() {
  pivots_.tiny = TinyPivots::data;
  phases_.run("factor", [&] {
    pivots_.definite =
        looks_definite(*analysis_->pattern, numeric_->factors().matrix().values, phases_.threads_at_work());
  });
}

// Exchanges of rows that scaling asks for would only mix what is large with what is small there.
template <class Scalar>
void MatrixFactors<Scalar>::look_at_diagonal() {
  phases_.run("factor", [&] {
    pivots_.dominant = rows_are_dominated(*analysis_->pattern, analysis_->matched.row_order,
                                          numeric_->factors().matrix().values, phases_.threads_at_work());
  });
}

template <class Scalar>
void MatrixFactors<Scalar>::factor_values(const PivotPolicy& policy) {
  FactorStatus status{};
  const auto factor_progress = [this](double fraction) { phases_.tell("factor", fraction); };
  phases_.run("factor", [&] { status = numeric_->factor(policy, std::ref(factor_progress)); });
  factored_ = true;
  report_.flops_used = {status.getrf, status.trsm, status.gemm};
  report_.perturbed_pivots = static_cast<std::int64_t>(status.perturbed);
  report_.bytes_used = numeric_->bytes();
  nonfinite_ = status.nonfinite > 0;
  if (phases_.logs(2))
    phases_.log(2, "factors: " + std::to_string(report_.perturbed_pivots) + " perturbed pivots");
}

// First values that lie on a device are compared only where something depends on it: it takes as long as
// small factors.
template <class Scalar>
void MatrixFactors<Scalar>::compare_with_analysis() {
  if (!std::exchange(uncompared_, false)) return;
  phases_.run("factor", [&] { check_values(factored_matrix(), phases_.threads_at_work(), &given_values_); });
  refactored_ = given_values_ != analysis_->values;
}

template <class Scalar>
bool MatrixFactors<Scalar>::climb(bool singular) {
  if (drop_rescaling()) return true;
  if (report_.single_precision) {
    report_.rung = Rung::full_precision;
    report_.single_precision = false;
    forget_tiny_pivots();
    replace_numeric();
    return true;
  }
  if (pivots_.tiny == TinyPivots::data && divides_proved_) {
    report_.rung = Rung::correction;
    forget_tiny_pivots();
    stays_corrected_ = true;
    factor_values();
    return true;
  }
  compare_with_analysis();
  if (refactored_ || has_high_tree()) {
    low_tree_ |= !refactored_;
    report_.rung = Rung::reanalysis;
    rematch();
    return true;
  }
  if (pivots_.tiny == TinyPivots::noise && report_.perturbed_pivots > 0 &&
      (!singular || options_.solve.solve_singular)) {
    report_.rung = Rung::tiny_pivots;
    divide_by_tiny_pivots();
    factor_values();
    return true;
  }
  if (pivots_.tiny == TinyPivots::data && pivots_.definite) {  // A was not what it looked like
    report_.rung = Rung::tiny_pivots;
    pivots_.definite = pivots_.mirrors = pivots_.dominant = false;
    factor_values();
    return true;
  }
  if (singular || host_is_better()) return false;
  report_.rung = Rung::larger_blocks;
  return strengthen();
}

template <class Scalar>
void MatrixFactors<Scalar>::watch_effort() {
  // A solution by correction proves that A is regular. What is divided by needs no correction, and such
  // solves stay where the factors are; so later values are factored that way, and corrected again should that
  // fail.
  if (report_.corrected_pivots > 0 && pivots_.tiny == TinyPivots::noise) pivots_proved_ = !stays_corrected_;
  // A solve by transposed factors takes a fifth longer on a device, so they wait until they are needed.
  const bool is_real = std::is_same_v<Scalar, RealOf<Scalar>>;  // others that look definite have A = A^H
  if (pivots_.definite && is_real && on_device() && !pivots_.mirrors && report_.refinement_steps > 0) {
    pivots_.mirrors = true;
    phases_.run("solve", [&] { numeric_->factors().resident()->solve_as(policy()); });
  }
  constexpr std::int64_t kMore = 4;
  const std::int64_t effort = report_.refinement_steps + report_.krylov_steps + report_.corrected_pivots;
  if (effort > kMore) compare_with_analysis();
  if (refactored_ && effort > usual_effort_) ++dear_solves_;
  if (!refactored_) {
    usual_effort_ = effort;
  } else if (effort > usual_effort_ + kMore && rematches_ < options_.factor.max_reanalyses) {
    drifted_ = true;
  }
}

// Moves pivots that failed up the tree while that helps and costs little. Three levels are enough for most,
// and cost little more than one, which half of them would have to leave again: a first factorization is one
// of two or three. False where the tree has not changed.
template <class Scalar>
bool MatrixFactors<Scalar>::delay_while_pivots_fail(double allowed_flops) {
  Vertex levels = kLevels;
  int round = 0;
  for (; round < options_.factor.max_reanalyses && report_.perturbed_pivots > 0; ++round) {
    if (!delay_failed_pivots(levels, allowed_flops)) break;
    replace_numeric(kMostDelayed);
    levels = std::min(2 * levels, kMostLevels);
  }
  return round > 0;
}

// False where the tree has not changed.
template <class Scalar>
bool MatrixFactors<Scalar>::delay_first_pivots() {
  const bool delayed = delay_while_pivots_fail(allowed_flops());
  divide_if_more_fail_than(kMostCorrected);
  return delayed;
}

template <class Scalar>
bool MatrixFactors<Scalar>::tree_is_outdated() const {
  return later_delays_ < options_.factor.max_reanalyses && dear_solves_ >= kPatience << later_delays_;
}

// Pivots that fail for later values move as those of the first factorization do; where none of the last ones
// has, those that are small beside their border, too. It may cost each factorization as much as a solve, as
// that is what it saves. Where some cannot move, it is not tried again.
template <class Scalar>
void MatrixFactors<Scalar>::delay_later_pivots() {
  dear_solves_ = 0;
  forget_tiny_pivots();
  if (report_.perturbed_pivots > 0) factor_values(kMostDelayed);
  if (report_.perturbed_pivots == 0) factor_values(pivots_.small_pivot_policy());
  const double solve_flops = backend_.info().flops_per_entry * static_cast<double>(report_.nnz_factor);
  if (delay_while_pivots_fail(usual_flops_ + solve_flops)) {
    divide_if_more_fail_than(kMostCorrected);
  } else {
    factor_values();  // not with those compared
  }
  later_delays_ = report_.perturbed_pivots > 0 ? options_.factor.max_reanalyses : later_delays_ + 1;
}

// Takes the plan in which perturbed pivots belong to an ancestor so many levels up. False where that changes
// nothing, or costs more operations than allowed or more memory than there is.
template <class Scalar>
bool MatrixFactors<Scalar>::delay_failed_pivots(Vertex levels, double allowed_flops) {
  std::shared_ptr<const SymbolicPlan> plan;
  Planned<Factorization<Scalar>> planned;
  DelayedTree delayed;
  bool fits = false;
  phases_.run_analysis("symbolic", [&] {
    const int threads = phases_.analysis_threads();
    std::vector<FailedPivot> failed;
    for (const Vertex p : numeric_->failed_pivots()) failed.push_back({p, numeric_->pivot_row(p)});
    if (!can_move(*analysis_->plan, failed)) return;
    delayed = delay_pivots(*analysis_->plan, failed, levels, threads);
    plan = std::make_shared<SymbolicPlan>(
        make_symbolic_plan(*analysis_->pattern, analysis_->blocks.get(), delayed.row_order, delayed.tree,
                           options_.analysis.max_block_size, threads, plan_needs().turns));
    if (plan->flops.total() > allowed_flops) return;
    try {
      planned = planned_for(plan, analysis_->pattern);
    } catch (const OutOfMemory&) {  // of a limit
      return;
    }
    const auto held = static_cast<std::size_t>(numeric_->bytes());  // by the factors that they replace
    fits = static_cast<std::size_t>(planned.bytes.total()) <= backend_.available_memory() + held;
  });
  if (!fits) return false;
  analysis_->plan = std::move(plan);
  analysis_->matched.row_order = std::move(delayed.row_order);
  planned_ = std::move(planned);
  ++report_.reanalyses;
  return true;
}

// Pivots large enough to pass can still be small beside their border, and then the factors grow. Delays those
// that have no better ones. False where nothing is left to delay.
template <class Scalar>
bool MatrixFactors<Scalar>::strengthen() {
  constexpr double kGrowth = 4, kFree = 2e10;  // a second, against a refusal
  if (strengthened_ >= options_.factor.max_reanalyses) return false;
  ++strengthened_;
  const double allowed = kGrowth * report_.flops.total() + kFree;
  factor_values(pivots_.threshold_policy());
  if (report_.perturbed_pivots > 0 && delay_failed_pivots(kLevels, allowed)) {
    replace_numeric();
    return true;
  }
  strengthened_ = options_.factor.max_reanalyses;
  factor_values();
  return false;
}

// Makes the factorization anew for the same values, after the plan or the precision has changed.
template <class Scalar>
void MatrixFactors<Scalar>::replace_numeric(std::size_t most_perturbed) {
  std::unique_ptr<Factorization<Scalar>> old = std::move(numeric_);  // does not fit any more, come what may
  factored_ = false;
  RawVector<Scalar> values;
  const Offset count = analysis_->pattern->nnz();
  const auto copy_values = [&](const Scalar* from, Scalar* to) {
#pragma omp parallel for num_threads(phases_.threads_at_work()) schedule(static)
    for (Offset slot = 0; slot < count; ++slot) to[slot] = from[slot];
  };
  phases_.run("factor", [&] {
    values.resize(static_cast<std::size_t>(count));
    copy_values(old->factors().matrix().values, values.data());
    old.reset();
    if (!planned_.make) plan_numeric(*analysis_);
  });
  report_analysis();
  make_numeric();
  phases_.run("factor", [&] { copy_values(values.data(), numeric_->factors().matrix_values()); });
  factor_values(most_perturbed);
}

// Matching, scaling, ordering and factors anew for the present values.
template <class Scalar>
void MatrixFactors<Scalar>::rematch() {
  refactored_ = drifted_ = false;
  dear_solves_ = 0;
  forget_tiny_pivots();
  ++rematches_;
  phases_.run_analysis("ordering", [&] {
    reanalyze(*analysis_, numeric_->factors().matrix().values, options_.analysis, plan_needs(),
              phases_.analysis_threads(), progress());
  });
  ++report_.reanalyses;
  look_at_diagonal();
  replace_numeric(kMostDelayed);
  usual_flops_ = report_.flops.total();
  delay_first_pivots();
}

template class MatrixFactors<float>;
template class MatrixFactors<double>;
template class MatrixFactors<std::complex<float>>;
template class MatrixFactors<std::complex<double>>;

}  // namespace mfs
