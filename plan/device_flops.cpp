#include "plan/device_flops.hpp"

#include <algorithm>

namespace mfs {

namespace {

void add_to(BlockFlops& sum, const BlockFlops& flops) {
  sum.getrf += flops.getrf;
  sum.trsm += flops.trsm;
  sum.gemm += flops.gemm;
}

/// One use: adds up launch after launch.
class Count {
 public:
  Count(const SymbolicPlan& plan, const DevicePlan& lists) : plan_(plan), lists_(lists) {}

  void add(const SmallLaunch& launch) {
    for (Offset i = launch.fronts.begin; i < launch.fronts.end; ++i) {
      const Vertex f = lists_.small_fronts[i];
      add_to(sum_.done, block_flops(plan_.pivots(f), plan_.border_rows(f)));
    }
  }
  void add(const Launch& launch) {
    for (Offset i = launch.tasks.begin; i < launch.tasks.end; ++i) {
      switch (launch.kind) {
        case Launch::Kind::diagonal:
          sum_.done.getrf += block_flops(pivots(lists_.steps[i]), 0).getrf;
          break;
        case Launch::Kind::strips:
          add_strips(lists_.steps[i]);
          break;
        case Launch::Kind::products:
        case Launch::Kind::wide_products:
        case Launch::Kind::vendor_gemm:
          add_product(lists_.products[i]);
          break;
      }
    }
  }
  void add(const RootTask& root) { sum_.done.getrf += block_flops(root.pivots, 0).getrf; }

  const DeviceFlops& sum() const { return sum_; }

 private:
  Vertex pivots(const StepTask& task) const {
    return std::min(lists_.tile, plan_.pivots(task.front) - task.k);
  }
  // L has the pivots on its diagonal to divide by, U has ones.
  void add_strips(const StepTask& task) {
    const double s = pivots(task);
    const double below = task.left ? plan_.rows(task.front) - task.k - s : 0, right = task.end - task.begin;
    sum_.done.trsm += s * s * below + s * (s - 1) * right;
  }
  void add_product(const ProductTask& task) {
    const double of_a_row = 2.0 * task.n * task.k;
    sum_.done.gemm += of_a_row * (task.m - task.padding);
    sum_.padding += of_a_row * task.padding;
  }

  const SymbolicPlan& plan_;
  const DevicePlan& lists_;
  DeviceFlops sum_;
};

}  // namespace

DeviceFlops count_flops(const SymbolicPlan& plan, const DevicePlan& lists, bool library_roots) {
  DeviceFlops all;
  all.steps.assign(static_cast<std::size_t>(plan.num_depths), BlockFlops{0, 0, 0});
  std::size_t number = 0;  // of the depth, or of the segment
  for (const DepthLaunches& depth : lists.depths) {
    Count count(plan, lists);
    for (const SmallLaunch& launch : depth.small) count.add(launch);
    const bool by_library = library_roots && !lists.roots.empty() && &depth == &lists.depths.back();
    if (by_library) {
      for (const RootTask& root : lists.roots) count.add(root);
    } else {
      for (const Launch& launch : depth.factor) count.add(launch);
    }
    for (const Launch& launch : depth.update) count.add(launch);
    const DeviceFlops& of_depth = count.sum();
    add_to(all.done, of_depth.done);
    all.padding += of_depth.padding;
    const std::size_t step =
        lists.segments.empty() ? number : static_cast<std::size_t>(lists.segments.segments[number].step);
    add_to(all.steps[step], of_depth.done);
    ++number;
  }
  return all;
}

}  // namespace mfs
