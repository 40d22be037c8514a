// The accuracy ladder of a solve, wherever the factors lie: from an approximate inverse to a solution whose
// backward error is known, or to the proof that there is none. The rungs in their order:
//
//   correction   pivots that were perturbed are taken back exactly, or show that A is singular
//                (accuracy/correction.hpp); if they are too many for that, a probe decides
//                (accuracy/probe.hpp)
//   refinement   iterative, in twice the precision, then FGMRES with the factors as preconditioner
//   (accuracy/refinement.hpp)
//
// Iterative refinement is one loop (accuracy/iterative_refinement.hpp) wherever the vectors lie. Where the
// factors lie in the memory of a device, it begins there (accuracy/resident_refinement.hpp), and the ladder
// goes on from what it leaves. All else has its vectors and the matrix on the host, where vector operations
// run on Exec. The same inverse gives the condition estimate and the determinant.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "accuracy/correction.hpp"
#include "accuracy/estimates.hpp"
#include "accuracy/factorization.hpp"
#include "accuracy/probe.hpp"
#include "accuracy/refinement.hpp"
#include "accuracy/resident_refinement.hpp"
#include "accuracy/solution_support.hpp"
#include "kernels/runtime/arena.hpp"
#include "kernels/stages/doubled_rows.hpp"
#include "ordering/scaling.hpp"

namespace mfs {

/// Where the vectors of the ladder lie: right-hand sides and solutions in one block of memory, work in
/// another.
struct LadderLayout {
  LadderLayout(Vertex n, Offset value_bytes, Vertex columns) {
    const Offset block = static_cast<Offset>(n) * columns * value_bytes;
    for (Offset* vector : {&b, &x}) *vector = ends.add(block);
    for (Offset* vector : {&best, &r, &d}) *vector = work.add(block);
    size = work.add(n * static_cast<Offset>(sizeof(double)));
  }
  ArenaLayout ends, work;
  Offset b, x, best, r, d, size;
};

template <class Exec, class Value>
class AccuracyLadder final : public Factorization<Value> {
 public:
  AccuracyLadder(std::unique_ptr<Factors<Value>> factors, std::shared_ptr<const SymbolicPlan> plan,
                 std::shared_ptr<const Pattern> pattern)
      : factors_(std::move(factors)), plan_(std::move(plan)), pattern_(std::move(pattern)) {
    take_vectors(1);
  }

  Factors<Value>& factors() override { return *factors_; }

  FactorStatus factor(const PivotPolicy& policy, const std::function<void(double)>& progress) override {
    for (auto& correction : correction_) correction.reset();
    probed_.reset();
    probed_where_factors_lie_ = false;
    balanced_.reset();
    support_.reset();
    divided_by_tiny_ = policy.tiny == TinyPivots::data;
    stalled_ = false;
    const Factored factored = factors_->factor(policy, progress);
    status_ = factored.status;
    largest_ = factored.largest;
    return status_;
  }

  Value* rhs(Vertex columns) override {
    if (columns > columns_) {
      factors_->make_room(columns);
      take_vectors(columns);
    }
    return at_.b;
  }
  const Value* solution() const override { return at_.x; }

  SolveOutcome solve(Vertex columns, const TransposedPattern* transposed, const SolveControls& controls,
                     const SolveOutcome* tried) override {
    SolveOutcome resident;
    if (tried) {
      resident = *tried;
    } else if (factors_->resident() && status_.perturbed == 0 && settled()) {
      const Offset n = plan_->n;
      factors_->resident()->start_from_host({rhs(columns), n, at_.x, n, columns, transposed},
                                            controls.row_floor);
      resident = refine_resident(*factors_->resident(), controls, resident_improved_);
      if (resident.backward_error <= controls.tolerance) return resident;
      tried = &resident;
    }
    matrix_ = factors_->matrix();
    const bool begun = tried && resident_improved_;
    if (begun) factors_->resident()->bring_solution(at_.x);
    SolveOutcome outcome = climb(columns, transposed, controls, begun);
    outcome.refinement_steps += resident.refinement_steps;
    outcome.time_ladder += resident.time_ladder;
    return outcome;
  }

