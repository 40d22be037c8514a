// Definition of factors_of_scalars.hpp, for the files that instantiate it.
//
// Substitutions, residuals and corrections run on the device. The vectors of a solve lie where contribution
// blocks were, if they fit there.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "kernels/cuda/device_stages_def.hpp"
#include "kernels/cuda/factors_of_scalars.hpp"
#include "kernels/cuda/solve/solve_vectors.hpp"
#include "kernels/cuda/solve/stream_loops.hpp"
#include "kernels/cuda/vector_layout.hpp"
#include "kernels/fallback.hpp"
#include "kernels/stages/diagonal.hpp"
#include "kernels/stages/pivots_on_host.hpp"
#include "kernels/stages/probe_directions.hpp"
#include "plan/segment_clock.hpp"

namespace mfs::cuda {

/// Vectors of kSolveColumns columns may take so many bytes beside the region of the plan, or this part of the
/// factors' memory; where they would take more, kFewColumns are solved for at once. Small factors take as
/// long for 16 columns as for four.
constexpr Offset kLittle = Offset(1) << 28, kShare = 8;

template <class Value, class Scalar>
class CudaFactors final : public Factors<Value>, public ResidentFactors<Value> {
  using S = DeviceScalar<Scalar>;
  using V = DeviceScalar<Value>;
  using VectorLayout = cuda::VectorLayout<S, V>;

 public:
  /// `room`: bytes of the device that vectors of more than one column may take.
  CudaFactors(std::shared_ptr<const SymbolicPlan> plan_of, std::shared_ptr<const Pattern> pattern,
              DevicePlan lists, Offset room)
      : plan_(std::move(plan_of)),
        pattern_(std::move(pattern)),
        loops_{&stream_},
        stages_(plan(), *pattern_, stream_, std::move(lists)) {
    const Offset n = plan().n;
    ArenaLayout layout;
    const Offset on_host = stages_.matrix_on_host() ? 0 : plan().nnz;
    const Offset values = layout.add(on_host * sizeof(Value)), row_scale = layout.add(n * sizeof(double)),
                 column_scale = layout.add(n * sizeof(double)), error = layout.add(sizeof(double)),
                 step = layout.add(sizeof(ProbeStep)), status = layout.add(sizeof(DeviceStatus));
    host_ = std::make_unique<PinnedArena>(layout.total());
    values_ = stages_.matrix_on_host() ? reinterpret_cast<Value*>(stages_.matrix_values())
                                       : host_->template at<Value>(values);
    row_scale_ = host_->template at<double>(row_scale);
    column_scale_ = host_->template at<double>(column_scale);
    error_ = host_->template at<double>(error);
    step_ = host_->template at<ProbeStep>(step);
    status_ = host_->template at<DeviceStatus>(status);
    make_room(1);
    scarce_ = !stages_.lists().segments.empty() || room < std::numeric_limits<Offset>::max();
    columns_at_once_ = std::min(stages_.most_columns(), columns_for(plan(), stages_.lists(), room));
  }

