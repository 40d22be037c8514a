// What a separator needs of a sparse network, such as a circuit or a grid of power lines, most of whose
// vertices have one neighbour or two: pendant trees are left out, and chains become edges (Ost, Schulz,
// Strash, "Engineering data reduction for nested dissection", ALENEX 2021, reductions of degree 1 and 2).
//
//        f   g             The skeleton: b, c and e, if each has three neighbours or more without
//        |   |             trees, with the edges b - c and c - e. a, f and g are trees, d a chain.
//    a - b - c - d - e
//       / \ / \     / \    A separator of the skeleton is one of the whole: trees and chains lie on
//                          the side of what they are joined to.
#pragma once

#include <utility>
#include <vector>

#include "ordering/subgraph.hpp"

namespace mfs {

struct Skeleton {
  /// Where a vertex of the whole is: in the chain of this number, or one of these.
  static constexpr Vertex kKept = -1, kTree = -2;

  SubGraph graph;  // its vertices are numbers of the whole
  RawVector<Vertex> place;
  std::vector<std::pair<Vertex, Vertex>> ends;     // of each chain; an edge is a chain without vertices
  std::vector<std::pair<Vertex, Vertex>> hanging;  // vertices of trees and what holds them, leaves first
  bool empty() const { return graph.size() == 0; }
};

/// Of a connected graph. Empty where it would not be much smaller, or is too small for an even cut.
Skeleton make_skeleton(const SubGraph& connected);

/// The sides of the whole by those of its skeleton. What is joined to the separator alone is on the lighter
/// one.
RawVector<idx_t> whole_part_of(const SubGraph& connected, const Skeleton& skeleton,
                               const RawVector<idx_t>& part_of);

}  // namespace mfs