  ResidentSolve solve_resident(const SolveBlock<Value>& block, const SolveControls& controls, void* stream,
                               SolveOutcome& outcome) override {
    if (status_.perturbed > 0 || (needs_probe() && !regular_where_factors_lie()))
      return ResidentSolve::refused;
    factors_->resident()->start(block, controls.row_floor, stream);
    outcome = refine_resident(*factors_->resident(), controls, resident_improved_);
    // A b that is not finite leaves no finite error.
    return outcome.backward_error <= controls.tolerance ? ResidentSolve::solved : ResidentSolve::missed;
  }

  double condition_estimate(const TransposedPattern& transposed, const SolveControls& controls) override {
    matrix_ = factors_->matrix();
    const blas::SequentialScope sequential;
    if (singular_by_probe()) return std::numeric_limits<double>::infinity();
    for (const bool flip : {false, true}) {
      make_correction(flip ? &transposed : nullptr);
      if (correction_[flip] && correction_[flip]->nullity() > 0)
        return std::numeric_limits<double>::infinity();
      if (!correction_[flip] && status_.perturbed > 0) return std::numeric_limits<double>::quiet_NaN();
    }
    // In units of the largest entry, as |A^-1| alone may be beyond the range.
    const int unit = largest_exponent(pattern_->nnz(), matrix_.values);
    bool solved = true, in_range = true;
    const auto note = [&](double error, const Value* x) {
      in_range = in_range && all_finite(x);
      solved = solved && error <= std::sqrt(std::numeric_limits<RealOf<Value>>::epsilon());
    };
    const double inverse_norm = blas::estimate_norm<Value>(
        plan_->n, [&](Value* x) { note(solve_for_estimate(x, unit, nullptr, controls), x); },
        [&](Value* x) {
          conjugate(plan_->n, x);
          note(solve_for_estimate(x, unit, &transposed, controls), x);
          conjugate(plan_->n, x);
        });
    if (!in_range && status_.nonfinite == 0) return std::numeric_limits<double>::infinity();
    if (!solved) return std::numeric_limits<double>::quiet_NaN();
    const double condition = norm_in_units(transposed, plan_->n, matrix_.values, unit) * inverse_norm;
    return condition <= std::numeric_limits<double>::max() ? condition
                                                           : std::numeric_limits<double>::infinity();
  }

  FoundDeterminant<Value> determinant() override {
    matrix_ = factors_->matrix();
    const blas::SequentialScope sequential;
    FoundDeterminant<Value> found;
    std::complex<double> phase = product_of_pivots(found.log_abs);
    bool singular = singular_by_probe();
    if (status_.perturbed > 0 && !singular) {
      if (!make_correction(nullptr)) return found;
      std::complex<double> factor;
      double log_factor = 0;
      correction_[0]->determinant(factor, log_factor);
      phase *= factor;
      found.log_abs += log_factor;
      singular = dependent_rows(nullptr) > 0;
    }
    found.phase = from_parts<Value>(phase.real(), phase.imag());
    if (singular) return {Value(0), -std::numeric_limits<double>::infinity(), Digits::all};
    found.digits = std::isfinite(found.log_abs) ? digits_of_determinant() : Digits::none;
    return found;
  }

  Vertex pivot_row(Vertex position) const override {
    const auto front = std::upper_bound(plan_->pivot_begin.begin(), plan_->pivot_begin.end(), position) - 1;
    return plan_->row_of[*front + factors_->local_row(position)];
  }

  std::vector<Vertex> failed_pivots() const override {
    std::vector<Vertex> failed;
    for (Vertex p = 0; p < plan_->n; ++p) {
      if (factors_->pivot_shift(p) != Value(0)) failed.push_back(p);
    }
    return failed;
  }

  Offset bytes() const override {
    if (factors_->memory() == MemorySpace::device) return factors_->bytes();
    std::size_t extra = krylov_space_.size() * sizeof(Value);
    for (const auto& correction : correction_) extra += correction ? correction->bytes() : 0;
    if (support_) extra += support_->bytes();
    const LadderLayout own(plan_->n, sizeof(Value), columns_);
    return factors_->bytes() + own.ends.total() + own.work.total() + static_cast<Offset>(extra);
  }

 private:
  struct Probed {
    bool regular = false;
    SolveOutcome refusal;
  };

