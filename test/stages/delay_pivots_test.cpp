// Pivots that failed, moved up the tree: by hand on a chain of three fronts, and on trees of grids and random
// matrices with any failures, where nothing may get lost and no entry may join two branches.
#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include <mfs/analysis_options.hpp>

#include "ordering/order_matrix.hpp"
#include "plan/delay_pivots.hpp"
#include "test/reference/generators.hpp"
#include "test/stages/artificial_problem.hpp"

namespace mfs::test {
namespace {

using testing::ElementsAre;

// Fronts {0, 1}, {2, 3}, {4, 5} of a chain, each the parent of the one before.
SymbolicPlan chain_plan() {
  const SeparatorTree tree{{0, 1, 2, 3, 4, 5}, {0, 2, 4, 6}, {1, 2, -1}};
  return make_symbolic_plan(pattern_of(tridiagonal(6)), {}, tree, 64, 1);
}

TEST(DelayPivots, OneLevelBehindThoseThatWereThere) {
  const SymbolicPlan plan = chain_plan();
  const DelayedTree delayed = delay_pivots(plan, {{0, 0}}, 1, 1);
  EXPECT_THAT(delayed.tree.order, ElementsAre(1, 2, 3, 0, 4, 5));
  EXPECT_THAT(delayed.tree.node_begin, ElementsAre(0, 1, 4, 6));
  EXPECT_THAT(delayed.tree.parent, ElementsAre(1, 2, -1));
  EXPECT_THAT(delayed.row_order, ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(DelayPivots, AtMostToTheRootWhereTheyStay) {
  const SymbolicPlan plan = chain_plan();
  const DelayedTree delayed = delay_pivots(plan, {{1, 1}, {2, 2}, {4, 4}}, 5, 1);
  EXPECT_THAT(delayed.tree.order, ElementsAre(0, 3, 4, 5, 1, 2));
  EXPECT_THAT(delayed.tree.node_begin, ElementsAre(0, 1, 2, 6));
}

TEST(DelayPivots, OnlyThoseOfRootsCannotMove) {
  const SymbolicPlan plan = chain_plan();
  EXPECT_FALSE(can_move(plan, {}));
  EXPECT_FALSE(can_move(plan, {{4, 4}, {5, 4}}));
  EXPECT_TRUE(can_move(plan, {{3, 3}, {4, 4}}));
  EXPECT_TRUE(can_move(plan, {{0, 0}}));
}

TEST(DelayPivots, AFrontWithoutPivotsIsNone) {
  const SymbolicPlan plan = chain_plan();
  const DelayedTree delayed = delay_pivots(plan, {{2, 2}, {3, 3}}, 1, 1);
  EXPECT_THAT(delayed.tree.order, ElementsAre(0, 1, 4, 5, 2, 3));
  EXPECT_THAT(delayed.tree.node_begin, ElementsAre(0, 2, 6));
  EXPECT_THAT(delayed.tree.parent, ElementsAre(1, -1));
}

// Row 1 was the pivot of column 0, and column 1 has failed with row 0.
TEST(DelayPivots, TheRowThatCameToThePivotGoesWithIt) {
  const SymbolicPlan plan = chain_plan();
  const DelayedTree delayed = delay_pivots(plan, {{1, 0}}, 1, 1);
  EXPECT_THAT(delayed.tree.order, ElementsAre(0, 2, 3, 1, 4, 5));
  EXPECT_THAT(delayed.row_order, ElementsAre(1, 0, 2, 3, 4, 5));
}

// Whichever pivots fail, with whichever rows of their blocks.
std::vector<FailedPivot> random_failures(const SymbolicPlan& plan, std::mt19937_64& random) {
  std::vector<FailedPivot> failed;
  std::bernoulli_distribution fails(0.2);
  for (Vertex f = 0; f < plan.num_fronts; ++f) {
    std::vector<Vertex> rows(plan.row_of.begin() + plan.pivot_begin[f],
                             plan.row_of.begin() + plan.pivot_begin[f + 1]);
    std::shuffle(rows.begin(), rows.end(), random);
    for (Vertex p = plan.pivot_begin[f]; p < plan.pivot_begin[f + 1]; ++p) {
      if (fails(random)) failed.push_back({p, rows[p - plan.pivot_begin[f]]});
    }
  }
  return failed;
}

std::vector<Vertex> sorted(std::vector<Vertex> list) {
  std::sort(list.begin(), list.end());
  return list;
}

std::vector<Vertex> front_of_column(const SymbolicPlan& plan) {
  std::vector<Vertex> front(static_cast<std::size_t>(plan.n));
  for (Vertex f = 0; f < plan.num_fronts; ++f) {
    for (Vertex p = plan.pivot_begin[f]; p < plan.pivot_begin[f + 1]; ++p) front[plan.column_of[p]] = f;
  }
  return front;
}

// Where column and row of the same position of the delayed plan were before.
void expect_pairs_of_one_front(const SymbolicPlan& before, const std::vector<FailedPivot>& failures,
                               Vertex levels, const SymbolicPlan& after) {
  const std::vector<Vertex> front = front_of_column(before), now = front_of_column(after);
  std::vector<Vertex> front_of_row(front.size()), position(front.size());
  std::vector<char> failed(front.size(), 0);
  for (const FailedPivot& pivot : failures) failed[pivot.position] = 1;
  for (Vertex p = 0; p < before.n; ++p) {
    front_of_row[before.row_of[p]] = front[before.column_of[p]];
    position[before.column_of[p]] = p;
  }
  for (Vertex p = 0; p < after.n; ++p) EXPECT_EQ(front_of_row[after.row_of[p]], front[after.column_of[p]]);
  // Columns of the front that a pivot was moved to, if that has kept any, are in one front with it.
  for (Vertex column = 0; column < before.n; ++column) {
    Vertex goal = front[column];
    for (Vertex k = 0; failed[position[column]] && k < levels && before.parent[goal] >= 0; ++k)
      goal = before.parent[goal];
    for (Vertex p = before.pivot_begin[goal]; p < before.pivot_begin[goal + 1]; ++p) {
      if (!failed[p]) {
        EXPECT_EQ(now[before.column_of[p]], now[column]);
      }
    }
  }
}

TEST(DelayPivots, AnyFailuresLeaveATreeOfTheMatrix) {
  std::mt19937_64 random(20261125);
  const std::vector<SparseMatrix> matrices{grid_2d(19, 23), random_diagonally_dominant(300, 2, 5),
                                           arrow(60, 4), tridiagonal(90), grid_2d(1, 1)};
  for (const SparseMatrix& matrix : matrices) {
    const Pattern pattern = pattern_of(matrix);
    const SeparatorTree tree = order_matrix(pattern, MatchedScaling(), AnalysisOptions(), 1);
    const SymbolicPlan plan = make_symbolic_plan(pattern, {}, tree, 64, 1);
    for (const Vertex levels : {1, 2, 3, 96}) {
      SCOPED_TRACE("n = " + std::to_string(matrix.n) + ", levels " + std::to_string(levels));
      const std::vector<FailedPivot> failed = random_failures(plan, random);
      const DelayedTree delayed = delay_pivots(plan, failed, levels, 2);
      const SymbolicPlan after =  // throws where an entry joins two branches
          make_symbolic_plan(pattern, delayed.row_order, delayed.tree, 64, 1);
      EXPECT_EQ(sorted(after.column_of), sorted(plan.column_of));
      EXPECT_EQ(sorted(after.row_of), sorted(plan.row_of));
      for (Vertex f = 0; f < after.num_fronts; ++f) EXPECT_GT(after.pivots(f), 0);
      expect_pairs_of_one_front(plan, failed, levels, after);
    }
  }
}

}  // namespace
}  // namespace mfs::test
