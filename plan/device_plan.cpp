#include "plan/device_plan.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "plan/assembly_lists.hpp"
#include "plan/segment_lists.hpp"
#include "plan/solve_lists.hpp"
#include "plan/step_lists.hpp"

namespace mfs {

namespace {

/// The fronts of one step of the plan, by how they are factored.
struct SortedFronts {
  std::vector<Vertex> small, large;
};

SortedFronts sort_fronts(const SymbolicPlan& plan, Vertex step, const DeviceLimits& limits) {
  SortedFronts fronts;
  const Vertex first = plan.depth_begin[step], last = plan.depth_begin[step + 1];
  const double few_flops = limits.small_part * std::accumulate(plan.front_flops.begin() + first,
                                                               plan.front_flops.begin() + last, 0.0);
  for (Vertex f = first; f < last; ++f) {
    const bool small = plan.rows(f) <= limits.small_rows ||
                       (plan.front_flops[f] < few_flops && plan.rows(f) <= kMostSmallRows);
    (small ? fronts.small : fronts.large).push_back(f);
  }
  return fronts;
}

/// Fronts of like size share a launch, so that shared memory fits them; all do where each has a
/// multiprocessor of its own, and the largest decides how long it takes.
void list_small(const SymbolicPlan& plan, const std::vector<Vertex>& small, const DeviceLimits& limits,
                DevicePlan& made, DepthLaunches& depth) {
  Vertex largest = 0;
  for (const Vertex f : small) largest = std::max(largest, plan.rows(f));
  const bool few = static_cast<Vertex>(small.size()) <= limits.multiprocessors;
  const Vertex step = few ? std::max(largest, Vertex(1)) : limits.small_step;
  for (Vertex most = step; most < largest + step; most += step) {
    SmallLaunch launch;
    launch.fronts.begin = static_cast<Offset>(made.small_fronts.size());
    for (const Vertex f : small) {
      if (plan.rows(f) <= most && plan.rows(f) > most - step) {
        made.small_fronts.push_back(f);
        launch.rows = std::max(launch.rows, plan.rows(f));
      }
    }
    launch.fronts.end = static_cast<Offset>(made.small_fronts.size());
    if (launch.fronts.count() > 0) depth.small.push_back(launch);
  }
}

}  // namespace

DevicePlan make_device_plan(const SymbolicPlan& plan, const DeviceLimits& limits) {
  return make_device_plan(plan, limits, {});
}

DevicePlan make_device_plan(const SymbolicPlan& plan, const DeviceLimits& limits, SegmentPlan segments) {
  DevicePlan made;
  made.segments = std::move(segments);
  made.tile = limits.tile;
  made.strip = limits.strip;
  made.small_rows = limits.small_rows;
  made.tall = limits.tall;
  made.panel_entries = limits.panel_entries;
  AssemblyLists assembly(plan, made);
  StepLists steps(plan, limits, made);
  made.depths.resize(static_cast<std::size_t>(plan.num_depths));
  for (Vertex step = 0; step < plan.num_depths; ++step) {
    DepthLaunches& depth = made.depths[step];
    const SortedFronts fronts = sort_fronts(plan, step, limits);
    list_small(plan, fronts.small, limits, made, depth);
    assembly.add_depth(fronts.large, depth);
    steps.add_depth(fronts.large, depth);
  }
  steps.add_roots();
  assembly.finish();
  SolveLists(plan, limits, made).run();
  if (!made.segments.empty()) SegmentLists(plan, limits, made).run();
  if (made.segments.blocks_out() > 0) made.block_read = plan.contribution_begin;
  if (made.segments.has_divided()) made.divided.assign(static_cast<std::size_t>(plan.num_fronts), 0);
  for (const BorderColumns& columns : made.segments.border_columns) made.divided[columns.front] = 1;
  return made;
}

}  // namespace mfs
