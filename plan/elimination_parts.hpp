// An order of elimination for a scalar program, and parts of it that can be done at the same time.
//
//   stage 0   | subtrees | subtrees | ... | subtrees |      of about as much work each
//   stage 1   | subtrees of what is above them | ... |      fewer, as there are fewer branches
//   ...
//   the last  | what is left                         |
//
// Columns of a part need those of the same part and of earlier stages, and no others. Within a part each
// subtree's come together, so that what a column needs has just been made.
#pragma once

#include <vector>

#include "plan/symbolic_plan.hpp"

namespace mfs {

struct EliminationParts {
  std::vector<Vertex> order;        // n: positions of the plan
  std::vector<Vertex> part_begin;   // parts + 1, into order
  std::vector<Vertex> stage_begin;  // stages + 1, into parts
};

/// Stage 0 has at most `most` parts, each later stage a quarter of the one before.
EliminationParts divide_elimination(const SymbolicPlan& plan, int most);

}  // namespace mfs
