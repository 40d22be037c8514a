// Factors in the memory of an execution space, for the files that compile them for a pair of scalars.
#pragma once

#include <algorithm>
#include <complex>
#include <cstring>
#include <vector>

#include "kernels/factors.hpp"
#include "kernels/portable/factors_of_scalars.hpp"
#include "kernels/portable/stages.hpp"
#include "kernels/stages/pivots_on_host.hpp"
#include "kernels/stages/probe_directions.hpp"
#include "kernels/stages/residual.hpp"

namespace mfs::portable {

/// Where the vectors of a solve lie in the memory of the space. `resident_bytes` are those of a number of the
/// matrix where right-hand sides, solutions and residuals lie there too.
template <class S>
struct VectorLayout {
  VectorLayout(Offset n, Offset places, Vertex columns, Offset resident_bytes) {
    const Offset bytes = static_cast<Offset>(sizeof(S)) * columns;
    v = arena.add(n * bytes);
    y = arena.add(n * bytes);
    border = arena.add(places * bytes);
    for (Offset* vector : {&rhs, &x, &r}) *vector = arena.add(resident_bytes * n * columns);
    errors = arena.add(resident_bytes > 0 ? 2 * kSolveColumns * static_cast<Offset>(sizeof(double)) : 0);
  }
  ArenaLayout arena;
  Offset v, y, border, rhs, x, r;
  Offset errors;  // of each column, and its largest unknown
};

/// kResident: whether right-hand sides, solutions and refinement are in the memory of the space as well, as
/// is right where that is not the host's.
template <class Exec, class Value, class Scalar, class Dense = DenseOf<Exec, DeviceScalar<Scalar>>,
          bool kResident = !kOnHost<Exec>>
class PortableFactors final : public Factors<Value>, public ResidentFactors<Value> {
  using S = DeviceScalar<Scalar>;
  using V = DeviceScalar<Value>;
  using Stages = PortableStages<Exec, S, V, Dense>;
  using Queue = typename Stages::Queue;
  using HostSide = typename Space<Exec>::HostSide;
  using Launches = typename Space<Exec>::Launches;

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
    bring_values();
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
  HostMatrix<Value> matrix() override {
    bring_values();
    return {values_, row_scale_, column_scale_};
  }

  // Again where fronts have to be strict.
  Factored factor(const PivotPolicy& policy, const std::function<void(double)>& progress) override {
    const CallerScope callers(threads_);
    pivots_.forget();
    send_matrix();
    if (policy.substitutes() != policy_.substitutes()) {
      forget_solves();
      stages_.forget_strict_fronts();
    }
    Status status = launch_factor(policy, progress);
    int passes = 1;
    for (; status.found_strict > 0 && status.pivots.perturbed <= policy.most_perturbed; ++passes) {
      stages_.make_ancestors_strict();
      status = launch_factor(policy, progress);
    }
    solve_as(policy);
    if (progress) progress(1.0);
    const BlockFlops& flops = stages_.flops();
    status.pivots.getrf = passes * flops.getrf;
    status.pivots.trsm = passes * flops.trsm;
    status.pivots.gemm = passes * flops.gemm;
    return {status.pivots, status.largest};
  }

  void solve_as(const PivotPolicy& policy) override {
    const bool mirrors = !Dense::kSearchesAll && policy.solves_by_transposed(host_status_->pivots.perturbed);
    if (mirrors != mirrors_) forget_solves();
    mirrors_ = mirrors;
  }

  void apply_inverse(const Value* from, Value* to, Vertex columns, bool transposed) override {
    const CallerScope callers(threads_);
    const V* in = reinterpret_cast<const V*>(from);
    V* out = reinterpret_cast<V*>(to);
    if constexpr (kResident) {
      queue().to_space(rhs_, from, bytes_of(columns));
      inverse_[transposed][columns].run(
          queue(), [&] { multiply_by_inverse(static_cast<const V*>(rhs_), x_, columns, transposed, false); });
      queue().to_host(to, x_, bytes_of(columns));
    } else {
      multiply_by_inverse(in, out, columns, transposed, false);
    }
    queue().wait();
  }

