// How threads share a solve that goes through the blocks of a triangle (plan/block_triangle.hpp): a row of
// lists as kernels/runtime/workers.hpp has them.
//
//   step   groups of blocks, each by one thread, and then the depths of those that are large, up and down
//
// Levels with little work are one group together, in one step.
#pragma once

#include <vector>

#include "plan/schedule.hpp"

namespace mfs {

struct BlockSchedule {
  /// Consecutive blocks.
  struct Group {
    Vertex begin, end;
  };
  struct Step {
    std::vector<Group> groups;
    Schedule depths;  // of the fronts of large blocks, deepest depth first
  };
  /// The groups of a step, or one depth of it.
  struct List {
    Vertex step, depth;  // -1: the groups
    bool down;           // backward substitution
  };
  std::vector<Step> steps;
  std::vector<List> lists[2];  // in the order of a solve with A, and of one with A^T
};

/// Empty where the plan has no triangle.
BlockSchedule make_block_schedule(const SymbolicPlan& plan, int threads);

}  // namespace mfs
