// Definitions of cuda_factorization.hpp, for the files that instantiate it.
#pragma once

#include <cmath>

#include "kernels/cuda/cuda_factorization.hpp"
#include "kernels/cuda/device_stages_def.hpp"
#include "kernels/residual.hpp"

namespace mfs::cuda {

template <class Value, class Scalar>
class CudaFactorization final : public Factorization<Value> {
 public:
  using S = DeviceScalar<Scalar>;
  using V = DeviceScalar<Value>;

  CudaFactorization(std::shared_ptr<const SymbolicPlan> plan, std::shared_ptr<const Pattern> pattern)
      : plan_(std::move(plan)),
        pattern_(std::move(pattern)),
        exec_(stream_.get()),
        stages_(*plan_, *pattern_, stream_),
        host_(plan_->nnz * static_cast<Offset>(sizeof(Value)) + 2 * plan_->n * static_cast<Offset>(sizeof(double)) +
              static_cast<Offset>(sizeof(DeviceStatus) + kSolveColumns * sizeof(double))) {
    row_scale_ = host_.template at<double>(0);
    column_scale_ = row_scale_ + plan_->n;
    errors_ = column_scale_ + plan_->n;
    status_ = reinterpret_cast<DeviceStatus*>(errors_ + kSolveColumns);
    values_ = reinterpret_cast<Value*>(status_ + 1);
    take_vectors(1);
  }

  Value* matrix_values() override { return values_; }
  double* row_scale() override {
    scales_sent_ = false;
    return row_scale_;
  }
  double* column_scale() override {
    scales_sent_ = false;
    return column_scale_;
  }

  FactorStatus factor(double tolerance, const std::function<void(double)>& progress) override {
    if (!scales_sent_) {
      stream_.to_device(stages_.row_scale(), row_scale_, plan_->n * static_cast<Offset>(sizeof(double)));
      stream_.to_device(stages_.column_scale(), column_scale_, plan_->n * static_cast<Offset>(sizeof(double)));
      scales_sent_ = true;
    }
    stream_.to_device(stages_.matrix_values(), values_, plan_->nnz * static_cast<Offset>(sizeof(Value)));
    do {
      launch_factor(tolerance);
      stream_.to_host(status_, stages_.status(), sizeof(DeviceStatus));
      stream_.synchronize();
    } while (status_->found_strict > 0);
    FactorStatus status = status_->pivots;
    status.getrf = plan_->flops.getrf;
    status.trsm = plan_->flops.trsm;
    status.gemm = plan_->flops.gemm;
    pivots_read_ = false;
    if (progress) progress(1.0);
    return status;
  }

  Value* rhs(Vertex columns) override {
    if (columns > columns_) take_vectors(columns);
    return host_b_;
  }
  const Value* solution() const override { return host_x_; }

  SolveOutcome solve(Vertex columns, const TransposedPattern* transposed, const SolveControls& controls) override {
    const Vertex n = plan_->n;
    const Offset block = static_cast<Offset>(n) * columns;
    SolveOutcome outcome;
    stream_.to_device(b_, host_b_, block * static_cast<Offset>(sizeof(Value)));
    apply_inverse(b_, x_, columns, transposed != nullptr);
    const RowAccess<V> rows = matrix_rows(transposed);
    double worst = 0;
    for (int step = 0;; ++step) {
      for (Vertex j = 0; j < columns; ++j) {
        const Offset at = static_cast<Offset>(j) * n;
        residual(exec_, n, rows, static_cast<const V*>(b_ + at), static_cast<const V*>(x_ + at), r_ + at, device_errors_ + j);
      }
      stream_.to_host(errors_, device_errors_, columns * static_cast<Offset>(sizeof(double)));
      stream_.synchronize();
      const double before = worst;
      worst = *std::max_element(errors_, errors_ + columns);
      if (worst <= controls.tolerance || step >= controls.max_steps || (step > 1 && worst > before / 2)) break;
      apply_inverse(r_, d_, columns, transposed != nullptr);
      const V *d = d_;
      V* x = x_;
      for_each_index(
          exec_, "mfs::add", block, KOKKOS_LAMBDA(Offset i) { x[i] += d[i]; });
      ++outcome.refinement_steps;
    }
    stream_.to_host(host_x_, x_, block * static_cast<Offset>(sizeof(Value)));
    stream_.synchronize();
    outcome.backward_error = worst;
    return outcome;
  }

  double condition_estimate(const TransposedPattern&) override { return 0; }
  bool determinant(Value&, double&) override { return false; }
  Vertex pivot_row(Vertex position) const override {
    read_pivots();
    const auto front = std::upper_bound(plan_->pivot_begin.begin(), plan_->pivot_begin.end(), position) - 1;
    return plan_->row_of[*front + local_row_[position]];
  }
  Value pivot_shift(Vertex position) const override {
    read_pivots();
    return static_cast<Value>(shift_[position]);
  }
  Offset bytes() const override { return stages_.bytes() + vectors_->bytes(); }

  // Public for nvcc, which takes no extended lambda of a private member.
  void launch_factor(double tolerance) {
    if (!warm_) {
      stages_.factor(tolerance);
      warm_ = true;
    } else {
      if (!graph_.recorded() || tolerance != graph_tolerance_) {
        graph_.record(stream_, [&] { stages_.factor(tolerance); });
        graph_tolerance_ = tolerance;
      }
      graph_.launch(stream_);
    }
  }