  void make_room(Vertex columns) override {
    const VectorLayout<S> layout = vector_layout(*plan_, stages_.border_places(), columns);
    vector_memory_ = std::make_unique<typename Space<Exec>::Arena>(layout.arena.total());
    vectors_ = {columns, vector_memory_->template at<S>(layout.v), vector_memory_->template at<S>(layout.y),
                vector_memory_->template at<S>(layout.border)};
    rhs_ = vector_memory_->template at<V>(layout.rhs);
    x_ = vector_memory_->template at<V>(layout.x);
    r_ = vector_memory_->template at<V>(layout.r);
    errors_ = vector_memory_->template at<double>(layout.errors);
    forget_solves();
  }

  ResidentFactors<Value>* resident() override { return kResident ? this : nullptr; }

  void require_reachable(const void* array, const char* name) const override {
    Space<Exec>::require_reachable(array, name);
  }
  bool take_values(const Value* values, void* stream) override {
    queue().follow(stream);
    const FrontStore<S, V>& at = stages_.store().fronts;
    queue().copy_within(at.matrix_values, values, plan_->nnz * static_cast<Offset>(sizeof(Value)));
    values_sent_ = true;
    values_here_ = false;
    finite_.run(queue(), [&] {
      find_nonfinite(queue().exec(), plan_->nnz, static_cast<const V*>(at.matrix_values), errors_);
    });
    return !(read_error(1) > 0);
  }
  void download(const Value* from, Offset ld, Offset rows, Vertex columns, Value* to, void* stream) override {
    queue().follow(stream);
    for (Vertex j = 0; j < columns; ++j)
      queue().to_host(to + j * rows, from + j * ld, rows * static_cast<Offset>(sizeof(Value)));
    queue().wait();
  }
  void upload(const Value* from, Offset rows, Vertex columns, Value* to, Offset ld, void* stream) override {
    queue().follow(stream);
    for (Vertex j = 0; j < columns; ++j)
      queue().to_space(to + j * ld, from + j * rows, rows * static_cast<Offset>(sizeof(Value)));
    queue().wait();
  }

  void start(const SolveBlock<Value>& block, double row_floor, void* stream) override {
    if (block.columns > vectors_.columns) make_room(block.columns);
    queue().follow(stream);
    for (Vertex j = 0; j < block.columns; ++j)
      queue().copy_within(rhs_ + j * n(), block.b + j * block.ldb, bytes_of(1));
    begin(block, row_floor, false);
  }
  void start_from_host(const SolveBlock<Value>& block, double row_floor) override {
    queue().to_space(rhs_, block.b, bytes_of(block.columns));
    begin(block, row_floor, true);
  }
  double backward_error(double bound) override {
    const SolveBlock<Value>& block = solve_;
    if (solve_on_host_) queue().to_host(block.x, x_, bytes_of(block.columns));
    const double error = read_error(block.columns);
    if (solve_on_host_ || !(error <= bound)) return error;
    for (Vertex j = 0; j < block.columns; ++j)
      queue().copy_within(block.x + j * block.ldx, x_ + j * n(), bytes_of(1));
    queue().wait();
    return error;
  }
  void correct() override {
    const bool transposed = solve_.transposed != nullptr;
    corrections_[transposed][solve_.columns].run(queue(), [&] {
      multiply_by_inverse(static_cast<const V*>(r_), x_, solve_.columns, transposed, true);
      measure();
    });
  }
  void bring_solution(Value* x) override {
    queue().to_host(x, x_, bytes_of(solve_.columns));
    queue().wait();
  }
  ProbeStep probe(bool from_nothing) override {
    const ProbeVectors<V> at = probe_vectors(from_nothing);
    auto* const found = reinterpret_cast<ProbeStep*>(errors_);
    probe_step_.run(queue(), [&] {
      const FrontStore<S, V>& fronts = stages_.store().fronts;
      multiply_by_inverse(static_cast<const V*>(r_), x_, 1, false, false);
      take_probe_step(queue().exec(), plan_->n, rows_of(nullptr), fronts.row_scale, fronts.column_scale, at,
                      found);
    });
    return bring_probe_step(found);
  }
  std::optional<ProbeStep> probe_together(bool from_nothing) override {
    if (ProbeDirections<V>::most(n()) == 0) return std::nullopt;
    if (!directions_memory_) {
      directions_memory_ = std::make_unique<typename Space<Exec>::Arena>(ProbeDirections<V>::bytes(n()));
      directions_ = ProbeDirections<V>(n(), directions_memory_->template at<char>(0));
    }
    if (from_nothing) directions_.forget();
    if (directions_.full()) return std::nullopt;
    const ProbeVectors<V> at = probe_vectors(from_nothing);
    auto* const found = reinterpret_cast<ProbeStep*>(errors_);
    const FrontStore<S, V>& fronts = stages_.store().fronts;
    multiply_by_inverse(static_cast<const V*>(r_), x_, 1, false, false);
    directions_.take_step(queue().exec(), rows_of(nullptr), fronts.row_scale, fronts.column_scale, at, found);
    return bring_probe_step(found);
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
    for (const Scalar& entry : found) {
      const std::complex<double> pivot(entry);
      *pivots++ = stages_.has_pivots() ? pivot : 1.0 / pivot;
    }
  }

