// One matrix and its factors over the life of a solver: analysed once per pattern, factored for one set of
// values after another, and made anew with another plan, matching or precision where the present factors do
// not do (the upper rungs of the accuracy ladder; the lower ones use the factors as they are,
// accuracy/ladder.hpp). Right-hand sides are the business of solver/block_solve.hpp.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <mfs/error.hpp>
#include <mfs/options.hpp>
#include <mfs/report.hpp>

#include "accuracy/factorization.hpp"
#include "ordering/stopwatch.hpp"
#include "solver/analysis.hpp"
#include "solver/backend.hpp"
#include "solver/option_checks.hpp"
#include "solver/phases.hpp"
#include "solver/pivot_knowledge.hpp"

namespace mfs {

template <class Scalar>
class MatrixFactors {
 public:
  /// All three must outlive this; `report` is kept true to what there is.
  MatrixFactors(const Options& options, Phases& phases, Report& report);

  // As BasicSolver's functions of these names; values are checked, the order of calls too. `list`: as
  // order_matrix has it.
  void analyze(const CsrView<Scalar>& a, const ListCost* list = nullptr) {
    make_analysis(a, list);
    if (planned_.early && a.values) make_early(a);
  }
  void factor(const CsrView<Scalar>& a);
  void refactor(const CsrView<Scalar>& a) {
    known("refactor");
    refactor_checked(a, true);
  }
  void refactor(const Scalar* values) { refactor_checked(known("refactor").caller_view(values), false); }
  void refactor_device(const Scalar* values, void* stream);

  bool analyzed() const { return analysis_.has_value(); }
  bool factored() const { return known_ && factored_; }
  /// False where singular must not be said: numbers ran out of range on the way.
  bool within_range() const { return !nonfinite_ && !analysis_->matched.beyond_range; }
  const Analysis& analysis() const { return *analysis_; }
  bool on_device() const { return backend_.info().memory == MemorySpace::device; }
  /// A device searches pivots in tiles and multiplies by inverses of L's blocks, which lets more grow than
  /// the host's search in all rows and substitution do. Where tiny pivots were divided by that may matter.
  bool host_is_better() const { return on_device() && pivots_.tiny == TinyPivots::data; }
  /// These numbers change with each analysis and with each set of values.
  std::int64_t analyses() const { return analyses_; }
  std::int64_t value_sets() const { return value_sets_; }
  /// As Planned has them.
  const std::vector<BlockFlops>& step_flops() const { return step_flops_; }
  Factorization<Scalar>& numeric() const { return *numeric_; }
  /// Of the factors, or of those that are planned.
  const Movement& movement() const { return movement_; }
  /// Made when it is first asked for; inside Phases::run.
  const TransposedPattern& transposed_pattern();

  /// The matrix with its rows sorted and repeated entries summed. Throws StateError where it is not held any
  /// more.
  CsrView<Scalar> factored_matrix() const;
  /// The factors, for what `call` does with them. Throws StateError in its name unless they are there.
  Factorization<Scalar>& numeric(const char* call) const;
  /// Those that must be on a device. Throws StateError in the name of `call` where they are not.
  ResidentFactors<Scalar>& resident(const char* call) const;

  /// The next rung after all that can be done with the present factors: full precision, then a new matching
  /// and tree for values that have changed since the analysis, then perturbed pivots divided by as they are
  /// (for a singular matrix only with SolveOptions::solve_singular), then larger pivot blocks wherever the
  /// factors grow (no help to a singular matrix, nor tried where the host is better). False when there is
  /// none.
  bool climb(bool singular);

  /// The last rung, for one right-hand side b: the present values are factored with rows scaled by the size
  /// that its residual is measured by (ordering/size_scaling.hpp). These scales may be beyond what another b
  /// or an estimate can use: those of the analysis return with the next values, where solves climb again, and
  /// by drop_rescaling().
  void rescale(const Scalar* b, bool transposed);
  /// False where that has nothing to do.
  bool drop_rescaling() {
    const bool had = take_scales_of_analysis();
    if (had) factor_values();
    return had;
  }

  /// Notes what solves need at first after an analysis. Where they need clearly more for later values, these
  /// have drifted away from the matching and the scales, and the next refactor makes new ones: not for ever,
  /// as values may go to and fro. Where many solves need some more, it delays pivots that are small now.
  void watch_effort();

