// Factors in the memory of an execution space, for the files that compile them for a pair of scalars.
#pragma once

#include <complex>
#include <vector>

#include "kernels/factors.hpp"
#include "kernels/fallback.hpp"
#include "kernels/portable/factors_of_scalars.hpp"
#include "kernels/portable/stages.hpp"
#include "kernels/stages/pivots_on_host.hpp"

namespace mfs::portable {

/// Vectors of a solve in the memory of the space.
template <class S>
struct VectorLayout {
  VectorLayout(Offset n, Offset places, Vertex columns, Offset staged_bytes) {
    const Offset bytes = static_cast<Offset>(sizeof(S)) * columns;
    v = arena.add(n * bytes);
    y = arena.add(n * bytes);
    border = arena.add(places * bytes);
    staged = arena.add(staged_bytes * n * columns);
  }
  ArenaLayout arena;
  Offset v, y, border;
  Offset staged;  // right-hand sides and solutions, where they are not read and written in their place
};

template <class Exec, class Value, class Scalar, class Dense = DenseOf<Exec, DeviceScalar<Scalar>>>
class PortableFactors final : public Factors<Value> {
  using S = DeviceScalar<Scalar>;
  using V = DeviceScalar<Value>;
  using Stages = PortableStages<Exec, S, V, Dense>;
  using HostSide = typename Space<Exec>::HostSide;

 public:
  PortableFactors(std::shared_ptr<const SymbolicPlan> plan, std::shared_ptr<const Pattern> pattern,
                  int threads, Lists lists)
      : plan_(std::move(plan)),
        pattern_(std::move(pattern)),
        threads_(threads),
        stages_(*plan_, *pattern_, std::move(lists)) {
    stages_.allocate();
    place_matrix();
    make_room(1);
  }
  static Lists lists_for(const SymbolicPlan& plan, int threads) {
    return make_lists(plan, sizes_for<Exec, S, Dense>(threads));
  }
  static NumericBytes bytes_for(const SymbolicPlan& plan, const Pattern& pattern, const Lists& lists) {
    NumericBytes bytes;
    bytes.factor = plan.factor_entries * static_cast<Offset>(sizeof(S));
    bytes.contribution = (plan.storage_entries - plan.factor_entries) * static_cast<Offset>(sizeof(S));
    bytes.other =
        Stages::bytes_for(plan, pattern, lists.device, lists.own) - bytes.factor - bytes.contribution;
    bytes.solve = vector_layout(plan, lists.device.border_places, 1).arena.total();
    return bytes;
  }

  Value* matrix_values() override {
    values_sent_ = false;
    return values_;
  }
  double* row_scale() override {
    scales_sent_ = false;
    return row_scale_;
  }
  double* column_scale() override {
    scales_sent_ = false;
    return column_scale_;
  }
  HostMatrix<Value> matrix() override { return {values_, row_scale_, column_scale_}; }

  // Again where fronts have to be strict.
  Factored factor(const PivotPolicy& policy, const std::function<void(double)>& progress) override {
    const CallerScope callers(threads_);
    pivots_.forget();
    send_matrix();
    strict_.begin();
    if (!strict_.active()) stages_.forget_strict_fronts();
    Status status = launch_factor(policy, progress);
    int passes = 1;
    for (; status.found_strict > 0; ++passes) {
      strict_.activate();
      status = launch_factor(policy, progress);
    }
    strict_.end();
    if (progress) progress(1.0);
    status.pivots.getrf = passes * plan_->flops.getrf;
    status.pivots.trsm = passes * plan_->flops.trsm;
    status.pivots.gemm = passes * plan_->flops.gemm;
    return {status.pivots, status.largest};
  }

  void apply_inverse(const Value* from, Value* to, Vertex columns, bool transposed) override {
    const CallerScope callers(threads_);
    const Vertex n = plan_->n;
    const Offset bytes = static_cast<Offset>(n) * columns * static_cast<Offset>(sizeof(Value));
    const FrontStore<S, V>& at = stages_.store().fronts;
    const V* in = reinterpret_cast<const V*>(from);
    V* out = reinterpret_cast<V*>(to);
    if constexpr (!kOnHost<Exec>) {
      queue().to_space(staged_, from, bytes);
      in = out = staged_;
    }
    Vectors<S> vectors = vectors_;
    vectors.columns = columns;
    gather_scaled<V>(queue().exec(), n, columns, transposed ? at.column_of : at.row_of,
                     transposed ? at.column_scale : at.row_scale, in, vectors.v);
    stages_.substitute(vectors, transposed);
    scatter_scaled<V>(queue().exec(), n, columns, transposed ? at.row_of : at.column_of,
                      transposed ? at.row_scale : at.column_scale, static_cast<const S*>(vectors.v), out);
    if constexpr (!kOnHost<Exec>) queue().to_host(to, staged_, bytes);
    queue().wait();
  }

  void make_room(Vertex columns) override {
    const VectorLayout<S> layout = vector_layout(*plan_, stages_.border_places(), columns);
    vector_memory_ = std::make_unique<typename Space<Exec>::Arena>(layout.arena.total());
    vectors_ = {columns, vector_memory_->template at<S>(layout.v), vector_memory_->template at<S>(layout.y),
                vector_memory_->template at<S>(layout.border)};
    staged_ = vector_memory_->template at<V>(layout.staged);
  }

  std::shared_ptr<char> host_vectors(Offset bytes) const override {
    const auto arena = std::make_shared<HostSide>(bytes);
    return {arena, arena->template at<char>(0)};
  }