  MemorySpace memory() const override { return kOnHost<Exec> ? MemorySpace::host : MemorySpace::device; }
  Offset bytes() const override {
    Offset bytes = stages_.bytes() + vector_memory_->bytes();
    for (const auto& arena : {&transposed_, &probe_, &directions_memory_})
      bytes += *arena ? (*arena)->bytes() : 0;
    return bytes;
  }

 private:
  /// On the host, as many threads as teams call BLAS.
  struct CallerScope {
    explicit CallerScope(int threads) : sequential(kOnHost<Exec> ? threads : 1) {}
    blas::SequentialScope sequential;
  };
  Queue& queue() const { return stages_.queue(); }
  Offset n() const { return plan_->n; }
  Offset bytes_of(Vertex columns) const { return n() * columns * static_cast<Offset>(sizeof(Value)); }

  static VectorLayout<S> vector_layout(const SymbolicPlan& plan, Offset places, Vertex columns) {
    return {plan.n, places, columns, kResident ? static_cast<Offset>(sizeof(V)) : 0};
  }

  // to = approximately A^-1 from (or A^-T), or += that, in the caller's order. The other factors may serve
  // (PivotPolicy::symmetric).
  void multiply_by_inverse(const V* from, V* to, Vertex columns, bool of_transposed, bool add) {
    const bool transposed = of_transposed || mirrors_;
    const FrontStore<S, V>& at = stages_.store().fronts;
    Vectors<S> vectors = vectors_;
    vectors.columns = columns;
    gather_scaled<V>(queue().exec(), plan_->n, columns, transposed ? at.column_of : at.row_of,
                     transposed ? at.column_scale : at.row_scale, from, n(), vectors.v);
    stages_.substitute(vectors, transposed);
    scatter_scaled<V>(queue().exec(), plan_->n, columns, transposed ? at.row_of : at.column_of,
                      transposed ? at.row_scale : at.column_scale, static_cast<const S*>(vectors.v), to, add);
  }

  // r is r_, and A^-1 r will be x_.
  ProbeVectors<V> probe_vectors(bool from_nothing) {
    if (!probe_) probe_ = std::make_unique<typename Space<Exec>::Arena>(bytes_of(2));
    V* const x = probe_->template at<V>(0);
    const ProbeVectors<V> at{x, x + n(), x_, r_};
    if (from_nothing) begin_probe(queue().exec(), plan_->n, stages_.store().fronts.row_scale, at);
    return at;
  }
  ProbeStep bring_probe_step(const ProbeStep* found) {
    ProbeStep step;
    queue().to_host(host_errors_, found, sizeof step);
    queue().wait();
    std::memcpy(&step, host_errors_, sizeof step);
    return step;
  }

