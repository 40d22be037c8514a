#include "kernels/schedule.hpp"

#include <algorithm>
#include <numeric>

namespace mfs {

namespace {

// Below this a front is not worth waking all threads several times for (2-core EPYC, 2026-11: 0.3 ms of
// work).
constexpr double kLargeFlops = 2e7;
// A depth may wait this much for its last thread before its largest front is shared instead.
constexpr double kImbalance = 1.08;

// Time of the longest thread when the fronts, longest first, each go to the thread that is free first.
double longest_thread(const std::vector<Vertex>& fronts, size_t begin, const std::vector<double>& flops,
                      int threads) {
  std::vector<double> load(threads, 0.0);
  for (size_t i = begin; i < fronts.size(); ++i)
    *std::min_element(load.begin(), load.end()) += flops[fronts[i]];
  return *std::max_element(load.begin(), load.end());
}

// Kokkos gives each thread a contiguous share of the list and lets the others steal from it.
std::vector<Vertex> deal(const std::vector<Vertex>& fronts, size_t begin, int threads) {
  std::vector<Vertex> dealt;
  dealt.reserve(fronts.size() - begin);
  for (int t = 0; t < threads; ++t) {
    for (size_t i = begin + t; i < fronts.size(); i += threads) dealt.push_back(fronts[i]);
  }
  return dealt;
}

DepthSchedule schedule_depth(const SymbolicPlan& plan, Vertex first, Vertex last, int threads) {
  std::vector<Vertex> fronts(last - first);
  std::iota(fronts.begin(), fronts.end(), first);
  if (threads == 1) return {fronts, {}};
  std::stable_sort(fronts.begin(), fronts.end(),
                   [&](Vertex a, Vertex b) { return plan.front_flops[a] > plan.front_flops[b]; });
  double total = 0;
  for (const Vertex f : fronts) total += plan.front_flops[f];
  size_t large = 0;
  while (large < fronts.size() && plan.front_flops[fronts[large]] > kLargeFlops &&
         longest_thread(fronts, large, plan.front_flops, threads) > kImbalance * total / threads) {
    total -= plan.front_flops[fronts[large]];
    ++large;
  }
  return {deal(fronts, large, threads),
          {fronts.begin(), fronts.begin() + static_cast<std::ptrdiff_t>(large)}};
}

}  // namespace

Schedule make_schedule(const SymbolicPlan& plan, int threads) {
  Schedule schedule;
  schedule.reserve(plan.num_depths);
  for (Vertex k = 0; k < plan.num_depths; ++k) {
    schedule.push_back(schedule_depth(plan, plan.depth_begin[k], plan.depth_begin[k + 1], threads));
  }
  return schedule;
}

}  // namespace mfs
