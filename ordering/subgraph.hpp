// Sub-graphs of the dissection, in the form that METIS reads, and what is done to a single one of them.
#pragma once

#include <metis.h>

#include <limits>
#include <vector>

#include "ordering/types.hpp"

namespace mfs {

struct SubGraph {
  RawVector<Vertex> vertices;  // of the whole graph, ascending
  RawVector<idx_t> offsets;    // vertices + 1
  RawVector<idx_t> neighbors;  // numbers within this sub-graph, ascending in each row
  RawVector<idx_t> weights;    // unknowns in each vertex
  Offset weight = 0;           // their sum
  Vertex size() const { return static_cast<Vertex>(vertices.size()); }
};

/// The sub-graph of all vertices that are not left out. Throws BackendError where it is too large for METIS.
SubGraph whole_graph(const Graph& graph, const std::vector<bool>& left_out, int threads);

/// part_of[v] in [0, parts) sends vertex v to a part; edges between parts are dropped, and so are vertices
/// with -1.
std::vector<SubGraph> split(const SubGraph& sub, const RawVector<idx_t>& part_of, int parts);

/// Connected components: part_of[v] in [0, large) for those heavier than `small`; all lighter ones share part
/// `large`.
struct Components {
  int large = 0;
  bool any_small = false;
};
Components find_components(const SubGraph& sub, Offset small, RawVector<idx_t>& part_of);

/// part_of[v] = 0 or 1 for the two sides, 2 for the separator.
struct Separator {
  RawVector<idx_t> part_of;
  /// Weight of the separator, times 1 + d^2 where d is the share by which the sides differ: sides of (1 + d)
  /// / 2 and (1 - d) / 2 have 1 + d^2 times the squares of halves, and operations grow with the square in
  /// three dimensions. Infinity where the separator is not worth it: a side empty or tiny, or a separator of
  /// half of the sub-graph.
  double cost = std::numeric_limits<double>::infinity();
};

/// With its cost.
Separator judged(const SubGraph& sub, RawVector<idx_t> part_of);

/// By METIS, from a seed.
Separator find_separator(const SubGraph& sub, idx_t seed, idx_t refinement);

bool is_tree(const SubGraph& connected);
/// The centroid of a tree: without it no component has more than half of the weight (Jordan, "Sur les
/// assemblages de lignes", J. reine angew. Math. 70, 1869). A component belongs to one side as a whole.
Separator tree_separator(const SubGraph& tree);

/// The vertices of `sub` in the order of constrained minimum degree. `graph` is the whole graph; its vertices
/// that are `left_out` do not count as boundary.
std::vector<Vertex> minimum_degree(const Graph& graph, const std::vector<bool>& left_out,
                                   const SubGraph& sub);

}  // namespace mfs
