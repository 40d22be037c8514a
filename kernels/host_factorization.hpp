// The factorization in the memory of the host, for any host execution space of Kokkos.
#pragma once

#include <optional>

#include "kernels/arena.hpp"
#include "kernels/correction.hpp"
#include "kernels/factorization.hpp"
#include "kernels/probe.hpp"
#include "kernels/refinement.hpp"
#include "kernels/stages.hpp"

namespace mfs {

/// Where each array of a factorization lies in its arena; made from the plan alone.
struct NumericLayout {
  NumericLayout(const SymbolicPlan& plan, Offset scalar_bytes, Offset value_bytes);
  ArenaLayout arena;
  Offset factor, contribution, matrix_values, row_scale, column_scale, interchange, local_row, shift, work,
      status;
  NumericBytes bytes;
};

/// The same for the vectors of a solve with `columns` right-hand sides.
struct SolveLayout {
  SolveLayout(const SymbolicPlan& plan, Offset scalar_bytes, Offset value_bytes, Vertex columns);
  ArenaLayout arena;
  Vertex columns;
  Offset v, y, border, b, x, best, r, d, size;
};

/// The plan's arrays as pointers, and the arena's regions behind them.
template <class Scalar, class Value>
FrontStore<Scalar, Value> make_front_store(const SymbolicPlan& plan, const Pattern& pattern,
                                           const NumericLayout& layout, const HostArena& arena);

/// Solves for matrices and vectors of Value by factors of Scalar: the same, or its single-precision kind.
template <class Exec, class Value, class Scalar>
class HostFactorization final : public Factorization<Value> {
 public:
  HostFactorization(std::shared_ptr<const SymbolicPlan> plan, std::shared_ptr<const Pattern> pattern,
                    int threads)
      : plan_(std::move(plan)),
        pattern_(std::move(pattern)),
        schedule_(make_schedule(*plan_, threads)),
        layout_(*plan_, sizeof(Scalar), sizeof(Value)),
        arena_(layout_.arena.total()),
        store_(make_front_store<Scalar, Value>(*plan_, *pattern_, layout_, arena_)),
        solve_layout_(*plan_, sizeof(Scalar), sizeof(Value), 1),
        solve_arena_(std::make_unique<HostArena>(solve_layout_.arena.total())) {}

  Value* matrix_values() override { return store_.matrix_values; }
  double* row_scale() override { return store_.row_scale; }
  double* column_scale() override { return store_.column_scale; }

  FactorStatus factor(double tolerance, const std::function<void(double)>& progress) override {
    const blas::SequentialScope sequential;
    *store_.status = FactorStatus();
    for (auto& correction : correction_) correction.reset();
    probed_.reset();
    largest_scaled_entry(exec_, store_, &largest_);
    const PivotRule rule = pivot_rule<RealOf<Scalar>>(tolerance, largest_);
    const double total = plan_->flops.getrf + plan_->flops.trsm + plan_->flops.gemm;
    for (const DepthSchedule& depth : schedule_) {
      factor_depth(exec_, store_, depth, rule);
      if (progress && total > 0) {
        progress((store_.status->getrf + store_.status->trsm + store_.status->gemm) / total);
      }
    }
    exec_.fence();
    return *store_.status;
  }

  Value* rhs(Vertex columns) override {
    if (columns > solve_layout_.columns) {
      const SolveLayout wider(*plan_, sizeof(Scalar), sizeof(Value), columns);
      auto arena = std::make_unique<HostArena>(wider.arena.total());
      const Value* held = vector<Value>(solve_layout_.b);
      std::copy(held, held + static_cast<Offset>(store_.n) * solve_layout_.columns,
                arena->template at<Value>(wider.b));
      solve_arena_ = std::move(arena);
      solve_layout_ = wider;
    }
    return vector<Value>(solve_layout_.b);
  }
  const Value* solution() const override { return vector<Value>(solve_layout_.x); }

