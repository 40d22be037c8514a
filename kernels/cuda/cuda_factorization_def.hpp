// Definition of factors.hpp, for the files that instantiate it.
//
// Vectors make the way to the device once per solve, and solve, residuals and a few steps of refinement run
// there: enough for most matrices. Where that misses the tolerance, or pivots were perturbed, the rungs of
// the ladder (kernels/ladder.hpp) follow with vectors on the host, and only the substitutions run on the
// device.
#pragma once

#include <algorithm>
#include <cmath>

#include "kernels/cuda/device_stages_def.hpp"
#include "kernels/cuda/diagonal.hpp"
#include "kernels/cuda/factors.hpp"
#include "kernels/ladder.hpp"

namespace mfs::cuda {

/// What one block may have on the devices of compute capability 9.0.
constexpr std::size_t kMostSharedMemory = 227 * 1024;

template <class S>
constexpr bool fits_shared_memory() {
  return small_front_bytes<S>(kSmallRows<S>) <= kMostSharedMemory &&
         block_lu_bytes<S>() <= kMostSharedMemory && strip_bytes<S>() <= kMostSharedMemory &&
         NarrowShape::bytes<S>() <= kMostSharedMemory &&
         (!kWideProducts<S> || WideShape::bytes<S>() <= kMostSharedMemory) &&
         substitution_bytes<S, 16>() <= kMostSharedMemory;
}

template <class Value, class Scalar>
class CudaFactorization final : public AccuracyLadder<Kokkos::OpenMP, PinnedArena, Value>,
                                public DeviceFactors<Value> {
  using Ladder = AccuracyLadder<Kokkos::OpenMP, PinnedArena, Value>;
  using Ladder::plan;
  using S = DeviceScalar<Scalar>;
  using V = DeviceScalar<Value>;
  static_assert(fits_shared_memory<S>());

 public:
  CudaFactorization(std::shared_ptr<const SymbolicPlan> plan_of, std::shared_ptr<const Pattern> pattern_of)
      : Ladder(std::move(plan_of), std::move(pattern_of)),
        exec_(stream_.get()),
        stages_(plan(), this->pattern(), stream_) {
    const Offset n = plan().n;
    ArenaLayout layout;
    const Offset values = layout.add(plan().nnz * sizeof(Value)), row_scale = layout.add(n * sizeof(double)),
                 column_scale = layout.add(n * sizeof(double)),
                 errors = layout.add(kSolveColumns * sizeof(double)),
                 status = layout.add(sizeof(DeviceStatus));
    host_ = std::make_unique<PinnedArena>(layout.total());
    this->hold_matrix({host_->template at<Value>(values), host_->template at<double>(row_scale),
                       host_->template at<double>(column_scale)});
    errors_ = host_->template at<double>(errors);
    status_ = host_->template at<DeviceStatus>(status);
    make_room(1);
  }

  Value* matrix_values() override {
    bring_values();
    values_sent_ = false;
    return Ladder::matrix_values();
  }
  double* row_scale() override {
    scales_sent_ = false;
    return Ladder::row_scale();
  }
  double* column_scale() override {
    scales_sent_ = false;
    return Ladder::column_scale();
  }

  FactorStatus factor(double tolerance, const std::function<void(double)>& progress) override {
    this->forget_factors();
    pivots_read_ = false;
    send_matrix();
    do {
      launch_factor(tolerance);
      stream_.to_host(status_, stages_.status(), sizeof(DeviceStatus));
      stream_.synchronize();
    } while (status_->found_strict > 0);
    FactorStatus status = status_->pivots;
    status.getrf = plan().flops.getrf;
    status.trsm = plan().flops.trsm;
    status.gemm = plan().flops.gemm;
    this->note_factors(status, status_->largest);
    if (progress) progress(1.0);
    return status;
  }

  SolveOutcome solve(Vertex columns, const TransposedPattern* transposed,
                     const SolveControls& controls) override {
    SolveOutcome on_device;
    if (this->status().perturbed == 0) {
      const Offset bytes = static_cast<Offset>(plan().n) * columns * static_cast<Offset>(sizeof(Value));
      stream_.to_device(b_, this->rhs(columns), bytes);
      on_device = solve_on_device(columns, transposed, controls);
      if (on_device.backward_error <= controls.tolerance) {
        stream_.to_host(this->vectors().x, x_, bytes);
        stream_.synchronize();
        return on_device;
      }
    }
    bring_values();
    SolveOutcome outcome = Ladder::solve(columns, transposed, controls);
    outcome.refinement_steps += on_device.refinement_steps;
    outcome.time_ladder += on_device.time_ladder;
    return outcome;
  }

  double condition_estimate(const TransposedPattern& transposed) override {
    bring_values();
    return Ladder::condition_estimate(transposed);
  }
  bool determinant(Value& phase, double& log_abs) override {
    bring_values();
    return Ladder::determinant(phase, log_abs);
  }

  DeviceFactors<Value>* device() override { return this; }

  bool take_values(const Value* values, void* stream) override {
    follow(stream);
    stream_.copy_columns(stages_.matrix_values(), 0, values, 0, plan().nnz * sizeof(Value), 1);
    values_sent_ = true;
    values_here_ = false;
    return finite(plan().nnz, stages_.matrix_values());
  }

  bool solve_resident(const Value* b, Offset ldb, Value* x, Offset ldx, Vertex columns,
                      const TransposedPattern* transposed, const SolveControls& controls, void* stream,
                      SolveOutcome& outcome) override {
    if (this->status().perturbed > 0) return false;
    this->rhs(columns);  // room
    const Offset n = plan().n, bytes = n * static_cast<Offset>(sizeof(Value));
    follow(stream);
    stream_.copy_columns(b_, bytes, b, ldb * static_cast<Offset>(sizeof(Value)), bytes, columns);
    outcome = solve_on_device(columns, transposed, controls);
    // A b that is not finite leaves no finite error.
    if (!(outcome.backward_error <= controls.tolerance)) return false;
    stream_.copy_columns(x, ldx * static_cast<Offset>(sizeof(Value)), x_, bytes, bytes, columns);
    stream_.synchronize();
    return true;
  }

  void download(const Value* from, Offset ld, Offset rows, Vertex columns, Value* to, void* stream) override {
    follow(stream);
    const Offset bytes = rows * static_cast<Offset>(sizeof(Value));
    stream_.copy_columns(to, bytes, from, ld * static_cast<Offset>(sizeof(Value)), bytes, columns);
    stream_.synchronize();
  }
  void upload(const Value* from, Offset rows, Vertex columns, Value* to, Offset ld, void* stream) override {
    follow(stream);
    const Offset bytes = rows * static_cast<Offset>(sizeof(Value));
    stream_.copy_columns(to, ld * static_cast<Offset>(sizeof(Value)), from, bytes, bytes, columns);
    stream_.synchronize();
  }

  Value pivot_shift(Vertex position) const override {
    read_pivots();
    return static_cast<Value>(shift_[position]);
  }
  /// Of device memory.
  Offset bytes() const override {
    return stages_.bytes() + vectors_->bytes() + (transposed_ ? transposed_->bytes() : 0);
  }

 private:
  void send_matrix() {
    const Offset n = plan().n;
    if (!scales_sent_) {
      stream_.to_device(stages_.row_scale(), Ladder::row_scale(), n * sizeof(double));
      stream_.to_device(stages_.column_scale(), Ladder::column_scale(), n * sizeof(double));
      scales_sent_ = true;
    }
    if (!values_sent_) {
      stream_.to_device(stages_.matrix_values(), Ladder::matrix_values(), plan().nnz * sizeof(Value));
      values_sent_ = true;
    }
  }

  // The values on the host, where they came from the device.
  void bring_values() {
    if (values_here_) return;
    stream_.to_host(Ladder::matrix_values(), stages_.matrix_values(), plan().nnz * sizeof(Value));
    stream_.synchronize();
    values_here_ = true;
  }

  void follow(void* stream) {
    foreign_.record_foreign(stream);
    stream_.wait_for(foreign_);
  }

  bool finite(Offset count, const V* values) {
    find_nonfinite(exec_, count, values, device_errors_);
    stream_.to_host(errors_, device_errors_, sizeof(double));
    stream_.synchronize();
    return !(*errors_ > 0);
  }

  void launch_factor(double tolerance) {
    if (!warm_) {
      stages_.factor(tolerance);
      warm_ = true;
      return;
    }
    if (!graph_.recorded() || tolerance != graph_tolerance_) {
      graph_.record(stream_, [&] { stages_.factor(tolerance); });
      graph_tolerance_ = tolerance;
    }
    graph_.launch(stream_);
  }

  // Solution x_ and error of the right-hand sides in b_, refined while that halves the error.
  SolveOutcome solve_on_device(Vertex columns, const TransposedPattern* transposed,
                               const SolveControls& controls) {
    const Offset block = static_cast<Offset>(plan().n) * columns;
    SolveOutcome outcome;
    substitute(b_, x_, columns, transposed != nullptr);
    outcome.backward_error = largest_error(columns, transposed);
    const Stopwatch refining;
    double before = std::numeric_limits<double>::max();  // a first step for every finite error
    while (outcome.backward_error > controls.tolerance && outcome.backward_error <= before / 2 &&
           outcome.refinement_steps < controls.max_steps) {
      substitute(r_, d_, columns, transposed != nullptr);
      add_vector(exec_, block, V(1), static_cast<const V*>(d_), x_);
      before = outcome.backward_error;
      outcome.backward_error = largest_error(columns, transposed);
      ++outcome.refinement_steps;
    }
    if (outcome.refinement_steps > 0) outcome.time_ladder = refining.seconds();
    return outcome;
  }

  // Of all columns of x_; leaves their residuals in r_.
  double largest_error(Vertex columns, const TransposedPattern* transposed) {
    const RowAccess<V> rows = device_rows(transposed);
    for (Vertex j = 0; j < columns; ++j) {
      const Offset at = static_cast<Offset>(j) * plan().n;
      residual(exec_, plan().n, rows, static_cast<const V*>(b_ + at), static_cast<const V*>(x_ + at), r_ + at,
               device_errors_ + j);
    }
    stream_.to_host(errors_, device_errors_, columns * sizeof(double));
    stream_.synchronize();
    return *std::max_element(errors_, errors_ + columns);
  }

  void apply_inverse(const Value* from, Value* to, Vertex columns, bool transposed) override {
    const Offset bytes = static_cast<Offset>(plan().n) * columns * static_cast<Offset>(sizeof(Value));
    stream_.to_device(r_, from, bytes);
    substitute(r_, d_, columns, transposed);
    stream_.to_host(to, d_, bytes);
    stream_.synchronize();
  }

  // to = approximately A^-1 from, scaling and permutation included; device vectors.
  void substitute(const V* from, V* to, Vertex columns, bool transposed) {
    const FrontStore<S, V>& at = stages_.store().fronts;
    const Vertex* in = transposed ? at.column_of : at.row_of;
    const Vertex* out = transposed ? at.row_of : at.column_of;
    const double* in_scale = transposed ? at.column_scale : at.row_scale;
    const double* out_scale = transposed ? at.row_scale : at.column_scale;
    gather_scaled<V>(exec_, plan().n, columns, in, in_scale, from, substitution_.v);
    substitution_.columns = columns;
    Graph& graph = solve_graph_[transposed][columns - 1];
    if (!graph.recorded()) graph.record(stream_, [&] { stages_.substitute(substitution_, transposed); });
    graph.launch(stream_);
    scatter_scaled<V>(exec_, plan().n, columns, out, out_scale, static_cast<const S*>(substitution_.v), to);
  }

  void make_room(Vertex columns) override {
    const Offset block = static_cast<Offset>(plan().n) * columns;
    const Offset borders = static_cast<Offset>(plan().border.size()) * columns;
    ArenaLayout layout;
    const Offset b = layout.add(block * sizeof(V)), x = layout.add(block * sizeof(V)),
                 r = layout.add(block * sizeof(V)), d = layout.add(block * sizeof(V)),
                 v = layout.add(block * sizeof(S)), y = layout.add(block * sizeof(S)),
                 border = layout.add(borders * sizeof(S)),
                 errors = layout.add(kSolveColumns * sizeof(double));
    vectors_ = std::make_unique<DeviceArena>(layout.total());
    b_ = vectors_->template at<V>(b);
    x_ = vectors_->template at<V>(x);
    r_ = vectors_->template at<V>(r);
    d_ = vectors_->template at<V>(d);
    substitution_ = {vectors_->template at<S>(v), vectors_->template at<S>(y),
                     vectors_->template at<S>(border), columns};
    device_errors_ = vectors_->template at<double>(errors);
    for (auto& graphs : solve_graph_) {
      for (Graph& graph : graphs) graph.reset();
    }
  }

  RowAccess<V> device_rows(const TransposedPattern* transposed) {
    const FrontStore<S, V>& at = stages_.store().fronts;
    if (!transposed) return {at.matrix_offsets, at.matrix_columns, nullptr, at.matrix_values};
    if (!transposed_) {
      const Offset n = plan().n, nnz = plan().nnz;
      ArenaLayout layout;
      const Offset offsets = layout.add((n + 1) * sizeof(Offset)), columns = layout.add(nnz * sizeof(Vertex)),
                   slots = layout.add(nnz * sizeof(Offset));
      auto arena = std::make_unique<DeviceArena>(layout.total());
      stream_.to_device(arena->template at<Offset>(offsets), transposed->offsets.data(),
                        (n + 1) * sizeof(Offset));
      stream_.to_device(arena->template at<Vertex>(columns), transposed->columns.data(),
                        nnz * sizeof(Vertex));
      stream_.to_device(arena->template at<Offset>(slots), transposed->slots.data(), nnz * sizeof(Offset));
      stream_.synchronize();
      transposed_rows_ = {arena->template at<Offset>(offsets), arena->template at<Vertex>(columns),
                          arena->template at<Offset>(slots), at.matrix_values};
      transposed_ = std::move(arena);
    }
    return transposed_rows_;
  }

  Vertex local_row(Vertex position) const override {
    read_pivots();
    return local_row_[position];
  }

  // Once per factorization that is asked about its pivots.
  void read_pivots() const {
    if (pivots_read_) return;
    const std::size_t n = static_cast<std::size_t>(plan().n);
    local_row_.resize(n);
    shift_.resize(n);
    const FrontStore<S, V>& at = stages_.store().fronts;
    stream_.to_host(local_row_.data(), at.local_row, n * sizeof(Vertex));
    stream_.to_host(shift_.data(), at.shift, n * sizeof(Scalar));
    stream_.synchronize();
    pivots_read_ = true;
  }

  void diagonal_pivots(std::complex<double>* pivots) const override {
    std::vector<Scalar> inverse(static_cast<std::size_t>(plan().n));
    gather_diagonal(exec_, stages_.store().fronts, plan().num_fronts, substitution_.v);
    stream_.to_host(inverse.data(), substitution_.v, plan().n * sizeof(Scalar));
    stream_.synchronize();
    for (const Scalar& entry : inverse) *pivots++ = 1.0 / std::complex<double>(entry);
  }

  Stream stream_;
  Kokkos::Cuda exec_;
  DeviceStages<S, V> stages_;
  std::unique_ptr<PinnedArena> host_;
  double* errors_;
  DeviceStatus* status_;
  bool scales_sent_ = false, values_sent_ = false, values_here_ = true, warm_ = false;
  Event foreign_;
  Graph graph_, solve_graph_[2][kSolveColumns];
  double graph_tolerance_ = 0;
  std::unique_ptr<DeviceArena> vectors_, transposed_;
  RowAccess<V> transposed_rows_{};
  V *b_, *x_, *r_, *d_;
  double* device_errors_;
  typename DeviceStages<S, V>::Vectors substitution_{};
  mutable bool pivots_read_ = false;
  mutable std::vector<Vertex> local_row_;
  mutable std::vector<Scalar> shift_;
};

template <class Value, class Scalar>
std::unique_ptr<Factorization<Value>> make_factors(std::shared_ptr<const SymbolicPlan> plan,
                                                   std::shared_ptr<const Pattern> pattern) {
  return std::make_unique<CudaFactorization<Value, Scalar>>(std::move(plan), std::move(pattern));
}

}  // namespace mfs::cuda
