// Nested dissection (George 1973): an elimination order in which a separator comes after the two parts that
// it cuts apart, found by recursive calls of METIS' vertex separator on ever smaller sub-graphs.
//
//   dense vertices        taken out first, ordered last: one row of n entries would tie everything together
//   components            a sub-graph in pieces needs no separator
//   separator             METIS' multilevel bisection (Karypis and Kumar 1998); of the uppermost sub-graphs
//   the best
//                         of several trials, which are independent tasks
//   small sub-graphs      constrained minimum degree (CAMD) with their boundary present but ordered last, so
//                         that degrees are those of the real elimination (Pellegrini, Roman and Amestoy 2000)
//
// Positions are given from the end: a sub-graph owns an interval of positions, its separator takes the last
// ones.
//
//   [ left part ......... | right part ......... | separator ]
//
// Sub-graphs are independent tasks, and METIS starts from the same seeds in each of them, so the order does
// not depend on the number of threads.
#pragma once

#include <vector>

#include <mfs/analysis_options.hpp>

#include "ordering/order_matrix.hpp"
#include "ordering/types.hpp"

namespace mfs {

/// order[position] = vertex, for each of `graphs`, which threads work on at the same time; the progress of
/// the first is told. Throws OutOfMemory, BackendError("METIS" or "CAMD"), and whatever `progress` throws.
std::vector<std::vector<Vertex>> nested_dissections(const std::vector<const Graph*>& graphs,
                                                    const AnalysisOptions& options, int threads,
                                                    const OrderingProgress& progress = {});

/// The same of one graph by minimum degree (CAMD) alone, dense vertices last: faster by far, and no worse
/// where the graph is small or its fill little.
std::vector<Vertex> minimum_degree_order(const Graph& graph, const AnalysisOptions& options);

}  // namespace mfs
