// The accuracy ladder of a solve, wherever the factors lie: from an approximate inverse to a solution whose
// backward error is known, or to the proof that there is none. The rungs in their order:
//
//   correction   pivots that were perturbed are taken back exactly, or show that A is singular
//                (kernels/correction.hpp); if they are too many for that, a probe decides (kernels/probe.hpp)
//   refinement   iterative, in twice the precision, then FGMRES with the factors as preconditioner
//   (kernels/refinement.hpp)
//
// The same inverse gives the condition estimate and the determinant. Vectors and matrix are those of the
// host, and vector operations run on Exec, an execution space of the host. What depends on where the factors
// lie is asked from the derived class: five questions, the protected virtual functions and pivot_shift.
#pragma once

#include <algorithm>
#include <complex>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "kernels/arena.hpp"
#include "kernels/correction.hpp"
#include "kernels/factorization.hpp"
#include "kernels/probe.hpp"
#include "kernels/refinement.hpp"

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

/// `Memory`, an arena of the host, is where right-hand sides and solutions lie.
template <class Exec, class Memory, class Value>
class AccuracyLadder : public Factorization<Value> {
 public:
  Value* matrix_values() override { return matrix_.values; }
  double* row_scale() override { return matrix_.row_scale; }
  double* column_scale() override { return matrix_.column_scale; }

  Value* rhs(Vertex columns) override {
    if (columns > columns_) {
      make_room(columns);
      take_vectors(columns);
    }
    return at_.b;
  }
  const Value* solution() const override { return at_.x; }

  SolveOutcome solve(Vertex columns, const TransposedPattern* transposed,
                     const SolveControls& controls) override {
    const blas::SequentialScope sequential;
    SolveOutcome outcome;
    // Whether A is singular is settled before any right-hand side is: one that happens to be consistent would
    // hide it.
    if (!regular_by_correction(transposed, outcome)) return outcome;
    if (!regular_by_probe(columns, outcome)) return outcome;
    refine(columns, transposed, controls, outcome);
    return outcome;
  }

  double condition_estimate(const TransposedPattern& transposed) override {
    const blas::SequentialScope sequential;
    for (const bool flip : {false, true}) {
      make_correction(flip ? &transposed : nullptr);
      if (correction_[flip] && correction_[flip]->nullity() > 0)
        return std::numeric_limits<double>::infinity();
      if (!correction_[flip] && status_.perturbed > 0) return std::numeric_limits<double>::quiet_NaN();
    }
    const Vertex n = plan_->n;
    const double inverse_norm = blas::estimate_norm<Value>(
        n, [&](Value* x) { apply_best_inverse(x, x, 1, false); },
        [&](Value* x) {
          conjugate(n, x);
          apply_best_inverse(x, x, 1, true);
          conjugate(n, x);
        });
    const double condition = matrix_norm(transposed) * inverse_norm;
    return condition <= std::numeric_limits<double>::max() ? condition
                                                           : std::numeric_limits<double>::infinity();
  }

  bool determinant(Value& phase, double& log_abs) override {
    const blas::SequentialScope sequential;
    const Vertex n = plan_->n;
    std::complex<double> product = permutation_sign();
    log_abs = 0;
    std::vector<std::complex<double>> pivots(static_cast<std::size_t>(n));
    diagonal_pivots(pivots.data());
    for (const std::complex<double>& pivot : pivots) {
      log_abs += std::log(std::abs(pivot));
      product *= pivot / std::abs(pivot);
    }
    for (Vertex i = 0; i < n; ++i)
      log_abs -= std::log(matrix_.row_scale[i]) + std::log(matrix_.column_scale[i]);
    if (status_.perturbed > 0) {
      if (!make_correction(nullptr)) return false;
      std::complex<double> factor;
      double log_factor = 0;
      correction_[0]->determinant(factor, log_factor);
      product *= factor;
      log_abs += log_factor;
      if (dependent_rows(nullptr) > 0) {
        product = 0;
        log_abs = -std::numeric_limits<double>::infinity();
      }
    }
    phase = from_parts<Value>(product.real(), product.imag());
    return true;
  }

  Vertex pivot_row(Vertex position) const override {
    const auto front = std::upper_bound(plan_->pivot_begin.begin(), plan_->pivot_begin.end(), position) - 1;
    return plan_->row_of[*front + local_row(position)];
  }

  /// Of what the ladder holds; derived classes add theirs.
  Offset bytes() const override {
    std::size_t extra = krylov_space_.size() * sizeof(Value);
    for (const auto& correction : correction_) extra += correction ? correction->bytes() : 0;
    return ends_->bytes() + work_->bytes() + static_cast<Offset>(extra);
  }

