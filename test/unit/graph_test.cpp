// The graph of Ahat + Ahat^T and its compression.
#include "ordering/graph.hpp"

#include <gmock/gmock.h>

#include <numeric>
#include <random>

#include "ordering/compression.hpp"
#include "test/unit/test_matrices.hpp"

namespace mfs::test {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;

void expect_well_formed(const Graph& graph) {
  ASSERT_EQ(static_cast<Vertex>(graph.offsets.size()), graph.n + 1);
  ASSERT_EQ(static_cast<Vertex>(graph.weight.size()), graph.n);
  for (Vertex v = 0; v < graph.n; ++v) {
    for (Offset k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k) {
      ASSERT_NE(graph.neighbors[k], v) << "loop";
      if (k > graph.offsets[v]) {
        ASSERT_LT(graph.neighbors[k - 1], graph.neighbors[k]);
      }
    }
  }
}

TEST(Graph, UnsymmetricPatternIsMirrored) {
  const Graph g = build_graph(pattern_of(3, {{{0, 2}, 1}, {{1, 0}, 1}, {{1, 1}, 1}, {{2, 0}, 1}}), {},
                              trivial_partition(3), 1);
  EXPECT_THAT(g.offsets, ElementsAre(0, 2, 3, 4));
  EXPECT_THAT(g.neighbors, ElementsAre(1, 2, 0, 0));
  EXPECT_THAT(g.weight, Each(1));
}

TEST(Graph, RowOrderIsApplied) {
  // Rows 0 and 1 change places: Ahat has (0, 2) from row 1 of A.
  const Graph g = build_graph(pattern_of(3, {{{0, 1}, 1}, {{1, 0}, 1}, {{1, 2}, 1}, {{2, 2}, 1}}), {1, 0, 2},
                              trivial_partition(3), 1);
  EXPECT_THAT(g.offsets, ElementsAre(0, 1, 1, 2));
  EXPECT_THAT(g.neighbors, ElementsAre(2, 0));
}

TEST(Graph, RandomPatternsAgainstSets) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 generator(seed);
    const Vertex n = 1 + static_cast<Vertex>(generator() % 40);
    const Entries entries = random_entries(generator, n, 2.5, 0.5, seed % 3 == 0);
    std::vector<Vertex> row_order;
    if (seed % 2 == 1) {
      row_order.resize(n);
      std::iota(row_order.begin(), row_order.end(), 0);
      std::shuffle(row_order.begin(), row_order.end(), generator);
    }
    const Graph g = build_graph(pattern_of(n, entries), row_order, trivial_partition(n), 1 + seed % 4);
    expect_well_formed(g);
    EXPECT_EQ(neighbor_sets(g), plain_graph(n, entries, row_order));
  }
}

TEST(Graph, MergingAnyVerticesKeepsAllEdges) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 generator(seed);
    const Vertex n = 2 + static_cast<Vertex>(generator() % 30);
    const Entries entries = random_entries(generator, n, 2.0, 0.5, false);
    std::vector<Vertex> leader(n);
    for (Vertex i = 0; i < n; ++i) {
      leader[i] = i;
      const auto other = static_cast<Vertex>(generator() % (i + 1));
      if (generator() % 3 == 0 && leader[other] == other) leader[i] = other;
    }
    const Partition partition = partition_by_leader(leader);
    std::vector<std::set<Vertex>> expected(partition.num_vertices());
    const auto fine = plain_graph(n, entries);
    for (Vertex i = 0; i < n; ++i) {
      for (const Vertex j : fine[i]) {
        const Vertex v = partition.vertex_of[i], w = partition.vertex_of[j];
        if (v != w) expected[v].insert(w);
      }
    }
    const Pattern p = pattern_of(n, entries);
    const Graph at_once = build_graph(p, {}, partition, 2);
    const Graph later = merge_vertices(build_graph(p, {}, trivial_partition(n), 2), partition, 2);
    for (const Graph& g : {at_once, later}) {
      expect_well_formed(g);
      EXPECT_EQ(neighbor_sets(g), expected);
      EXPECT_EQ(std::accumulate(g.weight.begin(), g.weight.end(), 0), n);
    }
    EXPECT_EQ(at_once.weight, later.weight);
  }
}

TEST(Partition, GroupsAreNumberedByTheirFirstMember) {
  const Partition p = partition_by_leader({0, 1, 0, 3, 1, 0});
  EXPECT_THAT(p.vertex_of, ElementsAre(0, 1, 0, 2, 1, 0));
  EXPECT_THAT(p.begin, ElementsAre(0, 3, 5, 6));
  EXPECT_THAT(p.members, ElementsAre(0, 2, 5, 1, 4, 3));
  const Partition coarse = compose(p, partition_by_leader({0, 1, 0}));
  EXPECT_THAT(coarse.vertex_of, ElementsAre(0, 1, 0, 0, 1, 0));
  EXPECT_THAT(coarse.members, ElementsAre(0, 2, 3, 5, 1, 4));
}

