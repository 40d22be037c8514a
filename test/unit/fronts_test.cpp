// Elimination tree, column counts, supernodes and amalgamation.
#include "ordering/fronts.hpp"

#include <gmock/gmock.h>

#include <numeric>
#include <random>

#include "ordering/elimination_tree.hpp"
#include "test/unit/test_matrices.hpp"

namespace mfs::test {
namespace {

using ::testing::ElementsAre;

std::vector<Vertex> natural(Vertex n) {
  std::vector<Vertex> order(n);
  std::iota(order.begin(), order.end(), 0);
  return order;
}

SeparatorTree fronts(Vertex n, const Entries& entries, const std::vector<Vertex>& order,
                     TreeHeight height = TreeHeight::any) {
  const Partition partition = trivial_partition(n);
  return breadth_first(
      fronts_of_order(build_graph(pattern_of(n, entries), {}, partition, 1), partition, order, 1, height));
}

TEST(EliminationTree, OfAPath) {
  const Graph g = build_graph(pattern_of(5, path(5)), {}, trivial_partition(5), 1);
  const EliminationTree chain = elimination_tree(g, natural(5), 1);
  EXPECT_THAT(chain.order, ElementsAre(0, 1, 2, 3, 4));
  EXPECT_THAT(chain.parent, ElementsAre(1, 2, 3, 4, -1));
  EXPECT_THAT(chain.count, ElementsAre(2, 2, 2, 2, 1));
  const EliminationTree cut = elimination_tree(g, {0, 1, 3, 4, 2}, 1);
  EXPECT_THAT(cut.order, ElementsAre(0, 1, 3, 4, 2));
  EXPECT_THAT(cut.parent, ElementsAre(1, 4, 3, 4, -1));
  EXPECT_THAT(cut.count, ElementsAre(2, 2, 3, 2, 1));  // 3 fills: 4 and 2 become neighbours
}

TEST(EliminationTree, OfAStar) {
  const Graph g = build_graph(pattern_of(5, star(5)), {}, trivial_partition(5), 1);
  EXPECT_THAT(elimination_tree(g, {1, 2, 3, 4, 0}, 1).parent, ElementsAre(4, 4, 4, 4, -1));
  const EliminationTree worst = elimination_tree(g, natural(5), 1);
  EXPECT_THAT(worst.parent, ElementsAre(1, 2, 3, 4, -1));
  EXPECT_THAT(worst.count, ElementsAre(5, 4, 3, 2, 1));
}

/// A graph of up to `most` weighted vertices in random order; `densities` of them by turns.
struct Problem {
  Vertex n;
  Entries entries;
  Graph graph;
  std::vector<Vertex> order;
};
Problem random_problem(unsigned seed, unsigned most, unsigned densities) {
  std::mt19937 generator(seed);
  Problem made;
  made.n = 1 + static_cast<Vertex>(generator() % most);
  made.entries =
      random_entries(generator, made.n, 0.25 * static_cast<double>(1 + seed % densities), 1.0, false);
  made.graph = build_graph(pattern_of(made.n, made.entries), {}, trivial_partition(made.n), 1);
  for (Vertex& weight : made.graph.weight) weight = 1 + static_cast<Vertex>(generator() % 3);
  made.order = natural(made.n);
  std::shuffle(made.order.begin(), made.order.end(), generator);
  return made;
}

TEST(EliminationTree, RandomGraphsAgainstPlainElimination) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const auto [n, entries, g, order] = random_problem(seed, 40, 12);
    const EliminationTree tree = elimination_tree(g, order, 1);
    expect_permutation(tree.order, n);
    const auto columns = plain_elimination(plain_graph(n, entries), tree.order);
    EXPECT_EQ(plain_fill(plain_graph(n, entries), tree.order), plain_fill(plain_graph(n, entries), order));
    for (Vertex p = 0; p < n; ++p) {
      EXPECT_EQ(tree.parent[p], columns[p].empty() ? -1 : *columns[p].begin());
      Vertex weight = g.weight[tree.order[p]];
      for (const Vertex q : columns[p]) weight += g.weight[tree.order[q]];
      EXPECT_EQ(tree.count[p], weight) << "position " << p;
    }
  }
}

void expect_equal(const EliminationTree& tree, const EliminationTree& expected) {
  EXPECT_EQ(tree.order, expected.order);
  EXPECT_EQ(tree.parent, expected.parent);
  EXPECT_EQ(tree.count, expected.count);
}

