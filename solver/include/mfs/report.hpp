// The report of a solver. Predicted figures are exact, because the plan knows every front before any number
// is computed.
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

/// The fronts of one depth of the separator tree.
struct DepthSummary {
  std::int32_t depth = 0;  ///< 0 for the roots
  std::int64_t fronts = 0;
  std::int64_t pivots = 0;                ///< unknowns eliminated at this depth
  std::int64_t max_front = 0;             ///< largest front (pivots + border), rows
  std::int64_t factor_entries = 0;        ///< entries of L and U stored
  std::int64_t contribution_entries = 0;  ///< entries of the contribution blocks
  Flops flops;                            ///< as the backend divides fronts into blocks or tiles
  std::int64_t segments = 0;              ///< in which its fronts are factored, 0 if all at once
};

/// A determinant as phase * exp(log_abs), because the number itself would overflow. |phase| is 1; for a
/// singular matrix phase is 0 and log_abs is -infinity.
template <class Scalar>
struct Determinant {
  Scalar phase;
  double log_abs;
};

/// The rungs of the accuracy ladder, in the order in which a solve tries them until its backward error is
/// small enough.
enum class Rung {
  factors,         ///< none: one pass over the factors was enough
  correction,      ///< perturbed pivots taken back by an exact low-rank correction
  refinement,      ///< iterative refinement
  krylov,          ///< FGMRES with the factors as preconditioner
  full_precision,  ///< factors of full precision in place of those of single precision
  reanalysis,      ///< a new matching and tree for values that have changed since the analysis
  tiny_pivots,     ///< perturbed pivots divided by as they are, though they may be rounding
  larger_blocks,   ///< larger pivot blocks wherever the factors grow
  rescaling,       ///< rows scaled by the size that the residual is measured by, for each right-hand side
  orthogonal,      ///< on the host: Householder reflections, under which nothing grows, where they take some
                   ///< seconds
  host,  ///< of a device: factors on the host, which substitutes where a device multiplies by inverses
};

/// The name of the enumerator, "unknown" for any other value.
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
    case Rung::tiny_pivots:
      return "tiny_pivots";
    case Rung::larger_blocks:
      return "larger_blocks";
    case Rung::rescaling:
      return "rescaling";
    case Rung::orthogonal:
      return "orthogonal";
    case Rung::host:
      return "host";
  }
  return "unknown";
}

/// Figures of the last analysis, factorization and solve; zero before these. Times are wall times in seconds.
struct Report {
  std::int64_t n = 0;    ///< rows of A
  std::int64_t nnz = 0;  ///< entries of A after repeated ones are summed
  Backend backend = Backend::openmp;
  int threads = 0;

  bool matched = false;              ///< a matching was computed (rows permuted, or unknowns paired)
  std::int64_t diagonal_blocks = 0;  ///< that are factored: those of a block triangular form, or A as one
  std::int64_t nnz_factor = 0;       ///< entries of L and U of these, those of whole fronts
  Flops flops;                       ///< predicted, as the backend divides fronts into blocks or tiles
  Flops flops_used;  ///< done by the last factorization, on a device with those that pivots made it repeat
  std::int64_t fronts = 0;
  std::int64_t depths = 0;     ///< of the separator tree
  std::int64_t max_front = 0;  ///< rows of the largest front

  // Of the memory where the factors lie, that of the host or of the device.
  std::int64_t bytes_factor = 0;  ///< predicted bytes of the factors alone
  /// Predicted bytes of factors, contribution blocks, plan copy and the vectors of a solve for one right-hand
  /// side. What libraries of a device's vendor take is left out.
  std::int64_t bytes_peak = 0;
  std::int64_t bytes_used = 0;  ///< bytes that the numeric phases really took, those libraries included
  /// Whether the factors are too large for the device, so that a part of them lies in page-locked memory of
  /// the host (Options::memory_limit), or for the host, so that a part lies in a file
  /// (Options::out_of_core_dir); predicted, and what was done once there are factors.
  bool partial = false;
  std::int64_t segments = 0;   ///< in which they are made then, one after the other
  std::int64_t bytes_out = 0;  ///< that one factorization copies to the host, or writes to the file
  std::int64_t bytes_in = 0;   ///< of those, contribution blocks that it reads there again
  /// That one pass of a solve copies or reads back, for up to 16 right-hand sides.
  std::int64_t bytes_back = 0;
  /// How many times as long as without a limit a refactorization takes then on a device, as foreseen.
  double slowdown = 1;

  double time_order = 0;     ///< s, check of the matrix, matching, graph, separators
  double time_symbolic = 0;  ///< s, symbolic plan, and what the backend makes of it
  double time_factor = 0;    ///< s, first factorization, with what it takes to get its memory
  double time_refactor = 0;  ///< s, last refactorization
  double time_solve = 0;     ///< s, last solve, with the accuracy ladder

  std::int64_t perturbed_pivots = 0;  ///< of the last factorization
  bool single_precision = false;      ///< the factors in use are of single precision
  int reanalyses = 0;                 ///< times that the tree was changed because pivots failed
  double time_reanalyses = 0;  ///< s, for those of the first values; part of time_symbolic or time_factor
  // What the last solve needed to reach the tolerance (all 0: the factors alone were good enough).
  Rung rung = Rung::factors;          ///< the highest one that was tried
  double time_ladder = 0;             ///< s, for all above Rung::factors; part of time_solve
  int refinement_steps = 0;           ///< of iterative refinement, the most of any block of columns
  int krylov_steps = 0;               ///< of FGMRES, the same
  std::int64_t corrected_pivots = 0;  ///< perturbed pivots taken back by an exact low-rank correction
  /// Above 0 only with SolveOptions::solve_singular: the matrix is singular to working precision, so many
  /// rows were found to depend on the others, and some z has |A z| = singularity * | |A||z| | (maximum norms
  /// in scaled rows).
  std::int64_t dependent_rows = 0;
  double singularity = 0;
  double backward_error = 0;  ///< componentwise (SolveOptions), the worst of the last solve's columns
};

}  // namespace mfs