  SolveOutcome solve(Vertex columns, const TransposedPattern* transposed,
                     const SolveControls& controls) override {
    const blas::SequentialScope sequential;
    const bool flip = transposed != nullptr;
    SolveOutcome outcome;
    const Stopwatch before_the_solve;
    // Whether A is singular is settled before any right-hand side is: one that happens to be consistent would
    // hide it.
    if (make_correction(flip, transposed)) {
      const Correction<Value>& correction = *correction_[flip];
      outcome.time_ladder = before_the_solve.seconds();
      if (correction.nullity() > 0) {
        name_dependent(correction, flip, outcome);
        return outcome;
      }
      outcome.corrected_pivots = correction.rank();
    }
    if (store_.status->perturbed > most_corrected(*plan_)) {
      if (!probed_) probe(columns);
      if (!probed_->regular) {
        outcome = probed_->refusal;
        return outcome;
      }
    }
    refine(columns, transposed, controls, outcome);
    return outcome;
  }

  double condition_estimate(const TransposedPattern& transposed) override {
    const blas::SequentialScope sequential;
    for (const bool flip : {false, true}) {
      make_correction(flip, flip ? &transposed : nullptr);
      if (correction_[flip] && correction_[flip]->nullity() > 0)
        return std::numeric_limits<double>::infinity();
      if (!correction_[flip] && store_.status->perturbed > 0) return std::numeric_limits<double>::quiet_NaN();
    }
    const Vertex n = store_.n;
    const double inverse_norm = blas::estimate_norm<Value>(
        n, [&](Value* x) { apply_best_inverse(x, x, 1, false); },
        [&](Value* x) {
          conjugate(n, x);
          apply_best_inverse(x, x, 1, true);
          conjugate(n, x);
        });
    double norm = 0;
    for (Vertex j = 0; j < n; ++j) {
      double sum = 0;
      for (Offset k = transposed.offsets[j]; k < transposed.offsets[j + 1]; ++k) {
        sum += std::abs(store_.matrix_values[transposed.slots[k]]);
      }
      norm = std::max(norm, sum);
    }
    const double condition = norm * inverse_norm;
    return condition <= std::numeric_limits<double>::max() ? condition
                                                           : std::numeric_limits<double>::infinity();
  }

  bool determinant(Value& phase, double& log_abs) override {
    const blas::SequentialScope sequential;
    std::complex<double> product = permutation_sign();
    log_abs = 0;
    for (Vertex f = 0; f < plan_->num_fronts; ++f) {
      const Front<Scalar> front = store_.front(f);
      for (Vertex i = 0; i < front.pivots; ++i) {
        const std::complex<double> pivot(front.lower[i + static_cast<Offset>(i) * front.rows()]);
        log_abs += std::log(std::abs(pivot));
        product *= pivot / std::abs(pivot);
      }
    }
    for (Vertex i = 0; i < store_.n; ++i)
      log_abs -= std::log(store_.row_scale[i]) + std::log(store_.column_scale[i]);
    const bool perturbed = !perturbed_entries(false).empty();
    if (perturbed && !make_correction(false, nullptr)) return false;
    if (perturbed) {
      std::complex<double> factor;
      double log_factor = 0;
      correction_[0]->determinant(factor, log_factor);
      product *= factor;
      log_abs += log_factor;
      if (correction_[0]->nullity() > 0) {
        product = 0;
        log_abs = -std::numeric_limits<double>::infinity();
      }
    }
    phase = from_parts<Value>(product.real(), product.imag());
    return true;
  }

  Vertex pivot_row(Vertex position) const override {
    const auto front = std::upper_bound(plan_->pivot_begin.begin(), plan_->pivot_begin.end(), position) - 1;
    return plan_->row_of[*front + store_.local_row[position]];
  }
  Value pivot_shift(Vertex position) const override { return static_cast<Value>(store_.shift[position]); }
  Offset bytes() const override {
    std::size_t extra = krylov_space_.size() * sizeof(Value);
    for (const auto& correction : correction_) extra += correction ? correction->bytes() : 0;
    return arena_.bytes() + solve_arena_->bytes() + static_cast<Offset>(extra);
  }