TEST(EliminationTree, ThreadsFindTheSameByPieces) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const auto [n, entries, g, order] = random_problem(seed, 120, 8);
    for (const Vertex most : {1, 2, 5, 11, 40, 200}) {
      SCOPED_TRACE("most " + std::to_string(most));
      const EliminationTree tree = elimination_tree(g, order, 1);
      expect_equal(elimination_tree(g, order, 3, most), tree);
      // In a postorder each subtree is a piece.
      expect_equal(elimination_tree(g, tree.order, 3, most), elimination_tree(g, tree.order, 1));
    }
  }
}

TEST(Fronts, ACliqueIsOneFront) {
  Entries entries;
  for (Vertex i = 0; i < 20; ++i) {
    for (Vertex j = 0; j < 20; ++j) entries[{i, j}] = 1.0;
  }
  const SeparatorTree tree = fronts(20, entries, natural(20));
  EXPECT_THAT(tree.node_begin, ElementsAre(0, 20));
  EXPECT_THAT(tree.parent, ElementsAre(-1));
}

TEST(Fronts, TwoCliquesAndTheirSeparator) {
  // Cliques 0 ... 59 and 60 ... 119, each tied to its half of the separator 120 ... 139, a clique as well.
  Entries entries;
  for (Vertex i = 0; i < 140; ++i) {
    for (Vertex j = 0; j < 140; ++j) {
      const auto half = [](Vertex v) { return v < 120 ? v / 60 : (v - 120) / 10; };
      if (half(i) == half(j) || (i >= 120 && j >= 120)) entries[{i, j}] = 1.0;
    }
  }
  const SeparatorTree tree = fronts(140, entries, natural(140));
  EXPECT_THAT(tree.node_begin, ElementsAre(0, 60, 120, 140));
  EXPECT_THAT(tree.parent, ElementsAre(2, 2, -1));
  std::vector<Vertex> separator(tree.order.begin() + 120, tree.order.end());
  EXPECT_EQ(separator.front(), 120);
  EXPECT_EQ(separator.back(), 139);
}

TEST(Fronts, AChildThatFillsItsParentsFrontIsMerged) {
  // As before, but both cliques touch the whole separator: the first merge costs no zero, the second many.
  Entries entries;
  for (Vertex i = 0; i < 140; ++i) {
    for (Vertex j = 0; j < 140; ++j) {
      if (i / 60 == j / 60 || i >= 120 || j >= 120) entries[{i, j}] = 1.0;
    }
  }
  const SeparatorTree tree = fronts(140, entries, natural(140));
  EXPECT_THAT(tree.node_begin, ElementsAre(0, 60, 140));
  EXPECT_THAT(tree.parent, ElementsAre(1, -1));
}

TEST(Fronts, LargeSiblingsStayByThemselves) {
  // Cliques of so many unknowns, each a vertex of the graph; the last is the separator of the others.
  const auto sizes = [](const std::vector<Vertex>& cliques) {
    std::vector<Vertex> leader, first;
    for (const Vertex size : cliques) {
      first.push_back(static_cast<Vertex>(leader.size()));
      leader.insert(leader.end(), size, first.back());
    }
    std::vector<std::pair<Vertex, Vertex>> edges;
    for (std::size_t c = 0; c + 1 < first.size(); ++c) edges.emplace_back(first[c], first.back());
    const auto n = static_cast<Vertex>(leader.size());
    const Partition partition = partition_by_leader(leader);
    const Graph graph = build_graph(pattern_of(n, symmetric(n, edges)), {}, partition, 1);
    return breadth_first(fronts_of_order(graph, partition, natural(partition.num_vertices()), 1)).node_begin;
  };
  EXPECT_THAT(sizes({2048, 2048, 100}), ElementsAre(0, 2048, 4096, 4196));
  EXPECT_THAT(sizes({2047, 2047, 100}), ElementsAre(0, 2047, 4194));
  EXPECT_THAT(sizes({1024, 2048, 100}), ElementsAre(0, 2048, 3172));  // the smaller is no large child
  EXPECT_THAT(sizes({1023, 2048, 100}), ElementsAre(0, 1023, 3171));  // less than half as large
  EXPECT_THAT(sizes({2048, 100}), ElementsAre(0, 2148));
}

std::vector<Vertex> fronts_of_unknowns(const SeparatorTree& tree) {
  std::vector<Vertex> front(tree.order.size());
  for (Vertex f = 0; f < tree.num_nodes(); ++f) {
    for (Vertex p = tree.node_begin[f]; p < tree.node_begin[f + 1]; ++p) front[tree.order[p]] = f;
  }
  return front;
}