  // From the factors on, or where vectors.x holds a solution that has been begun, from there.
  SolveOutcome climb(Vertex columns, const TransposedPattern* transposed, const SolveControls& controls,
                     bool begun) {
    const blas::SequentialScope sequential;
    SolveOutcome outcome;
    // Whether A is singular is settled before any right-hand side is: one that happens to be consistent would
    // hide it.
    const bool regular = regular_by_correction(transposed, outcome) && regular_by_probe(outcome);
    const bool singular = outcome.dependent_rows > 0;
    if (!regular && singular && !controls.solve_singular) return outcome;
    refine(columns, transposed, controls, outcome, begun);
    if (regular && outcome.krylov_steps > 0 && !needs_probe()) question(controls, outcome);
    return outcome;
  }

  // Whether A is singular after all. Its smallest pivot is as large as the factors have grown, so those that
  // are no good may hide it, and then FGMRES finds solutions as large as rounding lets them be.
  void question(const SolveControls& controls, SolveOutcome& outcome) {
    stalled_ = true;
    SolveOutcome found = outcome;
    if (regular_by_probe(found)) return;
    const bool refused = found.dependent_rows > 0 && !controls.solve_singular;
    if (!refused) found.backward_error = outcome.backward_error;
    found.refinement_steps = outcome.refinement_steps;
    found.krylov_steps = outcome.krylov_steps;
    outcome = found;
  }

  bool singular_by_probe() { return needs_probe() && probed().refusal.dependent_rows > 0; }
  // Before the first solve where the factors lie.
  bool settled() {
    if (!needs_probe() || regular_where_factors_lie()) return true;
    matrix_ = factors_->matrix();
    const blas::SequentialScope sequential;
    return probed().regular;
  }
  // Asked once: what is open there is settled on the host.
  bool regular_where_factors_lie() {
    if (!probed_ && !std::exchange(probed_where_factors_lie_, true)) {
      try {
        if (ResidentProbe<Value>(*factors_->resident(), plan_->n).proves_regular())
          probed_ = Probed{true, {}};
      } catch (const OutOfMemory&) {  // the host has vectors
      }
    }
    return probed_ && probed_->regular;
  }
  bool needs_probe() const { return divided_by_tiny_ || stalled_ || status_.perturbed > kMostCorrected; }

  // What is in the right-hand sides stays.
  void take_vectors(Vertex columns) {
    const LadderLayout layout(plan_->n, sizeof(Value), columns);
    const std::shared_ptr<char> ends = factors_->host_vectors(layout.ends.total());
    work_ = std::make_unique<HostArena>(layout.work.total());
    const auto in_ends = [&](Offset place) { return reinterpret_cast<Value*>(ends.get() + place); };
    if (ends_) std::copy(at_.b, at_.b + static_cast<Offset>(plan_->n) * columns_, in_ends(layout.b));
    ends_ = ends;
    columns_ = columns;
    at_ = {in_ends(layout.b),
           in_ends(layout.x),
           work_->template at<Value>(layout.best),
           work_->template at<Value>(layout.r),
           work_->template at<Value>(layout.d),
           work_->template at<double>(layout.size),
           &krylov_space_};
  }

  // The inverse corrected for perturbed pivots, where that has been made.
  void apply_best_inverse(const Value* from, Value* to, Vertex columns, bool transposed) {
    factors_->apply_inverse(from, to, columns, transposed);
    Correction<Exec, Value>* correction = correction_[transposed].get();
    if (!correction || correction->nullity() > 0) return;
    for (Vertex j = 0; j < columns; ++j) correction->apply(to + static_cast<Offset>(j) * plan_->n);
  }

  // False, and the refusal in `outcome`, where the correction finds A singular.
  bool regular_by_correction(const TransposedPattern* transposed, SolveOutcome& outcome) {
    const Stopwatch watch;
    if (!make_correction(transposed)) return true;
    outcome.dependent_rows = dependent_rows(transposed);
    if (outcome.dependent_rows > 0) {
      name_dependent(transposed != nullptr, outcome);
    } else {
      outcome.corrected_pivots = correction_[transposed != nullptr]->rank();
    }
    outcome.time_ladder = watch.seconds();
    return outcome.dependent_rows == 0;
  }

  // By the null vectors of A and of A^T (of the one whose correction there is first, of the other where that
  // leaves doubt): of both there are as many, and either may be too inaccurate to be counted.
  Vertex dependent_rows(const TransposedPattern* transposed) {
    const bool own = transposed != nullptr, other = !own;
    const Vertex nullity = correction_[own]->nullity();
    if (nullity == 0 && !correction_[own]->doubtful()) return 0;
    if (!correction_[other]) {
      const TransposedPattern other_pattern = other ? transpose(*pattern_, 1) : TransposedPattern();
      make_correction(other ? &other_pattern : nullptr);
    }
    return std::max(nullity, correction_[other] ? correction_[other]->nullity() : 0);
  }

