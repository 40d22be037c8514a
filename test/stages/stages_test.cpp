// Every stage alone, on the input that the plain reference has at that point, for fronts of all kinds of
// sizes: one row, around a vector register, past a panel, past a tile.
#include <map>
#include <string>

#include "test/stages/stage_cases.hpp"

namespace mfs::test {
namespace {

constexpr PivotRule kNoRule{0, 0};
constexpr Stages kAssemble{true, false, false}, kFactor{false, true, false}, kUpdate{false, false, true};

template <class Tested>
const std::vector<Case<typename Tested::Scalar>>& trees() {
  using Cases = std::vector<Case<typename Tested::Scalar>>;
  static const Cases* const cases = [] {
    auto* made = new Cases(four_trees<typename Tested::Scalar>());
    if (Tested::kThorough) {  // past the tiles of large fronts (384 in factor and update, 256 in solve)
      made->emplace_back("400 pivots, border 450", artificial_problem(leaf_and_root(400, 450), {5}));
    }
    return made;
  }();
  return *cases;
}

template <class Scalar>
StageProblem<Scalar> with_block_size(const StageProblem<Scalar>& problem, Vertex max_block_size) {
  StageProblem<Scalar> changed = problem;
  auto plan = std::make_shared<SymbolicPlan>(*problem.plan);
  plan->max_block_size = max_block_size;
  changed.plan = std::move(plan);
  return changed;
}

template <class Exec, class Scalar>
void check_depth(StageBench<Exec, Scalar>& bench, const SymbolicPlan& plan,
                 const ReferenceStages<Scalar>& expected, Vertex step, const DepthSchedule& schedule) {
  const auto each_front = [&](auto&& body) {
    for (Vertex f = plan.depth_begin[step]; f < plan.depth_begin[step + 1]; ++f) {
      SCOPED_TRACE("front " + std::to_string(f));
      body(f);
    }
  };
  each_front([&](Vertex f) {
    for (Vertex c = plan.child_begin[f]; c < plan.child_begin[f + 1]; ++c) {
      bench.put_front(plan.children[c], expected.updated[plan.children[c]]);
    }
  });
  bench.factor_depth(schedule, kNoRule, kAssemble);
  each_front([&](Vertex f) {  // sums of few terms in a fixed order: the same bits
    const FrontBlocks<Scalar> blocks = bench.front(f);
    EXPECT_EQ(difference(blocks.lower, expected.assembled[f].lower), 0) << "assemble, P and L";
    EXPECT_EQ(difference(blocks.upper, expected.assembled[f].upper), 0) << "assemble, U";
    EXPECT_EQ(difference(blocks.contribution, expected.assembled[f].contribution), 0) << "assemble, C";
    bench.put_front(f, expected.assembled[f]);
  });
  bench.factor_depth(schedule, kNoRule, kFactor);
  each_front([&](Vertex f) {
    const FrontBlocks<Scalar> blocks = bench.front(f);
    EXPECT_EQ(bench.row_at(f), expected.fronts[f].row_at);
    EXPECT_EQ(bench.shift(f), expected.fronts[f].shift);
    EXPECT_LT(difference(blocks.lower, expected.factored[f].lower), kTolerance<Scalar>) << "factor, P and L";
    EXPECT_LT(difference(blocks.upper, expected.factored[f].upper), kTolerance<Scalar>) << "factor, U";
    EXPECT_EQ(difference(blocks.contribution, expected.assembled[f].contribution), 0)
        << "factor must leave C";
    bench.put_front(f, expected.factored[f]);
  });
  bench.factor_depth(schedule, kNoRule, kUpdate);
  each_front([&](Vertex f) {
    const FrontBlocks<Scalar> blocks = bench.front(f);
    EXPECT_EQ(difference(blocks.lower, expected.factored[f].lower), 0) << "update must leave P and L";
    EXPECT_EQ(difference(blocks.upper, expected.factored[f].upper), 0) << "update must leave U";
    EXPECT_LT(difference(blocks.contribution, expected.updated[f].contribution), kTolerance<Scalar>)
        << "update, C";
  });
}

template <class Exec, class Scalar>
void check_factorization(const StageProblem<Scalar>& problem, const ReferenceStages<Scalar>& expected,
                         Path path) {
  StageBench<Exec, Scalar> bench(problem);
  const SymbolicPlan& plan = *problem.plan;
  BlockFlops flops{0, 0, 0};
  for (Vertex step = 0; step < plan.num_depths; ++step) {
    check_depth(bench, plan, expected, step, forced_schedule(plan, step, path));
  }
  for (Vertex f = 0; f < plan.num_fronts; ++f) {
    const BlockFlops front = plan.flops_of(f);
    flops.getrf += front.getrf;
    flops.trsm += front.trsm;
    flops.gemm += front.gemm;
  }
  const FactorStatus status = bench.status();
  EXPECT_EQ(status.perturbed, 0u);
  EXPECT_EQ(status.nonfinite, 0u);
  EXPECT_NEAR(status.getrf, flops.getrf, 1e-12 * flops.getrf);
  EXPECT_NEAR(status.trsm, flops.trsm, 1e-12 * flops.trsm);
  EXPECT_NEAR(status.gemm, flops.gemm, 1e-12 * flops.gemm);
}

/// v and what the reference makes of it, forward and all the way.
template <class Scalar>
struct SolveCase {
  Vertex columns;
  bool transposed;
  std::vector<Scalar> v, y, x;
};

template <class Scalar>
SolveCase<Scalar> solve_case(const Case<Scalar>& tested, Vertex columns, bool transposed) {
  const Vertex n = tested.problem.plan->n;
  const std::vector<double> random = Random(77).vector(static_cast<std::int64_t>(n) * columns);
  SolveCase<Scalar> solve{columns, transposed, {}, {}, {}};
  for (const double value : random) solve.v.push_back(static_cast<RealOf<Scalar>>(value));
  for (Vertex j = 0; j < columns; ++j) {
    std::vector<Scalar> column(solve.v.begin() + static_cast<Offset>(j) * n,
                               solve.v.begin() + static_cast<Offset>(j + 1) * n);
    solve_forward(tested.reference.fronts, transposed, column);
    solve.y.insert(solve.y.end(), column.begin(), column.end());
    solve_backward(tested.reference.fronts, transposed, column);
    solve.x.insert(solve.x.end(), column.begin(), column.end());
  }
  return solve;
}

template <class Exec, class Scalar>
void check_solve(const Case<Scalar>& tested, const SolveCase<Scalar>& solve, Path path) {
  const SymbolicPlan& plan = *tested.problem.plan;
  StageBench<Exec, Scalar> bench(tested.problem);
  for (Vertex f = 0; f < plan.num_fronts; ++f) bench.put_factored(f, tested.reference.fronts[f]);
  bench.put_vectors(solve.columns, solve.v, {});
  for (Vertex step = 0; step < plan.num_depths; ++step) {
    bench.solve_depth(forced_schedule(plan, step, path), true, solve.transposed);
  }
  EXPECT_LT(difference(bench.y(), solve.y), kTolerance<Scalar>) << "forward";
  const std::vector<Scalar> nothing(solve.v.size(), Scalar(std::numeric_limits<RealOf<Scalar>>::quiet_NaN()));
  bench.put_vectors(solve.columns, nothing, solve.y);
  for (Vertex step = plan.num_depths - 1; step >= 0; --step) {
    bench.solve_depth(forced_schedule(plan, step, path), false, solve.transposed);
  }
  EXPECT_LT(difference(bench.v(), solve.x), kTolerance<Scalar>) << "backward";
}

template <class Tested>
class StagesTest : public testing::Test {
 protected:
  using Exec = typename Tested::Exec;
  using Scalar = typename Tested::Scalar;
  using Cases = std::vector<Case<Scalar>>;