// All of a path's fronts lie on its one long path.
TEST(LowTree, OfAPathHasFrontsAsLargeAsTheyMayBe) {
  const Vertex n = 4096;
  const SeparatorTree low = fronts(n, path(n), natural(n), TreeHeight::low);
  expect_valid_tree(low, plain_graph(n, path(n)));
  EXPECT_LE(depths_of(low), 2 * n / kLowPivots);  // pairs are merged as long as both fit
  for (Vertex f = 0; f < low.num_nodes(); ++f)
    EXPECT_LE(low.node_begin[f + 1] - low.node_begin[f], kLowPivots);
}

TEST(LowTree, OfAnEvenTreeIsHardlyLower) {
  const Vertex n = 4095;
  std::vector<std::pair<Vertex, Vertex>> edges;  // to the parent: 1 + 2 + 4 + ... unknowns
  for (Vertex v = 0; v + 1 < n; ++v) edges.emplace_back(v, n - 1 - (n - 2 - v) / 2);
  const Entries entries = symmetric(n, edges);
  const SeparatorTree low = fronts(n, entries, natural(n), TreeHeight::low),
                      any = fronts(n, entries, natural(n));
  expect_valid_tree(low, plain_graph(n, entries));
  EXPECT_LE(depths_of(low), depths_of(any));
  EXPECT_GE(depths_of(low) + 2, depths_of(any));
}

TEST(LowTree, OfRandomGraphsConsistsOfWholeFrontsAndIsNoHigher) {
  bool lower = false;
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 generator(seed);
    const Vertex n = 1 + static_cast<Vertex>(generator() % 300);
    const Entries entries = random_entries(generator, n, 1.0 + 0.1 * (seed % 10), 1.0, true);
    std::vector<Vertex> order = natural(n);
    if (seed % 2) std::shuffle(order.begin(), order.end(), generator);
    const SeparatorTree any = fronts(n, entries, order), low = fronts(n, entries, order, TreeHeight::low);
    expect_valid_tree(low, plain_graph(n, entries));
    EXPECT_LE(depths_of(low), depths_of(any));
    lower = lower || depths_of(low) < depths_of(any);
    const std::vector<Vertex> in = fronts_of_unknowns(low);
    std::vector<Vertex> parts(static_cast<std::size_t>(low.num_nodes()), 0);
    for (Vertex f = 0; f < any.num_nodes(); ++f) {
      for (Vertex p = any.node_begin[f]; p < any.node_begin[f + 1]; ++p)
        EXPECT_EQ(in[any.order[p]], in[any.order[any.node_begin[f]]]);
      ++parts[in[any.order[any.node_begin[f]]]];
    }
    for (Vertex f = 0; f < low.num_nodes(); ++f) {
      if (parts[f] > 1) EXPECT_LE(low.node_begin[f + 1] - low.node_begin[f], kLowPivots);
    }
  }
  EXPECT_TRUE(lower);
}

TEST(Fronts, SmallChildrenAreMergedIntoTheirParent) {
  const SeparatorTree tree = fronts(4, path(4), natural(4));
  EXPECT_THAT(tree.node_begin, ElementsAre(0, 4));
}

TEST(Fronts, ALongPathBecomesAChainOfSmallFronts) {
  const SeparatorTree tree = fronts(1000, path(1000), natural(1000));
  expect_valid_tree(tree, plain_graph(1000, path(1000)));
  EXPECT_LT(tree.num_nodes(), 251);
  EXPECT_GT(tree.num_nodes(), 100);
}

void join(Entries& entries, Vertex i, Vertex j) {
  entries[{i, j}] = entries[{j, i}] = 1.0;
}

/// A path of which each vertex touches one vertex more of a clique than the one before, `border` for the
/// first.
SeparatorTree path_below_clique(Vertex length, Vertex border) {
  const Vertex n = 2 * length + border;
  Entries entries;
  for (Vertex k = 0; k < length; ++k) {
    join(entries, k, k);
    if (k > 0) join(entries, k, k - 1);
    for (Vertex j = 0; j < border + k; ++j) join(entries, k, length + j);
  }
  for (Vertex i = length; i < n; ++i) {
    for (Vertex j = length; j <= i; ++j) join(entries, i, j);
  }
  return fronts(n, entries, natural(n));
}