  // Of what is in rhs_. `block` says where the solution goes.
  void begin(const SolveBlock<Value>& block, double row_floor, bool on_host) {
    solve_ = block;
    solve_on_host_ = on_host;
    if (row_floor != row_floor_) forget_solves();
    row_floor_ = row_floor;
    rows_ = rows_of(block.transposed);
    const bool transposed = block.transposed != nullptr;
    solves_[transposed][block.columns].run(queue(), [&] {
      multiply_by_inverse(static_cast<const V*>(rhs_), x_, block.columns, transposed, false);
      measure();
    });
  }
  // r = b - A x and the backward error of each column.
  void measure() {
    const FrontStore<S, V>& at = stages_.store().fronts;
    const bool transposed = solve_.transposed != nullptr;
    for (Vertex j = 0; j < solve_.columns; ++j) {
      const V* const x = x_ + j * n();
      RowFloor floor;
      if (row_floor_ > 0) {
        double* const largest = errors_ + kSolveColumns + j;
        largest_unscaled(queue().exec(), plan_->n, transposed ? at.row_scale : at.column_scale, x, largest);
        floor = {row_floor_, largest, transposed ? at.column_scale : at.row_scale};
      }
      residual(queue().exec(), plan_->n, rows_, static_cast<const V*>(rhs_ + j * n()), x, r_ + j * n(),
               errors_ + j, nullptr, floor);
    }
  }
  double read_error(Vertex columns) {
    queue().to_host(host_errors_, errors_, columns * static_cast<Offset>(sizeof(double)));
    queue().wait();
    return *std::max_element(host_errors_, host_errors_ + columns);
  }
  void forget_solves() {
    for (auto* kind : {&inverse_, &solves_, &corrections_}) {
      for (auto& by_columns : *kind) {
        for (Launches& launches : by_columns) launches.forget();
      }
    }
    finite_.forget();
    probe_step_.forget();
  }

  RowAccess<V> rows_of(const TransposedPattern* transposed) {
    const FrontStore<S, V>& at = stages_.store().fronts;
    if (!transposed) return {at.matrix_offsets, at.matrix_columns, nullptr, at.matrix_values};
    if (!transposed_) {
      const Offset nnz = plan_->nnz;
      ArenaLayout layout;
      const Offset offsets = layout.add((n() + 1) * static_cast<Offset>(sizeof(Offset))),
                   columns = layout.add(nnz * static_cast<Offset>(sizeof(Vertex))),
                   slots = layout.add(nnz * static_cast<Offset>(sizeof(Offset)));
      auto arena = std::make_unique<typename Space<Exec>::Arena>(layout.total());
      const auto put = [&](auto* place, const auto& array) {
        queue().to_space(place, array.data(), static_cast<Offset>(array.size() * sizeof(array[0])));
        return place;
      };
      transposed_rows_ = {put(arena->template at<Offset>(offsets), transposed->offsets),
                          put(arena->template at<Vertex>(columns), transposed->columns),
                          put(arena->template at<Offset>(slots), transposed->slots), at.matrix_values};
      queue().wait();
      transposed_ = std::move(arena);
    }
    return transposed_rows_;
  }

  // The values on the host, where they came from the space.
  void bring_values() {
    if (values_here_) return;
    queue().to_host(values_, stages_.store().fronts.matrix_values,
                    plan_->nnz * static_cast<Offset>(sizeof(Value)));
    queue().wait();
    values_here_ = true;
  }

