// Block triangular form (ordering/diagonal_blocks.hpp) against transitive closures by plain loops.
#include "ordering/diagonal_blocks.hpp"

#include <numeric>

#include "ordering/order_matrix.hpp"
#include "test/unit/test_matrices.hpp"

namespace mfs::test {
namespace {

using Relation = std::vector<std::vector<bool>>;

/// reaches[i][j]: a way leads from unknown i to j (Warshall).
Relation closure(Vertex n, const Entries& entries, const MatchedScaling& matched) {
  Relation reaches(n, std::vector<bool>(n, false));
  for (Vertex i = 0; i < n; ++i) {
    reaches[i][i] = true;
    if (!matched.pair.empty()) reaches[i][matched.pair[i]] = true;
    for (Vertex j = 0; j < n; ++j)
      if (entries.count({matched.row_order.empty() ? i : matched.row_order[i], j})) reaches[i][j] = true;
  }
  for (Vertex k = 0; k < n; ++k)
    for (Vertex i = 0; i < n; ++i)
      for (Vertex j = 0; j < n; ++j)
        if (reaches[i][k] && reaches[k][j]) reaches[i][j] = true;
  return reaches;
}

MatchedScaling random_matching(std::mt19937& generator, Vertex n) {
  MatchedScaling matched;
  std::vector<Vertex> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), generator);
  if (generator() % 2) matched.row_order = order;
  if (generator() % 2) {
    matched.pair.resize(n);
    std::iota(matched.pair.begin(), matched.pair.end(), 0);
    for (Vertex k = 0; k + 1 < n && k < 4; k += 2) {
      matched.pair[order[k]] = order[k + 1];
      matched.pair[order[k + 1]] = order[k];
    }
  }
  return matched;
}

TEST(DiagonalBlocks, ComponentsAreThoseOfTheClosure) {
  std::mt19937 generator(7);
  int several = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Vertex n = 1 + static_cast<Vertex>(generator() % 12);
    const Entries entries =
        random_entries(generator, n, 0.2 * static_cast<double>(generator() % 10), 0.7, generator() % 4 == 0);
    const MatchedScaling matched = random_matching(generator, n);
    SCOPED_TRACE("trial " + std::to_string(trial));
    const std::vector<Vertex> block = strong_components(pattern_of(n, entries), matched);
    const Relation reaches = closure(n, entries, matched);
    for (Vertex i = 0; i < n; ++i) {
      for (Vertex j = 0; j < n; ++j) {
        ASSERT_EQ(block[i] == block[j], reaches[i][j] && reaches[j][i]) << i << ", " << j;
        if (reaches[i][j]) {
          ASSERT_LE(block[j], block[i]) << i << ", " << j;
        }
      }
    }
    const std::set<Vertex> numbers(block.begin(), block.end());
    ASSERT_EQ(*numbers.begin(), 0);
    ASSERT_EQ(*numbers.rbegin() + 1, static_cast<Vertex>(numbers.size()));
    several += numbers.size() > 2;
  }
  EXPECT_GT(several, 200);
}

