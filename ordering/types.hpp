// Types and glossary of the host side: what is computed once per pattern, without Kokkos.
//
// Glossary (each word means the same in every file of MFS):
//   unknown             a row and the column that is eliminated with it
//   vertex              a node of a graph: one unknown, or several that were compressed
//   separator           vertices whose removal cuts a sub-graph in two
//   separator tree      separators as parents of the sub-graphs that they cut; leaves are small sub-graphs
//   depth               distance of a tree node from its root (root: 0)
//   front               dense matrix of one tree node: its pivots (rows and columns eliminated there), then
//                       its border (rows and columns of ancestors that the elimination changes)
//
//                          pivots   border
//                        +--------+--------+
//                 pivots |   P    |   U    |   P: pivot block    U: row block
//                        +--------+--------+
//                 border |   L    |   C    |   L: column block   C: contribution block
//                        +--------+--------+
//
//   assemble            original entries and the children's contribution blocks are added into a front
//   extend-add          adding a child's contribution block into the rows and columns of its parent's front
//   variable factor     P = L_P U_P with row interchanges inside P, then L U_P^-1 and L_P^-1 U
//   variable update     C -= L U
//   position            place of an unknown in the elimination order
//   segment             fronts of one depth that a device takes as one, where not all factors fit its memory
#pragma once

#include <cstdint>
#include <vector>

#include "ordering/raw_vector.hpp"

namespace mfs {

using Vertex = std::int32_t;  // vertices, unknowns, positions, fronts: at most 2^31 - 1
using Offset = std::int64_t;  // everything that counts entries

/// The checked pattern of a square matrix: columns sorted and unique in each row.
struct Pattern {
  Vertex n = 0;
  std::vector<Offset> offsets;  // n + 1
  RawVector<Vertex> columns;    // offsets[n]
  /// Where entry k of the caller's matrix went: slot_of_entry[k] indexes `columns`. Empty when the caller's
  /// rows were sorted and unique already (then entry k is slot k).
  std::vector<Offset> slot_of_entry;
  Offset num_entries = 0;  // of the caller's matrix, duplicates counted

  Offset nnz() const { return offsets.empty() ? 0 : offsets.back(); }
};

/// An undirected graph without self-loops, each edge stored at both ends.
struct Graph {
  Vertex n = 0;
  std::vector<Offset> offsets;    // n + 1
  std::vector<Vertex> neighbors;  // offsets[n], sorted in each row
  std::vector<Vertex> weight;     // n: unknowns in this vertex
};

/// Unknowns with a weak diagonal, each with those of good diagonal that could give it a pivot by being
/// eliminated before it: partner[begin[k]] ... partner[begin[k + 1] - 1] for unknown[k], first its mate in
/// the matching. No two have the same mate.
struct WeakUnknowns {
  std::vector<Vertex> unknown;
  std::vector<Offset> begin;  // unknown.size() + 1
  std::vector<Vertex> partner;
};

/// How the caller's matrix A becomes the matrix that is factored:
///   Ahat = Q^-1 Dr A Dc,   row i of Ahat = row_order[i] of A, scaled by row_scale[row_order[i]].
struct MatchedScaling {
  std::vector<double> row_scale;     // n, by row of A
  std::vector<double> column_scale;  // n
  std::vector<Vertex> row_order;     // n, or empty for the identity
  /// pair[i] = the unknown that must be eliminated in the same pivot block as i, i itself for none, or empty.
  /// Chains of more than two are allowed: i, pair[i], pair[pair[i]], ... form one cycle.
  std::vector<Vertex> pair;
  /// Those of the pairs in which only one diagonal is weak: the pair may be parted if that one comes later.
  WeakUnknowns weak;
  bool matched = false;
  /// Scales under which matched entries are near 1 are no doubles: some matched entry stayed far below 1, and
  /// a small pivot says nothing about the matrix.
  bool beyond_range = false;
};

/// A tree of pivot sets over the unknowns, breadth first: nodes of the deepest depth come first, siblings lie
/// together, children before parents.
///
///   node_begin   0        p1       p2   ...            n
///   order       [ node 0 | node 1 | ...  | root        ]
struct SeparatorTree {
  std::vector<Vertex> order;       // n: position -> unknown
  std::vector<Vertex> node_begin;  // nodes + 1
  std::vector<Vertex> parent;      // nodes; -1 for a root
  Vertex num_nodes() const { return static_cast<Vertex>(parent.size()); }
};

}  // namespace mfs
