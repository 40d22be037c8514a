// An equivalent elimination order with a lower tree. Once the fill of an order is added, the graph is
// chordal: each vertex that is eliminated leaves a clique. The maximal cliques form a tree, of which every
// edge stands for the vertices that both cliques have (Lewis, Peyton and Pothen 1989). Eliminated from the
// leaves to any root, it makes the same fill or less. Minimum degree goes through a long body from one end to
// the other:
//
//   1 - 2 - 3 - 4 - 5 - 6 - 7        root 7, height 7          from the middle:  1 - 2 - 3 - 4 - 5 - 6 - 7
//   ----------------------->                                                     --------->     <---------
//
// So the root goes where the tree is lowest, which gives those who work on one system together about half of
// the steps that come one after another.
#pragma once

#include <vector>

#include "ordering/elimination_tree.hpp"
#include "ordering/types.hpp"

namespace mfs {

/// Unknowns on the longest path of the tree.
Vertex height_of(const Graph& graph, const EliminationTree& tree);

/// position -> vertex: an order with no more fill, for each tree of the forest from the best root of its
/// cliques. `tree` is that of `graph`. Time and memory are those of the factor of the graph.
std::vector<Vertex> order_from_middle(const Graph& graph, const EliminationTree& tree);

}  // namespace mfs
