// Solves of plans with a block triangle (plan/block_triangle.hpp), by fronts and by panels, against
// elimination by plain loops; and which blocks threads take together.
#include <numeric>
#include <string>

#include <gtest/gtest.h>

#include "kernels/panels/panel_factors.hpp"
#include "kernels/stages/front_store.hpp"
#include "ordering/diagonal_blocks.hpp"
#include "ordering/matching.hpp"
#include "ordering/order_matrix.hpp"
#include "plan/block_schedule.hpp"
#include "test/reference/generators.hpp"
#include "test/stages/artificial_problem.hpp"
#include "test/stages/in_engine.hpp"

namespace mfs::test {
namespace {

std::vector<std::int64_t> several(std::int64_t count, std::int64_t size) {
  return std::vector<std::int64_t>(static_cast<std::size_t>(count), size);
}

struct Blocks {
  std::string name;
  std::vector<std::int64_t> sizes;
};

/// Blocks of all sizes that kernels know borders at, many in a row, and some that several threads share.
std::vector<Blocks> cases() {
  return {{"singles", several(65, 1)},
          {"two", {1, 1}},
          {"sizes", {1, 2, 31, 32, 33, 65, 1, 2, 31}},
          {"chain", several(40, 7)},
          {"large", {1, 3, 600, 5, 600, 8, 1}}};
}

StageProblem<double> problem_of(const SparseMatrix& matrix) {
  StageProblem<double> problem;
  problem.values = matrix.values;
  problem.pattern = std::make_shared<Pattern>(pattern_of(matrix));
  MatchedScaling matched = match_and_scale(*problem.pattern, matrix.values.data(), {}, 1);
  const auto blocks = find_diagonal_blocks(*problem.pattern, matched);
  EXPECT_NE(blocks, nullptr);
  Random random(3);
  for (std::vector<double>* scale : {&problem.row_scale, &problem.column_scale}) {
    for (Vertex i = 0; i < problem.pattern->n; ++i)
      scale->push_back(std::ldexp(1.0, static_cast<int>(random.integer(-3, 4))));
  }
  const SeparatorTree tree =
      order_matrix(blocks->pattern, matched, {}, 1, {}, nullptr, TreeHeight::any, Parts::apart);
  problem.plan = std::make_shared<SymbolicPlan>(make_symbolic_plan(
      *problem.pattern, blocks.get(), matched.row_order, in_block_order(tree, *blocks), 64, 1, {}));
  return problem;
}

/// Gaussian elimination with exchanges of rows, one number after the other.
template <class Number>
class DenseMatrix {
 public:
  explicit DenseMatrix(Vertex n)
      : n_(n), entries_(static_cast<std::size_t>(n) * static_cast<std::size_t>(n)) {}
  Number& at(Vertex i, Vertex j) {
    return entries_[static_cast<std::size_t>(i) * static_cast<std::size_t>(n_) + static_cast<std::size_t>(j)];
  }
  std::vector<Number> solve(std::vector<Number> b) {
    for (Vertex k = 0; k < n_; ++k) {
      Vertex pivot = k;
      for (Vertex i = k + 1; i < n_; ++i)
        if (std::abs(at(i, k)) > std::abs(at(pivot, k))) pivot = i;
      for (Vertex j = 0; j < n_; ++j) std::swap(at(k, j), at(pivot, j));
      std::swap(b[k], b[pivot]);
      for (Vertex i = k + 1; i < n_; ++i) {
        if (at(i, k) == Number(0)) continue;
        const Number factor = at(i, k) / at(k, k);
        for (Vertex j = k; j < n_; ++j) at(i, j) -= factor * at(k, j);
        b[i] -= factor * b[k];
      }
    }
    for (Vertex k = n_ - 1; k >= 0; --k) {
      for (Vertex j = k + 1; j < n_; ++j) b[k] -= at(k, j) * b[j];
      b[k] /= at(k, k);
    }
    return b;
  }