 private:
  // to = approximately A^-1 from, scaling and permutation included; they may be the same array.
  void apply_inverse(const Value* from, Value* to, Vertex columns, bool transposed) {
    const SolveVectors<Scalar> vectors{columns, vector<Scalar>(solve_layout_.v),
                                       vector<Scalar>(solve_layout_.y), vector<Scalar>(solve_layout_.border)};
    const Vertex* in = transposed ? store_.column_of : store_.row_of;
    const Vertex* out = transposed ? store_.row_of : store_.column_of;
    const double* in_scale = transposed ? store_.column_scale : store_.row_scale;
    const double* out_scale = transposed ? store_.row_scale : store_.column_scale;
    gather_scaled<Value>(exec_, store_.n, columns, in, in_scale, from, vectors.v);
    for (auto depth = schedule_.begin(); depth != schedule_.end(); ++depth) {
      solve_depth(exec_, store_, *depth, vectors, true, transposed);
    }
    for (auto depth = schedule_.rbegin(); depth != schedule_.rend(); ++depth) {
      solve_depth(exec_, store_, *depth, vectors, false, transposed);
    }
    scatter_scaled<Value>(exec_, store_.n, columns, out, out_scale, vectors.v, to);
  }

  // The inverse corrected for perturbed pivots, where that has been made.
  void apply_best_inverse(const Value* from, Value* to, Vertex columns, bool transposed) {
    apply_inverse(from, to, columns, transposed);
    Correction<Value>* correction = correction_[transposed].get();
    if (!correction || correction->nullity() > 0) return;
    for (Vertex j = 0; j < columns; ++j) correction->apply(to + static_cast<Offset>(j) * store_.n);
  }

  void refine(Vertex columns, const TransposedPattern* transposed, const SolveControls& controls,
              SolveOutcome& outcome) {
    const auto inverse = [&](const Value* from, Value* to, Vertex count) {
      apply_best_inverse(from, to, count, transposed != nullptr);
    };
    const auto residual = [&](const Value* b, const Value* x, Value* r, double* size) {
      double error = 0;
      mfs::residual(exec_, store_.n, matrix_rows(transposed), b, x, r, &error, size);
      return error;
    };
    const SolveLayout& at = solve_layout_;
    const RefinementVectors<Value> vectors{vector<Value>(at.b), vector<Value>(at.x), vector<Value>(at.best),
                                           vector<Value>(at.r), vector<Value>(at.d), vector<double>(at.size)};
    Refinement<Exec, Value, decltype(inverse), decltype(residual)> refinement(
        exec_, store_.n, columns, controls, vectors, inverse, residual);
    refinement.run(krylov_space_, outcome);
  }

  // Whether A is singular, where more pivots were perturbed than the exact correction takes: by the solutions
  // for a right-hand side that is in nobody's range by chance (kernels/probe.hpp). Keeps what is in rhs().
  void probe(Vertex columns) {
    Value* b = vector<Value>(solve_layout_.b);
    const std::vector<Value> held(b, b + static_cast<Offset>(store_.n) * columns);
    probed_ = Probed();
    const NullDirection column = probe_direction(nullptr);
    probed_->regular = column.regular;
    if (!column.regular) {
      const TransposedPattern transposed = transpose(*pattern_);
      const NullDirection row = probe_direction(&transposed);
      probed_->refusal.backward_error = std::numeric_limits<double>::infinity();
      if (column.null && row.null) {
        probed_->refusal.dependent_rows = dependent_pivots();
        probed_->refusal.row = row.unknown;
        probed_->refusal.column = column.unknown;
      }
    }
    std::copy(held.begin(), held.end(), b);
  }

  NullDirection probe_direction(const TransposedPattern* transposed) {
    const double* in_scale = transposed ? store_.column_scale : store_.row_scale;
    const double* out_scale = transposed ? store_.row_scale : store_.column_scale;
    Value *b = vector<Value>(solve_layout_.b), *r = vector<Value>(solve_layout_.r);
    const Value* x = vector<Value>(solve_layout_.x);
    probing_vector(store_.n, in_scale, b);
    SolveOutcome outcome;
    refine(1, transposed, probing_controls<Value>(), outcome);
    double error = 0;
    mfs::residual(exec_, store_.n, matrix_rows(transposed), static_cast<const Value*>(b), x, r, &error);
    return null_direction(store_.n, in_scale, r, out_scale, x, largest_);
  }

  // Pivots that were replaced by something of the size of the largest entry: their columns depend on those
  // before them.
  Vertex dependent_pivots() const {
    Vertex count = 0;
    for (Vertex position = 0; position < store_.n; ++position)
      count += std::abs(store_.shift[position]) >= 0.5 * largest_;
    return std::max(count, Vertex(1));
  }

