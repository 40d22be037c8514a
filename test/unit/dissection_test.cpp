// Nested dissection and what it does to a single sub-graph.
#include "ordering/nested_dissection.hpp"

#include <gmock/gmock.h>

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>

#include "ordering/graph.hpp"
#include "ordering/subgraph.hpp"
#include "test/unit/test_matrices.hpp"

namespace mfs::test {
namespace {

using ::testing::ElementsAre;

Graph graph_of(Vertex n, const Entries& entries) {
  return build_graph(pattern_of(n, entries), {}, trivial_partition(n), 1);
}

/// n vertices on a ring, and a chord from each: nothing to leave out (ordering/skeleton.hpp).
Entries ring_with_chords(Vertex n, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::pair<Vertex, Vertex>> edges;
  for (Vertex v = 0; v < n; ++v) edges.emplace_back(v, (v + 1) % n);
  for (Vertex v = 0; v < n; ++v) {
    const Vertex w = static_cast<Vertex>(random() % static_cast<unsigned>(n));
    if (w != v) edges.emplace_back(v, w);
  }
  return symmetric(n, edges);
}

AnalysisOptions small_leaves(std::int32_t leaf_size) {
  AnalysisOptions options;
  options.leaf_size = leaf_size;
  return options;
}

TEST(SubGraph, SplitKeepsTheEdgesOfEachPart) {
  const Graph g = graph_of(6, path(6));
  const SubGraph whole = whole_graph(g, std::vector<bool>(6, false), 1);
  EXPECT_EQ(whole.weight, 6);
  const auto parts = split(whole, {0, 0, -1, 1, 1, 1}, 2);
  EXPECT_THAT(parts[0].vertices, ElementsAre(0, 1));
  EXPECT_THAT(parts[0].neighbors, ElementsAre(1, 0));
  EXPECT_THAT(parts[1].vertices, ElementsAre(3, 4, 5));
  EXPECT_THAT(parts[1].offsets, ElementsAre(0, 1, 3, 4));
  EXPECT_THAT(parts[1].neighbors, ElementsAre(1, 0, 2, 1));
  EXPECT_EQ(parts[1].weight, 3);
}

TEST(SubGraph, SmallComponentsShareAPart) {
  // Components {0, 1, 2}, {3}, {4, 5, 6}, {7, 8}.
  const Graph g = graph_of(9, symmetric(9, {{0, 1}, {1, 2}, {4, 5}, {5, 6}, {7, 8}}));
  RawVector<idx_t> part_of;
  const Components found = find_components(whole_graph(g, std::vector<bool>(9, false), 1), 2, part_of);
  EXPECT_EQ(found.large, 2);
  EXPECT_TRUE(found.any_small);
  EXPECT_THAT(part_of, ElementsAre(0, 0, 0, 2, 1, 1, 1, 2, 2));
}

TEST(SubGraph, BoundaryKeepsADegreeTrue) {
  // The path 0-1-2-3-4 without its ends: inside alone, 1 and 3 have the least degree; with their boundary all
  // three are alike, and the boundary must not show up in the order.
  const Graph g = graph_of(5, path(5));
  std::vector<bool> ends(5, false);
  const SubGraph inner = split(whole_graph(g, ends, 1), {-1, 0, 0, 0, -1}, 1)[0];
  std::vector<Vertex> order = minimum_degree(g, ends, inner);
  std::sort(order.begin(), order.end());
  EXPECT_THAT(order, ElementsAre(1, 2, 3));
}

TEST(SubGraph, ConstrainedOrderEliminatesAwayFromTheBoundary) {
  // A star's centre 0 and spokes 1, 2, 3; spokes 4 to 9 are outside. Inside, the spokes go before the centre.
  const Graph g = graph_of(10, star(10));
  std::vector<bool> none(10, false);
  const SubGraph inner = split(whole_graph(g, none, 1), {0, 0, 0, 0, -1, -1, -1, -1, -1, -1}, 1)[0];
  EXPECT_EQ(minimum_degree(g, none, inner).back(), 0);
}

TEST(SubGraph, CostOfASeparator) {
  const Graph g = graph_of(101, path(101));
  const Separator cut = find_separator(whole_graph(g, std::vector<bool>(101, false), 1), 42, 10);
  const double sides[] = {static_cast<double>(std::count(cut.part_of.begin(), cut.part_of.end(), 0)),
                          static_cast<double>(std::count(cut.part_of.begin(), cut.part_of.end(), 1))};
  ASSERT_EQ(sides[0] + sides[1], 100);
  EXPECT_DOUBLE_EQ(cut.cost, 1 + std::pow((sides[0] - sides[1]) / 100, 2));
  // Three vertices that are all joined: whatever is taken out leaves no two sides.
  const Graph triangle = graph_of(3, symmetric(3, {{0, 1}, {1, 2}, {0, 2}}));
  EXPECT_TRUE(std::isinf(find_separator(whole_graph(triangle, std::vector<bool>(3, false), 1), 42, 10).cost));
}

TEST(SubGraph, ATreeIsSeparatedByItsCentroid) {
  for (const unsigned seed : {1, 2, 3, 4, 5, 6}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const Vertex n = seed < 3 ? 2 + static_cast<Vertex>(seed) : 300;
    std::vector<std::pair<Vertex, Vertex>> edges;
    for (Vertex v = 1; v < n; ++v)  // bushy trees and long ones
      edges.emplace_back(random() % std::min<unsigned>(v, seed) + v - std::min<Vertex>(v, seed), v);
    SubGraph tree = whole_graph(graph_of(n, symmetric(n, edges)), std::vector<bool>(n, false), 1);
    tree.weight = 0;
    for (idx_t& weight : tree.weights) tree.weight += weight = 1 + static_cast<idx_t>(random() % 3);
    ASSERT_TRUE(is_tree(tree));

    const Separator cut = tree_separator(tree);
    ASSERT_EQ(std::count(cut.part_of.begin(), cut.part_of.end(), 2), 1);
    for (const auto& [v, w] : edges)
      EXPECT_TRUE(cut.part_of[v] == 2 || cut.part_of[w] == 2 || cut.part_of[v] == cut.part_of[w]);
    RawVector<idx_t> part_of = cut.part_of;
    std::replace(part_of.begin(), part_of.end(), idx_t(2), idx_t(-1));
    for (const SubGraph& side : split(tree, part_of, 2)) {
      RawVector<idx_t> component_of;
      const Components components = find_components(side, 0, component_of);
      for (const SubGraph& component : split(side, component_of, components.large))
        EXPECT_LE(2 * component.weight, tree.weight);
    }
  }
}

TEST(SubGraph, RingsAreNoTrees) {
  const Graph ring = graph_of(4, symmetric(4, {{0, 1}, {1, 2}, {2, 3}, {0, 3}}));
  EXPECT_FALSE(is_tree(whole_graph(ring, std::vector<bool>(4, false), 1)));
}

std::vector<Vertex> nested_dissection(const Graph& graph, const AnalysisOptions& options, int threads,
                                      const OrderingProgress& progress = {}) {
  return nested_dissections({&graph}, options, threads, progress).front();
}

TEST(Dissection, APathIsCutInTheMiddle) {
  const Graph g = graph_of(101, path(101));
  const auto order = nested_dissection(g, small_leaves(60), 1);
  expect_permutation(order, 101);
  EXPECT_EQ(order.back(), 50);
}

TEST(Dissection, ATreeWithOneHeavyVertexIsCutElsewhere) {
  // The first vertex has more than half of the weight, so the centroid is no separator.
  const Vertex n = 200;
  Graph g = graph_of(n, path(n));
  g.weight[0] = 250;
  const auto order = nested_dissection(g, small_leaves(30), 1);
  expect_permutation(order, n);
  EXPECT_GT(order.back(), 0);
  EXPECT_LT(order.back(), n - 1);
}

TEST(Dissection, SeparatorsSeparate) {
  // Whatever comes after the cut must be what ties both halves together: fill stays near n log n on a grid.
  const Vertex m = 40;
  const Entries entries = grid(m);
  const auto order = nested_dissection(graph_of(m * m, entries), small_leaves(20), 1);
  expect_permutation(order, m * m);
  EXPECT_LT(plain_fill(plain_graph(m * m, entries), order),
            60000u);  // natural order: 67 000 x 1; optimum near 40 000
}

TEST(Dissection, TheSameOrderForAnyNumberOfThreads) {
  const Vertex m = 90;
  const Graph g = graph_of(m * m, grid(m));
  const auto one = nested_dissection(g, small_leaves(30), 1);
  for (const int threads : {2, 4, 7}) EXPECT_EQ(nested_dissection(g, small_leaves(30), threads), one);
}

TEST(Dissection, OfSeveralGraphsAtATimeIsThatOfEach) {
  const Graph small = graph_of(400, grid(20)), large = graph_of(2500, grid(50));
  for (const int threads : {1, 3}) {
    const auto orders = nested_dissections({&large, &small, &large}, small_leaves(30), threads);
    EXPECT_THAT(orders, ::testing::ElementsAre(nested_dissection(large, small_leaves(30), 1),
                                               nested_dissection(small, small_leaves(30), 1), orders[0]));
  }
  EXPECT_TRUE(nested_dissections({}, small_leaves(30), 2).empty());
}

TEST(Dissection, TheSameOrderInAnyThread) {
  const Graph g = graph_of(2500, grid(50));
  const auto here = nested_dissection(g, small_leaves(30), 1);
  std::vector<Vertex> there;
  std::thread([&] { there = nested_dissection(g, small_leaves(30), 2); }).join();
  EXPECT_EQ(there, here);
}

TEST(Dissection, SeedAndTrialsReachMetis) {
  const Graph g = graph_of(2500, grid(50));
  AnalysisOptions options = small_leaves(30);
  options.separator_trials = 1;
  const auto first = nested_dissection(g, options, 1);
  options.seed = 7;
  EXPECT_NE(nested_dissection(g, options, 1), first);
  options.seed = AnalysisOptions().seed;
  options.separator_trials = 4;
  EXPECT_NE(nested_dissection(g, options, 1), first);
  options.seed = std::numeric_limits<std::int32_t>::max();  // the next one is the least
  expect_permutation(nested_dissection(g, options, 1), 2500);
}

TEST(Dissection, TheBestTrialIsTaken) {
  int not_the_first = 0;
  for (const unsigned seed : {1, 2, 3, 4}) {
    const Vertex n = 600;
    const Graph g = graph_of(n, ring_with_chords(n, seed));
    const SubGraph whole = whole_graph(g, std::vector<bool>(n, false), 1);
    AnalysisOptions options = small_leaves(30);
    options.separator_trials = 3;
    Separator best;
    for (int trial = 0; trial < 3; ++trial) {
      Separator found = find_separator(whole, options.seed + trial, options.separator_refinement);
      if (found.cost >= best.cost) continue;
      best = std::move(found);
      not_the_first += trial > 0;
    }
    std::vector<Vertex> separator;
    for (Vertex v = 0; v < n; ++v) {
      if (best.part_of[v] == 2) separator.push_back(v);
    }
    const auto order = nested_dissection(g, options, 4);
    EXPECT_EQ(std::vector<Vertex>(order.end() - static_cast<std::ptrdiff_t>(separator.size()), order.end()),
              separator)
        << "seed " << seed;
  }
  EXPECT_GT(not_the_first, 0) << "the test needs a graph for which the first trial is not the best";
}

TEST(Dissection, SingleVertexAndNoEdges) {
  EXPECT_THAT(nested_dissection(graph_of(1, {{{0, 0}, 1.0}}), {}, 1), ElementsAre(0));
  Entries diagonal;
  for (Vertex i = 0; i < 100000; ++i) diagonal[{i, i}] = 1.0;
  expect_permutation(nested_dissection(graph_of(100000, diagonal), {}, 2), 100000);
}

TEST(Dissection, ManySmallComponents) {
  std::vector<std::pair<Vertex, Vertex>> edges;
  const Vertex n = 30000;
  for (Vertex i = 0; i + 2 < n; i += 3) {
    edges.emplace_back(i, i + 1);
    edges.emplace_back(i + 1, i + 2);
  }
  const Entries entries = symmetric(n, edges);
  const auto order = nested_dissection(graph_of(n, entries), {}, 2);
  expect_permutation(order, n);
  EXPECT_EQ(plain_fill(plain_graph(n, entries), order),
            static_cast<std::size_t>(n / 3 * 5));  // no fill at all
}

TEST(Dissection, DenseVerticesComeLast) {
  // A path of 2000 unknowns, 2000 tied to all of them and to 2001, which is tied to half of them: the densest
  // is last.
  const Vertex n = 2002;
  Entries entries = path(2000);
  for (Vertex i = 0; i < n; ++i) {
    entries[{i, 2000}] = entries[{2000, i}] = 1.0;
    if (i % 2 == 0) entries[{i, 2001}] = entries[{2001, i}] = 1.0;
  }
  AnalysisOptions options = small_leaves(50);
  auto order = nested_dissection(graph_of(n, entries), options, 1);
  expect_permutation(order, n);
  EXPECT_THAT(std::vector<Vertex>(order.end() - 2, order.end()), ElementsAre(2001, 2000));
  options.dense_row = 1e9;  // nothing is dense any more: METIS puts the hubs into a separator
  order = nested_dissection(graph_of(n, entries), options, 1);
  expect_permutation(order, n);
}

TEST(Dissection, AllVerticesDense) {
  AnalysisOptions options;
  options.dense_row = 0.1;
  const Vertex n = 40;
  Entries entries;
  for (Vertex i = 0; i < n; ++i) {
    for (Vertex j = 0; j < n; ++j) entries[{i, j}] = 1.0;
  }
  expect_permutation(nested_dissection(graph_of(n, entries), options, 1), n);
}

TEST(Dissection, CliquesAreNotCut) {
  // No separator of a clique is worth anything: it falls back to minimum degree, whatever its size.
  const Vertex n = 300;
  Entries entries;
  for (Vertex i = 0; i < n; ++i) {
    for (Vertex j = 0; j < n; ++j) entries[{i, j}] = 1.0;
  }
  AnalysisOptions options = small_leaves(10);
  options.dense_row = 1e9;
  expect_permutation(nested_dissection(graph_of(n, entries), options, 2), n);
}

TEST(Dissection, RandomGraphsOfAllKinds) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 generator(seed);
    const Vertex n = 1 + static_cast<Vertex>(generator() % 400);
    const Graph g = graph_of(n, random_entries(generator, n, 0.2 * (1 + seed % 20), 1.0, false));
    const auto order = nested_dissection(g, small_leaves(1 + static_cast<int>(generator() % 40)), 1);
    expect_permutation(order, n);
    EXPECT_EQ(nested_dissection(g, small_leaves(1), 3), nested_dissection(g, small_leaves(1), 1));
  }
}