 protected:
  /// The matrix in the memory of the host: values by slot of the pattern, scales by row and column of A.
  struct Matrix {
    Value* values = nullptr;
    double* row_scale = nullptr;
    double* column_scale = nullptr;
  };

  AccuracyLadder(std::shared_ptr<const SymbolicPlan> plan, std::shared_ptr<const Pattern> pattern)
      : plan_(std::move(plan)), pattern_(std::move(pattern)) {
    take_vectors(1);
  }
  /// Called once, by the constructor of the derived class, which holds that memory.
  void hold_matrix(const Matrix& matrix) { matrix_ = matrix; }

  /// To be called by factor(): before it changes the factors, and when they are made.
  void forget_factors() {
    for (auto& correction : correction_) correction.reset();
    probed_.reset();
  }
  void note_factors(const FactorStatus& status, double largest_scaled_entry) {
    status_ = status;
    largest_ = largest_scaled_entry;
  }

  /// to = approximately A^-1 from (A^-T with `transposed`), scaling and permutation included: n x columns in
  /// the memory of the host and in the caller's numbering. They may be the same array.
  virtual void apply_inverse(const Value* from, Value* to, Vertex columns, bool transposed) = 0;
  /// Makes room for what apply_inverse needs for so many columns; before the ladder does so for its own.
  virtual void make_room(Vertex columns) = 0;
  /// The row of its pivot block that came to this position, counted from the block's first.
  virtual Vertex local_row(Vertex position) const = 0;
  /// pivots[0 ... n-1] = the pivots by position, as they are in the factors.
  virtual void diagonal_pivots(std::complex<double>* pivots) const = 0;

  const SymbolicPlan& plan() const { return *plan_; }
  const Pattern& pattern() const { return *pattern_; }
  const Exec& exec() const { return exec_; }
  const FactorStatus& status() const { return status_; }
  const RefinementVectors<Value>& vectors() const { return at_; }

 private:
  // What is in the right-hand sides stays.
  void take_vectors(Vertex columns) {
    const LadderLayout layout(plan_->n, sizeof(Value), columns);
    auto ends = std::make_unique<Memory>(layout.ends.total());
    work_ = std::make_unique<HostArena>(layout.work.total());
    if (ends_) {
      std::copy(at_.b, at_.b + static_cast<Offset>(plan_->n) * columns_, ends->template at<Value>(layout.b));
    }
    ends_ = std::move(ends);
    columns_ = columns;
    at_ = {ends_->template at<Value>(layout.b),    ends_->template at<Value>(layout.x),
           work_->template at<Value>(layout.best), work_->template at<Value>(layout.r),
           work_->template at<Value>(layout.d),    work_->template at<double>(layout.size)};
  }