 private:
  void take_vectors(Vertex columns) {
    const Offset n = plan_->n, block = n * columns;
    ArenaLayout layout;
    const Offset b = layout.add(block * sizeof(V)), x = layout.add(block * sizeof(V)), r = layout.add(block * sizeof(V)),
                 d = layout.add(block * sizeof(V)), v = layout.add(block * sizeof(S)), y = layout.add(block * sizeof(S)),
                 border = layout.add(static_cast<Offset>(plan_->border.size()) * columns * sizeof(S)),
                 errors = layout.add(kSolveColumns * sizeof(double));
    auto arena = std::make_unique<DeviceArena>(layout.total());
    auto host = std::make_unique<PinnedArena>(2 * block * static_cast<Offset>(sizeof(Value)));
    if (host_b_) std::copy(host_b_, host_b_ + n * columns_, host->template at<Value>(0));
    vectors_ = std::move(arena);
    host_vectors_ = std::move(host);
    host_b_ = host_vectors_->template at<Value>(0);
    host_x_ = host_b_ + block;
    b_ = vectors_->template at<V>(b);
    x_ = vectors_->template at<V>(x);
    r_ = vectors_->template at<V>(r);
    d_ = vectors_->template at<V>(d);
    substitution_ = {vectors_->template at<S>(v), vectors_->template at<S>(y), vectors_->template at<S>(border), columns};
    device_errors_ = vectors_->template at<double>(errors);
    columns_ = columns;
    for (auto& graph : solve_graph_) graph.reset();
  }

  // to = approximately A^-1 from, scaling and permutation included; device vectors.
  void apply_inverse(const V* from, V* to, Vertex columns, bool transposed) {
    const FrontStore<S, V>& at = stages_.store().fronts;
    const Vertex* in = transposed ? at.column_of : at.row_of;
    const Vertex* out = transposed ? at.row_of : at.column_of;
    const double* in_scale = transposed ? at.column_scale : at.row_scale;
    const double* out_scale = transposed ? at.row_scale : at.column_scale;
    gather_scaled<V>(exec_, plan_->n, columns, in, in_scale, from, substitution_.v);
    substitution_.columns = columns;
    Graph& graph = solve_graph_[transposed];
    if (!graph.recorded() || graph_columns_[transposed] != columns) {
      graph.record(stream_, [&] { stages_.substitute(substitution_, transposed); });
      graph_columns_[transposed] = columns;
    }
    graph.launch(stream_);
    scatter_scaled<V>(exec_, plan_->n, columns, out, out_scale, static_cast<const S*>(substitution_.v), to);
  }

  RowAccess<V> matrix_rows(const TransposedPattern* transposed) {
    const FrontStore<S, V>& at = stages_.store().fronts;
    if (!transposed) return {at.matrix_offsets, at.matrix_columns, nullptr, at.matrix_values};
    if (!transposed_) {
      const Offset n = plan_->n, nnz = plan_->nnz;
      ArenaLayout layout;
      const Offset offsets = layout.add((n + 1) * sizeof(Offset)), columns = layout.add(nnz * sizeof(Vertex)),
                   slots = layout.add(nnz * sizeof(Offset));
      transposed_ = std::make_unique<DeviceArena>(layout.total());
      transposed_rows_ = {transposed_->template at<Offset>(offsets), transposed_->template at<Vertex>(columns),
                          transposed_->template at<Offset>(slots), at.matrix_values};
      stream_.to_device(transposed_->template at<Offset>(offsets), transposed->offsets.data(), (n + 1) * sizeof(Offset));
      stream_.to_device(transposed_->template at<Vertex>(columns), transposed->columns.data(), nnz * sizeof(Vertex));
      stream_.to_device(transposed_->template at<Offset>(slots), transposed->slots.data(), nnz * sizeof(Offset));
      stream_.synchronize();
    }
    return transposed_rows_;
  }

  void read_pivots() const {
    if (pivots_read_) return;
    local_row_.resize(plan_->n);
    shift_.resize(plan_->n);
    const FrontStore<S, V>& at = stages_.store().fronts;
    stream_.to_host(local_row_.data(), at.local_row, plan_->n * static_cast<Offset>(sizeof(Vertex)));
    stream_.to_host(shift_.data(), at.shift, plan_->n * static_cast<Offset>(sizeof(Scalar)));
    stream_.synchronize();
    pivots_read_ = true;
  }

  std::shared_ptr<const SymbolicPlan> plan_;
  std::shared_ptr<const Pattern> pattern_;
  Stream stream_;
  Kokkos::Cuda exec_;
  DeviceStages<S, V> stages_;
  PinnedArena host_;
  double *row_scale_, *column_scale_, *errors_;
  DeviceStatus* status_;
  Value* values_;
  bool scales_sent_ = false, warm_ = false;
  Graph graph_, solve_graph_[2];
  double graph_tolerance_ = 0;
  Vertex graph_columns_[2] = {0, 0};
  std::unique_ptr<DeviceArena> vectors_, transposed_;
  std::unique_ptr<PinnedArena> host_vectors_;
  RowAccess<V> transposed_rows_{};
  Value *host_b_ = nullptr, *host_x_ = nullptr;
  V *b_, *x_, *r_, *d_;
  double* device_errors_;
  typename DeviceStages<S, V>::Vectors substitution_{};
  Vertex columns_ = 0;
  mutable bool pivots_read_ = false;
  mutable std::vector<Vertex> local_row_;
  mutable std::vector<Scalar> shift_;
};

}  // namespace mfs::cuda
