// The factors in the memory of the host, for any host execution space of Kokkos.
#pragma once

#include "kernels/factors.hpp"
#include "kernels/runtime/arena.hpp"
#include "kernels/stages/stages.hpp"
#include "kernels/stages/vector_ops.hpp"

namespace mfs {

/// Where each array of a factorization lies in its arena; made from the plan alone.
struct NumericLayout {
  NumericLayout(const SymbolicPlan& plan, Offset scalar_bytes, Offset value_bytes);
  ArenaLayout arena;
  Offset storage, matrix_values, row_scale, column_scale, interchange, local_row, shift, work, status;
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

/// Solves for matrices and vectors of Value by factors of Scalar: the same, or its single-precision kind.
template <class Exec, class Value, class Scalar>
class HostFactors final : public Factors<Value> {
 public:
  HostFactors(std::shared_ptr<const SymbolicPlan> plan, std::shared_ptr<const Pattern> pattern, int threads)
      : plan_(std::move(plan)),
        pattern_(std::move(pattern)),
        schedule_(make_schedule(*plan_, threads)),
        subtrees_(make_subtrees(*plan_, threads)),
        workers_(threads, 2 * tree().lists()),
        stacks_(subtrees_.stack.size()),
        layout_(*plan_, sizeof(Scalar), sizeof(Value)),
        arena_(layout_.arena.total()),
        store_(make_front_store<Scalar, Value>(*plan_, *pattern_, layout_, arena_)) {
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
    factor_tree(exec_, workers_, stacks_, store_, tree(), rule, Stages(), [&](std::size_t) {
      if (progress && total > 0) progress(flops_done(*store_.status) / total);
    });
    exec_.fence();
    return {*store_.status, largest};
  }

  void apply_inverse(const Value* from, Value* to, Vertex columns, bool transposed) override {
    const SolveVectors<Scalar> vectors{columns, substitution_->template at<Scalar>(v_),
                                       substitution_->template at<Scalar>(y_),
                                       substitution_->template at<Scalar>(border_)};
    const Vertex* in = transposed ? store_.column_of : store_.row_of;
    const Vertex* out = transposed ? store_.row_of : store_.column_of;
    const double* in_scale = transposed ? store_.column_scale : store_.row_scale;
    const double* out_scale = transposed ? store_.row_scale : store_.column_scale;
    gather_scaled<Value>(exec_, store_.n, columns, in, in_scale, from, store_.n, vectors.v);
    solve_tree(exec_, workers_, store_, tree(), vectors, Substitution{true, true, transposed});
    scatter_scaled<Value>(exec_, store_.n, columns, out, out_scale, vectors.v, to);
  }

  void make_room(Vertex columns) override {
    const SubstitutionLayout layout(*plan_, sizeof(Scalar), columns);
    substitution_ = std::make_unique<HostArena>(layout.arena.total());
    v_ = layout.v;
    y_ = layout.y;
    border_ = layout.border;
  }

  std::shared_ptr<char> host_vectors(Offset bytes) const override {
    const auto arena = std::make_shared<HostArena>(bytes);
    return {arena, arena->template at<char>(0)};
  }

  Vertex local_row(Vertex position) const override { return store_.local_row[position]; }
  Value pivot_shift(Vertex position) const override { return static_cast<Value>(store_.shift[position]); }

  void diagonal_pivots(std::complex<double>* pivots) const override {
    for (Vertex f = 0; f < plan_->num_fronts; ++f) {
      const Front<Scalar> front = store_.front(f);
      for (Vertex i = 0; i < front.pivots; ++i)
        *pivots++ = std::complex<double>(front.lower[i + static_cast<Offset>(i) * front.lower_ld]);
    }
  }

  MemorySpace memory() const override { return MemorySpace::host; }
  Offset bytes() const override { return arena_.bytes() + substitution_->bytes(); }

 private:
  TreeSchedule tree() const {
    const auto steps = static_cast<std::size_t>(subtrees_.steps);
    return {&subtrees_, schedule_.data() + steps, schedule_.size() - steps};
  }

  std::shared_ptr<const SymbolicPlan> plan_;
  std::shared_ptr<const Pattern> pattern_;
  Exec exec_;
  Schedule schedule_;
  Subtrees subtrees_;
  Workers workers_;
  StackPool stacks_;
  NumericLayout layout_;
  HostArena arena_;
  FrontStore<Scalar, Value> store_;
  std::unique_ptr<HostArena> substitution_;
  Offset v_ = 0, y_ = 0, border_ = 0;  // in there
};

}  // namespace mfs
