#include "solver/depth_table.hpp"

#include <algorithm>

namespace mfs {

std::vector<DepthSummary> depth_table(const SymbolicPlan& plan, const std::vector<BlockFlops>& step_flops,
                                      const std::vector<Vertex>& segments) {
  std::vector<DepthSummary> table;
  for (Vertex depth = 0; depth < plan.num_depths; ++depth) {
    const Vertex step = plan.num_depths - 1 - depth;
    DepthSummary& row = table.emplace_back();
    row.depth = depth;
    row.segments = segments.empty() ? 0 : segments[step];
    for (Vertex f = plan.depth_begin[step]; f < plan.depth_begin[step + 1]; ++f) {
      const std::int64_t p = plan.pivots(f), border = plan.border_rows(f);
      const BlockFlops flops = plan.flops_of(f);
      ++row.fronts;
      row.pivots += p;
      row.max_front = std::max(row.max_front, p + border);
      row.factor_entries += p * p + 2 * p * border;
      row.contribution_entries += border * border;
      row.flops.getrf += flops.getrf;
      row.flops.trsm += flops.trsm;
      row.flops.gemm += flops.gemm;
    }
    if (!step_flops.empty()) {
      const BlockFlops& own = step_flops[static_cast<std::size_t>(step)];
      row.flops = {own.getrf, own.trsm, own.gemm};
    }
  }
  return table;
}

}  // namespace mfs