  Vertex local_row(Vertex position) const override {
    bring_pivots();
    return pivots_.local_row(position);
  }
  Value pivot_shift(Vertex position) const override {
    bring_pivots();
    return static_cast<Value>(pivots_.shift(position));
  }
  void diagonal_pivots(std::complex<double>* pivots) const override {
    std::vector<Scalar> found(static_cast<std::size_t>(plan_->n));
    gather_diagonal(queue().exec(), stages_.store().fronts, plan_->num_fronts, vectors_.v);
    queue().to_host(found.data(), vectors_.v, plan_->n * static_cast<Offset>(sizeof(S)));
    queue().wait();
    for (const Scalar& pivot : found) *pivots++ = std::complex<double>(pivot);
  }

  MemorySpace memory() const override { return kOnHost<Exec> ? MemorySpace::host : MemorySpace::device; }
  Offset bytes() const override { return stages_.bytes() + vector_memory_->bytes(); }

 private:
  /// On the host, as many threads as teams call BLAS.
  struct CallerScope {
    explicit CallerScope(int threads) : sequential(kOnHost<Exec> ? threads : 1) {}
    blas::SequentialScope sequential;
  };
  const typename Stages::Queue& queue() const { return stages_.queue(); }

  static VectorLayout<S> vector_layout(const SymbolicPlan& plan, Offset places, Vertex columns) {
    return {plan.n, places, columns, kOnHost<Exec> ? 0 : static_cast<Offset>(sizeof(V))};
  }

  // Where the caller puts values and scales: in the memory of the space, if that is the host's.
  void place_matrix() {
    const FrontStore<S, V>& at = stages_.store().fronts;
    if constexpr (kOnHost<Exec>) {
      values_ = reinterpret_cast<Value*>(at.matrix_values);
      row_scale_ = at.row_scale;
      column_scale_ = at.column_scale;
      host_status_ = stages_.store().status;
    } else {
      const Offset n = plan_->n;
      ArenaLayout layout;
      const Offset values = layout.add(plan_->nnz * static_cast<Offset>(sizeof(Value))),
                   row = layout.add(n * static_cast<Offset>(sizeof(double))),
                   column = layout.add(n * static_cast<Offset>(sizeof(double))),
                   status = layout.add(static_cast<Offset>(sizeof(Status)));
      host_ = std::make_unique<HostSide>(layout.total());
      values_ = host_->template at<Value>(values);
      row_scale_ = host_->template at<double>(row);
      column_scale_ = host_->template at<double>(column);
      host_status_ = host_->template at<Status>(status);
    }
  }
  void send_matrix() {
    if constexpr (!kOnHost<Exec>) {
      const FrontStore<S, V>& at = stages_.store().fronts;
      const Offset n = plan_->n;
      if (!scales_sent_) {
        queue().to_space(at.row_scale, row_scale_, n * static_cast<Offset>(sizeof(double)));
        queue().to_space(at.column_scale, column_scale_, n * static_cast<Offset>(sizeof(double)));
      }
      if (!values_sent_)
        queue().to_space(at.matrix_values, values_, plan_->nnz * static_cast<Offset>(sizeof(Value)));
    }
    scales_sent_ = values_sent_ = true;
  }

  // Where launches return when their work is done, progress is told after each depth.
  Status launch_factor(const PivotPolicy& policy, const std::function<void(double)>& progress) {
    const double total = plan_->flops.total();
    double done = 0;
    stages_.factor(policy, [&]([[maybe_unused]] Vertex step) {
      if constexpr (kOnHost<Exec>) {
        if (!progress || !(total > 0)) return;
        for (Vertex f = plan_->depth_begin[step]; f < plan_->depth_begin[step + 1]; ++f)
          done += plan_->front_flops[f];
        progress(std::min(done / total, 1.0));
      }
    });
    if constexpr (!kOnHost<Exec>) queue().to_host(host_status_, stages_.store().status, sizeof(Status));
    queue().wait();
    return *host_status_;
  }

  void bring_pivots() const {
    pivots_.bring(
        stages_.store().fronts,
        [&](void* to, const void* from, Offset bytes) { queue().to_host(to, from, bytes); },
        [&] { queue().wait(); });
  }

  std::shared_ptr<const SymbolicPlan> plan_;
  std::shared_ptr<const Pattern> pattern_;
  int threads_;
  Stages stages_;
  std::unique_ptr<HostSide> host_;  // values, scales and status on the host's side
  Value* values_ = nullptr;
  double *row_scale_ = nullptr, *column_scale_ = nullptr;
  Status* host_status_ = nullptr;
  bool scales_sent_ = false, values_sent_ = false;
  Fallback strict_;  // some front is, else none
  std::unique_ptr<typename Space<Exec>::Arena> vector_memory_;
  Vectors<S> vectors_{};
  V* staged_ = nullptr;
  mutable PivotsOnHost<Scalar> pivots_;
};

template <class Exec, class Value, class Scalar>
Planned<Factors<Value>> plan_factors_in(std::shared_ptr<const SymbolicPlan> plan,
                                        std::shared_ptr<const Pattern> pattern, int threads) {
  using Made = PortableFactors<Exec, Value, Scalar>;
  const auto lists = std::make_shared<Lists>(Made::lists_for(*plan, threads));
  return {Made::bytes_for(*plan, *pattern, *lists), plan->flops, [=] {
            Space<Exec>::start();
            return std::make_unique<Made>(plan, pattern, threads, std::move(*lists));
          }};
}

#define MFS_INSTANTIATE_PORTABLE(Value, Scalar)                                                              \
  template <>                                                                                                \
  Planned<Factors<Value>> plan_factors<Value, Scalar>(std::shared_ptr<const SymbolicPlan> plan,              \
                                                      std::shared_ptr<const Pattern> pattern, int threads) { \
    return plan_factors_in<Kokkos::DefaultExecutionSpace, Value, Scalar>(std::move(plan),                    \
                                                                         std::move(pattern), threads);       \
  }

}  // namespace mfs::portable
