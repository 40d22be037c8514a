// Skeletons of sparse networks beside plain loops over sets of neighbours.
#include "ordering/skeleton.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "ordering/graph.hpp"
#include "ordering/nested_dissection.hpp"
#include "test/unit/test_matrices.hpp"

namespace mfs::test {
namespace {

using Edges = std::vector<std::pair<Vertex, Vertex>>;

struct Network {
  Vertex n = 0;
  Edges edges;

  /// From v to w through so many new vertices.
  void add_chain(Vertex v, Vertex w, Vertex length) {
    for (; length > 0; --length) v = add_leaf(v);
    edges.emplace_back(v, w);
  }
  Vertex add_leaf(Vertex v) {
    edges.emplace_back(v, n);
    return n++;
  }
  Graph graph() const { return build_graph(pattern_of(n, symmetric(n, edges)), {}, trivial_partition(n), 1); }
  SubGraph whole() const { return whole_graph(graph(), std::vector<bool>(n, false), 1); }
};

/// A grid whose edges are chains of up to `longest` vertices, from which trees hang, and chains back to where
/// they began.
Network grid_of_chains(Vertex side, Vertex longest, unsigned seed) {
  std::mt19937 random(seed);
  const auto draw = [&](Vertex most) { return static_cast<Vertex>(random() % (most + 1u)); };
  Network made;
  made.n = side * side;
  for (Vertex i = 0; i < side; ++i)
    for (Vertex j = 0; j < side; ++j) {
      const Vertex v = i * side + j;
      if (j + 1 < side) made.add_chain(v, v + 1, draw(longest));
      if (i + 1 < side) made.add_chain(v, v + side, draw(longest));
      if (draw(5) == 0) made.add_chain(v, v, 2 + draw(longest));
    }
  for (Vertex v = made.n; v > 0; v -= 3) made.add_leaf(draw(made.n - 1));
  return made;
}

/// Vertices of one neighbour leave, then those of two that are no lighter than one of them, which is joined
/// to the other.
std::vector<std::set<Vertex>> plain_skeleton(const SubGraph& whole) {
  std::vector<std::set<Vertex>> at(whole.vertices.size());
  for (Vertex v = 0; v < whole.size(); ++v)
    at[v].insert(whole.neighbors.begin() + whole.offsets[v], whole.neighbors.begin() + whole.offsets[v + 1]);
  const auto leave = [&](std::size_t most) {
    bool found = false;
    for (Vertex v = 0; v < whole.size(); ++v) {
      if (at[v].empty() || at[v].size() > most) continue;
      const Vertex a = *at[v].begin(), b = *at[v].rbegin();
      if (a != b && whole.weights[v] < std::min(whole.weights[a], whole.weights[b])) continue;
      at[v].clear();
      at[a].erase(v);
      at[b].erase(v);
      if (a != b) {
        at[a].insert(b);
        at[b].insert(a);
      }
      found = true;
    }
    return found;
  };
  while (leave(1)) {
  }
  while (leave(2)) {
  }
  return at;
}

void expect_separated(const SubGraph& whole, const RawVector<idx_t>& part_of) {
  ASSERT_EQ(part_of.size(), whole.vertices.size());
  for (Vertex v = 0; v < whole.size(); ++v) {
    ASSERT_TRUE(part_of[v] >= 0 && part_of[v] <= 2) << "vertex " << v;
    for (idx_t k = whole.offsets[v]; k < whole.offsets[v + 1]; ++k) {
      const idx_t w = whole.neighbors[k];
      EXPECT_TRUE(part_of[v] == 2 || part_of[w] == 2 || part_of[v] == part_of[w]) << v << " and " << w;
    }
  }
}

// Of equal weights.
TEST(Skeleton, IsThatOfPlainLoops) {
  for (const unsigned seed : {1, 2, 3, 4}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    Network network;
    network.n = 150;
    for (Vertex v = 0; v < network.n; ++v)
      for (const Vertex step : {1, 7, 31}) network.edges.emplace_back(v, (v + step) % 150);
    for (Vertex v = 0; v < 150; v += 2) network.add_chain(v, (v + 60) % 150, 1 + random() % 5);
    for (int leaves = 0; leaves < 200; ++leaves) network.add_leaf(random() % network.n);
    const SubGraph whole = network.whole();
    const Skeleton skeleton = make_skeleton(whole);
    ASSERT_FALSE(skeleton.empty());
    const auto plain = plain_skeleton(whole);
    Vertex kept = 0;
    for (Vertex v = 0; v < whole.size(); ++v) {
      EXPECT_EQ(skeleton.place[v] == Skeleton::kKept, !plain[v].empty()) << "vertex " << v;
      if (plain[v].empty()) continue;
      EXPECT_EQ(skeleton.graph.vertices[kept], v);
      std::set<Vertex> joined;
      for (idx_t k = skeleton.graph.offsets[kept]; k < skeleton.graph.offsets[kept + 1]; ++k)
        joined.insert(skeleton.graph.vertices[skeleton.graph.neighbors[k]]);
      EXPECT_EQ(joined, plain[v]) << "vertex " << v;
      ++kept;
    }
    EXPECT_EQ(skeleton.graph.size(), kept);
    EXPECT_EQ(skeleton.graph.weight, kept);
  }
}

TEST(Skeleton, ItsSeparatorsAreThoseOfTheWhole) {
  for (const unsigned seed : {1, 2, 3, 4, 5, 6}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    SubGraph whole = grid_of_chains(14, 3 * static_cast<Vertex>(seed), seed).whole();
    whole.weight = 0;
    for (idx_t& weight : whole.weights) whole.weight += weight = 1 + static_cast<idx_t>(random() % 3);
    const Skeleton skeleton = make_skeleton(whole);
    ASSERT_FALSE(skeleton.empty());
    for (Vertex v = 0; v < skeleton.graph.size(); ++v) {
      const auto row = skeleton.graph.neighbors.begin();
      ASSERT_EQ(std::count(row + skeleton.graph.offsets[v], row + skeleton.graph.offsets[v + 1], v), 0);
    }
    const Separator found = find_separator(skeleton.graph, 42, 10);
    ASSERT_TRUE(std::isfinite(found.cost));
    expect_separated(whole, whole_part_of(whole, skeleton, found.part_of));

    // What is joined to the separator alone: all of the skeleton is in it.
    expect_separated(whole,
                     whole_part_of(whole, skeleton, RawVector<idx_t>(skeleton.graph.vertices.size(), 2)));
  }
}

TEST(Skeleton, ALighterVertexOfAChainStays) {
  Network network;
  network.n = 100;
  for (Vertex v = 0; v < 100; ++v)
    for (const Vertex step : {1, 7}) network.edges.emplace_back(v, (v + step) % 100);
  for (Vertex v = 0; v < 50; ++v) network.add_chain(v, v + 50, 3);  // 100 + 3 v, and the next two
  SubGraph whole = network.whole();
  std::fill(whole.weights.begin(), whole.weights.end(), 5);
  whole.weights[100] = 7;
  whole.weights[101] = 2;
  whole.weights[102] = 3;
  const Skeleton skeleton = make_skeleton(whole);
  ASSERT_EQ(skeleton.graph.size(), 101);
  EXPECT_EQ(skeleton.graph.vertices[100], 101);
  EXPECT_EQ(skeleton.graph.weights[100], 2);
  EXPECT_THAT(std::vector<idx_t>(skeleton.graph.neighbors.end() - 2, skeleton.graph.neighbors.end()),
              ::testing::ElementsAre(0, 50));
}

TEST(Skeleton, OfGridsTreesRingsAndFewJunctionsIsNone) {
  Network grid, tree, ring, few;
  grid.n = 400;
  for (Vertex v = 0; v < 400; ++v) {
    if (v % 20 < 19) grid.edges.emplace_back(v, v + 1);
    if (v < 380) grid.edges.emplace_back(v, v + 20);
  }
  tree.n = ring.n = 400;
  for (Vertex v = 1; v < 400; ++v) tree.edges.emplace_back(v / 3, v);
  for (Vertex v = 0; v < 400; ++v) ring.edges.emplace_back(v, (v + 1) % 400);
  few.n = 4;
  for (const auto& [v, w] : Edges{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}) few.add_chain(v, w, 100);
  for (const Network& network : {grid, tree, ring, few}) EXPECT_TRUE(make_skeleton(network.whole()).empty());
}

TEST(Skeleton, OrdersOfNetworksFillLess) {
  const Network network = grid_of_chains(40, 10, 7);
  AnalysisOptions options;
  options.leaf_size = 20;
  const Graph graph = network.graph();
  const std::vector<Vertex> order = nested_dissections({&graph}, options, 2, {}).front();
  expect_permutation(order, network.n);
  EXPECT_LT(plain_fill(plain_graph(network.n, symmetric(network.n, network.edges)), order),
            92000u);  // 89 517; without skeletons 95 121
}

}  // namespace
}  // namespace mfs::test
