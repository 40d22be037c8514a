#include "ordering/elimination_tree.hpp"

#include <utility>

namespace mfs {
namespace {

/// Liu's algorithm: each earlier neighbour climbs to the root of its tree so far; `ancestor` shortens the
/// climbs.
std::vector<Vertex> find_parents(const Graph& graph, const std::vector<Vertex>& order) {
  const std::vector<Vertex> position = inverse_permutation(order);
  std::vector<Vertex> parent(graph.n, -1), ancestor(graph.n, -1);
  for (Vertex i = 0; i < graph.n; ++i) {
    for (Offset k = graph.offsets[order[i]]; k < graph.offsets[order[i] + 1]; ++k) {
      Vertex j = position[graph.neighbors[k]];
      while (j != -1 && j < i) {
        const Vertex next = ancestor[j];
        ancestor[j] = i;
        if (next == -1) parent[j] = i;
        j = next;
      }
    }
  }
  return parent;
}

/// Positions in postorder, children in ascending order; without recursion, for trees as deep as they are
/// large.
std::vector<Vertex> postorder(const std::vector<Vertex>& parent) {
  const auto n = static_cast<Vertex>(parent.size());
  std::vector<Vertex> first_child(n, -1), next_sibling(n, -1), result, stack;
  for (Vertex j = n - 1; j >= 0; --j) {
    if (parent[j] < 0) continue;
    next_sibling[j] = first_child[parent[j]];
    first_child[parent[j]] = j;
  }
  result.reserve(n);
  for (Vertex root = 0; root < n; ++root) {
    if (parent[root] >= 0) continue;
    stack.push_back(root);
    while (!stack.empty()) {
      const Vertex child = first_child[stack.back()];
      if (child < 0) {
        result.push_back(stack.back());
        stack.pop_back();
      } else {
        first_child[stack.back()] = next_sibling[child];
        stack.push_back(child);
      }
    }
  }
  return result;
}

/// Rewrites tree and order so that positions follow `post`.
void renumber(const std::vector<Vertex>& post, EliminationTree& tree) {
  const std::vector<Vertex> position = inverse_permutation(post);
  std::vector<Vertex> order(post.size()), parent(post.size());
  for (std::size_t i = 0; i < post.size(); ++i) {
    order[i] = tree.order[post[i]];
    const Vertex old_parent = tree.parent[post[i]];
    parent[i] = old_parent < 0 ? -1 : position[old_parent];
  }
  tree.order = std::move(order);
  tree.parent = std::move(parent);
}

/// Column counts. Row i of the factor is the subtree of positions that reach i through their columns; column
/// j counts the row subtrees that hold j. Each subtree is written as +weight at its leaves, -weight where two
/// paths join and above its root; sums over subtrees then give the counts.
class ColumnCounts {
 public:
  ColumnCounts(const Graph& graph, const EliminationTree& tree)
      : graph_(graph),
        tree_(tree),
        delta_(graph.n, 0),
        first_descendant_(graph.n, -1),
        largest_first_(graph.n, -1),
        previous_leaf_(graph.n, -1),
        ancestor_(graph.n) {}

  std::vector<Vertex> run() {
    find_first_descendants();
    const std::vector<Vertex> position = inverse_permutation(tree_.order);
    for (Vertex j = 0; j < graph_.n; ++j) ancestor_[j] = j;
    for (Vertex j = 0; j < graph_.n; ++j) {
      const Vertex vertex = tree_.order[j], parent = tree_.parent[j];
      if (parent >= 0) delta_[parent] -= graph_.weight[vertex];
      for (Offset k = graph_.offsets[vertex]; k < graph_.offsets[vertex + 1]; ++k) {
        const Vertex i = position[graph_.neighbors[k]];
        if (i > j) add_leaf(i, j, graph_.weight[graph_.neighbors[k]]);
      }
      if (parent >= 0) ancestor_[j] = parent;
    }
    for (Vertex j = 0; j < graph_.n; ++j) {
      if (tree_.parent[j] >= 0) delta_[tree_.parent[j]] += delta_[j];
    }
    return std::move(delta_);
  }

 private:
  void find_first_descendants() {
    for (Vertex k = 0; k < graph_.n; ++k) {
      if (first_descendant_[k] == -1)
        delta_[k] = graph_.weight[tree_.order[k]];  // a leaf: its own row begins here
      for (Vertex j = k; j != -1 && first_descendant_[j] == -1; j = tree_.parent[j]) first_descendant_[j] = k;
    }
  }

  /// j < i is a neighbour of i; is it a leaf of i's row subtree?
  void add_leaf(Vertex i, Vertex j, Vertex weight) {
    if (first_descendant_[j] <= largest_first_[i]) return;
    largest_first_[i] = first_descendant_[j];
    delta_[j] += weight;
    const Vertex previous = std::exchange(previous_leaf_[i], j);
    if (previous >= 0) delta_[common_ancestor(previous)] -= weight;
  }

  /// Of `previous` and the position that is being done: the root of previous' set, with path compression.
  Vertex common_ancestor(Vertex previous) {
    Vertex root = previous;
    while (root != ancestor_[root]) root = ancestor_[root];
    while (previous != root) previous = std::exchange(ancestor_[previous], root);
    return root;
  }

  const Graph& graph_;
  const EliminationTree& tree_;
  std::vector<Vertex> delta_, first_descendant_, largest_first_, previous_leaf_, ancestor_;
};

}  // namespace

std::vector<Vertex> inverse_permutation(const std::vector<Vertex>& order) {
  std::vector<Vertex> position(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) position[order[i]] = static_cast<Vertex>(i);
  return position;
}

EliminationTree elimination_tree(const Graph& graph, const std::vector<Vertex>& order) {
  EliminationTree tree;
  tree.order = order;
  tree.parent = find_parents(graph, order);
  renumber(postorder(tree.parent), tree);
  tree.count = ColumnCounts(graph, tree).run();
  return tree;
}

}  // namespace mfs
