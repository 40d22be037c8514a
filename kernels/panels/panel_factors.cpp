#include "kernels/panels/panel_factors.hpp"

#include <algorithm>
#include <complex>
#include <utility>

#include "kernels/panels/panel_lu.hpp"
#include "kernels/runtime/arena.hpp"
#include "kernels/runtime/scalars.hpp"

namespace mfs {

namespace {

/// Where the arrays of the panels lie.
struct PanelLayout {
  PanelLayout(const SymbolicPlan& plan, const PanelProgram& program, Offset scalar_bytes) {
    numbers = arena.add(program.numbers * scalar_bytes);
    local_row = arena.add(plan.n * static_cast<Offset>(sizeof(Vertex)));
    moved = arena.add(plan.num_fronts * static_cast<Offset>(sizeof(Vertex)));
    work = arena.add(program.most_pivots * panels::kSideBySide * scalar_bytes);
    y = arena.add(plan.n * panels::kSideBySide * scalar_bytes);
  }
  ArenaLayout arena;
  Offset numbers, local_row, moved, work, y;
};

template <class Value, class Scalar>
class PanelFactors final : public Factors<Value> {
 public:
  PanelFactors(std::unique_ptr<Factors<Value>> fronts, std::shared_ptr<const SymbolicPlan> plan,
               std::shared_ptr<const Pattern> pattern, std::shared_ptr<const PanelProgram> program)
      : fronts_(std::move(fronts)),
        plan_(std::move(plan)),
        pattern_(std::move(pattern)),
        program_(std::move(program)),
        layout_(*plan_, *program_, sizeof(Scalar)),
        arena_(layout_.arena.total()),
        system_{*plan_,
                *pattern_,
                *program_,
                arena_.at<Scalar>(layout_.numbers),
                arena_.at<Vertex>(layout_.local_row),
                arena_.at<Vertex>(layout_.moved),
                arena_.at<Scalar>(layout_.work)},
        y_(arena_.at<Scalar>(layout_.y)) {}

  Value* matrix_values() override { return fronts_->matrix_values(); }
  double* row_scale() override { return fronts_->row_scale(); }
  double* column_scale() override { return fronts_->column_scale(); }
  HostMatrix<Value> matrix() override { return fronts_->matrix(); }

  Factored factor(const PivotPolicy& policy, const std::function<void(double)>& progress) override {
    const HostMatrix<Value> a = fronts_->matrix();
    const double largest = panels::take_values(system_, a.values, a.row_scale, a.column_scale);
    const PivotRule rule = pivot_rule<RealOf<Scalar>>(policy, largest);
    by_panels_ = panels::factor(system_, {rule.bound, rule.tiny, rule.border_part, rule.preference});
    if (!by_panels_) return fronts_->factor(policy, progress);
    if (progress) progress(1.0);
    return {{0, 0, plan_->flops.getrf, plan_->flops.trsm, plan_->flops.gemm}, largest};
  }

  void apply_inverse(const Value* from, Value* to, Vertex columns, bool transposed) override {
    if (!by_panels_) return fronts_->apply_inverse(from, to, columns, transposed);
    constexpr Vertex kFew = 4;  // one by one
    for (Vertex done = 0; done < columns;) {
      const Vertex left = columns - done;
      const Vertex count = left < kFew ? 1 : std::min(left, panels::kSideBySide);
      const Offset begin = static_cast<Offset>(done) * plan_->n;
      count == 1 ? substitute<1>(from + begin, to + begin, count, transposed)
                 : substitute<panels::kSideBySide>(from + begin, to + begin, count, transposed);
      done += count;
    }
  }
  void make_room(Vertex columns) override { fronts_->make_room(columns); }
  Vertex columns_at_once() const override { return fronts_->columns_at_once(); }
  std::shared_ptr<char> host_vectors(Offset bytes) const override { return fronts_->host_vectors(bytes); }

