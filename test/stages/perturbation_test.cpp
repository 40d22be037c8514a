// Pivots that are too small: which are replaced, by what, and that the factors are then exactly those of the
// matrix with the noted shifts added (rule in kernels/dense/panel_lu.hpp).
#include <string>

#include "test/stages/followed_reference.hpp"
#include "test/stages/reference_stages.hpp"
#include "test/stages/weak_pivots.hpp"

namespace mfs::test {
namespace {

constexpr double kBound = 0x1p-26, kTiny = 0x1p-47, kLargest = 4;

template <class Exec>
FactoredFronts<double> factored(const StageProblem<double>& problem, Path path, int threads,
                                const PivotRule& rule) {
  FactoredFronts<double> result;
  in_engine(threads, [&] {
    StageBench<Exec, double> bench(problem);
    const SymbolicPlan& plan = *problem.plan;
    for (Vertex step = 0; step < plan.num_depths; ++step) {
      bench.factor_depth(forced_schedule(plan, step, path), rule, Stages());
    }
    for (Vertex f = 0; f < plan.num_fronts; ++f) {
      result.fronts.push_back(bench.front(f));
      result.row_at.push_back(bench.row_at(f));
      result.shift.push_back(bench.shift(f));
    }
    result.status = bench.status();
  });
  return result;
}

template <class Tested>
class PerturbationTest : public testing::Test {
 protected:
  /// check(path, threads) for all ways to run.
  template <class Check>
  void for_each_way(const Check& check) {
    for (const int threads : thread_counts<Tested>()) {
      for (const Path path : {Path::small, Path::large}) {
        SCOPED_TRACE("path " + std::to_string(static_cast<int>(path)) + ", threads " +
                     std::to_string(threads));
        check(path, threads);
      }
    }
  }

