// The factors in the memory of the host, for any host execution space of Kokkos. Where they are too large
// for it, segments of them go to a file (plan/segments.hpp, kernels/stages/segment_moves.hpp).
#pragma once

#include <optional>

#include "kernels/factors.hpp"
#include "kernels/runtime/arena.hpp"
#include "kernels/stages/segment_moves.hpp"
#include "kernels/stages/solve_blocks.hpp"
#include "kernels/stages/stages.hpp"
#include "kernels/stages/vector_ops.hpp"

namespace mfs {

/// Where each array of a factorization lies in its arena; made from the plan alone. `segments` is null where
/// all factors are in memory.
struct NumericLayout {
  NumericLayout(const SymbolicPlan& plan, Offset scalar_bytes, Offset value_bytes,
                const SegmentPlan* segments = nullptr);
  ArenaLayout arena;
  Offset storage, matrix_values, row_scale, column_scale, interchange, local_row, shift, work, status;
  Offset diagonal = 0;   // of the factors, with segments
  Offset couplings = 0;  // between the blocks of a triangle
};

/// The same for the vectors of a substitution with `columns` right-hand sides.
struct SubstitutionLayout {
  SubstitutionLayout(const SymbolicPlan& plan, Offset scalar_bytes, Vertex columns);
  ArenaLayout arena;
  Offset v, y, border;
};

/// The plan's arrays as pointers, and the arena's regions behind them.
template <class Scalar, class Value>
FrontStore<Scalar, Value> make_front_store(const SymbolicPlan& plan, const Pattern& pattern,
                                           const NumericLayout& layout, const HostArena& arena);

/// What factors have beside those that fit: the file, and what moves when. No numbers.
class SegmentedFactors {
 public:
  /// Takes the file's place. Throws as FactorFile's constructor.
  SegmentedFactors(const OutOfCore& made, Offset entry_bytes);

  const SegmentPlan& plan() const { return made_.segments; }
  const OutOfCore& made() const { return made_; }
  /// A pass over the region that begins at `storage`.
  void begin_factorization(std::optional<MovingPass>& pass, void* storage);
  void begin_solve(std::optional<MovingPass>& pass, void* storage);

 private:
  const OutOfCore made_;
  const SegmentMoves factorization_, solve_;
  FactorFile file_;
};

/// Solves for matrices and vectors of Value by factors of Scalar: the same, or its single-precision kind.
template <class Exec, class Value, class Scalar>
class HostFactors final : public Factors<Value> {
 public:
  HostFactors(std::shared_ptr<const SymbolicPlan> plan, std::shared_ptr<const Pattern> pattern, int threads,
              const OutOfCore* outside, Vertex columns)
      : plan_(std::move(plan)),
        pattern_(std::move(pattern)),
        columns_at_once_(outside ? outside->columns : columns),
        outside_(outside ? std::make_unique<SegmentedFactors>(*outside, sizeof(Scalar)) : nullptr),
        schedule_(make_schedule(*plan_, threads)),
        subtrees_(make_subtrees(*plan_, threads)),
        blocks_(make_block_schedule(*plan_, threads)),
        workers_(threads, std::max(2 * list_by_segment(threads), blocks_.lists[0].size())),
        stacks_(subtrees_.stack.size()),
        layout_(*plan_, sizeof(Scalar), sizeof(Value), segments()),
        arena_(layout_.arena.total()),
        store_(make_front_store<Scalar, Value>(*plan_, *pattern_, layout_, arena_)),
        solve_store_(store_) {
    if (outside_) {
      place(store_, segments()->lower, segments()->upper);
      store_.contribution_begin = segments()->contribution.data();
      place(solve_store_, segments()->solve_lower, segments()->solve_upper);
    }
    make_room(1);
  }

  Value* matrix_values() override { return store_.matrix_values; }
  double* row_scale() override { return store_.row_scale; }
  double* column_scale() override { return store_.column_scale; }
  HostMatrix<Value> matrix() override {
    return {store_.matrix_values, store_.row_scale, store_.column_scale};
  }

  Factored factor(const PivotPolicy& policy, const std::function<void(double)>& progress) override {
    const blas::SequentialScope sequential(workers_.count());
    *store_.status = FactorStatus();
    double largest = 0;
    largest_scaled_entry(exec_, store_, &largest);
    const PivotRule rule = pivot_rule<RealOf<Scalar>>(policy, largest);
    const double total = plan_->flops.total();
    std::optional<MovingPass> moves;
    if (outside_) outside_->begin_factorization(moves, store_.storage);
    const auto done = [&](std::size_t list) {
      if (moves) {
        keep_diagonal(list);
        moves->done(list);
      }
      if (progress && total > 0) progress(flops_done(*store_.status) / total);
    };
    factor_tree(exec_, workers_, stacks_, store_, tree(), rule, Stages(), done,
                [&](std::size_t list) { return !moves || moves->may_begin(list); });
    exec_.fence();
    if (moves) moves->finish();
    if (!plan_->triangle.empty()) take_couplings(exec_, store_, plan_->triangle, couplings());
    return {*store_.status, largest};
  }