TEST(Compression, NodesOfThreeUnknownsCollapse) {
  for (const int threads : {1, 2, 4}) {
    const CompressedGraph c = compressed_graph(pattern_of(75, grid(5, 3)), {}, threads);
    EXPECT_EQ(c.graph.n, 25);
    EXPECT_THAT(c.graph.weight, Each(3));
    EXPECT_EQ(neighbor_sets(c.graph), plain_graph(25, grid(5)));
    for (Vertex i = 0; i < 75; ++i) EXPECT_EQ(c.partition.vertex_of[i], i / 3);
  }
}

TEST(Compression, UnknownsApartFromEachOtherAreFound) {
  // The same nodes with their unknowns numbered far from each other: node v holds v, v + 25 and v + 50.
  Entries entries;
  for (const auto& [place, value] : grid(5, 3)) {
    const auto number = [](Vertex i) { return i / 3 + 25 * (i % 3); };
    entries[{number(place.first), number(place.second)}] = value;
  }
  const CompressedGraph c = compressed_graph(pattern_of(75, entries), {}, 1);
  EXPECT_EQ(c.graph.n, 25);
  for (Vertex i = 0; i < 75; ++i) EXPECT_EQ(c.partition.vertex_of[i], i % 25);
}

TEST(Compression, ADenseMatrixIsOneVertex) {
  Entries entries;
  for (Vertex i = 0; i < 10; ++i) {
    for (Vertex j = 0; j < 10; ++j) entries[{i, j}] = 1.0;
  }
  const CompressedGraph c = compressed_graph(pattern_of(10, entries), {}, 1);
  EXPECT_EQ(c.graph.n, 1);
  EXPECT_THAT(c.graph.weight, ElementsAre(10));
}

TEST(Compression, EqualRowsWithDifferentColumnsAreNotAlike) {
  // Rows 0 and 1 have the same entries, but only column 0 is touched by row 3.
  Entries entries = symmetric(4, {{0, 1}, {0, 2}, {1, 2}});
  entries[{3, 0}] = 1.0;
  const CompressedGraph c = compressed_graph(pattern_of(4, entries), {}, 1);
  EXPECT_NE(c.partition.vertex_of[0], c.partition.vertex_of[1]);
}

TEST(Compression, OneSidedEntriesDoNotHideLikeness) {
  // Unknowns 2k and 2k + 1 are alike in Ahat + Ahat^T, though no two rows are equal: each entry is on one
  // side only.
  Entries entries;
  const Vertex nodes = 12;
  for (Vertex v = 0; v < nodes; ++v) {
    for (Vertex d = 0; d < 2; ++d) {
      for (Vertex w = v; w < std::min(v + 2, nodes); ++w) {
        for (Vertex e = 0; e < 2; ++e) {
          if ((v + d + e) % 2 == 0) {
            entries[{2 * v + d, 2 * w + e}] = 1.0;
          } else {
            entries[{2 * w + e, 2 * v + d}] = 1.0;
          }
        }
      }
    }
  }
  const CompressedGraph c = compressed_graph(pattern_of(2 * nodes, entries), {}, 1);
  EXPECT_EQ(c.graph.n, nodes);
  EXPECT_EQ(neighbor_sets(c.graph), plain_graph(nodes, path(nodes)));
}

TEST(Compression, PairsAreMergedAndWhatTheyHideIsFound) {
  // Multiplier 6 is paired with unknown 0; unknowns 0, 1, 2 and 3, 4, 5 are nodes.
  Entries entries = grid(2, 3);
  const Vertex n = 13;
  entries[{0, 12}] = entries[{12, 0}] = 1.0;
  MatchedScaling matched;
  matched.pair.resize(n);
  std::iota(matched.pair.begin(), matched.pair.end(), 0);
  matched.pair[0] = 12;
  matched.pair[12] = 0;
  for (const int threads : {1, 3}) {
    const CompressedGraph c = compressed_graph(pattern_of(n, entries), matched, threads);
    EXPECT_EQ(c.partition.vertex_of[0], c.partition.vertex_of[12]);
    EXPECT_EQ(c.graph.n,
              1);  // a 2 x 2 grid is a clique, and the multiplier hangs on one of its unknowns alone
  }
  const CompressedGraph paired = paired_graph(pattern_of(n, entries), matched, 1);
  EXPECT_EQ(paired.graph.n, 12);
  EXPECT_EQ(paired.graph.weight[0], 2);
}

TEST(Compression, LongerCyclesOfPairsAreOneVertex) {
  MatchedScaling matched;
  matched.pair = {2, 1, 4, 3, 0};
  const CompressedGraph c = paired_graph(pattern_of(5, path(5)), matched, 1);
  EXPECT_THAT(c.partition.vertex_of, ElementsAre(0, 1, 0, 2, 0));
  EXPECT_THAT(c.graph.weight, ElementsAre(3, 1, 1));
}

}  // namespace
}  // namespace mfs::test
