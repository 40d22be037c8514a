// The fronts of a plan by depth, as the report shows them.
#pragma once

#include <vector>

#include <mfs/report.hpp>

#include "plan/symbolic_plan.hpp"

namespace mfs {

/// Root first.
std::vector<DepthSummary> depth_table(const SymbolicPlan& plan);

}  // namespace mfs