  // Where the caller puts values and scales: in the memory of the space, if that is the host's.
  void place_matrix() {
    const FrontStore<S, V>& at = stages_.store().fronts;
    const Offset doubles = static_cast<Offset>(sizeof(double));
    ArenaLayout layout;
    const Offset errors = layout.add(kSolveColumns * doubles),
                 values = layout.add(kOnHost<Exec> ? 0 : plan_->nnz * static_cast<Offset>(sizeof(Value))),
                 row = layout.add(kOnHost<Exec> ? 0 : n() * doubles),
                 column = layout.add(kOnHost<Exec> ? 0 : n() * doubles),
                 status = layout.add(static_cast<Offset>(sizeof(Status)));
    host_ = std::make_unique<HostSide>(layout.total());
    host_errors_ = host_->template at<double>(errors);
    if constexpr (kOnHost<Exec>) {
      values_ = reinterpret_cast<Value*>(at.matrix_values);
      row_scale_ = at.row_scale;
      column_scale_ = at.column_scale;
      host_status_ = stages_.store().status;
    } else {
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
    const auto after_depth = [&]([[maybe_unused]] Vertex step) {
      if constexpr (kOnHost<Exec>) {
        if (!progress || !(total > 0)) return;
        for (Vertex f = plan_->depth_begin[step]; f < plan_->depth_begin[step + 1]; ++f)
          done += plan_->front_flops[f];
        progress(std::min(done / total, 1.0));
      }
    };
    if (!(policy == policy_)) factor_.forget();
    policy_ = policy;
    factor_.run(queue(), [&] { stages_.factor(policy, after_depth); });
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
  std::unique_ptr<HostSide> host_;  // values, scales, status and errors on the host's side
  Value* values_ = nullptr;
  double *row_scale_ = nullptr, *column_scale_ = nullptr;
  Status* host_status_ = nullptr;
  double* host_errors_ = nullptr;
  bool scales_sent_ = false, values_sent_ = false, values_here_ = true;
  PivotPolicy policy_{0};  // of the recorded launches
  std::unique_ptr<typename Space<Exec>::Arena> vector_memory_, transposed_, probe_, directions_memory_;
  ProbeDirections<V> directions_;
  Vectors<S> vectors_{};
  V *rhs_ = nullptr, *x_ = nullptr, *r_ = nullptr;
  double* errors_ = nullptr;
  SolveBlock<Value> solve_{};  // under way
  bool solve_on_host_ = false;
  bool mirrors_ = false;  // A^-T serves for A^-1, too
  double row_floor_ = 0;
  RowAccess<V> rows_{}, transposed_rows_{};
  Launches factor_, finite_, probe_step_;
  using ByColumns = Launches[2][kSolveColumns + 1];  // by transposed
  ByColumns inverse_, solves_, corrections_;
  mutable PivotsOnHost<Scalar> pivots_;
};

template <class Exec, class Value, class Scalar>
Planned<Factors<Value>> plan_factors_in(std::shared_ptr<const SymbolicPlan> plan,
                                        std::shared_ptr<const Pattern> pattern, int threads) {
  using Made = PortableFactors<Exec, Value, Scalar>;
  const auto lists = std::make_shared<Lists>(Made::lists_for(*plan, threads));
  const DeviceFlops flops = count_flops(*plan, lists->device, false);
  return {Made::bytes_for(*plan, *pattern, *lists),
          flops.done,
          {},
          [=] {
            Space<Exec>::start();
            return std::make_unique<Made>(plan, pattern, threads, std::move(*lists));
          },
          flops.steps};
}

#define MFS_INSTANTIATE_PORTABLE(Value, Scalar)                                                              \
  template <>                                                                                                \
  Planned<Factors<Value>> plan_factors<Value, Scalar>(std::shared_ptr<const SymbolicPlan> plan,              \
                                                      std::shared_ptr<const Pattern> pattern, int threads) { \
    return plan_factors_in<Kokkos::DefaultExecutionSpace, Value, Scalar>(std::move(plan),                    \
                                                                         std::move(pattern), threads);       \
  }

}  // namespace mfs::portable
