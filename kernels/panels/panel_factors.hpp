// Factors of small fronts: those of fronts, and panels beside them (kernels/panels/panel_lu.hpp), which take
// a fraction of the time that looking after fronts does. Both search pivots by the same rule. Values with a
// pivot that panels do not pass are factored by fronts, which perturb it; nothing of that is left for the
// next values.
#pragma once

#include <memory>

#include "kernels/factors.hpp"
#include "plan/panel_program.hpp"

namespace mfs {

/// Bytes that panels take beside fronts, with factors whose entries have `scalar_bytes`.
Offset panel_bytes(const SymbolicPlan& plan, const PanelProgram& program, Offset scalar_bytes);

/// `fronts`: factors of that plan and pattern in the memory of the host, by one thread. They have single
/// precision or that of Value, and so do the panels. Throws std::bad_alloc.
template <class Value>
std::unique_ptr<Factors<Value>> make_panel_factors(bool single_precision,
                                                   std::unique_ptr<Factors<Value>> fronts,
                                                   std::shared_ptr<const SymbolicPlan> plan,
                                                   std::shared_ptr<const Pattern> pattern,
                                                   std::shared_ptr<const PanelProgram> program);

}  // namespace mfs