  void apply_inverse(const Value* from, Value* to, Vertex columns, bool transposed) override {
    const Vertex n = store_.n, width = rows::width_of(columns);
    const SolveVectors<Scalar> vectors{width, at<Scalar>(v_), at<Scalar>(y_), at<Scalar>(border_)};
    const Vertex* in = transposed ? store_.column_of : store_.row_of;
    const Vertex* out = transposed ? store_.row_of : store_.column_of;
    const double* in_scale = transposed ? store_.column_scale : store_.row_scale;
    const double* out_scale = transposed ? store_.row_scale : store_.column_scale;
    std::optional<MovingPass> moves;
    if (outside_) outside_->begin_solve(moves, store_.storage);
    if (width == 1) {
      gather_scaled<Value>(exec_, n, 1, in, in_scale, from, n, vectors.v);
    } else {
      columns_to_rows<Value>(exec_, n, columns, width, position_[transposed].data(), in_scale, from,
                             vectors.v);
    }
    if (plan_->triangle.empty()) {
      solve_tree(
          exec_, workers_, solve_store_, tree(), vectors, Substitution{true, true, transposed},
          [&](std::size_t list) {
            if (moves) moves->done(list);
          },
          [&](std::size_t list) { return !moves || moves->may_begin(list); });
    } else {
      const BlockSubstitution<Scalar, Value> blocks(store_, plan_->triangle, couplings(), vectors,
                                                    transposed);
      solve_blocks(exec_, workers_, blocks_, blocks, transposed);
    }
    if (moves) moves->finish();
    if (width == 1) {
      scatter_scaled<Value>(exec_, n, 1, out, out_scale, vectors.v, to);
    } else {
      rows_to_columns<Value>(exec_, n, columns, width, position_[!transposed].data(), out_scale, vectors.v,
                             to);
    }
  }

  void make_room(Vertex columns) override {
    const SubstitutionLayout layout(*plan_, sizeof(Scalar), columns);
    const bool inside = outside_ && columns <= columns_at_once();
    substitution_ = std::make_unique<HostArena>(inside ? 0 : layout.arena.total());
    vectors_ = inside ? reinterpret_cast<char*>(store_.storage + segments()->spare_begin)
                      : substitution_->template at<char>(0);
    v_ = layout.v;
    y_ = layout.y;
    border_ = layout.border;
    if (columns > 1 && position_[0].empty()) {
      std::vector<Vertex> of_rows = plan_->position_of_rows();
      position_[1] = plan_->position_of_columns();
      position_[0] = std::move(of_rows);
    }
  }
  Vertex columns_at_once() const override { return columns_at_once_; }

  std::shared_ptr<char> host_vectors(Offset bytes) const override {
    const auto arena = std::make_shared<HostArena>(bytes);
    return {arena, arena->template at<char>(0)};
  }

  Vertex local_row(Vertex position) const override { return store_.local_row[position]; }
  Value pivot_shift(Vertex position) const override { return static_cast<Value>(store_.shift[position]); }

  void diagonal_pivots(std::complex<double>* pivots) const override {
    if (outside_) {
      std::copy(diagonal(), diagonal() + plan_->n, pivots);
    } else {
      for (Vertex f = 0; f < plan_->num_fronts; ++f) copy_diagonal(f, pivots);
    }
  }

  MemorySpace memory() const override { return MemorySpace::host; }
  Offset bytes() const override {
    const Offset positions = 2 * static_cast<Offset>(position_[0].size() * sizeof(Vertex));
    return arena_.bytes() + substitution_->bytes() + positions;
  }
  Movement movement() const override { return outside_ ? outside_->made().movement : Movement(); }

 private:
  const SegmentPlan* segments() const { return outside_ ? &outside_->plan() : nullptr; }
  // With segments these are the lists, not the depths. Returns how many there are.
  std::size_t list_by_segment(int threads) {
    if (!outside_) return tree().lists();
    schedule_ = make_schedule(*plan_, *segments(), schedule_, subtrees_.steps, threads);
    subtrees_ = {};
    return schedule_.size();
  }
  TreeSchedule tree() const {
    const auto steps = static_cast<std::size_t>(subtrees_.steps);
    return {&subtrees_, schedule_.data() + steps, schedule_.size() - steps};
  }

  static void place(FrontStore<Scalar, Value>& store, const std::vector<Offset>& lower,
                    const std::vector<Offset>& upper) {
    store.lower_begin = lower.data();
    store.upper_begin = upper.data();
  }

  Scalar* couplings() const { return arena_.template at<Scalar>(layout_.couplings); }
  Scalar* diagonal() const { return arena_.template at<Scalar>(layout_.diagonal); }
  template <class Number>
  void copy_diagonal(Vertex f, Number* to) const {
    const Front<Scalar> front = store_.front(f);
    for (Vertex i = 0; i < front.pivots; ++i)
      to[plan_->pivot_begin[f] + i] = Number(front.lower[i + static_cast<Offset>(i) * front.lower_ld]);
  }
  // Of a segment, before its factors leave.
  void keep_diagonal(std::size_t t) {
    const Segment& segment = segments()->segments[t];
    for (Vertex i = segment.begin; i < segment.end; ++i) copy_diagonal(segments()->order[i], diagonal());
  }

  template <class T>
  T* at(Offset offset) const {
    return reinterpret_cast<T*>(vectors_ + offset);
  }

  std::shared_ptr<const SymbolicPlan> plan_;
  std::shared_ptr<const Pattern> pattern_;
  const Vertex columns_at_once_;
  std::unique_ptr<SegmentedFactors> outside_;  // null: all factors are in memory
  Exec exec_;
  Schedule schedule_;
  Subtrees subtrees_;
  BlockSchedule blocks_;  // of solves, where the plan has a triangle
  Workers workers_;
  StackPool stacks_;
  NumericLayout layout_;
  HostArena arena_;
  FrontStore<Scalar, Value> store_, solve_store_;  // in a solve factors may have other places
  std::unique_ptr<HostArena> substitution_;
  char* vectors_ = nullptr;            // of a solve
  Offset v_ = 0, y_ = 0, border_ = 0;  // in there
  std::vector<Vertex> position_[2];    // of rows and of columns, for more than one right-hand side
};

}  // namespace mfs