  // The inverse corrected for perturbed pivots, where that has been made.
  void apply_best_inverse(const Value* from, Value* to, Vertex columns, bool transposed) {
    apply_inverse(from, to, columns, transposed);
    Correction<Value>* correction = correction_[transposed].get();
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

  // The same where more pivots were perturbed than the exact correction takes.
  bool regular_by_probe(Vertex columns, SolveOutcome& outcome) {
    if (status_.perturbed <= most_corrected(*plan_)) return true;
    if (!probed_) probe(columns);
    if (!probed_->regular) outcome = probed_->refusal;
    return probed_->regular;
  }

  void refine(Vertex columns, const TransposedPattern* transposed, const SolveControls& controls,
              SolveOutcome& outcome) {
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
    Refinement<Exec, Value, decltype(inverse), decltype(residual), decltype(doubled)> refinement(
        exec_, plan_->n, columns, controls, at_, inverse, residual, doubled);
    refinement.run(krylov_space_, outcome);
  }

  RowFloor row_floor(double part, const Value* x, bool transposed) const {
    double largest = 0;
    largest_unscaled(exec_, plan_->n, transposed ? matrix_.row_scale : matrix_.column_scale, x, &largest);
    return {part * largest, transposed ? matrix_.column_scale : matrix_.row_scale};
  }

  // Whether A is singular, by the solutions for a right-hand side that is in nobody's range by chance. Keeps
  // what is in rhs().
  void probe(Vertex columns) {
    const std::vector<Value> held(at_.b, at_.b + static_cast<Offset>(plan_->n) * columns);
    probed_ = Probed();
    const NullDirection column = probe_direction(nullptr);
    probed_->regular = column.regular;
    if (!column.regular) {
      const TransposedPattern transposed = transpose(*pattern_, 1);
      const NullDirection row = probe_direction(&transposed);
      probed_->refusal.backward_error = std::numeric_limits<double>::infinity();
      if (column.null && row.null) {
        probed_->refusal.dependent_rows = dependent_pivots();
        probed_->refusal.row = row.unknown;
        probed_->refusal.column = column.unknown;
      }
    }
    std::copy(held.begin(), held.end(), at_.b);
  }

  NullDirection probe_direction(const TransposedPattern* transposed) {
    const double* in_scale = transposed ? matrix_.column_scale : matrix_.row_scale;
    const double* out_scale = transposed ? matrix_.row_scale : matrix_.column_scale;
    const Value *b = at_.b, *x = at_.x;
    probing_vector(plan_->n, in_scale, at_.b);
    SolveOutcome outcome;
    refine(1, transposed, probing_controls<Value>(), outcome);
    double error = 0;
    mfs::residual(exec_, plan_->n, matrix_rows(transposed), b, x, at_.r, &error);
    return null_direction(plan_->n, in_scale, at_.r, out_scale, x, largest_);
  }

  // Pivots that were replaced by something of the size of the largest entry: their columns depend on those
  // before them.
  Vertex dependent_pivots() const {
    Vertex count = 0;
    for (Vertex position = 0; position < plan_->n; ++position)
      count += std::abs(this->pivot_shift(position)) >= 0.5 * largest_;
    return std::max(count, Vertex(1));
  }

  // What was added to A by perturbed pivots; for A^T with rows and columns exchanged.
  std::vector<Perturbation<Value>> perturbed_entries(bool transposed) const {
    std::vector<Perturbation<Value>> entries;
    for (Vertex position = 0; position < plan_->n && entries.size() <= most_corrected(*plan_); ++position) {
      const Value shift = this->pivot_shift(position);
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
    if (perturbations.empty() || perturbations.size() > most_corrected(*plan_)) return false;
    rhs(this->columns_at_once());  // room for the vectors of a full block
    const auto inverse = [&](Value* x, Vertex count) { apply_inverse(x, x, count, flip); };
    const auto inverse_of_transposed = [&](Value* x) { apply_inverse(x, x, 1, !flip); };
    const ScaledRows<Value> rows{matrix_rows(transposed), flip ? matrix_.column_scale : matrix_.row_scale,
                                 flip ? matrix_.row_scale : matrix_.column_scale};
    correction_[flip] = std::make_unique<Correction<Value>>(
        plan_->n, std::move(perturbations), rows, this->columns_at_once(), inverse, inverse_of_transposed);
    if (!correction_[flip]->usable()) correction_[flip].reset();
    return correction_[flip] != nullptr;
  }

  // Of the row permutation that elimination made: the rows as they came to the diagonal against the columns.
  double permutation_sign() const {
    std::vector<Vertex> row_at(static_cast<std::size_t>(plan_->n));
    for (Vertex position = 0; position < plan_->n; ++position)
      row_at[plan_->column_of[position]] = pivot_row(position);
    double sign = 1;
    for (Vertex i = 0; i < plan_->n; ++i) {
      while (row_at[i] != i) {
        std::swap(row_at[i], row_at[row_at[i]]);
        sign = -sign;
      }
    }
    return sign;
  }

  // |A|_1
  double matrix_norm(const TransposedPattern& transposed) const {
    double norm = 0;
    for (Vertex j = 0; j < plan_->n; ++j) {
      double sum = 0;
      for (Offset k = transposed.offsets[j]; k < transposed.offsets[j + 1]; ++k)
        sum += std::abs(matrix_.values[transposed.slots[k]]);
      norm = std::max(norm, sum);
    }
    return norm;
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
    apply_inverse(null_vector, null_vector, 1, !by);
    const Vertex own = correction_[by]->dependent_unknown();
    const Vertex other =
        largest_unknown(plan_->n, null_vector, by ? matrix_.column_scale : matrix_.row_scale);
    outcome.backward_error = std::numeric_limits<double>::infinity();
    outcome.row = by ? own : other;
    outcome.column = by ? other : own;
  }

  RowAccess<Value> matrix_rows(const TransposedPattern* transposed) const {
    if (!transposed) return {pattern_->offsets.data(), pattern_->columns.data(), nullptr, matrix_.values};
    return {transposed->offsets.data(), transposed->columns.data(), transposed->slots.data(), matrix_.values};
  }

  std::shared_ptr<const SymbolicPlan> plan_;
  std::shared_ptr<const Pattern> pattern_;
  Matrix matrix_;
  FactorStatus status_{};
  double largest_ = 0;  // scaled entry of the matrix that is factored
  std::unique_ptr<Memory> ends_;
  std::unique_ptr<HostArena> work_;
  RefinementVectors<Value> at_{};
  Vertex columns_ = 0;
  std::vector<Value> krylov_space_;  // taken when FGMRES is first needed
  struct Probed {
    bool regular = false;
    SolveOutcome refusal;
  };
  std::optional<Probed> probed_;
  std::unique_ptr<Correction<Value>> correction_[2];  // for A, for A^T; made when first needed
  Exec exec_;
};

}  // namespace mfs
