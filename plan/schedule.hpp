// Which fronts of a depth are large enough to be worked on by several threads, and in which groups the others
// go to one thread each.
#pragma once

#include <vector>

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

}  // namespace mfs
