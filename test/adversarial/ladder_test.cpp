// The rungs above refinement, each on matrices that need it: FGMRES in the measure of the backward error,
// larger pivot blocks, a new matching for values that drifted, and "singular" only where it is true.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include <mfs/mfs.hpp>

#include "test/adversarial/hard_matrices.hpp"
#include "test/failure/fresh_solver.hpp"
#include "test/reference/random.hpp"

namespace mfs::test {
namespace {

Options one_thread() {
  Options options;
  options.backend = Backend::serial;
  return options;
}

/// Solves A x = b for the last values given to `solver`; the answer must be as good as promised.
void expect_right(Solver& solver, const SparseMatrix& a) {
  const std::vector<double> b = Random(3).vector(a.n);
  std::vector<double> x(b.size());
  solver.solve(b.data(), x.data());
  EXPECT_LE(backward_error(a, b, x), 1e-12);
}

/// A grid with random entries whose diagonal is `diagonal` times a random number.
SparseMatrix weak_grid(std::int64_t rows, double diagonal, std::uint64_t seed) {
  Random random(seed);
  const SparseMatrix grid = grid_2d(rows, rows + 1);
  std::vector<Entry> entries = entries_of(grid);
  for (Entry& e : entries) e.value = random.entry() * (e.row == e.column ? diagonal : 1.0);
  return from_entries(grid.n, entries);
}

// |A| |x| + |b| differs by tens of decades between rows, the scaled matrix is well conditioned, no pivot is
// small, and refinement in twice the precision does not help: small rows of the residual drown in what large
// entries of x leave there, unless measured by their size.
TEST(Ladder, SmallRowsDoNotDrown) {
  for (const std::uint64_t seed : {1015568, 2069928}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const HardMatrix hard = hard_matrix(seed);
    const std::vector<double> b = Random(seed).vector(hard.matrix.n);
    std::vector<double> x(b.size());
    Solver solver(one_thread());
    solver.factor(hard.matrix.view());
    solver.solve(b.data(), x.data());
    EXPECT_LE(backward_error(hard.matrix, b, x), 1e-12);
    EXPECT_GT(solver.report().krylov_steps, 0);
    EXPECT_EQ(solver.report().reanalyses, 0);
  }
}

// No pivot is below the tolerance asked for, but many are small beside their border: no perturbation, no
// accuracy. Larger pivot blocks help, and without them nothing but reflections.
TEST(Ladder, PivotBlocksGrowWhereFactorsGrow) {
  for (const double diagonal : {1e-10, 1e-12}) {
    for (const std::uint64_t seed : {40, 41, 42}) {
      SCOPED_TRACE("diagonal " + std::to_string(diagonal) + ", seed " + std::to_string(seed));
      const SparseMatrix a = weak_grid(40, diagonal, seed);
      Options options = one_thread();
      options.analysis.matching = Matching::never;
      options.analysis.leaf_size = 8;
      options.analysis.separator_trials = 1;  // the seeds were chosen with that order
      options.factor.pivot_tolerance = 1e-15;
      Solver solver(options);
      solver.factor(a.view());
      EXPECT_EQ(solver.report().reanalyses, 0);
      expect_right(solver, a);
      EXPECT_GT(solver.report().reanalyses, 0);
      EXPECT_LT(solver.report().rung, Rung::orthogonal);

      options.factor.max_reanalyses = 0;
      Solver weak(options);
      weak.factor(a.view());
      expect_right(weak, a);
      EXPECT_EQ(weak.report().rung, Rung::orthogonal);
      EXPECT_EQ(weak.report().reanalyses, 0);
    }
  }
}

int effort(const Report& report) {
  return report.refinement_steps + report.krylov_steps + static_cast<int>(report.corrected_pivots);
}

// The first values need no matching, the later ones do: the solve says so, the next refactor takes the hint.
// The later ones take some 40 steps, with whichever kernels the processor has.
TEST(Ladder, DriftedValuesAreMatchedAnew) {
  const SparseMatrix strong = weak_grid(40, 50.0, 5), weak = weak_grid(40, 1e-7, 8);
  Solver solver(one_thread());
  solver.factor(strong.view());
  expect_right(solver, strong);
  EXPECT_FALSE(solver.report().matched);
  solver.refactor(weak.view());
  expect_right(solver, weak);
  EXPECT_EQ(solver.report().reanalyses, 0);
  const int dear = effort(solver.report());
  EXPECT_GT(dear, 5);
  solver.refactor(weak.view());
  EXPECT_TRUE(solver.report().matched);
  EXPECT_GT(solver.report().reanalyses, 0);
  expect_right(solver, weak);
  EXPECT_LT(effort(solver.report()), dear);
}

// Values that go to and fro must not cost an analysis each time, and the limit is the caller's.
TEST(Ladder, MatchingAnewHasAnEnd) {
  const SparseMatrix strong = weak_grid(40, 50.0, 5), weak = weak_grid(40, 1e-7, 8);
  for (const int allowed : {0, 2}) {
    Options options = one_thread();
    options.factor.max_reanalyses = allowed;
    Solver solver(options);
    solver.factor(strong.view());
    expect_right(solver, strong);
    for (int round = 0; round < 12; ++round) {
      const SparseMatrix& a = round % 4 < 2 ? weak : strong;
      solver.refactor(a.view());
      expect_right(solver, a);
    }
    EXPECT_EQ(solver.report().matched, allowed > 0);
    EXPECT_LE(solver.report().reanalyses, allowed * (1 + allowed));
  }
}

// As above, but FGMRES is of no use either: what is missing is in the factors. Rows scaled for the solution
// give better ones, for each right-hand side its own, and only for these values.
TEST(Ladder, RowsAreScaledForTheSolution) {
  for (const std::uint64_t seed : {1000988, 1003248, 1003828}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const SparseMatrix a = hard_matrix(seed).matrix;
    const std::vector<double> b = Random(seed).vector(a.n);
    std::vector<double> x(b.size()), again(b.size());
    Solver solver(one_thread());
    solver.factor(a.view());
    solver.solve(b.data(), x.data());
    EXPECT_LE(backward_error(a, b, x), 1e-12);
    EXPECT_EQ(solver.report().rung, Rung::rescaling);
    solver.refactor(a.values.data());
    solver.solve(b.data(), again.data());
    EXPECT_EQ(again, x);
    EXPECT_EQ(solver.report().rung, Rung::rescaling);
  }
}

TEST(Ladder, RowsOfTheTransposedAreScaledForTheSolution) {
  for (const std::uint64_t seed : {1001928, 1003888, 1001988}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const SparseMatrix a = hard_matrix(seed).matrix, at = transposed(a);
    const std::vector<double> b = Random(seed).vector(a.n);
    std::vector<double> x(b.size());
    Solver solver(one_thread());
    solver.factor(at.view());
    solver.solve_transpose(b.data(), x.data());
    EXPECT_LE(backward_error(a, b, x), 1e-12);
    EXPECT_EQ(solver.report().rung, Rung::rescaling);
  }
}

TEST(Ladder, RowsAreScaledForEachRightHandSide) {
  const SparseMatrix a = hard_matrix(2006468).matrix;
  constexpr std::int64_t kColumns = 19;  // more than one block
  std::vector<std::vector<double>> columns;
  std::vector<double> b;
  for (std::int64_t j = 0; j < kColumns; ++j) {
    columns.push_back(Random(static_cast<std::uint64_t>(2006468 + j)).vector(a.n));
    if (j % 2 == 1) columns.back()[static_cast<std::size_t>(j % a.n)] *= 1e40;
    b.insert(b.end(), columns.back().begin(), columns.back().end());
  }
  Solver solver(one_thread());
  solver.factor(a.view());
  solver.solve(b.data(), b.data(), kColumns);
  for (std::int64_t j = 0; j < kColumns; ++j) {
    const std::vector<double> x(b.begin() + j * a.n, b.begin() + (j + 1) * a.n);
    EXPECT_LE(backward_error(a, columns[static_cast<std::size_t>(j)], x), 1e-12) << "column " << j;
  }
}

// Products of a hundred thousand ratios of about 5: whatever solves is beyond all numbers, and so is what might
// show that nothing does.
TEST(Ladder, DoubtIsSaid) {
  constexpr std::int64_t n = 100000;
  Random random(1);
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < n; ++i) {
    entries.push_back({i, i, random.entry()});
    if (i > 0) entries.push_back({i, i - 1, 0.1 * random.entry()});
    if (i + 1 < n) entries.push_back({i, i + 1, 5 * random.entry()});
  }
  const SparseMatrix a = from_entries_summed(n, entries);
  Solver solver(one_thread());
  solver.factor(a.view());
  std::vector<double> x(static_cast<std::size_t>(a.n), 1.0);
  const auto error = failure_of<AccuracyNotReached>([&] { solver.solve(x.data(), x.data()); });
  ASSERT_TRUE(error);
  EXPECT_THAT(error->what(), testing::HasSubstr("whether the matrix is singular"));
}

// The scales that would show this matrix regular are no doubles: not reached, but not "singular" either.
TEST(Ladder, BeyondTheRangeIsNotSingular) {
  for (const std::uint64_t seed : {600248, 602848, 605448, 605928}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const HardMatrix hard = hard_matrix(seed);
    Solver solver(one_thread());
    solver.factor(hard.matrix.view());
    if (const auto error = failure_of<AccuracyNotReached>([&] { expect_right(solver, hard.matrix); })) {
      EXPECT_THAT(error->what(), testing::HasSubstr("beyond the range of"));
    }
  }
}

}  // namespace
}  // namespace mfs::test
