// From a matched pattern to the tree of fronts: the whole ordering phase, as its steps.
#pragma once

#include <functional>

#include <mfs/analysis_options.hpp>

#include "ordering/fronts.hpp"
#include "ordering/types.hpp"

namespace mfs {

/// Receives the fraction of the ordering that is done (0 to 1, increasing), in the thread that called.
using OrderingProgress = std::function<void(double)>;

/// Whether the caller gives the elimination order or the tree: both are kept as they are.
bool brings_order(const AnalysisOptions& options);

/// What an order costs executors of lists of products on single entries (plan/scalar_program.hpp), in
/// products: those of the factors, one for each entry in substitutions, and some for each level of either
/// (plan/level_schedule.hpp).
struct ListCost {
  Offset most_entries, most_products_of_entry;  // of lists that are executed
  Offset products_of_level;                     // that take as long as what the end of a level takes
};

/// Graph of Ahat + Ahat^T, compression, nested dissection (or minimum degree where that makes few operations,
/// or the caller's permutation or tree), amalgamation. The tree is the same for any number of threads.
/// Unknowns joined by `matched.pair` share a tree node; those in `matched.weak` may instead come later than a
/// partner of their own. With a `list`, minimum degree is taken where that list costs clearly less and the
/// pattern is nearly symmetric. `height` and `parts` are of trees that are not the caller's. Throws
/// InvalidInput (the name of an option: "permutation", "tree", "leaf_size", ...), OutOfMemory, BackendError
/// (METIS, CAMD).
SeparatorTree order_matrix(const Pattern& pattern, const MatchedScaling& matched,
                           const AnalysisOptions& options, int threads, const OrderingProgress& progress = {},
                           const ListCost* list = nullptr, TreeHeight height = TreeHeight::any,
                           Parts parts = Parts::bundled);

}  // namespace mfs
