// The whole ordering phase: from a matrix to its tree.
#include "ordering/order_matrix.hpp"

#include <gmock/gmock.h>

#include <limits>
#include <numeric>
#include <random>

#include <mfs/error.hpp>

#include "ordering/matching.hpp"
#include "test/unit/test_matrices.hpp"

namespace mfs::test {
namespace {

using ::testing::ElementsAre;

struct Ordered {
  MatchedScaling matched;
  SeparatorTree tree;
};

Ordered order(Vertex n, const Entries& entries, const AnalysisOptions& options = {}, int threads = 1,
              const ListCost* list = nullptr) {
  const Matrix<double> a = matrix_of(n, entries);
  const Pattern pattern = check_pattern(a.view(), 1);
  Ordered result;
  result.matched = match_and_scale(pattern, a.values.data(), options, threads);
  result.tree = order_matrix(pattern, result.matched, options, threads, {}, list);
  return result;
}

void expect_equal(const SeparatorTree& a, const SeparatorTree& b) {
  EXPECT_EQ(a.order, b.order);
  EXPECT_EQ(a.node_begin, b.node_begin);
  EXPECT_EQ(a.parent, b.parent);
}

TEST(OrderMatrix, OneUnknown) {
  const Ordered o = order(1, {{{0, 0}, 2.0}});
  EXPECT_THAT(o.tree.order, ElementsAre(0));
  EXPECT_THAT(o.tree.node_begin, ElementsAre(0, 1));
  EXPECT_THAT(o.tree.parent, ElementsAre(-1));
}

TEST(OrderMatrix, UnknownsOfANodeStayTogether) {
  AnalysisOptions options;
  options.leaf_size = 30;
  const Entries entries = grid(12, 3);
  const Ordered o = order(432, entries, options);
  expect_valid_tree(o.tree, plain_graph(432, entries));
  for (Vertex p = 0; p < 432; p += 3) EXPECT_EQ(o.tree.order[p] / 3, o.tree.order[p + 2] / 3);
}

TEST(OrderMatrix, DisconnectedMatricesHaveSeveralRoots) {
  // Two grids that know nothing of each other.
  Entries entries = grid(15);
  for (const auto& [place, value] : grid(15)) entries[{place.first + 225, place.second + 225}] = value;
  const Ordered o = order(450, entries);
  expect_valid_tree(o.tree, plain_graph(450, entries));
  EXPECT_EQ(std::count(o.tree.parent.begin(), o.tree.parent.end(), -1), 2);
}

TEST(OrderMatrix, ADiagonalMatrixIsShallow) {
  const Vertex n = 100000;
  Entries entries;
  for (Vertex i = 0; i < n; ++i) entries[{i, i}] = 1.0 + i;
  const Ordered o = order(n, entries, {}, 2);
  expect_permutation(o.tree.order, n);
  EXPECT_EQ(o.tree.num_nodes(), n / 16);
  for (const Vertex parent : o.tree.parent) EXPECT_EQ(parent, -1);
}

TEST(OrderMatrix, AnArrowHasItsHeadAtTheRoot) {
  const Vertex n = 20000;
  const Ordered o = order(n, star(n));
  expect_valid_tree(o.tree, plain_graph(n, star(n)));
  EXPECT_EQ(
      std::count(o.tree.order.begin() + o.tree.node_begin[o.tree.num_nodes() - 1], o.tree.order.end(), 0), 1);
}

/// A grid with a multiplier on every unknown of a multiple of `stride`, coupled to the next unknown as well.
Entries constrained_grid(Vertex m, Vertex stride) {
  Entries entries = grid(m);
  Vertex n = m * m;
  for (Vertex i = 0; i + 1 < m * m; i += stride, ++n) {
    entries[{i, n}] = entries[{n, i}] = 1.0;
    entries[{i + 1, n}] = entries[{n, i + 1}] = -1.0;
  }
  return entries;
}

TEST(OrderMatrix, MultipliersComeAfterAPartner) {
  for (const Vertex stride : {1, 2, 7}) {
    SCOPED_TRACE("every " + std::to_string(stride));
    const Vertex m = 20;
    const Entries entries = constrained_grid(m, stride);
    const Vertex n = entries.rbegin()->first.first + 1;
    AnalysisOptions options;
    options.leaf_size = 20;
    const Ordered o = order(n, entries, options);
    expect_valid_tree(o.tree, plain_graph(n, entries));
    ASSERT_EQ(static_cast<Vertex>(o.matched.weak.unknown.size()), n - m * m);
    std::vector<Vertex> node_of(n);
    for (Vertex k = 0; k < o.tree.num_nodes(); ++k) {
      for (Vertex p = o.tree.node_begin[k]; p < o.tree.node_begin[k + 1]; ++p) node_of[o.tree.order[p]] = k;
    }
    bool paired = true;
    for (Vertex i = 0; i < n; ++i) paired = paired && node_of[i] == node_of[o.matched.pair[i]];
    EXPECT_TRUE(paired || all_served(o.matched.weak, o.tree.order));
  }
}

TEST(OrderMatrix, PairsShareAFrontWhereBothDiagonalsAreWeak) {
  // A grid of which every seventh row of unknowns is tied to another by a pair of zero diagonals.
  const Vertex m = 20;
  Entries entries = grid(m);
  for (Vertex i = 0; i + 1 < m * m; i += 14) {
    entries.erase({i, i});
    entries.erase({i + 1, i + 1});
    entries[{i, i + 1}] = entries[{i + 1, i}] = 8.0;
  }
  AnalysisOptions options;
  options.leaf_size = 20;
  const Ordered o = order(m * m, entries, options);
  ASSERT_FALSE(o.matched.pair.empty());
  EXPECT_TRUE(o.matched.weak.unknown.empty());
  for (Vertex k = 0; k < o.tree.num_nodes(); ++k) {
    const auto first = o.tree.order.begin() + o.tree.node_begin[k],
               last = o.tree.order.begin() + o.tree.node_begin[k + 1];
    for (auto i = first; i != last; ++i) EXPECT_NE(std::find(first, last, o.matched.pair[*i]), last);
  }
}

/// A grid of m x m x m points, each joined to its six neighbours.
Entries cube(Vertex m) {
  std::vector<std::pair<Vertex, Vertex>> edges;
  for (Vertex v = 0; v < m * m * m; ++v) {
    if (v % m + 1 < m) edges.emplace_back(v, v + 1);
    if (v / m % m + 1 < m) edges.emplace_back(v, v + m);
    if (v / (m * m) + 1 < m) edges.emplace_back(v, v + m * m);
  }
  return symmetric(m * m * m, edges);
}

// In regular meshes a separator is found again, by fewer trials than threads may have tried.
TEST(OrderMatrix, TheSameTreeForAnyNumberOfThreads) {
  AnalysisOptions options;
  options.leaf_size = 40;
  const auto expect_same = [&](Vertex n, const Entries& entries) {
    const Ordered one = order(n, entries, options, 1);
    for (const int threads : {2, 3, 4}) expect_equal(order(n, entries, options, threads).tree, one.tree);
  };
  expect_same(7200, grid(60, 2));
  for (const Vertex edge : {9, 10, 13}) expect_same(edge * edge * edge, cube(edge));
}

// Most multipliers have to move, so with and without their partners are ordered: many threads do it at a
// time.
TEST(OrderMatrix, TheSameTreeHoweverManyThreadsTryBothOrders) {
  for (const Vertex stride : {1, 2}) {
    const Entries entries = constrained_grid(40, stride);
    const Vertex n = entries.rbegin()->first.first + 1;
    AnalysisOptions options;
    options.leaf_size = 20;
    const Ordered one = order(n, entries, options, 1);
    ASSERT_GT(one.matched.weak.unknown.size(), static_cast<std::size_t>(n) / 6);
    for (const int threads : {7, 8, 16}) expect_equal(order(n, entries, options, threads).tree, one.tree);
  }
}

TEST(OrderMatrix, RandomMatricesGiveValidTrees) {
  for (unsigned seed = 0; seed < 150; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 generator(seed);
    const Vertex n = 1 + static_cast<Vertex>(generator() % 300);
    Entries entries = random_entries(generator, n, 0.2 * (1 + seed % 15), 0.7, seed % 3 == 0);
    std::vector<Vertex> hidden(
        n);  // some permutation without zeros, so that nothing is structurally singular
    std::iota(hidden.begin(), hidden.end(), 0);
    if (seed % 2 == 0) std::shuffle(hidden.begin(), hidden.end(), generator);
    for (Vertex i = 0; i < n; ++i) entries[{hidden[i], i}] = 1.0;
    AnalysisOptions options;
    options.leaf_size = 1 + static_cast<Vertex>(generator() % 60);
    const Ordered o = order(n, entries, options, 1 + seed % 3);
    expect_valid_tree(o.tree, plain_graph(n, entries, o.matched.row_order));
  }
}

TEST(OrderMatrix, OptionsOutOfRangeAreNamed) {
  const auto refused = [](AnalysisOptions options) -> std::string {
    try {
      order_matrix(pattern_of(3, path(3)), {}, options, 1);
    } catch (const InvalidInput& error) {
      return error.argument();
    }
    return "";
  };
  AnalysisOptions options;
  EXPECT_EQ(refused(options), "");
  options.leaf_size = 0;
  EXPECT_EQ(refused(options), "leaf_size");
  options = {};
  options.separator_trials = 0;
  EXPECT_EQ(refused(options), "separator_trials");
  options = {};
  options.separator_refinement = 0;
  EXPECT_EQ(refused(options), "separator_refinement");
  options = {};
  options.dense_row = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refused(options), "dense_row");
}

TEST(OrderMatrix, ProgressIsPassedOn) {
  const Pattern pattern = pattern_of(1600, grid(40));
  double last = -1;
  order_matrix(pattern, {}, {}, 1, [&](double fraction) { last = fraction; });
  EXPECT_GT(last, 0.5);
}

/// Whether the tree is that of minimum degree alone, as one leaf of the dissection has it.
bool is_by_degree(Vertex n, const Entries& entries, const AnalysisOptions& options = {}) {
  AnalysisOptions one_leaf;
  one_leaf.leaf_size = n;
  const SeparatorTree found = order(n, entries, options).tree, by_degree = order(n, entries, one_leaf).tree;
  return found.order == by_degree.order && found.parent == by_degree.parent;
}

TEST(OrderMatrix, GraphsOfLittleFillAreNotDissected) {
  EXPECT_TRUE(is_by_degree(1024, path(1024)));
  EXPECT_TRUE(is_by_degree(4000, path(4000)));
  Entries hub = path(1600);  // a row that is ordered last
  for (Vertex v = 1; v < 1600; ++v) hub[{0, v}] = hub[{v, 0}] = 0.001;
  EXPECT_TRUE(is_by_degree(1600, hub));
  EXPECT_TRUE(is_by_degree(30000, path(30000)));
  EXPECT_TRUE(is_by_degree(40000, star(40000)));
}

TEST(OrderMatrix, LargeGraphsOfLittleFillAreDissectedForThreadsThatShareThem) {
  const Pattern pattern = pattern_of(30000, path(30000));
  const auto depths = [&](TreeHeight height) {
    return depths_of(order_matrix(pattern, {}, {}, 2, {}, nullptr, height));
  };
  EXPECT_GT(depths(TreeHeight::any), 1000);
  EXPECT_LT(depths(TreeHeight::even), 30);
  EXPECT_LT(depths(TreeHeight::low), 30);
}

TEST(OrderMatrix, LargeGraphsWithMuchFillInAPartOfThemAreDissected) {
  Entries hidden = path(140000);  // what lies around its start, quarters and middle shows nothing of the grid
  for (const auto& [place, value] : grid(173)) hidden[{2100 + place.first, 2100 + place.second}] = value;
  EXPECT_FALSE(is_by_degree(140000, hidden));
  Entries apart = grid(173);  // many components
  for (Vertex v = 173 * 173; v < 60000; ++v) apart[{v, v}] = 1;
  EXPECT_FALSE(is_by_degree(60000, apart));
}

TEST(OrderMatrix, GraphsOfMuchFillAreDissectedAndSoAreThoseThatAreSmallOrLargeOrTheCallers) {
  EXPECT_FALSE(is_by_degree(2744, cube(14)));        // much fill
  EXPECT_FALSE(is_by_degree(2500, grid(50)));        // 1000 operations for an unknown
  EXPECT_FALSE(is_by_degree(900, grid(30)));         // few vertices
  EXPECT_FALSE(is_by_degree(1800, grid(30, 2)));     // likewise, of two unknowns each
  EXPECT_FALSE(is_by_degree(150 * 150, grid(150)));  // many
  AnalysisOptions own_leaves;
  own_leaves.leaf_size = 121;
  EXPECT_FALSE(is_by_degree(1024, path(1024), own_leaves));
}

TEST(OrderMatrix, LongGraphsOfLittleFillAreDissectedForALowTree) {
  const auto depths = [](Vertex n, const Entries& entries, TreeHeight height) {
    return depths_of(order_matrix(pattern_of(n, entries), {}, {}, 1, {}, nullptr, height));
  };
  EXPECT_GT(depths(4000, path(4000), TreeHeight::any), 100);
  EXPECT_LE(depths(4000, path(4000), TreeHeight::low), 10);
  EXPECT_LE(depths(1600, star(1600), TreeHeight::low), 3);
}

/// Products of the elimination, and columns on the longest path of its tree.
struct PlainList {
  Offset products = 0, entries = 0;
  Vertex levels = 0;
};
PlainList plain_list(const Entries& entries, const Ordered& ordered) {
  const auto n = static_cast<Vertex>(ordered.tree.order.size());
  const auto columns =
      plain_elimination(plain_graph(n, entries, ordered.matched.row_order), ordered.tree.order);
  PlainList list;
  std::vector<Vertex> level(columns.size(), 1);
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const auto rows = static_cast<Offset>(columns[k].size());
    list.products += rows * rows;
    list.entries += 2 * rows + 1;
    list.levels = std::max(list.levels, level[k]);
    if (rows > 0) level[*columns[k].begin()] = std::max(level[*columns[k].begin()], level[k] + 1);
  }
  return list;
}