  Vertex local_row(Vertex position) const override {
    return by_panels_ ? system_.local_row[position] : fronts_->local_row(position);
  }
  Value pivot_shift(Vertex position) const override {
    return by_panels_ ? Value(0) : fronts_->pivot_shift(position);
  }
  void diagonal_pivots(std::complex<double>* pivots) const override {
    if (!by_panels_) return fronts_->diagonal_pivots(pivots);
    for (const PanelProgram::Panel& panel : program_->panels) {
      const Scalar* diagonal = system_.numbers + panel.numbers + panel.pivot_row + panel.before;
      for (Vertex c = 0; c < panel.columns; ++c, diagonal += panel.rows + 1)
        pivots[panel.first + c] = 1.0 / std::complex<double>(*diagonal);
    }
  }

  MemorySpace memory() const override { return MemorySpace::host; }
  Offset bytes() const override { return fronts_->bytes() + arena_.bytes(); }

 private:
  // `count` columns, which lie in y side by side with `width` places: a whole line of cache comes from, and
  // goes to, as many vectors that are run through.
  template <Vertex width>
  void substitute(const Value* from, Value* to, Vertex count, bool transposed) {
    const HostMatrix<Value> a = fronts_->matrix();
    const Offset n = plan_->n;
    const Vertex* const in = (transposed ? program_->column_position : program_->row_position).data();
    const double* const in_scale = transposed ? a.column_scale : a.row_scale;
    for (Offset i = 0; i < n; ++i) {
      const auto scale = static_cast<RealOf<Value>>(in_scale[i]);
      Scalar* const y = y_ + Offset{in[i]} * width;
      for (Vertex j = 0; j < width; ++j)
        y[j] = j < count ? static_cast<Scalar>(from[i + j * n] * scale) : Scalar(0);
    }
    panels::substitute(system_, transposed, width > 1, y_);
    const Vertex* const out = (transposed ? program_->row_position : program_->column_position).data();
    const double* const out_scale = transposed ? a.row_scale : a.column_scale;
    for (Offset i = 0; i < n; ++i) {
      const auto scale = static_cast<RealOf<Value>>(out_scale[i]);
      const Scalar* const y = y_ + Offset{out[i]} * width;
      for (Vertex j = 0; j < count; ++j) to[i + j * n] = Value(y[j]) * scale;
    }
  }

  const std::unique_ptr<Factors<Value>> fronts_;
  const std::shared_ptr<const SymbolicPlan> plan_;
  const std::shared_ptr<const Pattern> pattern_;
  const std::shared_ptr<const PanelProgram> program_;
  const PanelLayout layout_;
  const HostArena arena_;
  const panels::System<Scalar> system_;
  Scalar* const y_;
  bool by_panels_ = false;  // the present factors are
};

}  // namespace

Offset panel_bytes(const SymbolicPlan& plan, const PanelProgram& program, Offset scalar_bytes) {
  return PanelLayout(plan, program, scalar_bytes).arena.total();
}

template <class Value>
std::unique_ptr<Factors<Value>> make_panel_factors(bool single_precision,
                                                   std::unique_ptr<Factors<Value>> fronts,
                                                   std::shared_ptr<const SymbolicPlan> plan,
                                                   std::shared_ptr<const Pattern> pattern,
                                                   std::shared_ptr<const PanelProgram> program) {
  if (single_precision)
    return std::make_unique<PanelFactors<Value, Narrow<Value>>>(std::move(fronts), std::move(plan),
                                                                std::move(pattern), std::move(program));
  return std::make_unique<PanelFactors<Value, Value>>(std::move(fronts), std::move(plan), std::move(pattern),
                                                      std::move(program));
}

#define MFS_INSTANTIATE(Value)                                                    \
  template std::unique_ptr<Factors<Value>> make_panel_factors<Value>(             \
      bool, std::unique_ptr<Factors<Value>>, std::shared_ptr<const SymbolicPlan>, \
      std::shared_ptr<const Pattern>, std::shared_ptr<const PanelProgram>);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs
