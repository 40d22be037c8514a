// The report of the ladder: which rung a solve needed, and that its time is told where there is some.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "test/reference/generators.hpp"
#include "test/solver/systems.hpp"

namespace mfs::test {
namespace {

Options without_matching() {
  Options options = with_threads(1);
  options.analysis.matching = Matching::never;
  return options;
}

Options with_single_precision() {
  Options options = with_threads(1);
  options.factor.precision = Precision::single;
  return options;
}

Report solve(Solver& solver, const SparseMatrix& a) {
  const std::vector<double> b = right_hand_sides(a, 1, a.n, 1);
  std::vector<double> x(b.size());
  solver.solve(b.data(), x.data());
  EXPECT_LE(backward_error(a, b, x), kPromised);
  const Report& report = solver.report();
  EXPECT_EQ(report.time_ladder > 0, report.rung != Rung::factors);
  EXPECT_LE(report.time_ladder, report.time_solve);
  return report;
}

Report factor_and_solve(const Options& options, const SparseMatrix& a) {
  Solver solver(options);
  solver.factor(a.view());
  return solve(solver, a);
}

TEST(Ladder, NothingNeeded) {
  const SparseMatrix a = grid_2d(14, 13);
  Solver solver(with_threads(1));
  solver.factor(a.view());
  const Report report = solve(solver, a);
  EXPECT_EQ(report.rung, Rung::factors);
  EXPECT_EQ(report.refinement_steps, 0);
  EXPECT_EQ(report.time_reanalyses, 0);
}

TEST(Ladder, Refinement) {
  const SparseMatrix a = grid_2d(14, 13);
  Solver solver(with_single_precision());
  solver.factor(a.view());
  const Report report = solve(solver, a);
  EXPECT_EQ(report.rung, Rung::refinement);
  EXPECT_GT(report.refinement_steps, 0);
  EXPECT_TRUE(report.single_precision);
  // What the last solve needed, not any before.
  const std::vector<double> zero(a.n, 0.0);
  std::vector<double> x(a.n);
  solver.solve(zero.data(), x.data());
  EXPECT_EQ(solver.report().rung, Rung::factors);
  EXPECT_EQ(solver.report().time_ladder, 0);
}

TEST(Ladder, ChangesOfTheTree) {
  const SparseMatrix a = adversarial_matrix("saddle point renumbered", 1);
  Solver solver(without_matching());
  solver.factor(a.view());
  EXPECT_GT(solver.report().reanalyses, 0);
  EXPECT_GT(solver.report().time_reanalyses, 0);
  EXPECT_LT(solver.report().time_reanalyses, solver.report().time_factor);
}

TEST(Ladder, Correction) {
  const SparseMatrix a = adversarial_matrix("saddle point renumbered", 1);
  Options options = without_matching();
  options.factor.max_reanalyses = 0;
  Solver solver(options);
  solver.factor(a.view());
  const Report report = solve(solver, a);
  EXPECT_GE(report.rung, Rung::correction);
  EXPECT_LE(report.rung, Rung::refinement);  // of what the correction left
  EXPECT_GT(report.corrected_pivots, 0);
}

TEST(Ladder, Krylov) {
  Options options = with_single_precision();
  options.solve.max_refinement_steps = 2;
  const Report report = factor_and_solve(options, floating_chains(200, 20, true, 1e-7));
  EXPECT_EQ(report.rung, Rung::krylov);
  EXPECT_GT(report.krylov_steps, 0);
}

TEST(Ladder, FullPrecision) {
  const Report report = factor_and_solve(with_single_precision(), floating_chains(400, 20, false, 1e-9));
  EXPECT_EQ(report.rung, Rung::full_precision);
  EXPECT_FALSE(report.single_precision);
}

/// A strong diagonal, and the same pattern with zeros there: the matching of one is of no use to the other.
struct DiagonalLost {
  SparseMatrix before, after;
};

DiagonalLost diagonal_lost() {
  const std::int64_t n = 400;
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < n; ++i) {
    entries.push_back({i, i, 4.0});
    entries.push_back({i, (i * 7 + 3) % n, 1.0});
    entries.push_back({i, (i * 11 + 5) % n, 0.5});
  }
  DiagonalLost lost;
  lost.before = lost.after = from_entries_summed(n, entries);
  SparseMatrix& a = lost.after;
  for (std::int64_t i = 0; i < n; ++i)
    for (std::int64_t k = a.offsets[i]; k < a.offsets[i + 1]; ++k)
      if (a.columns[k] == i) a.values[k] = 0;
  return lost;
}

TEST(Ladder, Reanalysis) {
  const DiagonalLost lost = diagonal_lost();
  Solver solver(with_threads(1));
  solver.factor(lost.before.view());
  solver.refactor(lost.after.view());
  const Report report = solve(solver, lost.after);
  EXPECT_EQ(report.rung, Rung::reanalysis);
  EXPECT_GT(report.reanalyses, 0);
}

// The values of the analysis only held the place of those to come.
TEST(Ladder, ReanalysisForTheFirstValues) {
  SparseMatrix a = diagonal_lost().after;
  SparseMatrix placeholder = a;
  std::fill(placeholder.values.begin(), placeholder.values.end(), 1.0);
  for (std::size_t k = 0; k < a.values.size(); ++k) a.values[k] *= std::pow(10.0, 6 * std::sin(k * k));
  Solver solver(with_threads(1));
  solver.analyze(placeholder.view());
  solver.factor(a.view());
  EXPECT_EQ(solve(solver, a).rung, Rung::reanalysis);
}

// Minimum degree goes around a ring from its first row to its last, and products of a hundred thousand ratios
// are of any size.
TEST(Ladder, AHighTreeIsLeftWhereEntriesGrow) {
  const std::int64_t n = 100000;
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < n; ++i) {
    const double k = static_cast<double>(i);
    entries.push_back({i, i, 1.0});
    entries.push_back({i, (i + 1) % n, -1.3 * std::pow(2.0, std::sin(k * k))});
  }
  const SparseMatrix a = from_entries_summed(n, entries);
  Solver solver(with_threads(1));
  solver.analyze(a.view());
  EXPECT_GT(solver.report().depths, 1000);
  solver.factor(a.view());
  EXPECT_NE(solve(solver, a).rung, Rung::orthogonal);
  EXPECT_LT(solver.report().depths, 100);
}

