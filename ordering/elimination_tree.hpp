// The elimination tree of a graph in a given order, and how many rows each column of the factor has, without
// the factor: almost linear time in the edges of the graph.
//
//   parent      the first later position that the elimination of a vertex touches (Liu 1990)
//   postorder   children just before their parent: an equivalent order, with the same fill, in which every
//               subtree is an interval
//   counts      skeleton leaves and least common ancestors (Gilbert, Ng and Peyton 1994), here with weighted
//               rows
#pragma once

#include <vector>

#include "ordering/types.hpp"

namespace mfs {

struct EliminationTree {
  std::vector<Vertex> order;   // position -> vertex, a postorder of the tree
  std::vector<Vertex> parent;  // position -> position, -1 for a root
  std::vector<Vertex> count;   // position -> unknowns in this vertex' column of the factor, its own included
};

/// position[order[i]] = i.
std::vector<Vertex> inverse_permutation(const std::vector<Vertex>& order);

/// Positions that one thread does at once.
constexpr Vertex kTreePiece = 10000;

/// `order`: position -> vertex of `graph`; any elimination order. Parts of the tree of at most `most`
/// positions are found by several threads, the same tree by any number of them.
EliminationTree elimination_tree(const Graph& graph, const std::vector<Vertex>& order, int threads,
                                 Vertex most = kTreePiece);

}  // namespace mfs
