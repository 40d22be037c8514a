// Subtrees that one thread does: that no block of theirs lies where another is needed, and that factors and
// solutions are those of the same stages depth by depth, bit for bit.
#include <algorithm>
#include <numeric>
#include <vector>

#include <mfs/analysis_options.hpp>

#include "ordering/order_matrix.hpp"
#include "plan/schedule.hpp"
#include "plan/subtrees.hpp"
#include "test/reference/generators.hpp"
#include "test/stages/stage_bench.hpp"

namespace mfs::test {
namespace {

StageProblem<double> grid_problem(int m, int n) {
  const SparseMatrix matrix = grid_2d(m, n);
  return matrix_problem(matrix, order_matrix(pattern_of(matrix), MatchedScaling(), AnalysisOptions(), 1), 64);
}

struct Range {
  Offset begin, end;
  bool meets(const Range& other) const { return begin < other.end && other.begin < end; }
};
Offset block_entries(const SymbolicPlan& plan, Vertex f) {
  return static_cast<Offset>(plan.contribution_ld(f)) * plan.border_rows(f);
}

/// Where nothing of a subtree may lie on a stack: the factors of all subtrees, and the blocks of their roots.
std::vector<Range> taken_ranges(const SymbolicPlan& plan, const Subtrees& subtrees) {
  std::vector<Range> taken;
  for (const Vertex f : subtrees.front) {
    const Offset p = plan.pivots(f);
    taken.push_back({plan.lower_begin[f], plan.lower_begin[f] + p * plan.lower_ld(f)});
    taken.push_back({plan.upper_begin[f], plan.upper_begin[f] + p * plan.border_rows(f)});
    if (subtrees.place[f] < 0)
      taken.push_back({plan.contribution_begin[f], plan.contribution_begin[f] + block_entries(plan, f)});
  }
  return taken;
}

void check_stacks(const SymbolicPlan& plan, const Subtrees& subtrees) {
  Offset height = 0;
  for (const Vertex f : subtrees.front) {
    if (subtrees.place[f] >= 0) height = std::max(height, subtrees.place[f] + block_entries(plan, f));
  }
  std::vector<Range> stacks = taken_ranges(plan, subtrees);
  const std::size_t others = stacks.size();
  for (const Offset begin : subtrees.stack) stacks.push_back({begin, begin + height});
  for (std::size_t i = others; i < stacks.size(); ++i) {
    EXPECT_LE(stacks[i].end, plan.storage_entries);
    for (std::size_t j = 0; j < i; ++j) ASSERT_FALSE(stacks[i].meets(stacks[j])) << i - others << ", " << j;
  }
}

/// One task, front after front: a block is made where none lies that is still to be read.
void follow(const SymbolicPlan& plan, const Subtrees& subtrees, Vertex task) {
  std::vector<Vertex> live;
  const auto range = [&](Vertex f) {
    return Range{subtrees.place[f], subtrees.place[f] + block_entries(plan, f)};
  };
  for (Vertex k = subtrees.begin[task]; k < subtrees.begin[task + 1]; ++k) {
    const Vertex f = subtrees.front[k];
    std::vector<Vertex> left;
    for (const Vertex g : live) {
      ASSERT_FALSE(subtrees.place[f] >= 0 && range(f).meets(range(g))) << "blocks of " << f << " and " << g;
      if (plan.parent[g] != f) left.push_back(g);
    }
    ASSERT_EQ(static_cast<Vertex>(live.size() - left.size()), plan.child_begin[f + 1] - plan.child_begin[f])
        << "front " << f << " comes before its children";
    live = left;
    if (subtrees.place[f] >= 0) live.push_back(f);
  }
  EXPECT_TRUE(live.empty());
}

/// A chain of 300 depths with ever larger blocks: the first places to cut it at have stacks that are too
/// high.
std::vector<FrontShape> high_chain() {
  std::vector<FrontShape> shapes;
  for (Vertex k = 0; k < 299; ++k) shapes.push_back({2, std::min(3 * k, 500), k + 1});
  shapes.push_back({500, 0, -1});
  return shapes;
}

std::vector<StageProblem<double>> problems() {
  return {grid_problem(70, 60),
          grid_problem(300, 3),
          artificial_problem(mixed_tree(), {21, 0.6, 64}),
          artificial_problem(broom(), {23}),
          artificial_problem(chain(), {24}),
          artificial_problem(high_chain(), {25})};
}

TEST(Subtrees, HaveTheirBlocksWhereNothingElseIs) {
  Vertex covered = 0;
  for (const StageProblem<double>& problem : problems()) {
    const SymbolicPlan& plan = *problem.plan;
    for (const int threads : {1, 2, 3, 16}) {
      const Subtrees subtrees = make_subtrees(plan, threads);
      covered += subtrees.steps;
      if (subtrees.steps == 0) continue;
      std::vector<Vertex> fronts = subtrees.front, all(plan.depth_begin[subtrees.steps]);
      std::sort(fronts.begin(), fronts.end());
      std::iota(all.begin(), all.end(), 0);
      EXPECT_EQ(fronts, all);
      ASSERT_EQ(static_cast<int>(subtrees.stack.size()), threads);
      check_stacks(plan, subtrees);
      for (Vertex task = 0; task < subtrees.tasks(); ++task) follow(plan, subtrees, task);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
  EXPECT_GT(covered, 20);
}

TEST(Subtrees, AreManyForManyThreads) {
  const StageProblem<double> problem = grid_problem(70, 60);
  const Subtrees one = make_subtrees(*problem.plan, 1), two = make_subtrees(*problem.plan, 2);
  EXPECT_GT(one.steps, two.steps);
  ASSERT_GT(two.steps, 0);
  double total = 0, largest = 0;
  for (Vertex task = 0; task < two.tasks(); ++task) {
    double flops = 0;
    for (Vertex k = two.begin[task]; k < two.begin[task + 1]; ++k)
      flops += problem.plan->front_flops[two.front[k]];
    total += flops;
    largest = std::max(largest, flops);
  }
  EXPECT_LT(largest, total / 4);
}

/// Factors, exchanges, shifts and a solution by the tree with subtrees and without.
template <class Exec>
void expect_same_with_subtrees(const StageProblem<double>& problem, int threads) {
  const SymbolicPlan& plan = *problem.plan;
  const Schedule depths = make_schedule(plan, threads);
  const Subtrees subtrees = make_subtrees(plan, threads);
  ASSERT_GT(subtrees.steps, 0);
  const auto steps = static_cast<std::size_t>(subtrees.steps);
  const std::vector<double> b = Random(3).vector(2 * static_cast<Offset>(plan.n));
  in_engine(threads, [&] {
    StageBench<Exec, double> plain(problem), with(problem);
    plain.factor_all({nullptr, depths.data(), depths.size()}, 0, PivotRule{1e-8, 1e-8});
    with.factor_all({&subtrees, depths.data() + steps, depths.size() - steps}, subtrees.stack.size(),
                    PivotRule{1e-8, 1e-8});
    for (Vertex f = 0; f < plan.num_fronts; ++f) {
      ASSERT_EQ(plain.front(f).lower, with.front(f).lower) << f;
      ASSERT_EQ(plain.front(f).upper, with.front(f).upper) << f;
      ASSERT_EQ(plain.row_at(f), with.row_at(f)) << f;
      ASSERT_EQ(plain.shift(f), with.shift(f)) << f;
    }
    EXPECT_NEAR(plain.status().gemm, with.status().gemm, 1e-12 * plain.status().gemm);
    EXPECT_NEAR(plain.status().getrf, with.status().getrf, 1e-12 * plain.status().getrf);
    EXPECT_EQ(plain.status().perturbed, with.status().perturbed);
    for (const bool transposed : {false, true}) {
      for (const Vertex columns : {1, 2}) {
        const std::vector<double> v(b.begin(), b.begin() + static_cast<Offset>(columns) * plan.n);
        plain.put_vectors(columns, v, {});
        with.put_vectors(columns, v, {});
        plain.solve_all({nullptr, depths.data(), depths.size()}, transposed);
        with.solve_all({&subtrees, depths.data() + steps, depths.size() - steps}, transposed);
        ASSERT_EQ(plain.v(), with.v()) << columns << (transposed ? ", transposed" : "");
      }
    }
  });
}

TEST(Subtrees, LeaveEveryNumberAsItIs) {
  const StageProblem<double> grid = grid_problem(70, 60),
                             tree = artificial_problem(mixed_tree(), {21, 0.6, 64});
  expect_same_with_subtrees<Kokkos::Serial>(grid, 1);
  expect_same_with_subtrees<Kokkos::Serial>(tree, 1);
  for (const int threads : {2, 3}) expect_same_with_subtrees<Kokkos::OpenMP>(grid, threads);
}

}  // namespace
}  // namespace mfs::test
