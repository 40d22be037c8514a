// How often a matrix is factored where fronts have to search their pivots in all rows: twice the first time,
// and later once, though values change. Backend kokkos' code for devices, in a space of the host.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "kernels/portable/portable_factors_def.hpp"
#include "test/reference/random.hpp"
#include "test/stages/artificial_problem.hpp"
#include "test/stages/in_engine.hpp"
#include "test/stages/weak_pivots.hpp"

namespace mfs::test {
namespace {

constexpr double kTolerance = 1e-8;

class Passes {
 public:
  explicit Passes(const StageProblem<double>& problem)
      : lists_(Made::lists_for(*problem.plan, 1)),
        flops_(count_flops(*problem.plan, lists_.device, false).done.total()),
        factors_(problem.plan, problem.pattern, 1, std::move(lists_)) {
    fill(problem, factors_);
  }
  /// Factors these values and returns how often.
  int of(const std::vector<double>& values) {
    std::copy(values.begin(), values.end(), factors_.matrix_values());
    const FactorStatus status = factors_.factor(kTolerance, {}).status;
    return static_cast<int>(std::lround((status.getrf + status.trsm + status.gemm) / flops_));
  }

 private:
  using Made = portable::PortableFactors<Kokkos::Serial, double, double, portable::OwnDense<double>,
                                         /*kResident=*/true>;
  portable::Lists lists_;
  double flops_;
  Made factors_;
};

std::vector<double> changed(const std::vector<double>& values, Random& random) {
  std::vector<double> others = values;
  for (double& value : others) value *= 1 + 1e-3 * random.entry();
  return others;
}

TEST(StrictPasses, OneForEachOfMatricesThatChangeLittle) {
  std::vector<StageProblem<double>> problems{pivots_below_the_tile(300, 150, 0.0),
                                             pivots_below_the_tile(300, 150, 1e-3)};
  for (const std::uint64_t seed : {1, 2}) {
    problems.push_back(artificial_problem(mixed_tree(), {seed, 0.6, 64, {}, 0.0}));
    weaken_rows(problems.back(), seed);
    problems.push_back(artificial_problem(leaf_and_root(200, 80), {seed, 1.0, 64, {}, 0.9}));
    weaken_rows(problems.back(), seed);
  }
  int repeated_once = 0;
  for (const StageProblem<double>& problem : problems) {
    SCOPED_TRACE("n = " + std::to_string(problem.plan->n));
    in_engine(1, [&] {
      Random random(3);
      Passes passes(problem);
      const int first = passes.of(problem.values);
      EXPECT_LE(first, 2);
      repeated_once += first == 2;
      int all = 0;
      for (int k = 0; k < 40; ++k) all += passes.of(changed(problem.values, random));
      EXPECT_LE(all, 41);
    });
  }
  EXPECT_GE(repeated_once, 2);
}

/// The same with all large entries on the diagonal.
std::vector<double> with_diagonal(const StageProblem<double>& problem) {
  std::vector<double> values = problem.values;
  const Pattern& pattern = *problem.pattern;
  for (Vertex position = 0; position < pattern.n; ++position) {
    const Vertex row = problem.plan->row_of[position], column = problem.plan->column_of[position];
    for (Offset k = pattern.offsets[row]; k < pattern.offsets[row + 1]; ++k) {
      if (pattern.columns[k] == column) values[k] = 1000;
    }
  }
  return values;
}

TEST(StrictPasses, FollowValuesThatNeedItAndOthersThatDoNot) {
  const StageProblem<double> weak = pivots_below_the_tile(300, 150, 0.0);
  const std::vector<double> mild = with_diagonal(weak);
  in_engine(1, [&] {
    Passes passes(weak);
    EXPECT_EQ(passes.of(weak.values), 2);
    EXPECT_EQ(passes.of(weak.values), 1);
    for (int k = 0; k < 3; ++k) EXPECT_EQ(passes.of(mild), 1);
    EXPECT_EQ(passes.of(weak.values), 2);  // had been released
    EXPECT_EQ(passes.of(mild), 1);
    EXPECT_EQ(passes.of(weak.values), 1);  // stays strict for longer now
    for (int k = 0; k < 70; ++k) EXPECT_EQ(passes.of(mild), 1);
    EXPECT_EQ(passes.of(weak.values), 2);
  });
}

}  // namespace
}  // namespace mfs::test
