#include "ordering/user_order.hpp"

#include <algorithm>
#include <string>

#include <mfs/error.hpp>

#include "ordering/elimination_tree.hpp"
#include "ordering/fronts.hpp"

namespace mfs {
namespace {

/// Unknown -> position.
std::vector<Vertex> checked_positions(const std::vector<std::int64_t>& permutation, Vertex n) {
  if (static_cast<Offset>(permutation.size()) != n) {
    throw InvalidInput("permutation", std::to_string(permutation.size()) + " entries for a matrix of order " +
                                          std::to_string(n));
  }
  std::vector<Vertex> position(n, -1);
  for (Vertex p = 0; p < n; ++p) {
    const std::int64_t unknown = permutation[p];
    if (unknown < 0 || unknown >= n) throw InvalidInput("permutation", "entry outside of the matrix", p);
    if (position[unknown] >= 0) {
      throw InvalidInput("permutation", "unknown " + std::to_string(unknown) + " appears twice", p);
    }
    position[unknown] = p;
  }
  return position;
}

void check_tree(const UserTree& tree, Vertex n) {
  const std::size_t nodes = tree.parent.size();
  if (tree.offsets.size() != nodes + 1) {
    throw InvalidInput("tree", std::to_string(tree.offsets.size()) + " offsets for " + std::to_string(nodes) +
                                   " nodes; one more than nodes is needed");
  }
  if (tree.offsets[0] != 0) throw InvalidInput("tree", "the first offset is not 0", 0);
  for (std::size_t k = 0; k < nodes; ++k) {
    const auto node = static_cast<std::int64_t>(k);
    if (tree.offsets[k + 1] < tree.offsets[k]) throw InvalidInput("tree", "offsets decrease", node);
    if (tree.offsets[k + 1] > n) throw InvalidInput("tree", "offset beyond the permutation", node);
    const std::int64_t parent = tree.parent[k];
    if (parent != -1 && (parent <= node || parent >= static_cast<std::int64_t>(nodes))) {
      throw InvalidInput("tree", "a parent must be a later node, or -1", node);
    }
  }
  if (tree.offsets[nodes] != n) throw InvalidInput("tree", "nodes do not hold all unknowns");
}

/// Node k is an ancestor of (or is) node j where first[k] <= j <= k, in a postorder of the nodes.
struct Ancestry {
  std::vector<Vertex> number;  // node -> place in a postorder
  std::vector<Vertex> first;   // node -> smallest place in its subtree
  bool related(Vertex a, Vertex b) const {
    return number[a] <= number[b] ? first[b] <= number[a] : first[a] <= number[b];
  }
};

/// Parents come after children, so sizes of subtrees add up in one pass; places are given from the roots
/// down.
Ancestry ancestry(const std::vector<std::int64_t>& parent) {
  const auto nodes = static_cast<Vertex>(parent.size());
  std::vector<Vertex> size(nodes, 1), next(nodes);  // next: place that the next child's subtree ends at
  for (Vertex k = 0; k < nodes; ++k) {
    if (parent[k] >= 0) size[parent[k]] += size[k];
  }
  Ancestry result;
  result.number.resize(nodes);
  result.first.resize(nodes);
  Vertex roots_end = nodes;
  for (Vertex k = nodes - 1; k >= 0; --k) {
    Vertex& end = parent[k] < 0 ? roots_end : next[parent[k]];
    result.number[k] = end - 1;
    result.first[k] = end - size[k];
    next[k] = end - 1;
    end -= size[k];
  }
  return result;
}

/// vertex -> the node that is nearest to the root among those of its unknowns.
std::vector<Vertex> nodes_of_vertices(const CompressedGraph& paired, const std::vector<Vertex>& position,
                                      const UserTree& tree) {
  std::vector<Vertex> node_of(paired.graph.n, 0);
  for (std::size_t i = 0; i < position.size(); ++i) {
    const auto found = std::upper_bound(tree.offsets.begin(), tree.offsets.end(), position[i]);
    const auto node = static_cast<Vertex>(found - tree.offsets.begin()) - 1;
    Vertex& vertex_node = node_of[paired.partition.vertex_of[i]];
    vertex_node = std::max(vertex_node, node);
  }
  return node_of;
}

void check_edges(const CompressedGraph& paired, const std::vector<Vertex>& node_of, const Ancestry& tree) {
  const Graph& graph = paired.graph;
  const auto first_unknown = [&](Vertex v) { return paired.partition.members[paired.partition.begin[v]]; };
  for (Vertex v = 0; v < graph.n; ++v) {
    for (Offset k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k) {
      const Vertex w = graph.neighbors[k];
      if (tree.related(node_of[v], node_of[w])) continue;
      throw InvalidInput("tree", "an entry of the matrix ties two unrelated branches together",
                         first_unknown(v), first_unknown(w));
    }
  }
}

/// Unknowns by node, in the caller's order within each node, without the nodes that hold none.
NodeList filled_nodes(const CompressedGraph& paired, const std::vector<Vertex>& node_of,
                      const AnalysisOptions& options) {
  const std::size_t nodes = options.tree.parent.size();
  std::vector<std::vector<Vertex>> unknowns(nodes);
  for (const std::int64_t unknown : options.permutation) {
    unknowns[node_of[paired.partition.vertex_of[unknown]]].push_back(static_cast<Vertex>(unknown));
  }
  NodeList list;
  list.node_begin.push_back(0);
  std::vector<Vertex> number(nodes, -1);
  std::vector<std::int64_t> filled_parent(options.tree.parent);
  for (std::size_t k = nodes; k-- > 0;) {  // past empty ancestors; from the roots down, so one step is enough
    const std::int64_t parent = filled_parent[k];
    if (parent >= 0 && unknowns[parent].empty()) filled_parent[k] = filled_parent[parent];
  }
  for (std::size_t k = 0; k < nodes; ++k) {
    if (unknowns[k].empty()) continue;
    number[k] = static_cast<Vertex>(list.node_begin.size()) - 1;
    list.order.insert(list.order.end(), unknowns[k].begin(), unknowns[k].end());
    list.node_begin.push_back(static_cast<Vertex>(list.order.size()));
  }
  for (std::size_t k = 0; k < nodes; ++k) {
    if (number[k] >= 0) list.parent.push_back(filled_parent[k] < 0 ? -1 : number[filled_parent[k]]);
  }
  return list;
}

}  // namespace

SeparatorTree tree_of_permutation(const CompressedGraph& paired, const AnalysisOptions& options,
                                  int threads) {
  const auto n = static_cast<Vertex>(paired.partition.vertex_of.size());
  const std::vector<Vertex> position = checked_positions(options.permutation, n);
  std::vector<Vertex> last(paired.graph.n, -1);  // position of a vertex' last unknown
  for (Vertex i = 0; i < n; ++i) {
    Vertex& vertex_last = last[paired.partition.vertex_of[i]];
    vertex_last = std::max(vertex_last, position[i]);
  }
  std::vector<Vertex> order;
  order.reserve(paired.graph.n);
  for (Vertex p = 0; p < n; ++p) {
    const Vertex v = paired.partition.vertex_of[options.permutation[p]];
    if (last[v] == p) order.push_back(v);
  }
  return breadth_first(fronts_of_order(paired.graph, paired.partition, order, threads));
}

SeparatorTree tree_of_caller(const CompressedGraph& paired, const AnalysisOptions& options) {
  const auto n = static_cast<Vertex>(paired.partition.vertex_of.size());
  const std::vector<Vertex> position = checked_positions(options.permutation, n);
  check_tree(options.tree, n);
  const std::vector<Vertex> node_of = nodes_of_vertices(paired, position, options.tree);
  check_edges(paired, node_of, ancestry(options.tree.parent));
  return breadth_first(filled_nodes(paired, node_of, options));
}

}  // namespace mfs