/// A saddle point with `pivot` on the diagonal of its multipliers.
SparseMatrix saddle_point(double pivot) {
  const SparseMatrix a = adversarial_matrix("saddle point renumbered", 1);
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < a.n; ++i) {
    bool has_diagonal = false;
    for (std::int64_t k = a.offsets[i]; k < a.offsets[i + 1]; ++k) {
      entries.push_back({i, a.columns[k], a.values[k]});
      has_diagonal = has_diagonal || (a.columns[k] == i && a.values[k] != 0);
    }
    if (!has_diagonal) entries.push_back({i, i, pivot});
  }
  return from_entries_summed(a.n, entries);
}

/// Of a solver that was factored for pivots of 1, and then refactored for others: a solve at first and after
/// so many that the tree has changed.
std::pair<Report, Report> with_later_pivots(double pivot) {
  Solver solver(without_matching());
  solver.factor(saddle_point(1).view());
  const SparseMatrix a = saddle_point(pivot);
  solver.refactor(a.view());
  const Report first = solve(solver, a);
  for (int k = 0; k < 40; ++k) solve(solver, a);
  solver.refactor(a.view());
  return {first, solve(solver, a)};
}

TEST(Ladder, PivotsThatFailForLaterValuesAreDelayed) {
  const auto [first, last] = with_later_pivots(0);
  EXPECT_GT(first.corrected_pivots, 0);
  EXPECT_EQ(first.reanalyses, 0);
  EXPECT_GT(last.reanalyses, 0);
  EXPECT_EQ(last.perturbed_pivots, 0);
  EXPECT_EQ(last.corrected_pivots, 0);
}

