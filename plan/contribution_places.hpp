// Where contribution blocks lie in the region of a plan, behind the factors of the step that reads them
// (drawing in symbolic_plan.hpp), and in which turn of its step each is assembled.
#pragma once

#include <vector>

#include "plan/symbolic_plan.hpp"

namespace mfs {

/// Sets contribution_begin, assembly_turn and storage_entries of a plan whose factors have their places.
/// `factors_end`: where those of each step end.
void place_contributions(SymbolicPlan& plan, const std::vector<Offset>& factors_end,
                         const AssemblyTurns& turns);

}  // namespace mfs
