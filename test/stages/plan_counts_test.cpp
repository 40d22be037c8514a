// What the symbolic plan says about sizes and places, against elimination on a full table.
#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include <gmock/gmock.h>

#include <mfs/analysis_options.hpp>
#include <mfs/error.hpp>

#include "ordering/order_matrix.hpp"
#include "test/reference/generators.hpp"
#include "test/reference/symbolic.hpp"
#include "test/stages/artificial_problem.hpp"

namespace mfs::test {
namespace {

std::vector<std::pair<std::string, Pattern>> small_patterns() {
  std::vector<std::pair<std::string, Pattern>> patterns;
  const auto add = [&](const std::string& name, const SparseMatrix& matrix) {
    patterns.emplace_back(name, pattern_of(matrix));
  };
  add("grid 9 x 11", grid_2d(9, 11));
  add("grid 17 x 13", grid_2d(17, 13));
  add("one unknown", grid_2d(1, 1));
  add("tridiagonal", tridiagonal(60));
  add("arrow", arrow(50, 7));
  add("diagonal", from_entries(5, {{0, 0, 1}, {1, 1, 1}, {2, 2, 1}, {3, 3, 1}, {4, 4, 1}}));
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    add("random, seed " + std::to_string(seed), random_diagonally_dominant(80, 2, seed));
  }
  return patterns;
}

std::vector<std::vector<Vertex>> borders_of(const SymbolicPlan& plan) {
  std::vector<std::vector<Vertex>> borders;
  for (Vertex f = 0; f < plan.num_fronts; ++f) {
    borders.emplace_back(plan.border.begin() + plan.border_begin[f],
                         plan.border.begin() + plan.border_begin[f + 1]);
  }
  return borders;
}

TEST(PlanCounts, FillIsExactWhereEveryUnknownIsAFront) {
  for (const auto& [name, pattern] : small_patterns()) {
    SCOPED_TRACE(name);
    const SeparatorTree tree = one_unknown_per_front(pattern);
    const SymbolicPlan plan = make_symbolic_plan(pattern, {}, tree, 64, 1);
    const auto filled = symmetric_pattern(pattern, {}, tree.order);
    EXPECT_EQ(plan.nnz_factor, factor_entries(filled));
    EXPECT_EQ(borders_of(plan), eliminate_fronts(filled, tree.node_begin));
  }
}

TEST(PlanCounts, FillCoversEliminationWhereFrontsAreMerged) {
  for (const auto& [name, pattern] : small_patterns()) {
    for (const std::int32_t leaf_size : {1, 10, 120}) {
      SCOPED_TRACE(name + ", leaf_size " + std::to_string(leaf_size));
      AnalysisOptions options;
      options.leaf_size = leaf_size;
      const SeparatorTree tree = order_matrix(pattern, MatchedScaling(), options, 1);
      const SymbolicPlan plan = make_symbolic_plan(pattern, {}, tree, 64, 1);
      const auto filled = symmetric_pattern(pattern, {}, tree.order);
      EXPECT_GE(plan.nnz_factor, factor_entries(filled));
      EXPECT_EQ(borders_of(plan), eliminate_fronts(filled, tree.node_begin));
      Offset entries = 0;
      Vertex largest = 0;
      for (Vertex f = 0; f < plan.num_fronts; ++f) {
        const Offset p = plan.pivots(f), b = plan.border_rows(f);
        entries += p * p + 2 * p * b;
        largest = std::max(largest, static_cast<Vertex>(p + b));
      }
      EXPECT_EQ(plan.nnz_factor, entries);
      EXPECT_EQ(plan.max_front, largest);
    }
  }
}

// In these trees a border may pass by its parent: the parent's front then carries it along, so a border holds
// what elimination needs, and exactly what the front's own entries and its children bring.
TEST(PlanCounts, ArtificialTreesWithPermutedRows) {
  for (const auto& shapes : {mixed_tree(), broom(), chain(), leaf_and_root(33, 65), leaf_and_root(7, 0)}) {
    for (const std::uint64_t seed : {1, 2}) {
      const StageProblem<double> problem = artificial_problem(shapes, {seed, 0.3, 64});
      const SymbolicPlan& plan = *problem.plan;
      std::vector<Vertex> row_order(plan.n);  // unknown -> row
      for (Vertex p = 0; p < plan.n; ++p) row_order[plan.column_of[p]] = plan.row_of[p];
      const auto filled = symmetric_pattern(*problem.pattern, row_order, plan.column_of);
      const auto needed = eliminate_fronts(filled, plan.pivot_begin), borders = borders_of(plan);
      for (Vertex f = 0; f < plan.num_fronts; ++f) {
        EXPECT_TRUE(std::includes(borders[f].begin(), borders[f].end(), needed[f].begin(), needed[f].end()));
        std::set<Vertex> brought;
        for (Vertex j = plan.pivot_begin[f + 1]; j < plan.n; ++j) {
          for (Vertex i = plan.pivot_begin[f]; i < plan.pivot_begin[f + 1]; ++i) {
            if (filled[i][j]) brought.insert(j);
          }
        }
        for (Vertex child = 0; child < f; ++child) {
          if (plan.parent[child] != f) continue;
          for (const Vertex j : borders[child]) {
            if (j >= plan.pivot_begin[f + 1]) brought.insert(j);
          }
        }
        EXPECT_EQ(borders[f], std::vector<Vertex>(brought.begin(), brought.end()));
      }
    }
  }
}

using Interval = std::pair<Offset, Offset>;

void expect_disjoint(std::vector<Interval> intervals, Offset end) {
  std::sort(intervals.begin(), intervals.end());
  Offset next = 0;
  for (const auto& [first, last] : intervals) {
    if (first == last) continue;
    EXPECT_GE(first, next);
    EXPECT_EQ(first % kAlignment, 0);
    next = last;
  }
  EXPECT_LE(next, end);
}

Interval contribution_of(const SymbolicPlan& plan, Vertex f) {
  const Offset begin = plan.contribution_begin[f], b = plan.border_rows(f);
  return {begin, begin + b * plan.contribution_ld(f)};
}

/// Checks each turn of each step, and returns what of the region is alive at once at most. Blocks that large
/// fronts have read in a turn are not needed any more.
Offset check_live_blocks(const SymbolicPlan& plan, const AssemblyTurns& turns = {}) {
  std::vector<Interval> factors;  // so far
  Offset most = 0;
  const auto is_done = [&](Vertex child, Vertex turn) {
    const Vertex f = plan.parent[child];
    return f >= 0 && plan.pivots(f) + plan.border_rows(f) > turns.rows && plan.assembly_turn[f] < turn;
  };
  for (Vertex step = 0; step < plan.num_depths; ++step) {
    for (Vertex f = plan.depth_begin[step]; f < plan.depth_begin[step + 1]; ++f) {
      const Offset p = plan.pivots(f), b = plan.border_rows(f);
      factors.emplace_back(plan.lower_begin[f], plan.lower_begin[f] + p * plan.lower_ld(f));
      factors.emplace_back(plan.upper_begin[f], plan.upper_begin[f] + p * b);
    }
    expect_disjoint(factors, plan.factor_entries);
    for (Vertex turn = 0; turn < turns.most; ++turn) {
      std::vector<Interval> live = factors;
      for (Vertex f = plan.depth_begin[step]; f < plan.depth_begin[step + 1]; ++f) {
        EXPECT_LT(plan.assembly_turn[f], turns.most);
        if (plan.assembly_turn[f] <= turn) live.push_back(contribution_of(plan, f));
      }
      for (Vertex f = plan.depth_begin[std::max(step - 1, 0)]; f < plan.depth_begin[step]; ++f) {
        if (!is_done(f, turn)) live.push_back(contribution_of(plan, f));
      }
      expect_disjoint(live, plan.storage_entries);
      Offset entries = 0;
      for (const auto& [first, last] : live) entries += last - first;
      most = std::max(most, entries);
    }
  }
  return most;
}

TEST(PlanCounts, NoTwoLiveBlocksOverlap) {
  for (const auto& shapes : {mixed_tree(), broom(), chain()})
    check_live_blocks(*artificial_problem(shapes, {1, 0.3, 64}).plan);
  for (const AssemblyTurns turns : {AssemblyTurns{2, 0}, AssemblyTurns{4, 350}})
    check_live_blocks(*artificial_problem(fork(), {1, 0.3, 64, turns}).plan, turns);
}

TEST(PlanCounts, TheRegionIsHardlyLargerThanWhatLivesInIt) {
  // Few large blocks, as of the last one, leave gaps.
  const std::pair<SparseMatrix, double> cases[] = {
      {grid_2d(150, 140), 1.05}, {grid_2d(90, 200), 1.05}, {random_diagonally_dominant(900, 4, 1), 1.2}};
  for (const auto& [matrix, limit] : cases) {
    const Pattern pattern = pattern_of(matrix);
    const SeparatorTree tree = order_matrix(pattern, MatchedScaling(), AnalysisOptions(), 1);
    const SymbolicPlan plan = make_symbolic_plan(pattern, {}, tree, 64, 1);
    ASSERT_GT(plan.num_depths, 5);
    const Offset live = check_live_blocks(plan);
    EXPECT_GE(plan.storage_entries, live);
    EXPECT_LE(static_cast<double>(plan.storage_entries), limit * static_cast<double>(live));
  }
}

void expect_smaller_region(const SymbolicPlan& plan, const AssemblyTurns& turns,
                           const SymbolicPlan& at_once) {
  EXPECT_TRUE(plan.has_turns());
  EXPECT_FALSE(at_once.has_turns());
  EXPECT_LT(plan.storage_entries, at_once.storage_entries);
  const Offset live = check_live_blocks(plan, turns);
  EXPECT_LE(static_cast<double>(plan.storage_entries), 1.05 * static_cast<double>(live));
}

TEST(PlanCounts, TurnsMakeTheRegionSmaller) {
  for (const SparseMatrix& matrix : {grid_2d(150, 140), grid_2d(90, 200)}) {
    const Pattern pattern = pattern_of(matrix);
    const SeparatorTree tree = order_matrix(pattern, MatchedScaling(), AnalysisOptions(), 1);
    const SymbolicPlan at_once = make_symbolic_plan(pattern, {}, tree, 64, 1);
    for (const AssemblyTurns& turns : {AssemblyTurns{2, 30}, AssemblyTurns{4, 60}})
      expect_smaller_region(make_symbolic_plan(pattern, {}, tree, 64, 1, turns), turns, at_once);
  }
  // Here the first order of its blocks leaves gaps.
  const AssemblyTurns turns{4, 0};
  expect_smaller_region(*artificial_problem(fork(), {1, 0.1, 64, turns}).plan, turns,
                        *artificial_problem(fork(), {1, 0.1}).plan);
}

TEST(PlanCounts, BlockWidthsAreAsEqualAsCanBe) {
  SymbolicPlan plan;
  plan.max_block_size = 64;
  EXPECT_EQ(plan.block_width(1), 1);
  EXPECT_EQ(plan.block_width(64), 64);
  EXPECT_EQ(plan.block_width(65), 33);
  EXPECT_EQ(plan.block_width(129), 43);
  plan.max_block_size = 1;
  EXPECT_EQ(plan.block_width(7), 1);
}

// Counted by hand: 2 pivots, 1 border row. LU of 2 x 2: one division, one multiplication, one subtraction;
// column block and row block: 5 + 3 - as LAPACK counts both together; update: 1 x 2 times 2 x 1.
TEST(PlanCounts, OperationsOfASmallFront) {
  const BlockFlops flops = block_flops(2, 1);
  EXPECT_EQ(flops.getrf, 3);
  EXPECT_EQ(flops.trsm, 6);
  EXPECT_EQ(flops.gemm, 4);
  EXPECT_EQ(block_flops(1, 0).getrf, 0);
  EXPECT_EQ(block_flops(1, 1).trsm, 1);
}

TEST(PlanCounts, EveryEntryIsThereOnceAndFrontsHaveThemByColumnAndRow) {
  const Pattern pattern = pattern_of(random_diagonally_dominant(700, 4, 11));
  AnalysisOptions options;
  options.leaf_size = 20;
  const SeparatorTree tree = order_matrix(pattern, MatchedScaling(), options, 1);
  const SymbolicPlan plan = make_symbolic_plan(pattern, {}, tree, 64, 3);
  std::vector<Vertex> position(plan.n);
  for (Vertex p = 0; p < plan.n; ++p) position[plan.column_of[p]] = p;
  std::vector<int> times(plan.nnz, 0);
  for (Vertex f = 0; f < plan.num_fronts; ++f) {
    std::pair<Vertex, Vertex> previous{-1, -1};
    for (Offset e = plan.entry_begin[f]; e < plan.entry_begin[f + 1]; ++e) {
      const Vertex row = plan.entry_row[e];
      const Offset slot = pattern.offsets[row] + plan.entry_in_row[e];
      ASSERT_GE(plan.entry_in_row[e], 0);
      ASSERT_LT(slot, pattern.offsets[row + 1]);
      ++times[slot];
      const Vertex column = pattern.columns[slot];
      const Vertex earlier = std::min(position[row], position[column]);
      EXPECT_LE(plan.pivot_begin[f], earlier);
      EXPECT_LT(earlier, plan.pivot_begin[f + 1]);
      EXPECT_LT(previous, std::pair(position[column], row));
      previous = {position[column], row};
    }
  }
  EXPECT_THAT(times, testing::Each(1));
}

TEST(PlanCounts, TheSamePlanForAnyNumberOfThreads) {
  for (const auto& matrix : {grid_2d(50, 61), random_diagonally_dominant(3000, 1, 5), arrow(400, 7)}) {
    const Pattern pattern = pattern_of(matrix);
    const SeparatorTree tree = order_matrix(pattern, MatchedScaling(), AnalysisOptions(), 1);
    const SymbolicPlan one = make_symbolic_plan(pattern, {}, tree, 64, 1);
    for (const int threads : {2, 3, 9}) {
      SCOPED_TRACE(std::to_string(threads) + " threads");
      const SymbolicPlan many = make_symbolic_plan(pattern, {}, tree, 64, threads);
      EXPECT_EQ(many.border, one.border);
      EXPECT_EQ(many.border_begin, one.border_begin);
      EXPECT_EQ(many.border_in_parent, one.border_in_parent);
      EXPECT_EQ(many.entry_begin, one.entry_begin);
      EXPECT_EQ(many.entry_target, one.entry_target);
      EXPECT_EQ(many.entry_row, one.entry_row);
      EXPECT_EQ(many.entry_in_row, one.entry_in_row);
      EXPECT_EQ(many.contribution_begin, one.contribution_begin);
      EXPECT_EQ(many.front_flops, one.front_flops);
    }
  }
}

TEST(PlanCounts, EntryBetweenBranchesIsRefused) {
  const SparseMatrix a = from_entries_summed(3, {{0, 0, 1}, {1, 1, 1}, {2, 2, 1}, {1, 0, 1}});
  const SeparatorTree tree{{0, 1, 2}, {0, 1, 2, 3}, {2, 2, -1}};
  try {
    make_symbolic_plan(pattern_of(a), {}, tree, 64, 1);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.argument(), "tree");
    EXPECT_EQ(error.row(), 1);
    EXPECT_EQ(error.column(), 0);
  }
}

}  // namespace
}  // namespace mfs::test
