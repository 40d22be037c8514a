// Larger pivot blocks where pivots failed: pivots are searched inside the pivot block of a front, so a front
// that found none that is good enough is merged into its parent, where the search has more rows. What a
// delayed pivot does during one factorization (Duff and Reid 1983) is done here once, in the tree, for all
// that follow.
#pragma once

#include "plan/symbolic_plan.hpp"

namespace mfs {

/// The tree of `plan` with each front f for which failed[f] is set merged into its parent (roots stay);
/// pivots of the child come first. A chain of failed fronts becomes one.
SeparatorTree merge_into_parents(const SymbolicPlan& plan, const std::vector<char>& failed);

}  // namespace mfs