  /// What these factors will take.
  static NumericBytes bytes_for(const SymbolicPlan& plan, const Pattern& pattern, const DevicePlan& lists) {
    NumericBytes bytes = DeviceStages<S, V>::bytes_for(plan, pattern, lists);
    bytes.solve = bytes_of(plan, 1) + VectorLayout(plan, lists, 1).beside.total();
    return bytes;
  }
  /// Of the region, what the vectors of a solve for so many columns take if all lie there.
  static Offset spare_for(const SymbolicPlan& plan, const DevicePlan& lists, Vertex columns) {
    return VectorLayout(plan, lists, columns, kWherever).spare.total();
  }
  /// Bytes of the device that factors in segments may take later, beside those of bytes_for: so many
  /// right-hand sides, before and after there is room for more, and the solution of a probe.
  static Offset bytes_later(const SymbolicPlan& plan, Vertex columns) {
    return bytes_of(plan, 2 * columns + 2);
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

  Factored factor(const PivotPolicy& policy, const std::function<void(double)>& progress) override {
    pivots_.forget();
    send_matrix();
    done_ = {0, 0, 0};
    find_factors(policy);
    solve_as(policy);
    FactorStatus status = status_->pivots;
    status.getrf = done_.getrf;
    status.trsm = done_.trsm;
    status.gemm = done_.gemm;
    if (progress) progress(1.0);
    return {status, status_->largest};
  }

  ResidentFactors<Value>* resident() override { return this; }

  void solve_as(const PivotPolicy& policy) override {
    mirrors_ = policy.solves_by_transposed(status_->pivots.perturbed);
  }

  void require_reachable(const void* array, const char* name) const override {
    cuda::require_reachable(array, name);
  }
  bool take_values(const Value* values, void* stream) override {
    follow(stream);
    stream_.copy_columns(stages_.matrix_values(), 0, values, 0, plan().nnz * sizeof(Value), 1);
    values_sent_ = true;
    values_here_ = false;
    return finite(plan().nnz, stages_.matrix_values());
  }

  void start(const SolveBlock<Value>& block, double row_floor, void* stream) override {
    make_vectors(solve_width(block.columns));
    follow(stream);
    begin({reinterpret_cast<const V*>(block.b), block.ldb, block.columns},
          {reinterpret_cast<V*>(block.x), block.ldx, block.columns}, nullptr, block.transposed, row_floor);
  }
  void start_from_host(const SolveBlock<Value>& block, double row_floor) override {
    const Offset n = plan().n;
    stream_.to_device(b_, block.b, bytes_of(block.columns));
    begin({b_, n, block.columns}, {b_, n, block.columns}, block.x, block.transposed, row_floor);
  }
  // What is on the way to the host has come when the error has: one wait for the device does for both.
  double backward_error(double bound) override {
    const Columns<V>& x = solve_.x;
    measure(solve_.b, solve_.transposed, solve_.row_floor, corrects_again() ? substitution_.v : nullptr);
    write_solution(x, bound);
    if (solve_.on_host) stream_.to_host(solve_.on_host, x.data, bytes_of(x.count));
    return read_error();
  }
  void correct() override {
    if (!corrects_again()) measure(solve_.b, solve_.transposed, solve_.row_floor, substitution_.v);
    ++corrections_;
    substitute(solve_.b.count, solve_.transposed != nullptr, true);
  }
  void bring_solution(Value* x) override { send_solution(x, solve_.b.count); }
  ProbeStep probe(bool from_nothing) override {
    return probe_step(from_nothing, [&](const auto&... step) { take_probe_step(loops_, plan().n, step...); });
  }
  // Directions are many vectors: where memory is scarce, the host has them.
  std::optional<ProbeStep> probe_together(bool from_nothing) override {
    if (scarce_ || ProbeDirections<V>::most(plan().n) == 0) return std::nullopt;
    if (!directions_memory_) {
      directions_memory_ = std::make_unique<DeviceArena>(ProbeDirections<V>::bytes(plan().n));
      directions_ = ProbeDirections<V>(plan().n, directions_memory_->template at<char>(0));
    }
    if (from_nothing) directions_.forget();
    if (directions_.full()) return std::nullopt;
    return probe_step(from_nothing, [&](const auto&... step) { directions_.take_step(loops_, step...); });
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

  Vertex columns_at_once() const override { return columns_at_once_; }
  std::shared_ptr<char> host_vectors(Offset bytes) const override {
    const auto arena = std::make_shared<PinnedArena>(bytes);
    return {arena, arena->template at<char>(0)};
  }

  void apply_inverse(const Value* from, Value* to, Vertex columns, bool transposed) override {
    stream_.to_device(b_, from, bytes_of(columns));
    enter({b_, plan().n, columns}, transposed);
    substitute(columns, transposed, false);
    send_solution(to, columns);
  }

  // Right-hand sides that come from the host have room of their own.
  void make_room(Vertex columns) override {
    make_vectors(solve_width(columns));
    rhs_ = std::make_unique<DeviceArena>(bytes_of(columns));
    b_ = rhs_->template at<V>(0);
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
    std::vector<Scalar> inverse(static_cast<std::size_t>(plan().n));
    gather_diagonal(loops_, stages_.store().fronts, plan().num_fronts, substitution_.v);
    stream_.to_host(inverse.data(), substitution_.v, plan().n * sizeof(Scalar));
    stream_.synchronize();
    take_diagonal_of_host(inverse);
    for (const Scalar& entry : inverse) {
      const std::complex<double> left(entry);
      *pivots++ = stages_.store().substitutes ? left : 1.0 / left;
    }
  }
  Movement movement() const override { return movement_of(plan(), stages_.lists()); }
  static Movement movement_of(const SymbolicPlan& plan, const DevicePlan& lists) {
    const SegmentPlan& segments = lists.segments;
    Movement movement;
    if (segments.empty()) return movement;
    movement.segments.assign(static_cast<std::size_t>(plan.num_depths), 0);
    for (const Segment& segment : segments.segments) ++movement.segments[segment.step];
    movement.out = (segments.host_entries + segments.blocks_out()) * static_cast<Offset>(sizeof(S));
    movement.in = segments.blocks_out() * static_cast<Offset>(sizeof(S));
    movement.back = segments.entries_back() * static_cast<Offset>(sizeof(S));
    const SegmentClock clock(plan, Outside::memory);
    const double matrix = lists.matrix_on_host ? clock.seconds_of_matrix() : 0;
    movement.slowdown = (clock.refactor_seconds(segments) + matrix) / clock.whole_refactor_seconds();
    return movement;
  }

  MemorySpace memory() const override { return MemorySpace::device; }
  Offset bytes() const override {
    Offset bytes = stages_.bytes() + rhs_->bytes();
    for (const auto& arena : {&vectors_, &transposed_, &probe_, &directions_memory_})
      bytes += *arena ? (*arena)->bytes() : 0;
    return bytes;
  }

 private:
  const SymbolicPlan& plan() const { return *plan_; }
  /// Of so many columns of right-hand sides or solutions.
  static Offset bytes_of(const SymbolicPlan& plan, Vertex columns) {
    return static_cast<Offset>(plan.n) * columns * static_cast<Offset>(sizeof(Value));
  }
  Offset bytes_of(Vertex columns) const { return bytes_of(plan(), columns); }

  struct TransposedLayout {
    ArenaLayout arena;
    Offset offsets, columns, slots;
    Offset total() const { return arena.total(); }
  };
  static TransposedLayout transposed_layout(const SymbolicPlan& plan) {
    TransposedLayout layout;
    layout.offsets = layout.arena.add((plan.n + Offset{1}) * static_cast<Offset>(sizeof(Offset)));
    layout.columns = layout.arena.add(plan.nnz * static_cast<Offset>(sizeof(Vertex)));
    layout.slots = layout.arena.add(plan.nnz * static_cast<Offset>(sizeof(Offset)));
    return layout;
  }

  // From r, which is b_, by A^-1 r, which is x_.
  template <class Take>
  ProbeStep probe_step(bool from_nothing, const Take& take) {
    const Vertex n = plan().n;
    if (!probe_) probe_ = std::make_unique<DeviceArena>(bytes_of(2));
    V* const x = probe_->template at<V>(0);
    const ProbeVectors<V> at{x, x + n, x_, b_};
    const FrontStore<S, V>& fronts = stages_.store().fronts;
    if (from_nothing) begin_probe(loops_, n, fronts.row_scale, at);
    enter({b_, n, 1}, false);
    substitute(1, false, false);
    auto* const found = reinterpret_cast<ProbeStep*>(device_error_);
    take(device_rows(nullptr), fronts.row_scale, fronts.column_scale, at, found);
    stream_.to_host(step_, found, sizeof(ProbeStep));
    stream_.synchronize();
    return *step_;
  }

  void send_matrix() {
    const Offset n = plan().n;
    if (!scales_sent_) {
      stream_.to_device(stages_.row_scale(), row_scale_, n * sizeof(double));
      stream_.to_device(stages_.column_scale(), column_scale_, n * sizeof(double));
      scales_sent_ = true;
    }
    if (!values_sent_) {
      if (!stages_.matrix_on_host())
        stream_.to_device(stages_.matrix_values(), values_, plan().nnz * sizeof(Value));
      values_sent_ = true;
    }
  }

  // The values on the host, where they came from the device.
  void bring_values() {
    if (values_here_) return;
    if (!stages_.matrix_on_host())
      stream_.to_host(values_, stages_.matrix_values(), plan().nnz * sizeof(Value));
    stream_.synchronize();
    values_here_ = true;
  }

  void follow(void* stream) {
    foreign_.record_foreign(stream);
    stream_.wait_for(foreign_);
  }

  bool finite(Offset count, const V* values) {
    find_nonfinite(loops_, count, values, device_error_);
    return !(read_error() > 0);
  }

  // Again where fronts have to be strict, or roots do need pivots.
  void find_factors(const PivotPolicy& policy) {
    pivoted_roots_.begin();
    if (policy.substitutes() != stages_.store().substitutes) {
      forget_solves();
      stages_.forget_strict_fronts();
      strict_ = false;
    }
    for (bool found = false; !found;) {
      const DeviceStatus& status = launch_factor(policy);
      found = (status.found_strict == 0 && status.pivots_needed == 0) ||
              status.pivots.perturbed > policy.most_perturbed;
      if (status.found_strict > 0) {
        strict_ = tall_ = true;
        if (!found) stages_.make_ancestors_strict();
      } else if (found) {
        strict_ = status.strict_left > 0;
        tall_ = status.tall_left > 0;
      } else {
        pivoted_roots_.activate();
      }
    }
    pivoted_roots_.end();
  }

  PivotSearch search() const {
    return strict_ && tall_ && stages_.has_tall_fronts()             ? PivotSearch::strict_by_panels
           : strict_                                                 ? PivotSearch::strict
           : pivoted_roots_.active() || !stages_.has_library_roots() ? PivotSearch::tiles
                                                                     : PivotSearch::not_in_roots;
  }

  const DeviceStatus& launch_factor(const PivotPolicy& policy) {
    const PivotSearch where = search();
    if (!warm_) {
      stages_.factor(policy, where);
      warm_ = true;
    } else {
      if (!(policy == graph_policy_)) {
        for (Graph& graph : graph_) graph.reset();
        graph_policy_ = policy;
      }
      Graph& graph = graph_[static_cast<int>(where)];
      if (!graph.recorded()) graph.record(stream_, [&] { stages_.factor(policy, where); });
      graph.launch(stream_);
    }
    done_.getrf += stages_.flops(where).getrf;
    done_.trsm += stages_.flops(where).trsm;
    done_.gemm += stages_.flops(where).gemm;
    stream_.to_host(status_, stages_.status(), sizeof(DeviceStatus));
    stream_.synchronize();
    return *status_;
  }

  double read_error() {
    stream_.to_host(error_, device_error_, sizeof(double));
    stream_.synchronize();
    return *error_;
  }

  // A solve that is under way: x, which may be b, is written once its error is small enough; what it holds
  // then is sent on to `on_host` (if any), n rows for each column.
  struct Solve {
    Columns<const V> b{};
    Columns<V> x{};
    Value* on_host = nullptr;
    const TransposedPattern* transposed = nullptr;
    double row_floor = 0;
  };
  void begin(const Columns<const V>& b, const Columns<V>& x, Value* on_host,
             const TransposedPattern* transposed, double row_floor) {
    solve_ = {b, x, on_host, transposed, row_floor};
    usual_corrections_ = std::exchange(corrections_, 0);
    enter(b, transposed != nullptr);
    substitute(b.count, transposed != nullptr, false);
  }

  // As the last solve did: what is left of b is then kept when the error is found, for the correction to
  // come.
  bool corrects_again() const { return corrections_ < usual_corrections_; }

  // x_ to the host, whatever its error, by way of b_.
  void send_solution(Value* to, Vertex columns) {
    stream_.clear(device_error_, sizeof(double));
    write_solution({b_, plan().n, columns}, 0);
    stream_.to_host(to, b_, bytes_of(columns));
    stream_.synchronize();
  }

  // How right-hand sides come into elimination order, and how solutions leave it.
  Side side(bool of_rows) const {
    const FrontStore<S, V>& at = stages_.store().fronts;
    return of_rows ? Side{at.row_of, at.row_scale} : Side{at.column_of, at.column_scale};
  }
  // Several columns by way of x_.
  void enter(const Columns<const V>& b, bool transposed) {
    const Offset n = plan().n;
    with_width(b.count, [&](auto k) {
      if constexpr (k() > 1) {
        gather_columns<k()><<<TurnedRows<k(), V>::blocks(n), kVectorThreads, 0, stream_.get()>>>(n, b, x_);
      }
      enter_elimination_order<k()><<<vector_blocks(n * k()), kVectorThreads, 0, stream_.get()>>>(
          n, side(!mirrored(transposed)), k() > 1 ? static_cast<const V*>(x_) : b.data, substitution_.v);
    });
  }
  // Whether the factors of A^T serve (PivotPolicy::symmetric).
  bool mirrored(bool transposed) const { return transposed || mirrors_; }

  // x_ = approximately A^-1 (or A^-T) of what has come into elimination order, or += that.
  void substitute(Vertex columns, bool transposed, bool add) {
    const Vertex width = solve_width(columns);
    const bool by = mirrored(transposed);
    Graph& graph = solve_graph_[by][(width > 1) + (width > kFewColumns)];
    if (!graph.recorded()) graph.record(stream_, [&] { stages_.substitute(substitution_, width, by); });
    graph.launch(stream_);
    const Offset n = plan().n;
    with_width(columns, [&](auto k) {
      leave_elimination_order<k()><<<vector_blocks(n * k()), kVectorThreads, 0, stream_.get()>>>(
          n, side(by), static_cast<const S*>(substitution_.v), add, x_);
    });
  }

  // Finds the backward error of x_; where r is given, what is left of b goes there in elimination order.
  void measure(const Columns<const V>& b, const TransposedPattern* transposed, double row_floor, S* r) {
    const Offset n = plan().n, nnz = plan().nnz;
    const RowAccess<V> rows = device_rows(transposed);
    stream_.clear(device_error_, (1 + kSolveColumns) * sizeof(double));
    const RowFloors floors{row_floor, device_error_ + 1};
    with_width(b.count, [&](auto k) {
      if (row_floor > 0) {
        largest_unscaled_unknowns<k()><<<reducing_blocks(n * k()), kVectorThreads, 0, stream_.get()>>>(
            n, side(transposed != nullptr).scale, static_cast<const V*>(x_), device_error_ + 1);
      }
      const auto launch = [&](auto lanes) {
        residual_in_elimination_order<k(), lanes()>
            <<<reducing_blocks(n * lanes()), kVectorThreads, 0, stream_.get()>>>(
                n, rows, side(!mirrored(transposed != nullptr)), b, static_cast<const V*>(x_), r, floors,
                device_error_);
      };
      if constexpr (k() > 1) {
        launch(k);
      } else {
        with_row_lanes(n, nnz, launch);
      }
    });
    check_launch("residual");
  }

  // Where the error on the device is at most `bound`.
  void write_solution(const Columns<V>& to, double bound) {
    const Offset n = plan().n;
    with_width(to.count, [&](auto k) {
      write_columns<k()><<<TurnedRows<k(), V>::blocks(n), kVectorThreads, 0, stream_.get()>>>(
          n, static_cast<const V*>(x_), to, static_cast<const double*>(device_error_), bound);
    });
    check_launch("solution");
  }

  // The diagonal of factors that have left the device.
  void take_diagonal_of_host(std::vector<Scalar>& diagonal) const {
    const SegmentPlan& all = stages_.lists().segments;
    for (const Segment& segment : all.segments) {
      if (segment.stays()) continue;
      const auto* const factors =
          static_cast<const Scalar*>(stages_.copies()->host()) + (segment.host - segment.place);
      for (Vertex i = segment.begin; i < segment.end; ++i) {
        const Vertex f = all.order[i];
        const Scalar* entry = factors + plan().lower_begin[f];
        for (Vertex k = plan().pivot_begin[f]; k < plan().pivot_begin[f + 1]; ++k) {
          diagonal[k] = *entry;
          entry += plan().lower_ld(f) + 1;
        }
      }
    }
  }

  // Columns that are solved for at once: where segments come and go, as many as they leave room for.
  static Vertex columns_for(const SymbolicPlan& plan, const DevicePlan& lists, Offset room) {
    const auto beside = [&](Vertex columns) { return VectorLayout(plan, lists, columns).beside.total(); };
    if (!lists.segments.empty()) return beside(kSolveColumns) == 0 ? kSolveColumns : kFewColumns;
    const Offset factors = plan.factor_entries * static_cast<Offset>(sizeof(S));
    const auto fit = [&](Vertex columns) { return beside(columns) + bytes_of(plan, columns) <= room; };
    if (beside(kSolveColumns) <= std::max(kLittle, factors / kShare) && fit(kSolveColumns))
      return kSolveColumns;
    return fit(kFewColumns) ? kFewColumns : 1;
  }

  void make_vectors(Vertex width) {
    if (width <= width_) return;
    const VectorLayout layout(plan(), stages_.lists(), width);
    auto beside = std::make_unique<DeviceArena>(layout.beside.total());
    const auto at = [&](const typename VectorLayout::Place& place) {
      return place.in_spare ? static_cast<char*>(stages_.spare()) + place.at
                            : beside->template at<char>(place.at);
    };
    x_ = reinterpret_cast<V*>(at(layout.x));
    substitution_ = {reinterpret_cast<S*>(at(layout.v)), reinterpret_cast<S*>(at(layout.y)),
                     reinterpret_cast<S*>(at(layout.border)), reinterpret_cast<S*>(at(layout.partial))};
    device_error_ = reinterpret_cast<double*>(at(layout.error));
    vectors_ = std::move(beside);
    width_ = width;
    forget_solves();
  }
  void forget_solves() {
    for (auto& graphs : solve_graph_) {
      for (Graph& graph : graphs) graph.reset();
    }
  }

  RowAccess<V> device_rows(const TransposedPattern* transposed) {
    const FrontStore<S, V>& at = stages_.store().fronts;
    if (!transposed) return {at.matrix_offsets, at.matrix_columns, nullptr, at.matrix_values};
    if (!transposed_ && !transposed_on_host_) {
      const Offset n = plan().n, nnz = plan().nnz;
      const TransposedLayout layout = transposed_layout(plan());
      std::unique_ptr<DeviceArena> on_device;
      std::unique_ptr<PinnedArena> on_host;
      if (stages_.copies()) {  // a factorization needs the room more than a residual now and then
        on_host = std::make_unique<PinnedArena>(layout.total());
      } else {
        on_device = std::make_unique<DeviceArena>(layout.total());
      }
      const RawArena& arena = on_device ? static_cast<const RawArena&>(*on_device) : *on_host;
      const auto fill = [&](Offset place, const void* from, Offset bytes) {
        char* const to = arena.at<char>(place);
        if (on_device) stream_.to_device(to, from, bytes);
        if (on_host) std::memcpy(to, from, static_cast<std::size_t>(bytes));
      };
      fill(layout.offsets, transposed->offsets.data(), (n + 1) * sizeof(Offset));
      fill(layout.columns, transposed->columns.data(), nnz * sizeof(Vertex));
      fill(layout.slots, transposed->slots.data(), nnz * sizeof(Offset));
      stream_.synchronize();
      transposed_rows_ = {arena.at<Offset>(layout.offsets), arena.at<Vertex>(layout.columns),
                          arena.at<Offset>(layout.slots), at.matrix_values};
      transposed_ = std::move(on_device);
      transposed_on_host_ = std::move(on_host);
    }
    return transposed_rows_;
  }

  void bring_pivots() const {
    pivots_.bring(
        stages_.store().fronts,
        [&](void* to, const void* from, Offset bytes) { stream_.to_host(to, from, bytes); },
        [&] { stream_.synchronize(); });
  }

  std::shared_ptr<const SymbolicPlan> plan_;
  std::shared_ptr<const Pattern> pattern_;
  Stream stream_;
  StreamLoops loops_;
  DeviceStages<S, V> stages_;
  std::unique_ptr<PinnedArena> host_;
  Value* values_;
  double *row_scale_, *column_scale_;
  double* error_;
  ProbeStep* step_;
  DeviceStatus* status_;
  bool scales_sent_ = false, values_sent_ = false, values_here_ = true, warm_ = false;
  BlockFlops done_{0, 0, 0};  // by the present factorization and those that it had to repeat
  bool strict_ = false;       // some front is, else none
  bool tall_ = false;         // a tall one may be
  bool mirrors_ = false;      // A^-T serves for A^-1, too
  Fallback pivoted_roots_;    // those that the vendor's LAPACK could have are factored by tiles
  Event foreign_;
  Graph graph_[kPivotSearches], solve_graph_[2][3];  // by PivotSearch; by transposed, by width
  PivotPolicy graph_policy_{0.0};
  std::unique_ptr<DeviceArena> vectors_, rhs_, transposed_, probe_, directions_memory_;
  ProbeDirections<V> directions_;
  bool scarce_ = false;                              // memory of the device
  std::unique_ptr<PinnedArena> transposed_on_host_;  // or there, where there are segments
  RowAccess<V> transposed_rows_{};
  Vertex width_ = 0;  // of the vectors
  Vertex columns_at_once_ = 1;
  V *b_, *x_;
  double* device_error_;  // and what the rows of each column count at least; or what a probe finds
  typename DeviceStages<S, V>::Vectors substitution_{};
  Solve solve_;
  int corrections_ = 0, usual_corrections_ = 0;  // of the present solve, of the one before
  mutable PivotsOnHost<Scalar> pivots_;
};

}  // namespace mfs::cuda
