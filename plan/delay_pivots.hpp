// Pivots that failed come later: pivots are searched inside the pivot block of a front, so one that found
// none that is good enough is moved to the pivot block of an ancestor, where the search has more rows and
// more of the matrix is eliminated. What a delayed pivot does during one factorization (Duff and Reid 1983)
// is done here once, in the tree, for all that follow.
#pragma once

#include <vector>

#include "plan/symbolic_plan.hpp"

namespace mfs {

/// No pivot for `position` was good enough; what was left there is row `row` of A.
struct FailedPivot {
  Vertex position, row;
};

/// Whether delay_pivots would move any of them.
bool can_move(const SymbolicPlan& plan, const std::vector<FailedPivot>& failed);

struct DelayedTree {
  SeparatorTree tree;
  std::vector<Vertex> row_order;  // as MatchedScaling has it
};

/// The tree of `plan` with each failed pivot moved up by `levels`, at most to the root; failed pivots of
/// roots stay. They are eliminated behind the pivots that were there. `failed` ascends by position.
DelayedTree delay_pivots(const SymbolicPlan& plan, const std::vector<FailedPivot>& failed, Vertex levels,
                         int threads);

}  // namespace mfs
