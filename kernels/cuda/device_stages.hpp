// All stages of a factorization on the device: the plan's copy, one arena, and the launches, depth by depth.
// What is launched goes to one stream; nothing here waits for it.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <type_traits>
#include <vector>

#include "kernels/cuda/early_assembly.hpp"
#include "kernels/cuda/factor/device_store.hpp"
#include "kernels/cuda/runtime/device.hpp"
#include "kernels/dense/device_blas.hpp"
#include "kernels/dense/device_lapack.hpp"
#include "kernels/factors.hpp"
#include "plan/device_flops.hpp"
#include "plan/symbolic_plan.hpp"

namespace mfs::cuda {

/// What a factorization says when it is done, as the device writes it.
struct DeviceStatus {
  FactorStatus pivots;
  int found_strict, pivots_needed;
  double largest;
  int strict_left, tall_left;  // fronts that the next factorization has to search in all rows, tall ones
};

/// Where pivots are searched: in strict fronts in all rows of the pivot block, with launches for each panel
/// of those that are tall or without them; or, as long as no front is strict, in tiles; or so, but not in the
/// roots that the library factors (DevicePlan::roots).
enum class PivotSearch { strict_by_panels, strict, tiles, not_in_roots };
constexpr int kPivotSearches = 4;

/// Told what is launched next, and for which step of the plan (deepest depth first); inverses, of all fronts,
/// count as the last one's.
enum class Kernel {
  largest,
  small_fronts,
  assemble,
  diagonal,
  strips,
  products,
  roots,
  exchange,
  update,
  inverses,
  end
};
using Mark = std::function<void(Kernel, Vertex step)>;

/// The kernels of a solve are made for 1, kFewColumns and kSolveColumns columns.
constexpr Vertex kFewColumns = 4;
/// On how many of those a solve for `columns` <= kSolveColumns works.
constexpr Vertex solve_width(Vertex columns) {
  return columns == 1 ? 1 : columns <= kFewColumns ? kFewColumns : kSolveColumns;
}
/// Calls work with that number as a constant.
template <class Work>
void with_width(Vertex columns, const Work& work) {
  switch (solve_width(columns)) {
    case 1:
      return work(std::integral_constant<int, 1>());
    case kFewColumns:
      return work(std::integral_constant<int, kFewColumns>());
    default:
      return work(std::integral_constant<int, kSolveColumns>());
  }
}

/// S: numbers of the factors, V: of the matrix, both as device code calls them.
template <class S, class V>
class DeviceStages {
 public:
  /// Copies the plan to the device and takes all memory of a factorization. Throws OutOfMemory, BackendError.
  DeviceStages(const SymbolicPlan& plan, const Pattern& pattern, const Stream& stream);
  /// With the library for roots of `least_root` pivots and more, however much its handle takes beside the
  /// factors.
  DeviceStages(const SymbolicPlan& plan, const Pattern& pattern, const Stream& stream, Vertex least_root);
  /// With the launches that have been made of the plan.
  DeviceStages(const SymbolicPlan& plan, const Pattern& pattern, const Stream& stream, DevicePlan lists);

  /// The launches for the current device; by segments, where there are any: `plan` is as placed_by makes it.
  static DevicePlan lists_for(const SymbolicPlan& plan, SegmentPlan segments = {});
  /// Of the memory that stages with these launches will take, the libraries' left out.
  static NumericBytes bytes_for(const SymbolicPlan& plan, const Pattern& pattern, const DevicePlan& lists);

  /// For the device; for the host as well, if matrix_on_host().
  V* matrix_values() const { return store_.fronts.matrix_values; }
  bool matrix_on_host() const { return lists_.matrix_on_host; }
  double* row_scale() const { return store_.fronts.row_scale; }
  double* column_scale() const { return store_.fronts.column_scale; }
  const DeviceStore<S, V>& store() const { return store_; }
  DeviceStatus* status() const { return status_; }
  /// Of device memory.
  Offset bytes() const {
    Offset bytes = arena_.bytes();
    for (const auto* blas : {&blas_, &blas_ahead_}) bytes += *blas ? (*blas)->bytes() : 0;
    return bytes + (lapack_ ? lapack_->bytes() : 0);
  }
  /// What is free of the region between two factorizations, for spare_bytes() bytes: where contribution
  /// blocks were, or what segments leave.
  void* spare() const {
    const bool in_one = lists_.segments.empty();
    return store_.fronts.storage + (in_one ? plan_.factor_entries : lists_.segments.spare_begin);
  }
  static Offset spare_bytes(const SymbolicPlan& plan, const DevicePlan& lists) {
    const Offset entries =
        lists.segments.empty() ? plan.storage_entries - plan.factor_entries : lists.segments.spare_entries;
    return entries * static_cast<Offset>(sizeof(S));
  }
  /// At most what the vendor's libraries take for these launches.
  static Offset library_bytes(const DevicePlan& lists);
  /// Null where all factors are on the device.
  const SegmentCopies* copies() const { return copies_.get(); }

