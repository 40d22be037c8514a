// All forms in which a matrix and its right-hand sides may come.
#include <string>

#include "test/reference/generators.hpp"
#include "test/solver/systems.hpp"

namespace mfs::test {
namespace {

template <class OffsetInteger, class ColumnInteger>
void expect_same_solution(const SparseMatrix& a) {
  const std::vector<OffsetInteger> offsets(a.offsets.begin(), a.offsets.end());
  const std::vector<ColumnInteger> columns(a.columns.begin(), a.columns.end());
  const CsrView<double> view{a.n, a.n, offsets.data(), columns.data(), a.values.data()};
  Solver plain(with_threads(1)), other(with_threads(1));
  plain.factor(a.view());
  other.factor(view);
  other.refactor(view);
  const std::vector<double> b = right_hand_sides(a, 1, a.n, 3);
  std::vector<double> x(a.n), y(a.n);
  plain.solve(b.data(), x.data());
  other.solve(b.data(), y.data());
  EXPECT_EQ(x, y);
}

TEST(Forms, AllWidthsOfIndices) {
  const SparseMatrix a = random_diagonally_dominant(200, 4, 1);
  expect_same_solution<std::int32_t, std::int32_t>(a);
  expect_same_solution<std::int32_t, std::int64_t>(a);
  expect_same_solution<std::int64_t, std::int32_t>(a);
  expect_same_solution<std::int64_t, std::int64_t>(a);
  expect_same_solution<std::uint32_t, std::uint64_t>(a);
}

/// Rows shuffled, and some entries in two or three parts that sum up to them.
SparseMatrix scattered(const SparseMatrix& a, std::uint64_t seed) {
  Random random(seed);
  std::vector<Entry> entries;
  for (const Entry& e : entries_of(a)) {
    if (random.chance(0.3)) {
      entries.push_back({e.row, e.column, 0.75 * e.value});
      entries.push_back({e.row, e.column, 0.25 * e.value});
      if (random.chance(0.5)) entries.push_back({e.row, e.column, 0.0});
    } else {
      entries.push_back(e);
    }
  }
  std::vector<Entry> shuffled;
  for (const std::size_t k : random.permutation(entries.size())) shuffled.push_back(entries[k]);
  return from_entries(a.n, shuffled);
}

TEST(Forms, UnsortedRowsAndRepeatedEntries) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    for (const SparseMatrix& a : {grid_2d(15, 14), random_diagonally_dominant(250, 4, seed), arrow(80, 3)}) {
      const SparseMatrix same = scattered(a, seed);
      Solver solver(with_threads(2));
      solver.factor(same.view());
      EXPECT_EQ(solver.report().nnz, a.entries());
      expect_solves(solver, a);
      std::vector<double> values = same.values;
      for (double& v : values) v *= 3;
      solver.refactor(values.data());
      SparseMatrix three = a;
      for (double& v : three.values) v *= 3;
      expect_solves(solver, three);
    }
  }
}

TEST(Forms, ManyRightHandSidesWithGaps) {
  const SparseMatrix a = random_diagonally_dominant(150, 4, 5);
  const SparseMatrix at = transposed(a);
  Solver solver(with_threads(2));
  solver.factor(a.view());
  for (const std::int64_t nrhs : {1, 2, 15, 16, 17, 33, 40}) {
    for (const bool transpose : {false, true}) {
      SCOPED_TRACE(std::to_string(nrhs) + (transpose ? " transposed" : ""));
      const std::int64_t ldb = a.n + 3, ldx = a.n + 5;
      const std::vector<double> b = right_hand_sides(transpose ? at : a, nrhs, ldb, 11);
      std::vector<double> x(static_cast<std::size_t>(ldx * nrhs), -4.0);
      (solver.*(transpose ? &Solver::solve_transpose : &Solver::solve))(b.data(), x.data(), nrhs, ldb, ldx);
      EXPECT_LE(worst_error(transpose ? at : a, b, ldb, x, ldx, nrhs), kPromised);
      for (std::int64_t j = 0; j < nrhs; ++j) {
        for (std::int64_t i = a.n; i < ldx; ++i) EXPECT_EQ(x[j * ldx + i], -4.0) << "the gap is the caller's";
      }
    }
  }
}