// Below a large border the chain becomes one front with the clique, whatever the share of zeros in it: each
// piece of it would have a contribution block of its own.
TEST(Fronts, ChainsBelowLargeBordersAreMerged) {
  EXPECT_EQ(path_below_clique(200, 600).num_nodes(), 1);
  EXPECT_GT(path_below_clique(200, 60).num_nodes(), 2);
}

// Vertices with 550 others behind each, below a clique of 5000: in its front their columns would be nine
// times as long, and few of them are worth it.
TEST(Fronts, ChildrenOfAFarLargerFrontStayByThemselves) {
  constexpr Vertex kLeaves = 400, kCentres = 10, kBorder = 550, kRows = 5000;
  const Vertex n = kLeaves + kCentres + kRows, rest = kLeaves + kCentres;
  Entries entries;
  for (Vertex i = 0; i < n; ++i) join(entries, i, i);
  for (Vertex c = kLeaves; c < rest; ++c) {
    for (Vertex j = c + 1; j < n; ++j) join(entries, c, j);
  }
  for (Vertex leaf = 0; leaf < kLeaves; ++leaf) {
    join(entries, leaf, kLeaves);
    for (Vertex j = 0; j < kBorder; ++j) join(entries, leaf, rest + (leaf * 10 + j) % kRows);
  }
  EXPECT_GT(fronts(n, entries, natural(n)).num_nodes(), kLeaves / 2);
}

TEST(Fronts, VeryDeepTreesNeedNoStack) {
  const Vertex n = 300000;
  const SeparatorTree tree = fronts(n, path(n), natural(n));
  expect_permutation(tree.order, n);
}

TEST(Fronts, SpokesOfAStarAreBundled) {
  const Vertex n = 10001;
  std::vector<Vertex> order = natural(n);
  std::rotate(order.begin(), order.begin() + 1, order.end());  // the centre last
  const SeparatorTree tree = fronts(n, star(n), order);
  expect_valid_tree(tree, plain_graph(n, star(n)));
  EXPECT_LT(tree.num_nodes(), 1000);
  EXPECT_EQ(tree.parent.front(), tree.num_nodes() - 1);
}

TEST(Fronts, SpokesOfDifferentCentresAreNotBundled) {
  // A clique 0 ... 59, which is one front; spokes hang on unknown 0 (those below `half`) or on unknown 1 of
  // it.
  const Vertex clique = 60, n = 260;
  for (Vertex half = 150; half < 166; ++half) {
    std::vector<std::pair<Vertex, Vertex>> edges;
    for (Vertex i = 0; i < clique; ++i) {
      for (Vertex j = 0; j < i; ++j) edges.emplace_back(i, j);
    }
    for (Vertex i = clique; i < n; ++i) {
      edges.emplace_back(0, i);
      edges.emplace_back(i < half ? 1 : 2, i);
    }
    std::vector<Vertex> order = natural(n);
    std::rotate(order.begin(), order.begin() + clique, order.end());
    const SeparatorTree tree = fronts(n, symmetric(n, edges), order);
    EXPECT_LT(tree.num_nodes(), 30);
    for (Vertex k = 0; k + 1 < tree.num_nodes(); ++k) {
      std::set<bool> centres;
      for (Vertex p = tree.node_begin[k]; p < tree.node_begin[k + 1]; ++p)
        centres.insert(tree.order[p] < half);
      EXPECT_EQ(centres.size(), 1u) << "node " << k << ", half " << half;
    }
  }
}

TEST(Fronts, BreadthFirstNumbersFromTheDeepest) {
  // 0 and 1 below 4; 2 below 3; 3 and 4 below 5; 6 alone.
  NodeList nodes;
  nodes.order = natural(7);
  nodes.node_begin = {0, 1, 2, 3, 4, 5, 6, 7};
  nodes.parent = {4, 4, 3, 5, 5, -1, -1};
  const SeparatorTree tree = breadth_first(nodes);
  EXPECT_THAT(tree.order, ElementsAre(2, 0, 1, 3, 4, 5, 6));
  EXPECT_THAT(tree.parent, ElementsAre(3, 4, 4, 5, 5, -1, -1));
}

TEST(Fronts, RandomOrdersGiveValidTrees) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 generator(seed);
    const Vertex n = 1 + static_cast<Vertex>(generator() % 150);
    const Entries entries =
        random_entries(generator, n, 0.25 * static_cast<double>(1 + seed % 12), 1.0, false);
    std::vector<Vertex> order = natural(n);
    std::shuffle(order.begin(), order.end(), generator);
    expect_valid_tree(fronts(n, entries, order), plain_graph(n, entries));
  }
}

}  // namespace
}  // namespace mfs::test
