#include "ordering/clique_tree.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace mfs {
namespace {

/// Column k of the factor: the positions after k that the elimination of its vertex touches.
struct Columns {
  std::vector<Offset> begin;  // positions + 1
  std::vector<Vertex> rows;
};

Columns columns_of(const Graph& graph, const EliminationTree& tree) {
  const std::vector<Vertex> position = inverse_permutation(tree.order);
  std::vector<Vertex> last(position.size(), -1), next_child(position.size(), -1), first_child = next_child;
  Columns columns{{0}, {}};
  for (Vertex k = 0; k < graph.n; ++k) {
    const auto add = [&](Vertex row) {
      if (row > k && std::exchange(last[row], k) != k) columns.rows.push_back(row);
    };
    const Vertex vertex = tree.order[k];
    for (Offset e = graph.offsets[vertex]; e < graph.offsets[vertex + 1]; ++e)
      add(position[graph.neighbors[e]]);
    for (Vertex child = first_child[k]; child >= 0; child = next_child[child]) {
      for (Offset e = columns.begin[child]; e < columns.begin[child + 1]; ++e) add(columns.rows[e]);
    }
    columns.begin.push_back(static_cast<Offset>(columns.rows.size()));
    if (tree.parent[k] >= 0) next_child[k] = std::exchange(first_child[tree.parent[k]], k);
  }
  return columns;
}

/// A maximal clique: the position `first` with its column. Positions up to `last` are in no other that is
/// nearer to the root.
struct Clique {
  Vertex first, last;
  Vertex parent = -1;             // clique, -1 for a root
  Vertex weight = 0, shared = 0;  // unknowns; those that the parent has, too
};

class CliqueTree {
 public:
  CliqueTree(const Graph& graph, const EliminationTree& tree)
      : tree_(tree), columns_(columns_of(graph, tree)) {
    find_cliques(graph);
    below_.assign(cliques_.size(), 0);
    children_.resize(cliques_.size());
    for (const Vertex c : by_last_) {
      const Clique& clique = cliques_[c];
      for (const Vertex child : children_[c]) below_[c] = std::max(below_[c], rise(child));
      if (clique.parent >= 0) children_[clique.parent].push_back(c);
    }
  }

  std::vector<Vertex> order() {
    for (const Vertex c : by_last_) {
      if (cliques_[c].parent < 0) roots_.push_back(c);
    }
    for (Vertex& root : roots_) root = moved_to_middle(root);
    return order_from_roots();
  }

 private:
  /// A column that has one unknown less than that of a child, which is eliminated, is the rest of its clique.
  void find_cliques(const Graph& graph) {
    const auto n = static_cast<std::size_t>(graph.n);
    std::vector<Vertex> clique_of(n, -1);
    for (Vertex k = 0; k < graph.n; ++k) {
      if (clique_of[k] < 0) {
        clique_of[k] = static_cast<Vertex>(cliques_.size());
        cliques_.push_back({k, k});
        cliques_.back().weight = tree_.count[k];
      }
      Clique& clique = cliques_[clique_of[k]];
      clique.last = k;
      const Vertex parent = tree_.parent[k], left = tree_.count[k] - graph.weight[tree_.order[k]];
      const bool ends = parent < 0 || left != tree_.count[parent] || clique_of[parent] >= 0;
      if (!ends) clique_of[parent] = clique_of[k];
      if (ends) clique.shared = left;
      if (ends) by_last_.push_back(clique_of[k]);
    }
    for (Clique& clique : cliques_) {
      if (tree_.parent[clique.last] >= 0) clique.parent = clique_of[tree_.parent[clique.last]];
    }
  }
  /// Unknowns on the longest path from a leaf through this clique to the next one.
  Vertex rise(Vertex c) const { return cliques_[c].weight - cliques_[c].shared + below_[c]; }

  /// Goes from the root into the highest subtree as long as the tree becomes lower, and turns the edges.
  Vertex moved_to_middle(Vertex root) {
    Vertex former = -1, behind = 0;  // the clique above, and the rise through it
    for (;;) {
      Vertex highest = -1, second = behind;
      for (const Vertex child : children_[root]) {
        if (child == former) continue;
        if (highest < 0 || rise(child) > rise(highest)) {
          if (highest >= 0) second = std::max(second, rise(highest));
          highest = child;
        } else {
          second = std::max(second, rise(child));
        }
      }
      if (highest < 0) return root;
      const Clique& next = cliques_[highest];
      const Vertex turned = cliques_[root].weight - next.shared + second;
      const Vertex now = cliques_[root].weight + std::max(rise(highest), behind);
      if (next.weight + std::max(below_[highest], turned) >= now) return root;
      turn_edge(root, highest);
      behind = turned;
      former = std::exchange(root, highest);
    }
  }
  void turn_edge(Vertex from, Vertex to) {
    cliques_[from].parent = to;
    cliques_[to].parent = -1;
    children_[to].push_back(from);
  }

  /// A vertex is eliminated with the clique nearest to the root that has it, after all cliques below.
  std::vector<Vertex> order_from_roots() {
    std::vector<Vertex> order;
    std::vector<char> placed(tree_.order.size(), 0);
    std::vector<Vertex> own;
    while (!roots_.empty()) {
      const Vertex c = roots_.back();
      roots_.pop_back();
      const Vertex first = cliques_[c].first;
      own.assign(columns_.rows.begin() + columns_.begin[first],
                 columns_.rows.begin() + columns_.begin[first + 1]);
      own.push_back(first);
      std::sort(own.rbegin(), own.rend());
      for (const Vertex position : own) {
        if (!std::exchange(placed[position], 1)) order.push_back(tree_.order[position]);
      }
      for (const Vertex child : children_[c]) {
        if (cliques_[child].parent == c) roots_.push_back(child);
      }
    }
    std::reverse(order.begin(), order.end());
    return order;
  }

  const EliminationTree& tree_;
  const Columns columns_;
  std::vector<Clique> cliques_;
  std::vector<Vertex> by_last_;                // children before parents
  std::vector<std::vector<Vertex>> children_;  // and former ones, whose parent is another one
  std::vector<Vertex> below_;                  // the highest rise of a child
  std::vector<Vertex> roots_;
};

}  // namespace

Vertex height_of(const Graph& graph, const EliminationTree& tree) {
  std::vector<Vertex> height(tree.order.size());
  Vertex most = 0;
  for (Vertex k = 0; k < graph.n; ++k) {
    height[k] += graph.weight[tree.order[k]];
    most = std::max(most, height[k]);
    if (tree.parent[k] >= 0) height[tree.parent[k]] = std::max(height[tree.parent[k]], height[k]);
  }
  return most;
}

std::vector<Vertex> order_from_middle(const Graph& graph, const EliminationTree& tree) {
  return CliqueTree(graph, tree).order();
}

}  // namespace mfs
