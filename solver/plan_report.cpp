#include "solver/plan_report.hpp"

#include <cstdint>
#include <numeric>

namespace mfs {

void report_plan(const SymbolicPlan& plan, const NumericBytes& bytes, const BlockFlops& flops,
                 Report& report) {
  report.n = plan.n;
  report.nnz = plan.nnz;
  report.diagonal_blocks = plan.triangle.empty() ? 1 : plan.triangle.blocks();
  report.nnz_factor = plan.nnz_factor;
  report.flops = {flops.getrf, flops.trsm, flops.gemm};
  report.fronts = plan.num_fronts;
  report.depths = plan.num_depths;
  report.max_front = plan.max_front;
  report.bytes_factor = bytes.factor;
  report.bytes_peak = bytes.total();
}

void report_movement(const Movement& movement, Report& report) {
  report.partial = !movement.segments.empty();
  report.segments = std::accumulate(movement.segments.begin(), movement.segments.end(), std::int64_t{0});
  report.bytes_out = movement.out;
  report.bytes_in = movement.in;
  report.bytes_back = movement.back;
  report.slowdown = movement.slowdown;
}

std::string plan_line(const Report& report) {
  return "plan: " + std::to_string(report.fronts) + " fronts in " + std::to_string(report.depths) +
         " depths, " + std::to_string(report.nnz_factor) + " factor entries, " +
         std::to_string(report.bytes_peak) + " bytes";
}

}  // namespace mfs