TEST(Dissection, ProgressRisesToOneInTheThreadThatCalled) {
  const Graph g = graph_of(14400, grid(120));
  const auto caller = std::this_thread::get_id();
  for (const int threads : {1, 3}) {
    double last = 0;
    int calls = 0;
    nested_dissection(g, small_leaves(30), threads, [&](double fraction) {
      EXPECT_EQ(std::this_thread::get_id(), caller);
      EXPECT_GE(fraction, last);
      EXPECT_LE(fraction, 1.0);
      last = fraction;
      ++calls;
    });
    if (threads == 1) {
      EXPECT_GT(calls, 50);
      EXPECT_GT(last, 0.7);
    }
  }
}

TEST(Dissection, AnExceptionOfTheCallbackComesThrough) {
  const Graph g = graph_of(14400, grid(120));
  for (const int threads : {1, 4}) {
    int calls = 0;
    const auto stop = [&](double) {
      if (++calls == 3) throw std::runtime_error("stop");
    };
    if (threads == 1) {
      EXPECT_THROW(nested_dissection(g, small_leaves(30), threads, stop), std::runtime_error);
      EXPECT_EQ(calls, 3);
    } else {
      try {
        nested_dissection(g, small_leaves(30), threads, stop);
      } catch (const std::runtime_error&) {
      }
    }
    expect_permutation(nested_dissection(g, small_leaves(30), threads), 14400);  // nothing is left behind
  }
}

}  // namespace
}  // namespace mfs::test