 private:
  const Analysis& known(const char* call) const;
  bool was_given_values() const { return known_ && numeric_; }
  void make_analysis(const CsrView<Scalar>& a, const ListCost* list = nullptr);
  void make_early(const CsrView<Scalar>& a);
  void forget();
  void reset_report();
  void report_analysis();
  PhaseProgress progress() const {
    return [this](const char* phase, double fraction) { phases_.tell(phase, fraction); };
  }
  PlanNeeds plan_needs() const {
    PlanNeeds needs = backend_.plan_needs(phases_.threads_at_work());
    if (low_tree_) needs.height = TreeHeight::low;
    if (!options_.out_of_core_dir.empty()) needs.largest_block = 0;  // factors come back once a solve
    return needs;
  }
  /// Whether entries may have grown from each of many fronts to the next, and an order of ours may be lower.
  bool has_high_tree() const {
    constexpr Vertex kManyDepths = 64;
    return plan_needs().height != TreeHeight::low && !brings_order(options_.analysis) &&
           analysis_->plan->num_depths > kManyDepths;
  }

  Planned<Factorization<Scalar>> planned_for(std::shared_ptr<const SymbolicPlan> plan,
                                             std::shared_ptr<const Pattern> pattern) const;
  void plan_numeric(Analysis& analysis);
  void make_numeric();
  void use_scales(const std::vector<double>& row, const std::vector<double>& column);
  bool take_scales_of_analysis() {
    if (rescaled_) use_scales(analysis_->matched.row_scale, analysis_->matched.column_scale);
    return std::exchange(rescaled_, false);
  }
  void begin_values();
  void replace_numeric(std::size_t most_perturbed = kMostCorrected);
  void take_values(const CsrView<Scalar>& a);
  void check(const CsrView<Scalar>& a, bool pattern);
  void refactor_checked(const CsrView<Scalar>& a, bool pattern);
  void factor_first_values(const CsrView<Scalar>& a);
  void factor_untried_values();
  void factor_other_values(const CsrView<Scalar>& a);
  double pivot_tolerance() const {
    return pivot_tolerance_of<Scalar>(options_.factor, report_.single_precision);
  }
  PivotPolicy policy() const { return pivots_.policy(pivot_tolerance()); }
  void factor_values(std::size_t most_perturbed = kMostCorrected);
  void divide_if_more_fail_than(std::size_t most);
  void factor_values(const PivotPolicy& policy);
  void divide_by_tiny_pivots();
  void forget_tiny_pivots() {
    pivots_.forget_tiny();
    pivots_proved_ = divides_proved_ = false;
  }
  void look_at_diagonal();
  void compare_with_analysis();

  bool delay_while_pivots_fail(double allowed_flops);
  bool delay_first_pivots();
  /// Where pivots of the values of the analysis move.
  double allowed_flops() const { return 1.5 * usual_flops_ + 1e8; }
  bool tree_is_outdated() const;
  void delay_later_pivots();
  bool delay_failed_pivots(Vertex levels, double allowed_flops);
  bool strengthen();
  void rematch();

  const Options& options_;
  const BackendFor<Scalar>& backend_;
  Phases& phases_;
  Report& report_;
  std::optional<Analysis> analysis_;
  std::uint64_t given_values_ = 0;          // fingerprint of the first ones to be factored
  Planned<Factorization<Scalar>> planned_;  // what numeric_ is made of; empty once it is
  std::vector<BlockFlops> step_flops_;
  std::unique_ptr<Factorization<Scalar>> numeric_;
  Movement movement_;
  std::optional<TransposedPattern> transposed_pattern_;
  bool factored_ = false;
  bool known_ = false;             // factor() has had its memory since the analysis
  bool tried_ = false;             // the analysis has factored its values
  bool refactored_ = false;        // the values are not those of the analysis any more
  bool uncompared_ = false;        // with those of the analysis, first ones that came on a device
  bool drifted_ = false;           // solves have become dearer: the next refactor matches anew
  std::int64_t usual_effort_ = 0;  // steps that a solve took for the values of the analysis
  bool low_tree_ = false;          // a high one was left
  int rematches_ = 0;
  double usual_flops_ = 0;        // of the plan of the analysis
  std::int64_t dear_solves_ = 0;  // with more steps than usual since the tree changed
  int later_delays_ = 0;          // changes of the tree for later values
  std::int64_t analyses_ = 0, value_sets_ = 0;
  PivotKnowledge pivots_;
  bool pivots_proved_ = false;    // by a corrected solve: the next factorization divides by them
  bool divides_proved_ = false;   // since then
  bool stays_corrected_ = false;  // that has failed
  bool rescaled_ = false;         // the scales are not those of the analysis
  int strengthened_ = 0;          // rounds of strengthen() for the present values
  bool nonfinite_ = false;
};

}  // namespace mfs
