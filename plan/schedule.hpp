// Which fronts of a depth are large enough to be worked on by several threads, and in which groups the others
// go to one thread each.
#pragma once

#include <vector>

#include "plan/segments.hpp"
#include "plan/symbolic_plan.hpp"

namespace mfs {

/// What taking a front costs beside its operations, in operations.
constexpr double kFrontFlops = 2e4;

struct DepthSchedule {
  std::vector<Vertex> large;        // longest first
  std::vector<int> share;           // threads that each is worth, by its part of the depth's operations
  std::vector<Vertex> small;        // neighbours of the plan stay together, groups with most work first
  std::vector<Vertex> group_begin;  // group g: small[group_begin[g]] ... small[group_begin[g+1] - 1]
};

using Schedule = std::vector<DepthSchedule>;  // by step of the plan, deepest depth first

Schedule make_schedule(const SymbolicPlan& plan, int threads);

/// The same for some fronts, which ascend, and the depths that have any.
Schedule make_schedule(const SymbolicPlan& plan, const std::vector<Vertex>& fronts, int threads);

/// The same for segments in place of depths. Each front is large, and worth as many threads, as in
/// `by_depth`, but for those of the first `alone` steps, which are never shared: what is computed of it
/// depends on that.
Schedule make_schedule(const SymbolicPlan& plan, const SegmentPlan& segments, const Schedule& by_depth,
                       Vertex alone, int threads);

}  // namespace mfs
