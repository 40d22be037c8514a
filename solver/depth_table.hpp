// The fronts of a plan by depth, as the report shows them.
#pragma once

#include <vector>

#include <mfs/report.hpp>

#include "plan/symbolic_plan.hpp"

namespace mfs {

/// Root first. `step_flops`: as Planned has them. `segments`: of each depth, deepest first; empty where there
/// are none.
std::vector<DepthSummary> depth_table(const SymbolicPlan& plan, const std::vector<BlockFlops>& step_flops,
                                      const std::vector<Vertex>& segments);

}  // namespace mfs