constexpr ListCost kOnHost{400'000, 40, 0};

// Dissection leaves a body a border on both sides.
TEST(OrderMatrix, AListOfProductsIsMadeShortAndItsLevelsAreHalved) {
  const Vertex bodies = 60, n = 11 * bodies + 5;
  const Entries entries = chain_of_bodies(bodies);
  const Ordered usual = order(n, entries), listed = order(n, entries, {}, 1, &kOnHost);
  expect_valid_tree(listed.tree, plain_graph(n, entries));
  const PlainList before = plain_list(entries, usual), now = plain_list(entries, listed);
  EXPECT_LT(2 * now.products, before.products);
  EXPECT_LE(now.levels, 6 * n / 10);
  for (const int threads : {2, 8}) expect_equal(order(n, entries, {}, threads, &kOnHost).tree, listed.tree);
}

TEST(OrderMatrix, WhatAListCostsDecidesBetweenTheOrders) {
  const Vertex n = 665;
  const Entries entries = chain_of_bodies(60);
  const Ordered usual = order(n, entries), listed = order(n, entries, {}, 1, &kOnHost);
  const PlainList before = plain_list(entries, usual), now = plain_list(entries, listed);
  ASSERT_LT(now.products, before.products);
  ASSERT_GT(now.levels, before.levels);
  const auto is_listed = [&](const ListCost& list) {
    const SeparatorTree found = order(n, entries, {}, 1, &list).tree;
    EXPECT_TRUE(found.order == usual.tree.order || found.order == listed.tree.order);
    return found.order == listed.tree.order;
  };
  // Levels that cost 0.6 of what the shorter list saves, and all of it.
  const Offset saved = before.products + before.entries - now.products - now.entries;
  const Offset even = saved / (3 * (now.levels - before.levels));
  EXPECT_TRUE(is_listed({400'000, 40, even * 6 / 10}));
  EXPECT_FALSE(is_listed({400'000, 40, even}));
  EXPECT_TRUE(is_listed({now.entries, 40, 0}));
  EXPECT_FALSE(is_listed({now.entries - 1, 40, 0}));
  EXPECT_FALSE(is_listed({400'000, now.products / now.entries, 0}));
}

// Of a graph that has the order of minimum degree as it is: from its middle where levels cost anything.
TEST(OrderMatrix, LevelsOfMinimumDegreeAreHalvedWhereTheyCost) {
  const Vertex bodies = 200, n = 11 * bodies + 5;
  const Entries entries = chain_of_bodies(bodies);
  const ListCost on_device{400'000, 40, 80};
  const Ordered usual = order(n, entries), host = order(n, entries, {}, 1, &kOnHost),
                device = order(n, entries, {}, 1, &on_device);
  expect_equal(host.tree, usual.tree);
  const PlainList before = plain_list(entries, usual), now = plain_list(entries, device);
  EXPECT_LE(now.levels, 6 * before.levels / 10);
  EXPECT_LE(100 * now.products, 105 * before.products);  // other multipliers are deferred
}

TEST(OrderMatrix, OrdersStayWhereNoListIsCheaperOrTheCallerSaysWhatALeafIs) {
  const auto stays = [](Vertex n, const Entries& entries, const AnalysisOptions& options = {}) {
    const SeparatorTree before = order(n, entries, options).tree,
                        now = order(n, entries, options, 1, &kOnHost).tree;
    return now.order == before.order && now.parent == before.parent;
  };
  EXPECT_TRUE(stays(512, cube(8)));
  EXPECT_TRUE(stays(1, path(1)));
  EXPECT_TRUE(stays(115, chain_of_bodies(10)));  // a leaf
  EXPECT_TRUE(stays(300, star(300)));
  EXPECT_FALSE(stays(665, chain_of_bodies(60)));
  Entries one_sided = chain_of_bodies(60);  // the graph is the same
  for (Vertex i = 0; i < 360; ++i) {
    for (Vertex j = 0; j < i; ++j) one_sided.erase({i, j});
  }
  EXPECT_TRUE(stays(665, one_sided));
  AnalysisOptions own_leaves;
  own_leaves.leaf_size = 121;
  EXPECT_TRUE(stays(665, chain_of_bodies(60), own_leaves));
  AnalysisOptions own_order;
  own_order.permutation.resize(665);
  std::iota(own_order.permutation.begin(), own_order.permutation.end(), 0);
  EXPECT_TRUE(stays(665, chain_of_bodies(60), own_order));
}

}  // namespace
}  // namespace mfs::test
