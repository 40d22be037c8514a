// Orders that the caller brings: an elimination order, or a whole separator tree.
#pragma once

#include <mfs/analysis_options.hpp>

#include "ordering/compression.hpp"
#include "ordering/types.hpp"

namespace mfs {

/// The tree of options.permutation: its elimination tree with supernodes and amalgamation, the same fill but
/// for the zeros that amalgamation adds. A pair takes the place of its later unknown. Throws
/// InvalidInput("permutation", first position that is wrong).
SeparatorTree tree_of_permutation(const CompressedGraph& paired, const AnalysisOptions& options, int threads);

/// The nodes of options.tree as they are (empty ones vanish), renumbered breadth first. A pair moves to the
/// node of the unknown that is nearer to the root. Throws InvalidInput("permutation"), InvalidInput("tree",
/// node) where offsets or parents are wrong, and InvalidInput("tree", row, column) where the matrix ties
/// unknowns of unrelated branches together.
SeparatorTree tree_of_caller(const CompressedGraph& paired, const AnalysisOptions& options);

}  // namespace mfs