  /// Pivots of one unknown with one border row: what is added to `pivot` beside `border` in its column?
  struct Lone {
    double pivot, border, shift;
  };
  void expect_shifts(const std::vector<Lone>& cases, const PivotRule& rule = {kBound, kTiny, kLargest}) {
    for_each_way([&](Path path, int threads) {
      for (const Lone& lone : cases) {
        SCOPED_TRACE("pivot " + std::to_string(lone.pivot) + ", border " + std::to_string(lone.border));
        const StageProblem<double> problem =
            two_fronts(1, 1, {{0, 0, lone.pivot}, {1, 0, lone.border}, {0, 1, 0.0}, {1, 1, 1.0}}, 64);
        const FactoredFronts<double> result = factored<typename Tested::Exec>(problem, path, threads, rule);
        EXPECT_EQ(result.shift[0][0], lone.shift);
        EXPECT_EQ(result.status.perturbed, lone.shift == 0 ? 0u : 1u);
        expect_exact_factors(problem, result);
      }
    });
  }
};
using RealKinds = testing::Types<Kind<Kokkos::Serial, double>, Kind<Kokkos::OpenMP, double>>;
TYPED_TEST_SUITE(PerturbationTest, RealKinds);

TYPED_TEST(PerturbationTest, LargePivotIsLeftAlone) {
  this->expect_shifts({{kBound, 1.0, 0.0}, {-kBound, 1.0, 0.0}});  // the bound itself is large enough
}

TYPED_TEST(PerturbationTest, TinyPivotBecomesTheBoundWithItsSign) {
  this->expect_shifts({{0.0, 1.0, kBound},
                       {0.0, 10.5 * kTiny, kBound},
                       {kTiny, 1.0, kBound - kTiny},  // tiny itself is tiny
                       {-kTiny, 1.0, kTiny - kBound},
                       {5e-324, 1.0, kBound - 5e-324}});
}

TYPED_TEST(PerturbationTest, ColumnThatDependsOnOthersGetsALargePivot) {
  this->expect_shifts({{0.0, 0.0, kLargest},
                       {kTiny, 0.0, kLargest - kTiny},
                       {-kTiny, 5 * kTiny, kTiny - kLargest},
                       {0.0, 10 * kTiny, kLargest}});
}

TYPED_TEST(PerturbationTest, SuspectPivotIsJudgedByItsBorder) {
  const double suspect = 0x1p-30;
  this->expect_shifts({{suspect, 0.0, 0.0},
                       {suspect, 99 * suspect, 0.0},
                       {suspect, 101 * suspect, kBound - suspect},
                       {-suspect, 1.0, suspect - kBound},
                       {kTiny * 1.001, 50 * kTiny, 0.0}});
}

// Down to the border's part, and never replaced by more than rounding where their columns hold nothing.
TYPED_TEST(PerturbationTest, TinyPivotsThatAreDataAreDividedBy) {
  constexpr double kPart = 0x1p-26, rounding = 0x1p-52 * kLargest, bound = kPart * kLargest;
  this->expect_shifts({{0x1p-40, 0.0, 0.0},
                       {0x1p-40, 0x1p-14, 0.0},
                       {-0x1p-40, 0x1p-13, 0x1p-40 - bound},
                       {1.5 * rounding, 0.0, 0.0},
                       {-rounding / 2, 0.0, -rounding / 2},
                       {0.0, 0.0, rounding},
                       {0.0, 1.0, bound}},
                      pivot_rule<double>(PivotPolicy(kPart, TinyPivots::data, kPart), kLargest));
}

// The entry on the diagonal is taken up to an eighth of the largest entry, in matrices that look definite up
// to 2^-20 of it; by any other rule the largest is.
TYPED_TEST(PerturbationTest, DiagonalIsPreferredWhereTinyPivotsAreData) {
  constexpr double kPart = 0x1p-26;
  PivotPolicy policy(kPart, TinyPivots::data, kPart);
  const PivotRule data = pivot_rule<double>(policy, kLargest);
  policy.preference = kDefinitePreference;
  const PivotRule definite = pivot_rule<double>(policy, kLargest);
  const auto first_row = [](double diagonal, const PivotRule& rule, Path path, int threads) {
    const StageProblem<double> problem = two_fronts(
        2, 1,
        {{0, 0, diagonal}, {0, 1, 1.0}, {1, 0, -1.0}, {1, 1, 2.0}, {2, 0, 0.5}, {0, 2, 0.5}, {2, 2, 1.0}},
        64);
    const FactoredFronts<double> result = factored<typename TypeParam::Exec>(problem, path, threads, rule);
    expect_exact_factors(problem, result);
    return result.row_at[0][0];
  };
  this->for_each_way([&](Path path, int threads) {
    EXPECT_EQ(first_row(0.126, data, path, threads), 0);
    EXPECT_EQ(first_row(0.124, data, path, threads), 1);
    EXPECT_EQ(first_row(0x1.01p-20, definite, path, threads), 0);
    EXPECT_EQ(first_row(0x1.fp-21, definite, path, threads), 1);
    EXPECT_EQ(first_row(0.999, {kBound, kTiny, kLargest}, path, threads), 1);
  });
}

// The border as it is once the columns before are eliminated, not as it was assembled:
//   [ 1  1         ]
//   [ 1  1+suspect ]  second pivot: suspect;   border row [0.5 g]: g - 0.5 is what counts
TYPED_TEST(PerturbationTest, BorderIsSeenAfterTheColumnsBefore) {
  const double suspect = 0x1p-30;
  const auto shift = [&](double g, Vertex block_size, Path path, int threads) {
    const StageProblem<double> problem = two_fronts(2, 1,
                                                    {{0, 0, 1.0},
                                                     {0, 1, 1.0},
                                                     {1, 0, 1.0},
                                                     {1, 1, 1.0 + suspect},
                                                     {2, 0, 0.5},
                                                     {2, 1, g},
                                                     {0, 2, 0.25},
                                                     {2, 2, 1.0}},
                                                    block_size);
    const FactoredFronts<double> result =
        factored<typename TypeParam::Exec>(problem, path, threads, {kBound, kTiny, kLargest});
    expect_exact_factors(problem, result);
    EXPECT_EQ(result.shift[0][0], 0.0);
    return result.shift[0][1];
  };
  this->for_each_way([&](Path path, int threads) {
    for (const Vertex block_size : {1, 2, 64}) {
      EXPECT_EQ(shift(0.5, block_size, path, threads), 0.0);
      EXPECT_EQ(shift(0.0, block_size, path, threads), kBound - suspect);
      EXPECT_EQ(shift(0.5 + 0x1p-20, block_size, path, threads), kBound - suspect);
    }
  });
}

// A zero pivot block: every pivot is replaced, whatever the border.
TYPED_TEST(PerturbationTest, ZeroPivotBlocks) {
  std::vector<StageProblem<double>> problems;
  for (const Vertex p : {1, 2, 33, 150}) {
    for (const Vertex b : {0, 1, 70}) {
      for (const Vertex block_size : {1, 32, 1024}) problems.push_back(zero_pivot_block(p, b, block_size));
    }
  }
  this->for_each_way([&](Path path, int threads) {
    for (const StageProblem<double>& problem : problems) {
      const Vertex p = problem.plan->pivots(0);
      SCOPED_TRACE(std::to_string(p) + " pivots, border " + std::to_string(problem.plan->border_rows(0)));
      const FactoredFronts<double> result =
          factored<typename TypeParam::Exec>(problem, path, threads, {kBound, kTiny, kLargest});
      EXPECT_EQ(result.shift[0],
                std::vector<double>(p, problem.plan->border_rows(0) > 0 ? kBound : kLargest));
      expect_exact_factors(problem, result);
    }
  });
}

// Pivot blocks of known rank, of small integers: what is left after as many pivots is rounding, and replaced.
TYPED_TEST(PerturbationTest, PivotBlocksOfLowRank) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Vertex p = 140, rank = 100, b = 30;
    for (const Vertex block_size : {7, 64, 1024}) {
      const StageProblem<double> problem = low_rank_pivot_block(seed, p, rank, b, block_size, 1e9);
      this->for_each_way([&](Path path, int threads) {
        const FactoredFronts<double> result =
            factored<typename TypeParam::Exec>(problem, path, threads, {1e-6, 1e-10});
        EXPECT_EQ(result.status.perturbed, static_cast<unsigned long long>(p - rank));
        for (Vertex i = 0; i < p; ++i) EXPECT_EQ(result.shift[0][i] != 0, i >= rank) << i;
        expect_exact_factors(problem, result);
      });
    }
  }
}