  /// Launches assemble, factor and update of all depths for matrix_values(). `tolerance` of pivots is
  /// relative to the largest scaled entry. Unless fronts are strict, which exchange rows that an update works
  /// on, large fronts are updated beside their next panel. `mark`, where given, is called before each launch,
  /// one after the other then, and once at the end.
  void factor(const PivotPolicy& policy, PivotSearch search, const Mark& mark = {});
  /// Operations of that (plan/device_flops.hpp).
  const BlockFlops& flops(PivotSearch search) const {
    return flops_[search == PivotSearch::not_in_roots && has_library_roots()].done;
  }
  /// Whether PivotSearch::not_in_roots is another way than `tiles`.
  bool has_library_roots() const { return !lists_.roots.empty(); }
  /// Whether PivotSearch::strict_by_panels is another way than `strict`.
  bool has_tall_fronts() const { return lists_.tall_tasks > 0; }
  /// No front is strict any more, until a factorization finds that it has to be.
  void forget_strict_fronts() {
    stream_.clear(store_.strict, plan_.num_fronts * static_cast<Offset>(sizeof(int)));
  }
  /// Before a factorization is repeated that found strict fronts. Waits for it.
  void make_ancestors_strict();
  /// Launches v := A'^-1 v (elimination order, scaled) for the factors, or the transposed. All have
  /// solve_width(...) columns side by side: v and y n rows, border border_rows(), partial partial_rows().
  struct Vectors {
    S *v, *y, *border, *partial;
  };
  /// Columns of the widest substitution that this device has the shared memory for.
  Vertex most_columns() const { return most_columns_; }
  static Offset border_rows(const DevicePlan& lists) { return lists.border_places; }
  static Offset partial_rows(const DevicePlan& lists) { return lists.solve_places * kSolveTile; }
  const DevicePlan& lists() const { return lists_; }
  void substitute(const Vectors& vectors, Vertex width, bool transposed);

 private:
  struct Layout;
  static constexpr unsigned kAllBlocks = std::numeric_limits<unsigned>::max();
  void open_libraries();
  void find_places_on_host();
  Offset upload(const Pattern& pattern);
  void set_kernel_attributes();
  void launch_small_fronts(const std::vector<SmallLaunch>& launches);
  void join_small_fronts(const std::vector<SmallLaunch>& launches);
  void launch_stages(const PivotPolicy& policy, PivotSearch search, const Mark& mark);
  template <class Next>
  void launch_steps(const DepthLaunches& depth, bool look_ahead, const Next& next);
  void follow_divided(const Segment& segment);
  void launch_roots();
  void launch_strict_panels(const Launch& tiles);
  void invert(const Range& tiles);
  DeviceStore<S, V> store_for_solve() const;
  void launch(const Launch& what, const Stream& stream, const std::optional<DeviceBlas>& blas);
  void assemble(const DepthLaunches& depth, bool look_ahead);
  void assemble_early(Vertex done);
  void assemble(const Range& parts, const Stream& stream, unsigned most_blocks = kAllBlocks);
  template <class Side, class Main>
  void launch_side_by_side(bool has_side, bool has_main, const Side& side, const Main& main);
  template <class Work>
  void with_sides(const Work& work);
  template <int K, bool Transposed, bool Substituted>
  void substitute_columns(const Vectors& vectors);

  const SymbolicPlan& plan_;
  const Stream& stream_;
  Stream side_[kMostSmallLaunches];
  Event fork_, joined_[kMostSmallLaunches];
  SideStream assembly_, ahead_;
  DevicePlan lists_;
  DeviceFlops flops_[2];                         // with the roots by tiles, and by the library
  std::optional<DeviceBlas> blas_, blas_ahead_;  // where the plan has products for them
  std::optional<DeviceLapack> lapack_;           // or roots
  std::unique_ptr<SegmentCopies> copies_;
  std::unique_ptr<EarlyAssembly> early_;
  DeviceArena arena_;
  std::unique_ptr<PinnedArena> host_arena_;  // where the matrix lies there
  DeviceStore<S, V> store_;
  DeviceStatus* status_;
  std::vector<int> states_;  // of fronts, on their way
  Vertex most_columns_ = 1;
  bool small_begin_early_ = false;  // kernels of small fronts can
  bool short_products_ = false;     // a block may have too little shared memory for NarrowShape
};

}  // namespace mfs::cuda
