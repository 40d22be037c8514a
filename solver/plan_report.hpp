// What a report says of a plan.
#pragma once

#include <string>

#include <mfs/report.hpp>

#include "kernels/factors.hpp"
#include "plan/symbolic_plan.hpp"

namespace mfs {

/// Of the plan, and of what the backend makes of it.
void report_plan(const SymbolicPlan& plan, const NumericBytes& bytes, const BlockFlops& flops,
                 Report& report);
void report_movement(const Movement& movement, Report& report);

/// For the log.
std::string plan_line(const Report& report);

}  // namespace mfs