  // What was added to A by perturbed pivots; for A^T with rows and columns exchanged.
  std::vector<Perturbation<Value>> perturbed_entries(bool transposed) const {
    std::vector<Perturbation<Value>> entries;
    for (Vertex position = 0; position < store_.n && entries.size() <= most_corrected(*plan_); ++position) {
      if (store_.shift[position] == Scalar(0)) continue;
      const Vertex row = pivot_row(position), column = store_.column_of[position];
      const double scale = store_.row_scale[row] * store_.column_scale[column];
      const Value amount = pivot_shift(position) / static_cast<RealOf<Value>>(scale);
      entries.push_back(transposed ? Perturbation<Value>{column, row, amount}
                                   : Perturbation<Value>{row, column, amount});
    }
    return entries;
  }

  // False where there is nothing to correct, or too much.
  bool make_correction(bool flip, const TransposedPattern* transposed) {
    if (correction_[flip]) return true;
    std::vector<Perturbation<Value>> perturbations = perturbed_entries(flip);
    if (perturbations.empty() || perturbations.size() > most_corrected(*plan_)) return false;
    rhs(kSolveColumns);  // room for the vectors of a full block
    const auto inverse = [&](Value* x, Vertex count) { apply_inverse(x, x, count, flip); };
    correction_[flip] = std::make_unique<Correction<Value>>(
        store_.n, std::move(perturbations), flip ? store_.row_scale : store_.column_scale,
        flip ? store_.column_scale : store_.row_scale, inverse, matrix_rows(transposed));
    if (!correction_[flip]->usable()) correction_[flip].reset();
    return correction_[flip] != nullptr;
  }

  // Of the row permutation that elimination made: the rows as they came to the diagonal against the columns.
  double permutation_sign() const {
    std::vector<Vertex> row_at(static_cast<std::size_t>(store_.n));
    for (Vertex position = 0; position < store_.n; ++position)
      row_at[store_.column_of[position]] = pivot_row(position);
    double sign = 1;
    for (Vertex i = 0; i < store_.n; ++i) {
      while (row_at[i] != i) {
        std::swap(row_at[i], row_at[row_at[i]]);
        sign = -sign;
      }
    }
    return sign;
  }

  static void conjugate(Vertex n, Value* x) {
    if constexpr (!std::is_same_v<Value, RealOf<Value>>) {
      for (Vertex i = 0; i < n; ++i) x[i] = std::conj(x[i]);
    }
  }

  // A row and a column of A that depend on the others, from the null vectors of A and A^T.
  void name_dependent(const Correction<Value>& correction, bool transposed, SolveOutcome& outcome) {
    const double* own_scale = transposed ? store_.row_scale : store_.column_scale;
    const double* other_scale = transposed ? store_.column_scale : store_.row_scale;
    Value* null_vector = vector<Value>(solve_layout_.d);
    correction.left_null_source(null_vector);
    apply_inverse(null_vector, null_vector, 1, !transposed);
    const Vertex own = correction.dependent_unknown(own_scale);
    const Vertex other = largest_unknown(store_.n, null_vector, other_scale);
    outcome.backward_error = std::numeric_limits<double>::infinity();
    outcome.dependent_rows = correction.nullity();
    outcome.row = transposed ? own : other;
    outcome.column = transposed ? other : own;
  }

  template <class T>
  T* vector(Offset place) const {
    return solve_arena_->template at<T>(place);
  }

  RowAccess<Value> matrix_rows(const TransposedPattern* transposed) const {
    if (!transposed) return {store_.matrix_offsets, store_.matrix_columns, nullptr, store_.matrix_values};
    return {transposed->offsets.data(), transposed->columns.data(), transposed->slots.data(),
            store_.matrix_values};
  }

  std::shared_ptr<const SymbolicPlan> plan_;
  std::shared_ptr<const Pattern> pattern_;
  Schedule schedule_;
  NumericLayout layout_;
  HostArena arena_;
  FrontStore<Scalar, Value> store_;
  SolveLayout solve_layout_;
  std::unique_ptr<HostArena> solve_arena_;
  std::vector<Value> krylov_space_;  // taken when FGMRES is first needed
  double largest_ = 0;               // scaled entry of the matrix that is factored
  struct Probed {
    bool regular = false;
    SolveOutcome refusal;
  };
  std::optional<Probed> probed_;
  std::unique_ptr<Correction<Value>> correction_[2];  // for A, for A^T; made when first needed
  Exec exec_;
};

}  // namespace mfs
