// What is known once per pattern: made by analyze_matrix from the caller's matrix, never changed.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include <mfs/analysis_options.hpp>
#include <mfs/csr_view.hpp>

#include "ordering/diagonal_blocks.hpp"
#include "ordering/order_matrix.hpp"
#include "plan/device_plan.hpp"
#include "plan/symbolic_plan.hpp"

namespace mfs {

struct Analysis {
  std::shared_ptr<const Pattern> pattern;
  MatchedScaling matched;
  std::shared_ptr<const DiagonalBlocks> blocks;  // of the plan; null: A is one
  std::shared_ptr<const SymbolicPlan> plan;
  /// Offsets and columns of the caller's matrix where they are not the pattern's own (unsorted or repeated).
  std::vector<Offset> caller_offsets;
  std::vector<Vertex> caller_columns;
  std::optional<std::uint64_t> values;  // fingerprint of those of the caller; none of a pattern alone
  double time_order = 0;                // s: check, matching, ordering
  double time_symbolic = 0;             // s

  /// `values`, in the order of the caller's entries, as the matrix that was analysed.
  template <class Scalar>
  CsrView<Scalar> caller_view(const Scalar* values) const {
    const bool own = !pattern->slot_of_entry.empty();
    return {pattern->n, pattern->n, own ? caller_offsets.data() : pattern->offsets.data(),
            own ? caller_columns.data() : pattern->columns.data(), values};
  }
};

/// What a backend asks of its trees and plans.
struct PlanNeeds {
  TreeHeight height = TreeHeight::any;
  AssemblyTurns turns{};
  /// Of the unknowns, to which block triangular form is used; 0: never.
  double largest_block = 0;
};
constexpr PlanNeeds host_needs(int threads) {
  return {threads == 1 ? TreeHeight::any : TreeHeight::even};
}
constexpr PlanNeeds kDeviceNeeds{TreeHeight::low, kAssemblyTurns};

/// Receives the name of a phase and the fraction of it that is done.
using PhaseProgress = std::function<void(const char*, double)>;

/// Check of the input, matching and scaling, ordering, symbolic plan, for a backend with such needs; `list`:
/// as order_matrix has it, for executors without depths. `checked` is called once the input is known to be
/// good. Throws as BasicSolver::analyze does.
template <class Scalar>
Analysis analyze_matrix(
    const CsrView<Scalar>& matrix, const AnalysisOptions& options, const PlanNeeds& needs, int threads,
    const PhaseProgress& progress, const std::function<void(const Pattern&)>& checked = [](const Pattern&) {},
    const ListCost* list = nullptr);

/// Matching, scaling, ordering and plan anew for other values (one per slot of the pattern); the pattern
/// stays.
template <class Scalar>
void reanalyze(Analysis& analysis, const Scalar* slot_values, const AnalysisOptions& options,
               const PlanNeeds& needs, int threads, const PhaseProgress& progress,
               const ListCost* list = nullptr);

}  // namespace mfs