  // The same where tiny pivots were divided by, or more perturbed than the exact correction takes.
  bool regular_by_probe(SolveOutcome& outcome) {
    if (!needs_probe()) return true;
    const Stopwatch watch;
    const Probed& found = probed();
    if (!found.regular) {
      const double before = outcome.time_ladder;
      outcome = found.refusal;
      outcome.time_ladder = before;
    }
    outcome.time_ladder += watch.seconds();
    return found.regular;
  }

  void refine(Vertex columns, const TransposedPattern* transposed, const SolveControls& controls,
              SolveOutcome& outcome, bool begun) {
    const auto inverse = [&](const Value* from, Value* to, Vertex count) {
      apply_best_inverse(from, to, count, transposed != nullptr);
    };
    const auto residual = [&](const Value* b, const Value* x, Value* r, double* size) {
      RowFloor floor;
      if (controls.row_floor > 0 && b) floor = row_floor(controls.row_floor, x, transposed != nullptr);
      double error = 0;
      mfs::residual(exec_, plan_->n, matrix_rows(transposed), b, x, r, &error, size, floor);
      return error;
    };
    const auto doubled = [&](const Value* b, const Value* x, const Value* low, Value* r) {
      doubled_residual(exec_, plan_->n, matrix_rows(transposed), b, x, low, r);
    };
    // Floors are of single columns.
    const RowAccess<Value> together = controls.row_floor > 0 ? RowAccess<Value>{} : matrix_rows(transposed);
    const auto support = [&](const Value* b) { return support_of(b, transposed != nullptr); };
    const HostVectors vectors(exec_, plan_->n, columns, at_, together, inverse, residual, doubled, support);
    Refinement(vectors, controls).run(outcome, begun);
  }

  // Empty: of all unknowns.
  std::vector<char> support_of(const Value* b, bool transposed) {
    std::vector<char> right_side(static_cast<std::size_t>(plan_->n));
    for (std::size_t i = 0; i < right_side.size(); ++i) right_side[i] = b[i] != Value(0);
    if (std::find(right_side.begin(), right_side.end(), false) == right_side.end()) return {};
    if (!support_) {
      RawVector<Cost> costs(static_cast<std::size_t>(pattern_->nnz()));
      for (std::size_t k = 0; k < costs.size(); ++k)
        costs[k] = matrix_.values[k] == Value(0) ? kNoEdge : Cost(0);
      support_.emplace(*pattern_, std::move(costs));
    }
    return support_->of(right_side, transposed);
  }

  RowFloor row_floor(double part, const Value* x, bool transposed) {
    largest_unknown_ = 0;
    largest_unscaled(exec_, plan_->n, transposed ? matrix_.row_scale : matrix_.column_scale, x,
                     &largest_unknown_);
    return {part, &largest_unknown_, transposed ? matrix_.column_scale : matrix_.row_scale};
  }

  // Whether A is singular, by the solutions for a right-hand side that is in nobody's range by chance: of A,
  // and of A^T where that leaves doubt, or to name a row.
  const Probed& probed() {
    if (probed_) return *probed_;
    Probed found;
    const NullDirection column = probe_direction(nullptr);
    found.regular = column.regular;
    if (!column.regular) {
      const TransposedPattern transposed = transpose(*pattern_, 1);
      const NullDirection row = probe_direction(&transposed);
      found.regular = row.regular && !column.null;
      SolveOutcome& refusal = found.refusal;
      refusal.doubtful = !found.regular && !column.null && !row.null;
      refusal.backward_error = std::numeric_limits<double>::infinity();
      if (column.null || row.null) {
        refusal.dependent_rows = dependent_pivots();
        refusal.row = row.unknown;
        refusal.column = column.unknown;
        refusal.singularity = std::min(column.smallness, row.smallness);
      }
    }
    probed_ = found;
    return *probed_;
  }

  NullDirection probe_direction(const TransposedPattern* transposed) {
    const bool flip = transposed != nullptr;
    return null_direction(exec_, scaled_rows(transposed), plan_->n,
                          [&](Value* x) { apply_best_inverse(x, x, 1, flip); });
  }