// Two systems, with fronts {0}, {1} and {2, 3}, {4}. The root {1} holds 1e-9, which may be rounding until a
// corrected solve proves that it is not. Divided by, it is right; but then the diagonal is preferred, and
// 1e-8 is too small beside the border of {2, 3}, where 4e-8 was taken before.
TEST(Ladder, WhatIsTooSmallToBeDividedByIsDelayed) {
  const double one = 1 + 1e-9;
  const std::vector<std::int32_t> offsets{0, 2, 4, 6, 8, 10}, columns{0, 1, 0, 1, 2, 3, 2, 4, 2, 4};
  const std::vector<double> values{1, 1, 1, one, 1e-8, 1, 4e-8, 1, 1, 1}, b{1, 2, 3, 4, 5};
  Options options = without_matching();
  options.analysis.permutation = {0, 1, 2, 3, 4};
  options.analysis.tree.offsets = {0, 1, 2, 4, 5};
  options.analysis.tree.parent = {1, -1, 3, -1};
  Solver solver(options);
  solver.factor(CsrView<double>{5, 5, offsets.data(), columns.data(), values.data()});
  std::vector<double> x(5);
  const auto expect_solved = [&](std::int64_t corrected) {
    solver.solve(b.data(), x.data());
    EXPECT_EQ(solver.report().corrected_pivots, corrected);
    EXPECT_NEAR(x[1] * (one - 1), 1, 1e-6);
    EXPECT_NEAR((x[0] + x[1]) / x[1], 0, 1e-6);
    EXPECT_DOUBLE_EQ(x[4], (4 - 4e-8 * 5) / (1 - 4e-8));
    EXPECT_DOUBLE_EQ(x[2], 5 - x[4]);
    EXPECT_DOUBLE_EQ(x[3], 3 - 1e-8 * x[2]);
  };
  expect_solved(1);
  EXPECT_EQ(solver.report().reanalyses, 0);
  solver.refactor(values.data());
  const auto changes = solver.report().reanalyses;
  EXPECT_GT(changes, 0);
  EXPECT_EQ(solver.report().perturbed_pivots, 0);
  expect_solved(0);
  solver.refactor(values.data());
  EXPECT_EQ(solver.report().reanalyses, changes);
  expect_solved(0);
}

TEST(Ladder, PivotsThatAreSmallForLaterValuesAreDelayed) {
  const auto [first, last] = with_later_pivots(1e-6);
  EXPECT_EQ(first.perturbed_pivots, 0);
  EXPECT_EQ(first.rung, Rung::refinement);
  EXPECT_GT(last.reanalyses, 0);
  EXPECT_EQ(last.rung, Rung::factors);
}

// Nothing is small beside its row there but what scaling has made so. Exchanges of rows cost up to three
// digits.
TEST(Ladder, PivotsStayOnADominantDiagonal) {
  for (const Backend backend : {Backend::serial, Backend::openmp})
    for (const std::uint64_t seed : {1, 2, 3}) {
      const SparseMatrix a = resistors(30000, seed);
      Options options = with_threads(2);
      options.backend = backend;
      Solver solver(options);
      solver.factor(a.view());
      EXPECT_LE(error_of_solution(solver, a), 2e-15) << "seed " << seed;
      EXPECT_EQ(solver.report().rung, Rung::factors);
    }
}

/// Ones on the diagonal and in the last column, -1 below: with exchanges of rows the last column doubles with
/// each pivot (Wilkinson, The Algebraic Eigenvalue Problem, 1965, chapter 4, section 57).
template <class Scalar>
BasicSparseMatrix<Scalar> doubling(std::int64_t n) {
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < n; ++i) {
    for (std::int64_t j = 0; j < i; ++j) entries.push_back({i, j, -1});
    entries.push_back({i, i, 1});
    if (i + 1 < n) entries.push_back({i, n - 1, 1});
  }
  const SparseMatrix a = from_entries(n, entries);
  return {n, a.offsets, a.columns, std::vector<Scalar>(a.values.begin(), a.values.end())};
}

template <class Scalar>
void expect_reflections(Backend backend, std::int64_t n, bool transposed_solve) {
  SCOPED_TRACE(std::string(backend_name(backend)) + ", n = " + std::to_string(n) +
               (transposed_solve ? ", transposed" : ""));
  const BasicSparseMatrix<Scalar> a = doubling<Scalar>(n);
  constexpr std::int64_t kColumns = 19;  // more than one block
  const BasicSparseMatrix<Scalar> solved = transposed_solve ? transposed(a) : a;
  const std::vector<Scalar> b = right_hand_sides(solved, kColumns, n, 5);
  std::vector<Scalar> x(b.size());
  Options options = with_threads(2);
  options.backend = backend;
  BasicSolver<Scalar> solver(options);
  solver.factor(a.view());
  transposed_solve ? solver.solve_transpose(b.data(), x.data(), kColumns)
                   : solver.solve(b.data(), x.data(), kColumns);
  EXPECT_LE(worst_error(solved, b, n, x, n, kColumns), kPromisedFor<Scalar>);
  EXPECT_GE(solver.report().rung, Rung::orthogonal);
  EXPECT_EQ(solver.report().dependent_rows, 0);
}

