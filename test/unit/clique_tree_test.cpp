// Equivalent orders with lower trees: against plain elimination.
#include "ordering/clique_tree.hpp"

#include <gmock/gmock.h>

#include <numeric>
#include <random>

#include "ordering/graph.hpp"
#include "test/unit/test_matrices.hpp"

namespace mfs::test {
namespace {

using ::testing::ElementsAre;

Graph graph_of(Vertex n, const Entries& entries) {
  return build_graph(pattern_of(n, entries), {}, trivial_partition(n), 1);
}

std::vector<Vertex> natural(Vertex n) {
  std::vector<Vertex> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

std::vector<Vertex> from_middle(const Graph& graph, const std::vector<Vertex>& order) {
  return order_from_middle(graph, elimination_tree(graph, order, 1));
}

Vertex height(const Graph& graph, const std::vector<Vertex>& order) {
  return height_of(graph, elimination_tree(graph, order, 1));
}

/// The same by plain elimination.
Vertex plain_height(const Graph& graph, const std::vector<Vertex>& order) {
  const auto columns = plain_elimination(neighbor_sets(graph), order);
  std::vector<Vertex> below(order.size());
  Vertex most = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const Vertex own = below[k] + graph.weight[order[k]];
    most = std::max(most, own);
    if (!columns[k].empty()) below[*columns[k].begin()] = std::max(below[*columns[k].begin()], own);
  }
  return most;
}

TEST(CliqueTree, APathIsEliminatedFromBothEnds) {
  const Graph seven = graph_of(7, path(7));
  EXPECT_EQ(height(seven, natural(7)), 7);
  EXPECT_THAT(from_middle(seven, natural(7)), ElementsAre(0, 1, 2, 6, 5, 3, 4));
  for (const Vertex n : {1, 2, 3, 10, 101, 1000}) {
    const Graph graph = graph_of(n, path(n));
    const std::vector<Vertex> order = from_middle(graph, natural(n));
    expect_permutation(order, n);
    EXPECT_LE(height(graph, order), n / 2 + 2);
    EXPECT_EQ(plain_fill(neighbor_sets(graph), order), static_cast<std::size_t>(2 * n - 1));
  }
}

// A path of heavy vertices and one of light ones: the middle is where the unknowns are.
TEST(CliqueTree, TheMiddleIsThatOfTheUnknowns) {
  Graph graph = graph_of(40, path(40));
  for (Vertex v = 0; v < 10; ++v) graph.weight[v] = 30;
  const std::vector<Vertex> order = from_middle(graph, natural(40));
  EXPECT_EQ(height(graph, natural(40)), 330);
  EXPECT_LE(height(graph, order), 330 / 2 + 2 * 30);
}

// A star, whose cliques are as near to each other as can be, and several trees, one of them a vertex.
TEST(CliqueTree, LowTreesStayAndEachTreeHasAMiddle) {
  const Graph star_graph = graph_of(9, star(9));
  std::vector<Vertex> leaves_first = natural(9);
  std::rotate(leaves_first.begin(), leaves_first.begin() + 1, leaves_first.end());
  EXPECT_EQ(height(star_graph, from_middle(star_graph, leaves_first)), 2);
  Entries entries = path(20);
  for (const auto& [place, value] : path(31)) entries[{place.first + 20, place.second + 20}] = value;
  entries[{51, 51}] = 1.0;
  const Graph forest = graph_of(52, entries);
  const std::vector<Vertex> order = from_middle(forest, natural(52));
  expect_permutation(order, 52);
  EXPECT_LE(height(forest, order), 31 / 2 + 2);
}

TEST(CliqueTree, NoOrderHasMoreFill) {
  int lower = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 generator(seed);
    const Vertex n = 1 + static_cast<Vertex>(generator() % 60);
    Graph graph = graph_of(n, random_entries(generator, n, 0.1 + 0.4 * (seed % 8), 1.0, true));
    for (Vertex& weight : graph.weight) weight = 1 + static_cast<Vertex>(generator() % 4);
    std::vector<Vertex> order = natural(n);
    std::shuffle(order.begin(), order.end(), generator);
    const std::vector<Vertex> now = from_middle(graph, order);
    expect_permutation(now, n);
    EXPECT_LE(plain_fill(neighbor_sets(graph), now), plain_fill(neighbor_sets(graph), order));
    EXPECT_EQ(height(graph, now), plain_height(graph, now));
    lower += height(graph, now) < height(graph, order);
  }
  EXPECT_GT(lower, 50);
}

}  // namespace
}  // namespace mfs::test
