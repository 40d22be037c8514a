#include "ordering/order_matrix.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include <mfs/error.hpp>

#include "ordering/clique_tree.hpp"
#include "ordering/compression.hpp"
#include "ordering/deferral.hpp"
#include "ordering/elimination_tree.hpp"
#include "ordering/fronts.hpp"
#include "ordering/nested_dissection.hpp"
#include "ordering/user_order.hpp"

namespace mfs {
namespace {

void check_options(const AnalysisOptions& options) {
  if (options.leaf_size < 1) throw InvalidInput("leaf_size", "less than 1");
  if (options.separator_trials < 1) throw InvalidInput("separator_trials", "less than 1");
  if (options.separator_refinement < 1) throw InvalidInput("separator_refinement", "less than 1");
  if (!(options.dense_row > 0)) throw InvalidInput("dense_row", "not positive");
}

bool brings_tree(const AnalysisOptions& options) {
  return !options.tree.parent.empty() || !options.tree.offsets.empty();
}

/// Where more than this share of the vertices had to move, an order that keeps all pairs together is tried as
/// well. Measured 2026-11: kkt:24 moves 0.03 of them, kkt_UBH1 0.0001; kkt_CVXQP1_L 0.30, and moving costs
/// 0.71 of the flops of pairing; kkt_CONT_201 0.42, and 2.03.
constexpr double kManyMoved = 0.15;

/// A graph and the order in which its vertices are to be eliminated.
struct OrderedGraph {
  CompressedGraph compressed;
  std::vector<Vertex> order;
  bool by_degree = false;  // the order is that of minimum degree
};

/// Orders what is in `compressed` of all of them.
using OrderGraphs = std::function<void(const std::vector<OrderedGraph*>&, const OrderingProgress&)>;

double elimination_flops(const Graph& graph, const EliminationTree& tree) {
  double flops = 0;
  for (std::size_t p = 0; p < tree.order.size(); ++p) {
    const double weight = graph.weight[tree.order[p]], count = tree.count[p];
    flops += 2 * weight * count * (count - weight);
  }
  return flops;
}

/// Where the caller says what a leaf is, the graph is dissected.
bool has_usual_leaves(const AnalysisOptions& options) {
  return options.leaf_size == AnalysisOptions().leaf_size;
}

/// The order of minimum degree is kept where it makes at most so many operations for each unknown.
/// Dissection takes 20 to 50 us for one, as long as a hundred factorizations that make no more. Where there
/// is more to do, it saves operations of each factorization, and its tree has half of the depths
/// (docs/experiments/ordering.md).
constexpr double kFewFlops = 500;

/// Operations for each unknown.
double mean_flops(const Graph& graph, const EliminationTree& tree) {
  return elimination_flops(graph, tree) / std::accumulate(graph.weight.begin(), graph.weight.end(), 0.0);
}

/// The `count` vertices that are found first by a breadth-first search from `start`, with the edges between
/// them. Where it ends, it goes on from the next vertex.
Graph ball_around(const Graph& graph, Vertex start, Vertex count) {
  std::vector<Vertex> number(graph.n, -1), found;
  const auto find = [&](Vertex v) {
    if (number[v] >= 0 || static_cast<Vertex>(found.size()) == count) return;
    number[v] = static_cast<Vertex>(found.size());
    found.push_back(v);
  };
  std::size_t done = 0;
  for (Vertex v = start; static_cast<Vertex>(found.size()) < count; v = (v + 1) % graph.n) {
    find(v);
    for (; done < found.size(); ++done)
      for (Offset k = graph.offsets[found[done]]; k < graph.offsets[found[done] + 1]; ++k)
        find(graph.neighbors[k]);
  }
  Graph ball{count, {0}, {}, {}};
  for (const Vertex v : found) {
    const auto first = static_cast<std::ptrdiff_t>(ball.neighbors.size());
    for (Offset k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k)
      if (number[graph.neighbors[k]] >= 0) ball.neighbors.push_back(number[graph.neighbors[k]]);
    std::sort(ball.neighbors.begin() + first, ball.neighbors.end());
    ball.offsets.push_back(static_cast<Offset>(ball.neighbors.size()));
    ball.weight.push_back(graph.weight[v]);
  }
  return ball;
}

/// Whether minimum degree may make few operations, by parts of the graph that are a small part of it. They
/// make fewer than the whole does.
bool has_little_fill_nearby(const Graph& graph, const AnalysisOptions& options) {
  constexpr Vertex kBalls = 4, kBall = 2000, kLargePart = 8;
  const auto flops_around = [&](Vertex start, Vertex count) {
    const Graph ball = ball_around(graph, start, count);
    return mean_flops(ball, elimination_tree(ball, minimum_degree_order(ball, options), 1));
  };
  double mean = 0;
  for (Vertex b = 0; b < kBalls; ++b) mean += flops_around(graph.n / kBalls * b, kBall) / kBalls;
  return mean <= kFewFlops && flops_around(graph.n / 2, graph.n / kLargePart) <= kFewFlops;
}

/// Whether minimum degree is tried before dissection. It is a small part of its time for graphs with at most
/// so many neighbours of each vertex, below so few vertices the time is little, and above so many one thread
/// alone is as fast with its order.
bool tries_minimum_degree(const Graph& graph, const AnalysisOptions& options, TreeHeight height) {
  constexpr Vertex kFewVertices = 1000, kManyVertices = 20000;
  constexpr Offset kFewNeighbors = 10;
  if (!has_usual_leaves(options) || graph.n < kFewVertices ||
      static_cast<Offset>(graph.neighbors.size()) > kFewNeighbors * graph.n)
    return false;
  return graph.n <= kManyVertices || (height == TreeHeight::any && has_little_fill_nearby(graph, options));
}

/// Minimum degree goes through a long body from one end to the other, and no merges make a low tree of that.
bool is_high(const Graph& graph, const EliminationTree& tree) {
  return height_of(graph, tree) > static_cast<double>(kLowPivots) * std::log2(graph.n + 1.0);
}

/// Empty where that makes more, or a high tree where a low one is asked for.
std::vector<Vertex> cheap_order(const Graph& graph, const AnalysisOptions& options, TreeHeight height,
                                int threads) {
  if (!tries_minimum_degree(graph, options, height)) return {};
  std::vector<Vertex> order = minimum_degree_order(graph, options);
  const EliminationTree tree = elimination_tree(graph, order, threads);
  const bool cheap = mean_flops(graph, tree) <= kFewFlops;
  if (!cheap || (height == TreeHeight::low && is_high(graph, tree))) order.clear();
  return order;
}

void order_for_fronts(const std::vector<OrderedGraph*>& all, const AnalysisOptions& options,
                      TreeHeight height, int threads, const OrderingProgress& progress) {
  std::vector<OrderedGraph*> left;
  for (OrderedGraph* const one : all) {
    one->order = cheap_order(one->compressed.graph, options, height, threads);
    one->by_degree = !one->order.empty();
    if (!one->by_degree) left.push_back(one);
  }
  std::vector<const Graph*> graphs;
  for (const OrderedGraph* const one : left) graphs.push_back(&one->compressed.graph);
  if (!graphs.empty()) {
    std::vector<std::vector<Vertex>> orders = nested_dissections(graphs, options, threads, progress);
    for (std::size_t i = 0; i < left.size(); ++i) left[i]->order = std::move(orders[i]);
  }
  if (progress) progress(1.0);
}

/// What the ordering reads of `matched`, with only those pairs in which both diagonals are weak.
MatchedScaling part_pairs(const MatchedScaling& matched) {
  MatchedScaling parted;
  parted.row_order = matched.row_order;
  parted.pair = matched.pair;
  for (const Vertex i : matched.weak.unknown) {
    parted.pair[matched.pair[i]] = matched.pair[i];
    parted.pair[i] = i;
  }
  return parted;
}

/// Pairs are parted where the order serves the weak unknown all the same: the fill is then that of the
/// symmetric pattern, while compressed pairs share all neighbours of both. Where many may have to move, many
/// threads find both orders at a time: one dissection leaves most of them idle.
OrderedGraph order_compressed(const Pattern& pattern, const MatchedScaling& matched, int threads,
                              const OrderGraphs& order_graphs, const OrderingProgress& progress) {
  constexpr int kManyThreads = 8;
  const auto compressed = [&](const MatchedScaling& joined) {
    return OrderedGraph{compressed_graph(pattern, joined, threads), {}};
  };
  if (matched.weak.unknown.empty()) {
    OrderedGraph paired = compressed(matched);
    order_graphs({&paired}, progress);
    return paired;
  }
  OrderedGraph parted = compressed(part_pairs(matched)), paired;
  const double many = kManyMoved * parted.compressed.graph.n;
  const bool both = threads >= kManyThreads && static_cast<double>(matched.weak.unknown.size()) > many;
  std::vector<OrderedGraph*> at_once{&parted};
  if (both) {
    paired = compressed(matched);
    at_once.push_back(&paired);
  }
  order_graphs(at_once, progress);
  Deferral deferral = defer_weak_unknowns(matched.weak, parted.compressed.partition, parted.order);
  parted.order = std::move(deferral.order);
  if (deferral.moved <= many) return parted;
  if (!both) {
    paired = compressed(matched);
    order_graphs({&paired}, {});
  }
  const auto flops_of = [&](const OrderedGraph& ordered) {
    const Graph& graph = ordered.compressed.graph;
    return elimination_flops(graph, elimination_tree(graph, ordered.order, threads));
  };
  return flops_of(paired) < flops_of(parted) ? paired : parted;
}

SeparatorTree tree_of(const OrderedGraph& ordered, int threads, TreeHeight height = TreeHeight::any,
                      Parts parts = Parts::bundled) {
  return breadth_first(fronts_of_order(ordered.compressed.graph, ordered.compressed.partition, ordered.order,
                                       threads, height, parts));
}

/// The order of minimum degree, with the levels of the lowest tree that has its fill.
std::vector<Vertex> order_for_list(const Graph& graph, const AnalysisOptions& options, const ListCost& list) {
  std::vector<Vertex> order = minimum_degree_order(graph, options);
  const EliminationTree tree = elimination_tree(graph, order, 1);
  const Offset entries = std::accumulate(tree.count.begin(), tree.count.end(), Offset(0));
  return entries > list.most_entries ? order : order_from_middle(graph, tree);
}

/// Whether nine of ten entries of Ahat have a mirror image. `graph`: of the unknowns. Without them a list is
/// shorter than the graph says, by how much depends on the order.
bool is_mirrored(const Pattern& pattern, const MatchedScaling& matched, const Graph& graph) {
  Offset off_diagonal = pattern.nnz();
  for (Vertex i = 0; i < pattern.n; ++i) {
    const Vertex row = matched.row_order.empty() ? i : matched.row_order[i];
    const auto columns = pattern.columns.begin();
    off_diagonal -= std::binary_search(columns + pattern.offsets[row], columns + pattern.offsets[row + 1], i);
  }
  return 10 * off_diagonal >= 9 * static_cast<Offset>(graph.neighbors.size());
}

/// Exact for pivots on the diagonal of Ahat where its pattern is symmetric. `graph`: of the unknowns. A
/// column waits for those below it in the tree, so there are as many levels as unknowns on the longest path.
Offset cost_of(const Graph& graph, const SeparatorTree& ordered, const ListCost& list) {
  const EliminationTree tree = elimination_tree(graph, ordered.order, 1);
  Offset products = 0, entries = 0;
  for (const Offset count : tree.count) {
    products += (count - 1) * (count - 1);
    entries += 2 * count - 1;
  }
  if (entries > list.most_entries || products > list.most_products_of_entry * entries)
    return std::numeric_limits<Offset>::max();
  constexpr Offset kSweeps = 3;  // factors, forward and backward substitution
  return products + entries + list.products_of_level * kSweeps * height_of(graph, tree);
}

/// Hundredths by which another order must cost less: a product takes more or less time, by how many are taken
/// together and what the cache has. chain:400 was not faster with 8 % fewer (2-core Xeon, 2026-11-26).
constexpr Offset kWorthwhile = 10;

/// Where there are few entries and several leaves, as one has the order of minimum degree as it is. Where the
/// whole graph has it, another root of its tree saves no products.
bool tries_list(const Pattern& pattern, const OrderedGraph& usual, const AnalysisOptions& options,
                const ListCost& list) {
  return has_usual_leaves(options) && pattern.n > options.leaf_size && pattern.nnz() <= list.most_entries &&
         (!usual.by_degree || list.products_of_level > 0);
}

SeparatorTree cheaper_for(const ListCost& list, SeparatorTree usual, const Pattern& pattern,
                          const MatchedScaling& matched, const AnalysisOptions& options, int threads) {
  const Graph graph = build_graph(pattern, matched.row_order, trivial_partition(pattern.n), threads);
  if (!is_mirrored(pattern, matched, graph)) return usual;
  const OrderGraphs by_degree = [&](const std::vector<OrderedGraph*>& all, const OrderingProgress&) {
    for (OrderedGraph* const one : all) one->order = order_for_list(one->compressed.graph, options, list);
  };
  SeparatorTree other = tree_of(order_compressed(pattern, matched, threads, by_degree, {}), threads);
  const Offset before = cost_of(graph, usual, list), now = cost_of(graph, other, list);
  return now < before - before / 100 * kWorthwhile ? std::move(other) : std::move(usual);
}

}  // namespace

bool brings_order(const AnalysisOptions& options) {
  return brings_tree(options) || !options.permutation.empty();
}

SeparatorTree order_matrix(const Pattern& pattern, const MatchedScaling& matched,
                           const AnalysisOptions& options, int threads, const OrderingProgress& progress,
                           const ListCost* list, TreeHeight height, Parts parts) {
  check_options(options);
  if (brings_tree(options)) return tree_of_caller(paired_graph(pattern, matched, threads), options);
  if (!options.permutation.empty())
    return tree_of_permutation(paired_graph(pattern, matched, threads), options, threads);

  const OrderGraphs usually = [&](const std::vector<OrderedGraph*>& all, const OrderingProgress& of_all) {
    order_for_fronts(all, options, height, threads, of_all);
  };
  const OrderedGraph usual = order_compressed(pattern, matched, threads, usually, progress);
  SeparatorTree tree = tree_of(usual, threads, height, parts);
  if (!list || !tries_list(pattern, usual, options, *list)) return tree;
  return cheaper_for(*list, std::move(tree), pattern, matched, options, threads);
}

}  // namespace mfs