  // Pivots that are rounding beside the largest entry: their columns depend on those before them.
  Vertex dependent_pivots() const {
    constexpr double kRounding = 10;
    const double most = kRounding * std::numeric_limits<RealOf<Value>>::epsilon() * largest_;
    std::vector<std::complex<double>> pivots(static_cast<std::size_t>(plan_->n));
    factors_->diagonal_pivots(pivots.data());
    const auto count = std::count_if(pivots.begin(), pivots.end(), [&](const std::complex<double>& pivot) {
      return std::abs(pivot) <= most;
    });
    return std::max(static_cast<Vertex>(count), Vertex(1));
  }

  // What was added to A by perturbed pivots; for A^T with rows and columns exchanged.
  std::vector<Perturbation<Value>> perturbed_entries(bool transposed) const {
    std::vector<Perturbation<Value>> entries;
    for (Vertex position = 0; position < plan_->n && entries.size() <= kMostCorrected; ++position) {
      const Value shift = factors_->pivot_shift(position);
      if (shift == Value(0)) continue;
      const Vertex row = pivot_row(position), column = plan_->column_of[position];
      const double scale = matrix_.row_scale[row] * matrix_.column_scale[column];
      const Value amount = shift / static_cast<RealOf<Value>>(scale);
      entries.push_back(transposed ? Perturbation<Value>{column, row, amount}
                                   : Perturbation<Value>{row, column, amount});
    }
    return entries;
  }

  // For A, or for A^T where its pattern is given. False where there is nothing to correct, or too much.
  bool make_correction(const TransposedPattern* transposed) {
    const bool flip = transposed != nullptr;
    if (correction_[flip]) return true;
    if (status_.perturbed == 0) return false;
    std::vector<Perturbation<Value>> perturbations = perturbed_entries(flip);
    if (perturbations.empty() || perturbations.size() > kMostCorrected) return false;
    rhs(factors_->columns_at_once());  // room for the vectors of a full block
    const auto inverse = [&](Value* x, Vertex count) { factors_->apply_inverse(x, x, count, flip); };
    const auto inverse_of_transposed = [&](Value* x) { factors_->apply_inverse(x, x, 1, !flip); };
    const ScaledRows<Value> rows = scaled_rows(transposed);
    correction_[flip] = std::make_unique<Correction<Exec, Value>>(exec_, plan_->n, std::move(perturbations),
                                                                  rows, factors_->columns_at_once(), inverse,
                                                                  inverse_of_transposed);
    if (!correction_[flip]->usable()) correction_[flip].reset();
    return correction_[flip] != nullptr;
  }

  // x := 2^unit A^-1 x; returns its backward error.
  double solve_for_estimate(Value* x, int unit, const TransposedPattern* transposed,
                            const SolveControls& controls) {
    const double before = std::ldexp(1.0, unit / 2), after = std::ldexp(1.0, unit - unit / 2);
    const auto times = [](double power, const Value& entry) {
      return entry * static_cast<RealOf<Value>>(power);
    };
    Value* b = rhs(1);
    for (Vertex i = 0; i < plan_->n; ++i) b[i] = times(before, x[i]);
    SolveOutcome outcome;
    refine(1, transposed, controls, outcome, false);
    for (Vertex i = 0; i < plan_->n; ++i) x[i] = times(after, at_.x[i]);
    return outcome.backward_error;
  }
  bool all_finite(const Value* x) const {
    return std::all_of(x, x + plan_->n, [](const Value& entry) { return std::isfinite(std::abs(entry)); });
  }

  // Of the diagonal of U, of the scales and of the permutation; of A, if no pivot was perturbed.
  std::complex<double> product_of_pivots(double& log_abs) const {
    std::vector<Vertex> row_at(static_cast<std::size_t>(plan_->n));
    for (Vertex position = 0; position < plan_->n; ++position)
      row_at[plan_->column_of[position]] = pivot_row(position);
    std::complex<double> phase = permutation_sign(std::move(row_at));
    log_abs = 0;
    std::vector<std::complex<double>> pivots(static_cast<std::size_t>(plan_->n));
    factors_->diagonal_pivots(pivots.data());
    for (const std::complex<double>& pivot : pivots) {
      log_abs += std::log(std::abs(pivot));
      phase *= pivot / std::abs(pivot);
    }
    for (Vertex i = 0; i < plan_->n; ++i)
      log_abs -= std::log(matrix_.row_scale[i]) + std::log(matrix_.column_scale[i]);
    return phase;
  }

