#include "ordering/elimination_tree.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

#include "ordering/first_error.hpp"

namespace mfs {
namespace {

/// Positions begin ... end - 1, which one thread does by itself.
struct Piece {
  Vertex begin, end;
  Vertex size() const { return end - begin; }
};

/// Ascending pieces, in which neighbours are joined as long as they have at most `most` positions.
std::vector<Piece> joined(const std::vector<Piece>& pieces, Vertex most) {
  std::vector<Piece> result;
  for (const Piece& piece : pieces) {
    if (!result.empty() && result.back().end == piece.begin && piece.end - result.back().begin <= most) {
      result.back().end = piece.end;
    } else {
      result.push_back(piece);
    }
  }
  return result;
}

/// Ascending pieces of at most `most` positions that no edge joins to an earlier position outside. Every
/// position begins as one; it takes in those before it that its earliest neighbour asks for.
std::vector<Piece> closed_pieces(const Graph& graph, const std::vector<Vertex>& order,
                                 const std::vector<Vertex>& position, int threads, Vertex most) {
  RawVector<Vertex> earliest(order.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Vertex i = 0; i < graph.n; ++i) {
    earliest[i] = i;
    for (Offset k = graph.offsets[order[i]]; k < graph.offsets[order[i] + 1]; ++k)
      earliest[i] = std::min(earliest[i], position[graph.neighbors[k]]);
  }
  std::vector<Piece> open, closed;
  const auto close_from = [&](std::vector<Piece>::const_iterator first) {
    std::copy_if(first, open.cend(), std::back_inserter(closed),
                 [&](const Piece& piece) { return piece.size() <= most; });
  };
  for (Vertex i = 0; i < graph.n; ++i) {
    Piece grown{i, i + 1};
    auto taken = open.end();
    while (earliest[i] < grown.begin) grown.begin = (--taken)->begin;
    if (grown.size() > most) close_from(taken);
    open.erase(taken, open.end());
    open.push_back(grown);
  }
  close_from(open.begin());
  std::sort(closed.begin(), closed.end(), [](const Piece& a, const Piece& b) { return a.begin < b.begin; });
  return joined(closed, most);
}

/// What lies before each of ascending pieces, and last what is behind them.
std::vector<Piece> gaps_beside(const std::vector<Piece>& pieces, Vertex n) {
  std::vector<Piece> gaps;
  Vertex done = 0;
  for (const Piece& piece : pieces) {
    gaps.push_back({done, piece.begin});
    done = piece.end;
  }
  gaps.push_back({done, n});
  return gaps;
}

/// `inside(k)` for the pieces, by all threads; the last first, which would show if one needed another.
template <class Inside>
void for_pieces(const std::vector<Piece>& pieces, int threads, const Inside& inside) {
  FirstError error;
#pragma omp parallel for num_threads(threads) schedule(dynamic)
  for (std::size_t k = pieces.size(); k > 0; --k) error.attempt([&] { inside(k - 1); });
  error.rethrow();
}

/// Liu's algorithm: each earlier neighbour climbs to the root of its tree so far; `ancestor` shortens the
/// climbs.
std::vector<Vertex> find_parents(const Graph& graph, const std::vector<Vertex>& order, int threads,
                                 Vertex most) {
  const std::vector<Vertex> position = inverse_permutation(order);
  std::vector<Vertex> parent(graph.n, -1), ancestor(graph.n, -1);
  const auto join = [&](const Piece& piece) {
    for (Vertex i = piece.begin; i < piece.end; ++i) {
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
  };
  std::vector<Piece> pieces;
  if (threads > 1) pieces = closed_pieces(graph, order, position, threads, most);
  for_pieces(pieces, threads, [&](std::size_t k) { join(pieces[k]); });
  for (const Piece& gap : gaps_beside(pieces, graph.n)) join(gap);
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
        position_(inverse_permutation(tree.order)),
        delta_(graph.n, 0),
        size_(graph.n, 1),
        largest_first_(graph.n, -1),
        previous_leaf_(graph.n, -1),
        ancestor_(tree.parent) {}

  std::vector<Vertex> run(int threads, Vertex most) {
    measure_subtrees();
    std::vector<Piece> pieces;
    if (threads > 1) pieces = subtrees(most);
    const std::vector<Piece> gaps = gaps_beside(pieces, graph_.n);
    std::vector<std::vector<Pair>> leaving(gaps.size());  // of each piece, to rows that others have, too
    for_pieces(pieces, threads, [&](std::size_t k) {
      visit_pairs(pieces[k], [&](const Pair& pair) {
        if (pair.i < pieces[k].end) {
          add(pair);
        } else {
          leaving[k].push_back(pair);
        }
      });
    });
    ancestor_ = tree_.parent;  // shortcuts that hold at the end of a piece do not at its begin
    for (std::size_t k = 0; k < gaps.size(); ++k) {
      visit_pairs(gaps[k], [&](const Pair& pair) { add(pair); });
      for (const Pair& pair : leaving[k]) add(pair);
    }
    for (Vertex j = 0; j < graph_.n; ++j) {
      const Vertex parent = tree_.parent[j];
      if (parent >= 0) delta_[parent] += delta_[j] - graph_.weight[tree_.order[j]];
    }
    return std::move(delta_);
  }

 private:
  /// j < i is a neighbour of i, which has `weight` unknowns.
  struct Pair {
    Vertex i, j, weight;
  };

  void measure_subtrees() {
    for (Vertex j = 0; j < graph_.n; ++j) {
      if (size_[j] == 1) delta_[j] = graph_.weight[tree_.order[j]];  // a leaf: its own row begins here
      if (tree_.parent[j] >= 0) size_[tree_.parent[j]] += size_[j];
    }
  }
  Vertex first_descendant(Vertex j) const { return j - size_[j] + 1; }

  /// The largest subtrees of at most `most` positions, joined.
  std::vector<Piece> subtrees(Vertex most) const {
    std::vector<Piece> found;
    for (Vertex j = 0; j < graph_.n; ++j) {
      const Vertex parent = tree_.parent[j];
      if (size_[j] <= most && (parent < 0 || size_[parent] > most))
        found.push_back({first_descendant(j), j + 1});
    }
    return joined(found, most);
  }

  /// `visit` all pairs of neighbours of which the earlier lies in the piece, by that one.
  template <class Visit>
  void visit_pairs(const Piece& piece, const Visit& visit) const {
    for (Vertex j = piece.begin; j < piece.end; ++j) {
      const Vertex vertex = tree_.order[j];
      for (Offset k = graph_.offsets[vertex]; k < graph_.offsets[vertex + 1]; ++k) {
        const Vertex i = position_[graph_.neighbors[k]];
        if (i > j) visit(Pair{i, j, graph_.weight[graph_.neighbors[k]]});
      }
    }
  }

  /// Is j a leaf of i's row subtree? For each i pairs have to come by ascending j.
  void add(const Pair& pair) {
    const auto [i, j, weight] = pair;
    if (first_descendant(j) <= largest_first_[i]) return;
    largest_first_[i] = first_descendant(j);
    delta_[j] += weight;
    const Vertex previous = std::exchange(previous_leaf_[i], j);
    if (previous >= 0) delta_[common_ancestor(previous, j)] -= weight;
  }

  /// Of `previous` and a later position: the first ancestor that is not before it, with path compression.
  Vertex common_ancestor(Vertex previous, Vertex later) {
    Vertex common = previous;
    while (common < later) common = ancestor_[common];
    while (previous < later) previous = std::exchange(ancestor_[previous], common);
    return common;
  }

  const Graph& graph_;
  const EliminationTree& tree_;
  const std::vector<Vertex> position_;
  std::vector<Vertex> delta_, size_, largest_first_, previous_leaf_, ancestor_;
};

}  // namespace

std::vector<Vertex> inverse_permutation(const std::vector<Vertex>& order) {
  std::vector<Vertex> position(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) position[order[i]] = static_cast<Vertex>(i);
  return position;
}

EliminationTree elimination_tree(const Graph& graph, const std::vector<Vertex>& order, int threads,
                                 Vertex most) {
  EliminationTree tree;
  tree.order = order;
  tree.parent = find_parents(graph, order, threads, most);
  renumber(postorder(tree.parent), tree);
  tree.count = ColumnCounts(graph, tree).run(threads, most);
  return tree;
}

}  // namespace mfs
