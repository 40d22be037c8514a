// What the solver says about its work. Predicted figures are exact: the plan knows every front before any
// number is computed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <mfs/options.hpp>

namespace mfs {

/// Floating-point operations by kind. An operation with complex numbers counts as one.
struct Flops {
  double getrf = 0;  ///< LU of the diagonal blocks
  double trsm = 0;   ///< triangular solves of their row and column blocks
  double gemm = 0;   ///< matrix products of the variable update
  double total() const { return getrf + trsm + gemm; }
};

/// The fronts of one depth of the tree (0 is the root).
struct DepthSummary {
  std::int32_t depth = 0;
  std::int64_t fronts = 0;
  std::int64_t pivots = 0;          ///< unknowns eliminated at this depth
  std::int64_t max_front = 0;       ///< largest front (pivots + border), rows
  std::int64_t factor_entries = 0;  ///< entries of L and U stored
  std::int64_t contribution_entries = 0;
  Flops flops;
};

/// A determinant as phase * exp(log_abs), |phase| = 1 (0 with log_abs = -infinity for a singular matrix): the
/// number itself would overflow.
template <class Scalar>
struct Determinant {
  Scalar phase;
  double log_abs;
};

/// The rungs of the ladder that a solve climbs until its backward error is small enough, in the order in
/// which they are tried.
enum class Rung {
  factors,         ///< none: one pass over the factors was enough
  correction,      ///< perturbed pivots taken back by an exact low-rank correction
  refinement,      ///< iterative refinement
  krylov,          ///< FGMRES with the factors as preconditioner
  full_precision,  ///< factors of full precision in place of those of single precision
  reanalysis,      ///< a new matching and tree for values that have changed since the analysis
  larger_blocks,   ///< larger pivot blocks wherever the factors grow
  rescaling,       ///< rows scaled by the size that the residual is measured by, for each right-hand side
};

/// "factors", "correction", ...
inline const char* rung_name(Rung rung) {
  switch (rung) {
    case Rung::factors:
      return "factors";
    case Rung::correction:
      return "correction";
    case Rung::refinement:
      return "refinement";
    case Rung::krylov:
      return "krylov";
    case Rung::full_precision:
      return "full_precision";
    case Rung::reanalysis:
      return "reanalysis";
    case Rung::larger_blocks:
      return "larger_blocks";
    case Rung::rescaling:
      return "rescaling";
  }
  return "unknown";
}

struct Report {
  std::int64_t n = 0;
  std::int64_t nnz = 0;  ///< entries of A after duplicates are summed
  Backend backend = Backend::openmp;
  int threads = 0;

  bool matched = false;  ///< a matching was computed (rows permuted, or unknowns paired)
  std::int64_t nnz_factor = 0;
  Flops flops;       ///< predicted, as the backend divides fronts into blocks or tiles
  Flops flops_used;  ///< done by the last factorization, on a device with those that pivots made it repeat
  std::int64_t fronts = 0;
  std::int64_t depths = 0;
  std::int64_t max_front = 0;

  // Of the memory where the factors lie, that of the host or of the device.
  std::int64_t bytes_factor = 0;  ///< predicted bytes of the factors alone
  /// Predicted bytes of factors, contribution blocks, plan copy and the vectors of a solve for one right-hand
  /// side. What libraries of a device's vendor take is left out.
  std::int64_t bytes_peak = 0;
  std::int64_t bytes_used = 0;  ///< bytes that the numeric phases really took, those libraries included

  double time_order = 0;  ///< s, matrix check, matching, graph, separators
  double time_symbolic = 0;
  double time_factor = 0;    ///< s, first factorization (memory included)
  double time_refactor = 0;  ///< s, last refactorization
  double time_solve = 0;     ///< s, last solve, refinement included

  std::int64_t perturbed_pivots = 0;
  bool single_precision = false;  ///< the factors in use are of single precision
  int reanalyses = 0;             ///< times that the tree was changed because pivots failed
  double time_reanalyses = 0;     ///< s, for those that the first factorization needed; part of time_factor
  // What the last solve needed to reach the tolerance (all 0: the factors alone were good enough).
  Rung rung = Rung::factors;  ///< the highest one that was tried
  double time_ladder = 0;     ///< s, for all above Rung::factors; part of time_solve
  int refinement_steps = 0;
  int krylov_steps = 0;               ///< of FGMRES, where refinement stalled
  std::int64_t corrected_pivots = 0;  ///< perturbed pivots taken back by an exact low-rank correction
  double backward_error = 0;          ///< componentwise (SolveOptions), the worst of the last solve's columns
};

}  // namespace mfs