// Neither exchanges of rows nor larger blocks nor scales keep entries from growing there.
TEST(Ladder, ReflectionsLetNothingGrow) {
  for (const bool transposed_solve : {false, true}) {
    for (const Backend backend : {Backend::serial, Backend::openmp, Backend::kokkos})
      expect_reflections<double>(backend, 257, transposed_solve);
    expect_reflections<float>(Backend::openmp, 200, transposed_solve);
    expect_reflections<std::complex<double>>(Backend::openmp, 300, transposed_solve);
    expect_reflections<std::complex<float>>(Backend::openmp, 100, transposed_solve);
  }
}

TEST(Ladder, EveryRungHasAName) {
  std::set<std::string> names;
  for (const Rung rung : {Rung::factors, Rung::correction, Rung::refinement, Rung::krylov,
                          Rung::full_precision, Rung::reanalysis, Rung::tiny_pivots, Rung::larger_blocks,
                          Rung::rescaling, Rung::orthogonal, Rung::host})
    names.insert(rung_name(rung));
  EXPECT_EQ(names.size(), 11u);
  EXPECT_EQ(names.count("unknown"), 0u);
}

// Rank 11 of 12 by exact elimination. Pivots that were chosen for other values, or for none, let the factors
// grow until no pivot is small, and FGMRES finds solutions as large as rounding lets them be.
TEST(Ladder, GrowthHidesNoSingularMatrix) {
  const SparseMatrix regular{
      12,
      {0, 4, 8, 14, 21, 24, 28, 33, 39, 42, 47, 53, 57},
      {0, 7, 9, 11, 1, 2, 3, 10, 0,  2,  3, 6, 7,  10, 1, 3, 4, 8, 9, 10, 11, 1, 4,  8,  2, 5, 6, 9, 1,
       5, 6, 8, 10, 2, 3, 5, 7,  10, 11, 3, 8, 10, 2,  4, 6, 7, 9, 1, 4,  6,  9, 10, 11, 0, 3, 8, 11},
      {4, 2, 1,  3,  3, -1, 2,  -2, 0, 3, -2, -1, 0, -1, 3,  9,  -1, 3, 1,  0,  -2, 0, 8, -3, -1, 8, 2, 3, 0,
       3, 4, -2, -3, 2, -3, -2, 5,  2, 0, -1, 7,  0, -3, -2, -2, 0,  8, -1, -2, -1, 3, 8, -2, 1,  1, 0, 6}};
  SparseMatrix singular = regular;
  singular.values = {3,  -2, 3,  -3, 0,  1,  2, 1,  1, 0, -3, 2, -2, 0, -2, -3, 2, 2,  2,
                     2,  0,  -2, 2,  0,  -1, 2, 3,  2, 3, 3,  3, 3,  3, -3, 2,  2, 2,  -2,
                     -2, -2, -3, 1,  -1, 0,  3, -2, 1, 1, -3, 1, 2,  1, -3, 0,  1, -2, 0};
  for (const bool with_values : {false, true}) {
    auto first = regular.view();
    if (!with_values) first.values = nullptr;
    Solver solver(with_threads(1));
    BatchSolver batch(with_threads(1));
    solver.analyze(first);
    batch.analyze(first);
    solver.factor(regular.view());
    for (int column = 0; column < 19; ++column) {
      solver.refactor(singular.values.data());
      std::vector<double> b(12), x(12);
      for (int i = 0; i < 12; ++i) b[i] = (37 * column + 101 * i) % 19 - 9;
      EXPECT_THROW(solver.solve(b.data(), x.data()), SingularMatrix);
      batch.solve({1, singular.values.data(), 0, b.data(), x.data()});
      EXPECT_EQ(batch.systems()[0].status, SystemStatus::singular);
    }
    solve(solver, (solver.refactor(regular.values.data()), regular));
  }
}

}  // namespace
}  // namespace mfs::test
