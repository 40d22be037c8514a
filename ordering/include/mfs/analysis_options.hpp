// Options of what is done once per pattern: matching, scaling, ordering, symbolic plan.
#pragma once

#include <cstdint>
#include <vector>

namespace mfs {

/// When rows are matched to columns so that large entries come to the diagonal or into 2 x 2 pairs (Duff and
/// Koster 2001; Duff and Pralet 2005).
enum class Matching {
  automatic,  ///< only where a cheap test finds the diagonal weak
  always,     ///< for every matrix that has values
  never,      ///< not at all
};

/// A separator tree of the caller. Node k holds the elimination positions [offsets[k], offsets[k + 1]) of
/// AnalysisOptions::permutation. Children come before their parent.
struct UserTree {
  std::vector<std::int64_t> offsets;  ///< nodes + 1
  std::vector<std::int64_t> parent;   ///< nodes; -1 for a root
};

struct AnalysisOptions {
  Matching matching = Matching::automatic;
  /// Rows and columns are scaled by powers of two.
  bool scaling = true;

  /// Threads of the analysis alone, at most 512. 0 means as many as every other phase has (Options::threads).
  /// More pay where the other phases have few because their work is done on a device.
  int threads = 0;

  /// Rows and columns of the widest block into which a pivot block is divided. Backend::cuda and
  /// Backend::kokkos have blocks of their own and refuse any other value than the default.
  std::int32_t max_block_size = 1024;
  /// Sub-graphs of at most this many unknowns are ordered by CAMD instead of being dissected. With the
  /// default so are whole graphs of 1000 to 20 000 vertices with few neighbours, where CAMD makes few
  /// operations (and no long tree, for a device), and those of a BatchSolver where it makes clearly fewer.
  std::int32_t leaf_size = 120;
  /// Trials for the separator of each sub-graph with a sixth of all unknowns or more; smaller ones have one
  /// trial. Trials run in parallel, with the seeds `seed`, `seed` + 1, ...
  std::int32_t separator_trials = 4;
  /// METIS' refinement passes (NITER) in each trial.
  std::int32_t separator_refinement = 10;
  /// A row with more than dense_row * sqrt(n) neighbours is ordered last instead of being dissected.
  double dense_row = 10.0;
  /// Of the random numbers of the dissection. The order depends on it, but not on the number of threads.
  std::int32_t seed = 42;

  /// The caller's elimination order, n entries: permutation[position] = row and column. Where it is empty,
  /// nested dissection finds the order.
  std::vector<std::int64_t> permutation;
  /// The caller's tree over `permutation`. Where it is empty, the elimination tree of the permutation is
  /// taken.
  UserTree tree;
};

}  // namespace mfs
