// Options of what is done once per pattern: matching, scaling, ordering, symbolic plan.
#pragma once

#include <cstdint>
#include <vector>

namespace mfs {

/// When rows are matched to columns so that large entries come to the diagonal (or into 2x2 pairs).
enum class Matching {
  automatic,  ///< where a cheap test finds the diagonal weak
  always,
  never,
};

/// A separator tree given by the caller: node k holds the elimination positions
/// [offsets[k], offsets[k+1]) of `permutation`; children come before their parent; -1 for a root.
struct UserTree {
  std::vector<std::int64_t> offsets;  ///< nodes + 1
  std::vector<std::int64_t> parent;   ///< nodes
};

struct AnalysisOptions {
  Matching matching = Matching::automatic;
  bool scaling = true;

  /// Threads of the analysis alone; 0: as many as every other phase (Options::threads). Pays where the other
  /// phases get few, because their work is done on a device.
  int threads = 0;

  /// Widest block into which a pivot block is divided (rows and columns). Backend::cuda has blocks of its own
  /// and refuses others than the default.
  std::int32_t max_block_size = 1024;
  /// Sub-graphs of at most this many unknowns are ordered by CAMD instead of being dissected.
  std::int32_t leaf_size = 120;
  /// Trials for the separator of each sub-graph with a sixth of all unknowns or more (others get one), side
  /// by side, with the seeds `seed`, `seed` + 1, ...; METIS' refinement passes (NITER) in each.
  std::int32_t separator_trials = 4;
  std::int32_t separator_refinement = 10;
  /// A row with more than dense_row * sqrt(n) neighbours is ordered last instead of being dissected.
  double dense_row = 10.0;
  std::int32_t seed = 42;

  /// The caller's own elimination order: permutation[position] = row/column; empty: nested dissection.
  std::vector<std::int64_t> permutation;
  /// The caller's own tree over `permutation`; empty: the elimination tree of the permutation.
  UserTree tree;
};

}  // namespace mfs