  // Without perturbed pivots the error of the inverse is what the rounding of an elimination is under the
  // condition of A, and the factors may grow.
  Digits digits_of_determinant() {
    constexpr double kGrown = 1e-2, kDigit = 0.1;
    const double half = std::sqrt(std::numeric_limits<RealOf<Value>>::epsilon());
    const double error = inverse_error(exec_, plan_->n, scaled_rows(nullptr),
                                       [&](Value* x) { apply_best_inverse(x, x, 1, false); });
    if (error <= (status_.perturbed > 0 ? half : kGrown)) return Digits::all;
    return status_.perturbed == 0 || error <= kDigit ? Digits::some : Digits::none;
  }
  static void conjugate(Vertex n, Value* x) {
    if constexpr (!std::is_same_v<Value, RealOf<Value>>) {
      for (Vertex i = 0; i < n; ++i) x[i] = std::conj(x[i]);
    }
  }

  // A row and a column of A that depend on the others, from the null vectors of A and A^T, of which the
  // correction for the one (that of this solve, if it can) gives both.
  void name_dependent(bool transposed, SolveOutcome& outcome) {
    const bool by = correction_[transposed]->nullity() > 0 ? transposed : !transposed;
    Value* null_vector = at_.d;
    correction_[by]->left_null_source(null_vector);
    factors_->apply_inverse(null_vector, null_vector, 1, !by);
    const Vertex own = correction_[by]->dependent_unknown();
    const Vertex other =
        largest_unknown(plan_->n, null_vector, by ? matrix_.column_scale : matrix_.row_scale);
    outcome.backward_error = std::numeric_limits<double>::infinity();
    outcome.singularity = correction_[by]->singularity();
    outcome.row = by ? own : other;
    outcome.column = by ? other : own;
  }

  ScaledRows<Value> scaled_rows(const TransposedPattern* transposed) {
    const bool flip = transposed != nullptr;
    return {matrix_rows(transposed), flip ? matrix_.column_scale : matrix_.row_scale,
            flip ? matrix_.row_scale : matrix_.column_scale, [this, flip] {
              if (!balanced_) balanced_ = balanced_scaling();
              return (flip ? balanced_->column : balanced_->row).data();
            }};
  }

  struct Scales {
    std::vector<double> row, column;
  };
  // From the scales of the factors on, which parts of A that nothing links keep.
  Scales balanced_scaling() const {
    PowerScaling scaling(plan_->n);
    for (Vertex i = 0; i < plan_->n; ++i) {
      scaling.row[i] = std::ilogb(matrix_.row_scale[i]);
      scaling.column[i] = std::ilogb(matrix_.column_scale[i]);
    }
    balance(*pattern_, exponents_of(matrix_.values, pattern_->nnz(), 1), scaling);
    return {powers_of_two(scaling.row, 1), powers_of_two(scaling.column, 1)};
  }

  RowAccess<Value> matrix_rows(const TransposedPattern* transposed) const {
    if (!transposed) return {pattern_->offsets.data(), pattern_->columns.data(), nullptr, matrix_.values};
    return {transposed->offsets.data(), transposed->columns.data(), transposed->slots.data(), matrix_.values};
  }

  std::unique_ptr<Factors<Value>> factors_;
  std::shared_ptr<const SymbolicPlan> plan_;
  std::shared_ptr<const Pattern> pattern_;
  HostMatrix<Value> matrix_;
  FactorStatus status_{};
  bool divided_by_tiny_ = false;  // pivots as small as rounding were accepted
  bool stalled_ = false;          // a solve needed FGMRES
  double largest_ = 0;            // scaled entry of the matrix that is factored
  double largest_unknown_ = 0;
  std::shared_ptr<char> ends_;
  std::unique_ptr<HostArena> work_;
  RefinementVectors<Value> at_{};
  Vertex columns_ = 0;
  bool resident_improved_ = false;   // whether the last steps where the factors lie are worth going on from
  std::vector<Value> krylov_space_;  // taken when FGMRES is first needed
  std::optional<Probed> probed_;
  bool probed_where_factors_lie_ = false;                   // whatever came of it
  std::optional<Scales> balanced_;                          // made when first needed
  std::optional<SolutionSupport> support_;                  // made when first needed
  std::unique_ptr<Correction<Exec, Value>> correction_[2];  // for A, for A^T; made when first needed
  Exec exec_;
};

}  // namespace mfs
