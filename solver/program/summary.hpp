// The reports for people.
#pragma once

#include <string>
#include <vector>

#include <mfs/report.hpp>
#include <mfs/version.hpp>

#include "solver/program/case_result.hpp"

namespace mfs::program {

/// What `mfs solve` and `mfs bench` print without --json: a few lines, as far as the case came.
std::string solve_summary(const CaseResult& result);

/// What `mfs analyze` prints: the tree, the fronts by depth, flops by operation, memory.
std::string analysis_summary(const CaseResult& result);

/// Names of the backends that this build can use on this machine: "serial, openmp".
std::string usable_backends();
/// What Backend::cuda uses of a device, and why.
std::string device_summary(const DeviceInfo& device);

/// What `mfs info` prints.
std::string library_summary();
/// Rates by size, and the file that keeps them.
std::string rates_summary(const MachineRates& rates, const std::string& path);

}  // namespace mfs::program