 private:
  Vertex n_;
  std::vector<Number> entries_;
};

/// In double precision.
template <class Scalar>
using Exact = std::conditional_t<std::is_same_v<Scalar, RealOf<Scalar>>, double, std::complex<double>>;

template <class Scalar>
std::vector<Exact<Scalar>> reference(const StageProblem<Scalar>& problem, bool transposed,
                                     const Scalar* right) {
  const Pattern& pattern = *problem.pattern;
  DenseMatrix<Exact<Scalar>> dense(pattern.n);
  for (Vertex i = 0; i < pattern.n; ++i)
    for (Offset k = pattern.offsets[i]; k < pattern.offsets[i + 1]; ++k)
      (transposed ? dense.at(pattern.columns[k], i) : dense.at(i, pattern.columns[k])) =
          Exact<Scalar>(problem.values[k]);
  return dense.solve({right, right + pattern.n});
}

template <class Scalar>
std::unique_ptr<Factors<Scalar>> fronts_of(const StageProblem<Scalar>& problem, int threads) {
  const HostSpace space = threads == 1 ? HostSpace::serial : HostSpace::openmp;
  return make_host_factors<Scalar>(space, false, problem.plan, problem.pattern, threads);
}
template <class Scalar>
std::unique_ptr<Factors<Scalar>> panels_of(const StageProblem<Scalar>& problem) {
  return make_panel_factors<Scalar>(
      false, fronts_of(problem, 1), problem.plan, problem.pattern,
      std::make_shared<PanelProgram>(plan_panels(*problem.plan, *problem.pattern)));
}

template <class Scalar>
std::vector<Scalar> solutions(const StageProblem<Scalar>& problem, Factors<Scalar>& factors,
                              const std::vector<Scalar>& b, bool transposed) {
  const auto n = static_cast<std::size_t>(problem.pattern->n);
  fill(problem, factors);
  EXPECT_EQ(factors.factor(PivotPolicy(1e-8), {}).status.perturbed, 0u);
  const auto columns = static_cast<Vertex>(b.size() / n);
  factors.make_room(columns);
  std::vector<Scalar> x(b.size());
  factors.apply_inverse(b.data(), x.data(), columns, transposed);
  return x;
}

template <class Scalar>
class BlockTriangleOf : public testing::Test {};
using Scalars = testing::Types<double, float, std::complex<double>, std::complex<float>>;
TYPED_TEST_SUITE(BlockTriangleOf, Scalars);

TYPED_TEST(BlockTriangleOf, SolvesAsPlainLoopsDo) {
  constexpr double kEpsilon = std::numeric_limits<RealOf<TypeParam>>::epsilon();
  constexpr Vertex kColumns = 16;
  for (const Blocks& blocks : cases()) {
    const StageProblem<TypeParam> problem =
        in_numbers_of<TypeParam>(problem_of(permuted_blocks(blocks.sizes, 5)));
    ASSERT_EQ(problem.plan->triangle.blocks(), static_cast<Vertex>(blocks.sizes.size()));
    const auto n = static_cast<std::size_t>(problem.pattern->n);
    const std::vector<TypeParam> b = Random(6).vector<TypeParam>(problem.pattern->n * kColumns);
    for (const bool transposed : {false, true}) {
      std::vector<std::vector<Exact<TypeParam>>> expected;
      for (const std::size_t column : {0, 3, 15})
        expected.push_back(reference(problem, transposed, b.data() + column * n));
      const auto expect_right = [&](Factors<TypeParam>& factors, const std::string& by) {
        SCOPED_TRACE(blocks.name + by + (transposed ? ", transposed" : ""));
        for (const Vertex columns : {1, 4, 16}) {
          const std::vector<TypeParam> x = solutions(
              problem, factors,
              std::vector<TypeParam>(b.begin(), b.begin() + static_cast<std::ptrdiff_t>(n) * columns),
              transposed);
          std::size_t known = 0;
          for (const std::size_t column : {0, 3, 15}) {
            if (column >= static_cast<std::size_t>(columns)) break;
            double size = 0, error = 0;
            for (std::size_t i = 0; i < n; ++i) {
              size = std::max(size, std::abs(expected[known][i]));
              error = std::max(error, std::abs(expected[known][i] - Exact<TypeParam>(x[column * n + i])));
            }
            EXPECT_LT(error, 1e4 * kEpsilon * size) << columns << " columns, column " << column;
            ++known;
          }
        }
      };
      for (const int threads : {1, 3})
        in_engine(threads, [&] {
          expect_right(*fronts_of(problem, threads), ", " + std::to_string(threads) + " threads");
        });
      in_engine(1, [&] { expect_right(*panels_of(problem), ", panels"); });
    }
  }
}

TEST(BlockTriangle, TheSameBitsFromRunToRun) {
  const StageProblem<double> problem = problem_of(permuted_blocks(cases().back().sizes, 5));
  const std::vector<double> b = Random(6).vector(problem.pattern->n);
  std::vector<double> first;
  in_engine(4, [&] {
    for (int run = 0; run < 5; ++run) {
      const auto factors = fronts_of(problem, 4);
      const std::vector<double> x = solutions(problem, *factors, b, run % 2 == 1);
      if (run < 2) first.insert(first.end(), x.begin(), x.end());
      const auto begin = first.begin() + (run % 2 == 1 ? problem.pattern->n : 0);
      EXPECT_TRUE(std::equal(x.begin(), x.end(), begin)) << "run " << run;
    }
  });
}

/// Goes through the lists as executors do, and asks that what a block needs has been solved for.
void expect_complete(const SymbolicPlan& plan, const BlockSchedule& schedule, bool transposed) {
  const BlockTriangle& triangle = plan.triangle;
  const BlockTriangle::Couplings& couplings = transposed ? triangle.by_column : triangle.by_row;
  std::vector<Vertex> block_of(static_cast<std::size_t>(plan.num_fronts));
  for (Vertex b = 0; b < triangle.blocks(); ++b)
    for (Vertex k = triangle.block_begin[b]; k < triangle.block_begin[b + 1]; ++k)
      block_of[triangle.front[k]] = b;
  std::vector<int> up(static_cast<std::size_t>(plan.num_fronts), 0), down(up);
  std::vector<Vertex> front_of(static_cast<std::size_t>(plan.n));
  for (Vertex f = 0; f < plan.num_fronts; ++f)
    for (Vertex p = plan.pivot_begin[f]; p < plan.pivot_begin[f + 1]; ++p) front_of[p] = f;
  const auto go_up = [&](Vertex f) {
    ++up[f];
    for (Vertex c = plan.child_begin[f]; c < plan.child_begin[f + 1]; ++c) EXPECT_EQ(up[plan.children[c]], 1);
    for (Vertex p = plan.pivot_begin[f]; p < plan.pivot_begin[f + 1]; ++p)
      for (Offset k = couplings.begin[p]; k < couplings.begin[p + 1]; ++k)
        EXPECT_EQ(down[front_of[couplings.others[k]]], 1) << "block " << block_of[f];
  };
  const auto go_down = [&](Vertex f) {
    EXPECT_EQ(up[f], 1);
    if (plan.parent[f] >= 0) {
      EXPECT_EQ(down[plan.parent[f]], 1);
    }
    ++down[f];
  };
  for (const BlockSchedule::List& list : schedule.lists[transposed]) {
    const BlockSchedule::Step& step = schedule.steps[list.step];
    if (list.depth < 0) {
      for (const BlockSchedule::Group& group : step.groups) {
        ASSERT_LT(group.begin, group.end);
        for (Vertex i = 0; i < group.end - group.begin; ++i) {
          const Vertex b = transposed ? group.end - 1 - i : group.begin + i;
          for (Vertex k = triangle.block_begin[b]; k < triangle.block_begin[b + 1]; ++k)
            go_up(triangle.front[k]);
          for (Vertex k = triangle.block_begin[b + 1]; k-- > triangle.block_begin[b];)
            go_down(triangle.front[k]);
        }
      }
      continue;
    }
    const DepthSchedule& depth = step.depths[list.depth];
    std::vector<Vertex> fronts = depth.large;
    fronts.insert(fronts.end(), depth.small.begin(), depth.small.end());
    for (const Vertex f : fronts) list.down ? go_down(f) : go_up(f);
  }
  EXPECT_EQ(up, std::vector<int>(up.size(), 1));
  EXPECT_EQ(down, std::vector<int>(down.size(), 1));
}

TEST(BlockTriangle, SchedulesHaveEachBlockAfterWhatItNeeds) {
  std::vector<Blocks> all = cases();
  all.push_back({"many singles", several(2000, 1)});
  std::size_t shared = 0, groups = 0;
  for (const Blocks& blocks : all) {
    const StageProblem<double> problem = problem_of(permuted_blocks(blocks.sizes, 5));
    for (const int threads : {1, 2, 16}) {
      SCOPED_TRACE(blocks.name + ", " + std::to_string(threads) + " threads");
      const BlockSchedule schedule = make_block_schedule(*problem.plan, threads);
      for (const bool transposed : {false, true}) expect_complete(*problem.plan, schedule, transposed);
      for (const BlockSchedule::Step& step : schedule.steps) {
        shared += step.depths.size();
        groups = std::max(groups, step.groups.size());
      }
      if (threads == 1) {
        EXPECT_EQ(schedule.lists[0].size(), 1u);
        EXPECT_EQ(shared, 0u);
      }
      shared = threads == 16 ? 0 : shared;
      if (threads == 2 && blocks.name == "large") {
        EXPECT_GE(shared, 3u);
      }
    }
  }
  EXPECT_GT(groups, 4u);
  EXPECT_TRUE(make_block_schedule(SymbolicPlan(), 4).lists[0].empty());
}

}  // namespace
}  // namespace mfs::test