  template <class Check>
  void for_each_run(const Cases& cases, const std::vector<Path>& paths, const Check& check) {
    for (const int threads : thread_counts<Tested>()) {
      if (threads > 2 && cases.size() > 10) continue;  // trees are enough for that
      in_engine(threads, [&] {
        for (const Case<Scalar>& tested : cases) {
          for (const Path path : paths) {
            if (this->HasFailure()) return;  // one broken case says enough
            SCOPED_TRACE(tested.name + ", path " + std::to_string(static_cast<int>(path)) + ", threads " +
                         std::to_string(threads));
            check(tested, path, threads);
          }
        }
      });
    }
  }

  void check_stages(const Cases& cases, const std::vector<Path>& paths) {
    for_each_run(cases, paths, [](const Case<Scalar>& tested, Path path, int threads) {
      const bool all = Tested::kThorough && threads == 1;
      for (const Vertex block :
           all ? std::vector<Vertex>{1, 7, 32, 64, 1024} : std::vector<Vertex>{7, 1024}) {
        SCOPED_TRACE("max_block_size " + std::to_string(block));
        check_factorization<Exec>(with_block_size(tested.problem, block), tested.reference, path);
      }
    });
  }

  void check_solves(const Cases& cases, const std::vector<Path>& paths) {
    std::map<std::tuple<const Case<Scalar>*, Vertex, bool>, SolveCase<Scalar>> solves;
    for (const Case<Scalar>& tested : cases) {
      for (const Vertex columns : {1, 2, 5, 16}) {
        for (const bool transposed : {false, true}) {
          solves.emplace(std::tuple(&tested, columns, transposed), solve_case(tested, columns, transposed));
        }
      }
    }
    for_each_run(cases, paths, [&](const Case<Scalar>& tested, Path path, int) {
      for (const Vertex columns : {1, 2, 5, 16}) {
        for (const bool transposed : {false, true}) {
          SCOPED_TRACE(std::to_string(columns) + " columns" + (transposed ? ", transposed" : ""));
          check_solve<Exec>(tested, solves.at({&tested, columns, transposed}), path);
        }
      }
    });
  }
};
TYPED_TEST_SUITE(StagesTest, Kinds);

const std::vector<Path> kOnePath{Path::small, Path::large};  // where a depth has one front
const std::vector<Path> kAnyPath{Path::small, Path::large, Path::mixed};

TYPED_TEST(StagesTest, AssembleFactorUpdateOfAllFrontSizes) {
  this->check_stages(front_sizes<typename TypeParam::Scalar, TypeParam::kThorough>(), kOnePath);
}
TYPED_TEST(StagesTest, AssembleFactorUpdateOfTrees) {
  this->check_stages(trees<TypeParam>(), kAnyPath);
}
TYPED_TEST(StagesTest, SolveWithAllFrontSizes) {
  this->check_solves(front_sizes<typename TypeParam::Scalar, TypeParam::kThorough>(), kOnePath);
}
TYPED_TEST(StagesTest, SolveWithTrees) {
  this->check_solves(trees<TypeParam>(), kAnyPath);
}

}  // namespace
}  // namespace mfs::test