// Suspect pivots all over a tree: the same decisions as the reference, and exact factors.
TYPED_TEST(PerturbationTest, TreesWithManySuspectPivots) {
  for (const std::uint64_t seed : {11, 12, 13}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    StageProblem<double> problem = artificial_problem(mixed_tree(), {seed, 0.5, 32});
    weaken_rows(problem, seed);
    const ReferenceStages<double> expected(problem, {kBound, kTiny, kLargest});
    unsigned long long perturbed = 0;
    for (const auto& front : expected.fronts) {
      for (const double shift : front.shift) perturbed += shift != 0;
    }
    EXPECT_GT(perturbed, 0u);
    this->for_each_way([&](Path path, int threads) {
      const FactoredFronts<double> result =
          factored<typename TypeParam::Exec>(problem, path, threads, {kBound, kTiny, kLargest});
      EXPECT_EQ(result.status.perturbed, perturbed);
      for (Vertex f = 0; f < problem.plan->num_fronts; ++f) {
        EXPECT_EQ(result.row_at[f], expected.fronts[f].row_at) << "front " << f;
        for (Vertex i = 0; i < problem.plan->pivots(f); ++i) {
          EXPECT_EQ(result.shift[f][i] != 0, expected.fronts[f].shift[i] != 0)
              << "front " << f << ", pivot " << i;
        }
      }
      follow<double>(problem, result, {kBound, kTiny, kLargest},
                     [&](Vertex f, Vertex) { return SearchedRows{problem.plan->pivots(f)}; });
      expect_exact_factors(problem, result);
    });
  }
}

TYPED_TEST(PerturbationTest, PivotsThatAreNoNumbersAreCounted) {
  const double infinity = std::numeric_limits<double>::infinity();
  this->for_each_way([&](Path path, int threads) {
    const StageProblem<double> problem =
        two_fronts(2, 1, {{0, 0, infinity}, {1, 1, 1.0}, {2, 0, 1.0}, {2, 2, 1.0}}, 64);
    EXPECT_GT(factored<typename TypeParam::Exec>(problem, path, threads, {kBound, kTiny, kLargest})
                  .status.nonfinite,
              0u);
  });
}

}  // namespace
}  // namespace mfs::test