TEST(Forms, EachColumnIsSolvedAsIfAlone) {
  const SparseMatrix a = grid_2d(20, 20);
  Solver solver(with_threads(1));
  solver.factor(a.view());
  const std::vector<double> b = right_hand_sides(a, 40, a.n, 2);
  std::vector<double> x(b.size()), alone(a.n);
  solver.solve(b.data(), x.data(), 40);
  for (std::int64_t j = 0; j < 40; ++j) {
    solver.solve(b.data() + j * a.n, alone.data());
    for (std::int64_t i = 0; i < a.n; ++i) EXPECT_NEAR(alone[i], x[j * a.n + i], 1e-12);
  }
}

TEST(Forms, SolutionInPlaceOfTheRightHandSide) {
  const SparseMatrix a = random_diagonally_dominant(150, 4, 5);
  Solver solver(with_threads(1));
  solver.factor(a.view());
  for (const std::int64_t nrhs : {1, 5, 40}) {
    const std::int64_t ld = a.n + 2;
    const std::vector<double> b = right_hand_sides(a, nrhs, ld, 2);
    std::vector<double> apart = b, in_place = b;
    solver.solve(b.data(), apart.data(), nrhs, ld, ld);
    solver.solve(in_place.data(), in_place.data(), nrhs, ld, ld);
    for (std::int64_t j = 0; j < nrhs; ++j) {
      for (std::int64_t i = 0; i < a.n; ++i) EXPECT_EQ(in_place[j * ld + i], apart[j * ld + i]);
    }
  }
}

TEST(Forms, AnalysisOfThePatternAlone) {
  SparseMatrix a = random_diagonally_dominant(150, 4, 5);
  CsrView<double> pattern = a.view();
  pattern.values = nullptr;
  Solver solver(with_threads(1));
  solver.analyze(pattern);
  EXPECT_TRUE(solver.analyzed());
  EXPECT_FALSE(solver.factored());
  solver.factor(a.view());
  expect_solves(solver, a);
}

TEST(Forms, RefactorWithNewValues) {
  for (const int threads : {1, 2}) {
    SparseMatrix a = random_diagonally_dominant(300, 4, 9);
    Solver solver(with_threads(threads));
    solver.analyze(a.view());
    solver.factor(a.view());
    Random random(1);
    for (int step = 0; step < 6; ++step) {
      for (double& v : a.values) v *= 1 + 0.3 * random.entry();
      if (step % 3 == 0) solver.refactor(a.view());
      if (step % 3 == 1) solver.refactor(a.values.data());
      if (step % 3 == 2) solver.factor(a.view());
      expect_solves(solver, a, 2);
    }
  }
}

// Values may change so much that what was chosen for the first ones (matching, scaling) is of no use any
// more.
TEST(Forms, RefactorWithQuiteOtherValues) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    SparseMatrix a = random_diagonally_dominant(200, 4, seed);
    Solver solver(with_threads(1));
    solver.factor(a.view());
    Random random(seed);
    for (double& v : a.values) v = random.entry() * std::pow(10.0, 4 * random.entry());
    solver.refactor(a.view());
    const std::vector<double> b = right_hand_sides(a, 1, a.n, 1);
    std::vector<double> x(b.size());
    try {
      solver.solve(b.data(), x.data());
      EXPECT_LE(backward_error(a, b, x), kPromised);
    } catch (const SingularMatrix&) {  // allowed: never a wrong success
    } catch (const AccuracyNotReached&) {
    }
  }
}

TEST(Forms, OneUnknown) {
  const SparseMatrix a = from_entries(1, {{0, 0, -4.0}});
  Solver solver;
  solver.factor(a.view());
  double b = 2, x = 0;
  solver.solve(&b, &x);
  EXPECT_EQ(x, -0.5);
  solver.solve_transpose(&b, &x);
  EXPECT_EQ(x, -0.5);
  EXPECT_EQ(solver.depths().size(), 1u);
}

TEST(Forms, MovedSolversKeepTheirWork) {
  const SparseMatrix a = grid_2d(10, 10);
  Solver first(with_threads(1));
  first.factor(a.view());
  Solver second(std::move(first));
  EXPECT_TRUE(second.factored());
  expect_solves(second, a);
  Solver third;
  third = std::move(second);
  expect_solves(third, a);
  first = Solver(with_threads(1));  // a moved-from object can be filled again
  first.factor(a.view());
  expect_solves(first, a);
}

}  // namespace
}  // namespace mfs::test