TEST(DiagonalBlocks, EntriesAreInsideOrToBlocksOfLevelsBefore) {
  std::mt19937 generator(8);
  int found = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const Vertex n = 1 + static_cast<Vertex>(generator() % 40);
    const Entries entries =
        random_entries(generator, n, 0.1 * static_cast<double>(generator() % 20), 0.7, false);
    const MatchedScaling matched = random_matching(generator, n);
    const Pattern pattern = pattern_of(n, entries);
    SCOPED_TRACE("trial " + std::to_string(trial));
    const std::vector<Vertex> component = strong_components(pattern, matched);
    const double part = generator() % 2 ? 0.5 : 1;
    const auto blocks = find_diagonal_blocks(pattern, matched, part);
    std::map<Vertex, int> size;
    for (const Vertex c : component) ++size[c];
    int largest = 0;
    for (const auto& [c, unknowns] : size) largest = std::max(largest, unknowns);
    bool couples = false;
    for (Vertex i = 0; i < n; ++i) {
      const Vertex row = matched.row_order.empty() ? i : matched.row_order[i];
      for (Offset k = pattern.offsets[row]; k < pattern.offsets[row + 1]; ++k)
        couples |= component[pattern.columns[k]] != component[i];
    }
    ASSERT_EQ(blocks != nullptr, couples && largest <= part * n);
    if (!blocks) continue;
    ++found;
    ASSERT_EQ(blocks->count(), static_cast<Vertex>(size.size()));
    const auto level_of = [&](Vertex block) {
      return std::upper_bound(blocks->level_begin.begin(), blocks->level_begin.end(), block) -
             blocks->level_begin.begin();
    };
    Offset inner = 0;
    for (Vertex i = 0; i < n; ++i) {
      const Vertex row = matched.row_order.empty() ? i : matched.row_order[i];
      ASSERT_EQ(blocks->of_row[row], blocks->of_column[i]);
      for (Vertex j = 0; j < n; ++j)
        ASSERT_EQ(blocks->of_column[i] == blocks->of_column[j], component[i] == component[j]);
      for (Offset k = pattern.offsets[row]; k < pattern.offsets[row + 1]; ++k) {
        const Vertex column = pattern.columns[k];
        if (blocks->of_column[column] != blocks->of_row[row]) {
          ASSERT_LT(level_of(blocks->of_column[column]), level_of(blocks->of_row[row]));
        } else {
          ++inner;
        }
      }
      for (Offset k = blocks->pattern.offsets[row]; k < blocks->pattern.offsets[row + 1]; ++k) {
        ASSERT_EQ(blocks->of_column[blocks->pattern.columns[k]], blocks->of_row[row]);
        ASSERT_EQ(blocks->pattern.columns[k], pattern.columns[pattern.offsets[row] + blocks->in_row[k]]);
      }
    }
    ASSERT_EQ(blocks->pattern.nnz(), inner);
    const SeparatorTree tree =
        order_matrix(blocks->pattern, matched, {}, 1, {}, nullptr, TreeHeight::any, Parts::apart);
    const SeparatorTree ordered = in_block_order(tree, *blocks);
    Entries inside;
    for (const auto& [place, value] : entries)
      if (blocks->of_row[place.first] == blocks->of_column[place.second]) inside[place] = value;
    for (Vertex i = 0; !matched.pair.empty() && i < n; ++i)
      inside[{matched.row_order.empty() ? i : matched.row_order[i], matched.pair[i]}] = 1;
    expect_valid_tree(ordered, plain_graph(n, inside, matched.row_order));
    for (Vertex f = 0; f < ordered.num_nodes(); ++f) {
      const Vertex own = blocks->of_column[ordered.order[ordered.node_begin[f]]];
      for (Vertex p = ordered.node_begin[f]; p < ordered.node_begin[f + 1]; ++p)
        ASSERT_EQ(blocks->of_column[ordered.order[p]], own) << "two blocks in one front";
    }
  }
  EXPECT_GT(found, 200);
}

TEST(DiagonalBlocks, DeepMatricesNeedNoStack) {
  constexpr Vertex kMany = 1'000'000;
  Pattern pattern;
  pattern.n = kMany;
  pattern.offsets.push_back(0);
  for (Vertex i = 0; i < kMany; ++i) {
    pattern.columns.push_back(i);
    if (i + 1 < kMany) pattern.columns.push_back(i + 1);
    pattern.offsets.push_back(static_cast<Offset>(pattern.columns.size()));
  }
  const auto blocks = find_diagonal_blocks(pattern, {});
  ASSERT_NE(blocks, nullptr);
  EXPECT_EQ(blocks->count(), kMany);
  EXPECT_EQ(static_cast<Vertex>(blocks->level_begin.size()), kMany + 1);
  EXPECT_EQ(blocks->of_column[0], kMany - 1);
  EXPECT_EQ(blocks->pattern.nnz(), kMany);
}

TEST(DiagonalBlocks, NothingHasNone) {
  EXPECT_EQ(find_diagonal_blocks(Pattern{0, {0}, {}, {}, 0}, {}), nullptr);
}

}  // namespace
}  // namespace mfs::test
