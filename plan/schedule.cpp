#include "plan/schedule.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mfs {

namespace {

// Below this a front is not worth sharing: some 0.1 ms of work.
constexpr double kLargeFlops = 2e6;
// Nor is one that is less than this part of what each thread has to do in the depth: others fill the time.
constexpr double kLargePart = 0.1;
// A group is worth being taken when it has this many operations, and small beside a thread's part of the
// depth.
constexpr double kGroupFlops = 5e5;
constexpr double kGroupPart = 0.1;

struct Group {
  double flops;
  Vertex begin, end;  // in the list that is cut
};

// Neighbours are grouped until there is enough to do. One thread has no use for groups.
std::vector<Group> cut(const std::vector<Vertex>& fronts, const std::vector<double>& flops, int threads) {
  const Vertex count = static_cast<Vertex>(fronts.size());
  double total = 0;
  for (const Vertex f : fronts) total += flops[f] + kFrontFlops;
  const double enough = threads == 1 ? total : std::min(kGroupFlops, kGroupPart * total / threads);
  std::vector<Group> groups;
  Group next{0, 0, 0};
  for (Vertex i = 0; i < count; ++i) {
    next.flops += flops[fronts[i]] + kFrontFlops;
    next.end = i + 1;
    if (next.flops < enough && next.end < count) continue;
    groups.push_back(next);
    next = {0, next.end, next.end};
  }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const Group& a, const Group& b) { return a.flops > b.flops; });
  return groups;
}

void put_in_groups(const std::vector<Vertex>& small, const std::vector<double>& flops, int threads,
                   DepthSchedule& depth) {
  depth.small.reserve(small.size());
  depth.group_begin.push_back(0);
  for (const Group& group : cut(small, flops, threads)) {
    depth.small.insert(depth.small.end(), small.begin() + group.begin, small.begin() + group.end);
    depth.group_begin.push_back(static_cast<Vertex>(depth.small.size()));
  }
}

DepthSchedule schedule_depth(const SymbolicPlan& plan, const std::vector<Vertex>& fronts, int threads) {
  const std::vector<double>& flops = plan.front_flops;
  double total = 0;
  for (const Vertex f : fronts) total += flops[f];
  const double large = std::max(kLargeFlops, kLargePart * total / threads);

  DepthSchedule depth;
  std::vector<Vertex> small;
  for (const Vertex f : fronts) (threads > 1 && flops[f] > large ? depth.large : small).push_back(f);
  std::stable_sort(depth.large.begin(), depth.large.end(),
                   [&](Vertex a, Vertex b) { return flops[a] > flops[b]; });
  for (const Vertex f : depth.large)
    depth.share.push_back(std::max(1, static_cast<int>(std::lround(threads * flops[f] / total))));
  put_in_groups(small, flops, threads, depth);
  return depth;
}

}  // namespace

Schedule make_schedule(const SymbolicPlan& plan, int threads) {
  std::vector<Vertex> all(static_cast<std::size_t>(plan.num_fronts));
  std::iota(all.begin(), all.end(), 0);
  return make_schedule(plan, all, threads);
}

Schedule make_schedule(const SymbolicPlan& plan, const std::vector<Vertex>& fronts, int threads) {
  Schedule schedule;
  std::vector<Vertex> of_depth;
  auto f = fronts.begin();
  for (Vertex k = 0; k < plan.num_depths; ++k) {
    of_depth.clear();
    for (; f != fronts.end() && *f < plan.depth_begin[k + 1]; ++f) of_depth.push_back(*f);
    if (!of_depth.empty()) schedule.push_back(schedule_depth(plan, of_depth, threads));
  }
  return schedule;
}

Schedule make_schedule(const SymbolicPlan& plan, const SegmentPlan& segments, const Schedule& by_depth,
                       Vertex alone, int threads) {
  std::vector<int> share(static_cast<std::size_t>(plan.num_fronts), 0);  // 0: of one thread
  for (std::size_t step = static_cast<std::size_t>(alone); step < by_depth.size(); ++step) {
    const DepthSchedule& depth = by_depth[step];
    for (std::size_t i = 0; i < depth.large.size(); ++i) share[depth.large[i]] = depth.share[i];
  }
  Schedule schedule;
  schedule.reserve(segments.segments.size());
  for (const Segment& segment : segments.segments) {
    DepthSchedule own;
    std::vector<Vertex> small;
    for (Vertex i = segment.begin; i < segment.end; ++i) {
      const Vertex f = segments.order[i];
      (share[f] > 0 ? own.large : small).push_back(f);
    }
    std::stable_sort(own.large.begin(), own.large.end(),
                     [&](Vertex a, Vertex b) { return plan.front_flops[a] > plan.front_flops[b]; });
    for (const Vertex f : own.large) own.share.push_back(share[f]);
    put_in_groups(small, plan.front_flops, threads, own);
    schedule.push_back(std::move(own));
  }
  return schedule;
}

}  // namespace mfs
