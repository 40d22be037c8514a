// The undirected graph that is dissected: an edge between two vertices where Ahat + Ahat^T has an entry
// between their unknowns.
//
// A vertex stands for one unknown or for several. Which ones, a Partition says; merging unknowns that are not
// alike is allowed (the edges of a vertex are those of all its unknowns), so a partition is never wrong, only
// good or bad.
#pragma once

#include <vector>

#include "ordering/types.hpp"

namespace mfs {

/// Unknowns (or finer vertices) grouped into vertices. Vertices are numbered by their first member.
struct Partition {
  std::vector<Vertex> vertex_of;  // members: the vertex that holds it
  std::vector<Vertex> begin;      // vertices + 1
  std::vector<Vertex> members;    // vertex v holds members[begin[v]] ... members[begin[v + 1] - 1], ascending
  Vertex num_vertices() const { return static_cast<Vertex>(begin.size()) - 1; }
};

/// Groups by leader: leader[i] <= i is the first member of i's group (leader[i] == i for the leader itself).
Partition partition_by_leader(const std::vector<Vertex>& leader);

/// Each unknown on its own.
Partition trivial_partition(Vertex n);

/// The partition of the unknowns that `coarse` makes of the vertices of `fine`.
Partition compose(const Partition& fine, const Partition& coarse);

/// The graph of Ahat + Ahat^T with the vertices of `partition`, where row i of Ahat is row row_order[i] of A
/// (empty: the identity). Linear time but for a binary search per edge; the same result for any number of
/// threads.
Graph build_graph(const Pattern& pattern, const std::vector<Vertex>& row_order, const Partition& partition,
                  int threads);

/// `graph` with its vertices merged as `partition` says.
Graph merge_vertices(const Graph& graph, const Partition& partition, int threads);

}  // namespace mfs
