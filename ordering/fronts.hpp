// From an elimination order to fronts of a useful size.
//
//   fundamental supernodes   chains of vertices whose columns have the same structure
//   amalgamation             a child is merged into its parent where that costs few explicit zeros (Ashcraft
//                            and Grimes 1989; the limits are those of CHOLMOD), or less time than its
//                            contribution block
//   a low tree               fronts on long paths are merged, too, where each depth takes time of its own
//   bundles                  many tiny siblings with the same border share a front
//   breadth first            deepest depth first, siblings together
#pragma once

#include <vector>

#include "ordering/graph.hpp"
#include "ordering/types.hpp"

namespace mfs {

/// Nodes in any order with children before parents, each with its unknowns in elimination order; no node is
/// empty.
struct NodeList {
  std::vector<Vertex> order;       // unknowns, node after node
  std::vector<Vertex> node_begin;  // nodes + 1
  std::vector<Vertex> parent;      // nodes, -1 for a root
};

/// The nodes in the order in which they are visited, each after its children.
SeparatorTree in_order(const NodeList& nodes, const std::vector<Vertex>& visit);

/// Renumbers the nodes breadth first: deepest depth first, siblings together, roots last.
SeparatorTree breadth_first(const NodeList& nodes);

/// What executors ask of a tree. One thread is as fast with any. Threads that share the work ask for subtrees
/// of even size. Where one depth is done after the other, as devices do, each takes some microseconds,
/// however little is done in it: a low tree has fewer depths, and some more zeros.
enum class TreeHeight { any, even, low };

/// Fronts that are merged for a low tree have at most so many pivots together.
constexpr Offset kLowPivots = 32;

/// Whether parts of a graph between which there are no edges may share fronts.
enum class Parts { bundled, apart };

/// The fronts of the vertices of `graph` eliminated in `order`, with the unknowns of `partition` in them.
NodeList fronts_of_order(const Graph& graph, const Partition& partition, const std::vector<Vertex>& order,
                         int threads, TreeHeight height = TreeHeight::any, Parts parts = Parts::bundled);

}  // namespace mfs
