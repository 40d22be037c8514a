// Phases out of order, changed patterns, singular matrices, tolerances out of reach: the class of each error,
// its place, and what is left of the object's state.
#include "test/failure/fresh_solver.hpp"

namespace mfs::test {
namespace {

TEST(State, PhasesOutOfOrder) {
  const SparseMatrix a = grid_2d(4, 4);
  Solver solver(with_threads(1));
  expect_not_factored(solver, a);
  solver.analyze(a.view());
  expect_not_factored(solver, a);
  solver.factor(a.view());
  expect_solves(solver, a);
  solver.analyze(a.view());  // forgets the factorization
  EXPECT_FALSE(solver.factored());
  expect_not_factored(solver, a);
  expect_usable(solver);
}

TEST(State, MovedFrom) {
  const SparseMatrix a = grid_2d(4, 4);
  Solver solver(with_threads(1));
  solver.factor(a.view());
  Solver taken(std::move(solver));
  expect_solves(taken, a);
  EXPECT_FALSE(solver.analyzed());  // NOLINT(bugprone-use-after-move)
  EXPECT_FALSE(solver.factored());
  failure_of<StateError>([&] { solver.analyze(a.view()); });
  failure_of<StateError>([&] { solver.factor(a.view()); });
  expect_not_factored(solver, a);
  failure_of<StateError>([&] { solver.report(); });
  failure_of<StateError>([&] { solver.options(); });
  failure_of<StateError>([&] { solver.depths(); });
  solver = std::move(taken);
  expect_solves(solver, a);
}

TEST(State, PatternChanged) {
  const SparseMatrix a = grid_2d(5, 5);
  Solver solver(with_threads(2));
  solver.factor(a.view());
  const auto changed = [&](const SparseMatrix& other, std::int64_t row) {
    for (const bool again : {false, true}) {
      const auto call = [&] { again ? solver.refactor(other.view()) : solver.factor(other.view()); };
      if (const auto error = failure_of<PatternChanged>(call)) {
        EXPECT_EQ(error->row(), row);
        EXPECT_THAT(error->what(), testing::HasSubstr("row " + std::to_string(row)));
      }
      expect_solves(solver, a);  // the last factorization is still there
    }
  };
  SparseMatrix other = a;
  other.columns[other.offsets[7]] = 0;
  changed(other, 7);

  std::vector<Entry> entries = entries_of(a);
  entries.push_back({13, 0, 1.0});
  changed(from_entries_summed(a.n, entries), 13);

  entries = entries_of(a);
  entries.erase(entries.begin() + a.offsets[20]);
  changed(from_entries_summed(a.n, entries), 20);

  other = a;
  std::swap(other.columns[other.offsets[3]],
            other.columns[other.offsets[3] + 1]);  // the same entries in another order
  changed(other, 3);
  changed(grid_2d(4, 4), 16);
  changed(grid_2d(5, 6), 25);
  expect_usable(solver);
}

TEST(State, PatternChangedBesideRepeatedEntries) {
  const SparseMatrix a = from_entries(3, {{0, 1, 1}, {0, 0, 4}, {1, 1, 5}, {1, 1, 1}, {2, 2, 3}});
  Solver solver(with_threads(1));
  solver.factor(a.view());
  SparseMatrix other = a;
  other.columns[3] = 0;
  auto error = failure_of<PatternChanged>([&] { solver.refactor(other.view()); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->row(), 1);
  other = a;
  other.offsets[1] = 3;
  error = failure_of<PatternChanged>([&] { solver.refactor(other.view()); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->row(), 0);
  expect_solves(solver, from_entries_summed(3, entries_of(a)));
}

TEST(State, StructurallySingular) {
  const auto refused = [](const SparseMatrix& a, std::int64_t row, std::int64_t column,
                          std::int64_t dependent) {
    for (const bool pattern_only : {false, true}) {
      Solver solver(with_threads(1));
      CsrView<double> view = a.view();
      if (pattern_only) view.values = nullptr;
      if (const auto error = failure_of<SingularMatrix>([&] { solver.analyze(view); })) {
        EXPECT_EQ(error->kind(), SingularMatrix::Kind::structural);
        EXPECT_EQ(error->row(), row);
        EXPECT_EQ(error->column(), column);
        EXPECT_EQ(error->dependent_rows(), dependent);
      }
      EXPECT_FALSE(solver.analyzed());
      expect_usable(solver);
    }
  };
  refused(from_entries(3, {{0, 0, 1}, {2, 2, 1}}), 1, 1, 1);  // an empty row and column
  refused(from_entries(3, {{0, 0, 1}, {0, 2, 1}, {2, 0, 1}, {2, 2, 1}}), 1, 1, 1);
  refused(from_entries(4, {{1, 1, 1}}), 0, 0, 3);
  refused(from_entries(1, {}), 0, 0, 1);
}

TEST(State, NumericallySingular) {
  const auto refused = [](const SparseMatrix& a, const std::vector<double>& b, std::vector<std::int64_t> rows,
                          std::vector<std::int64_t> columns) {
    Solver solver(with_threads(1));
    std::vector<double> x(b.size(), 5.0);
    const auto call = [&] {
      solver.factor(a.view());
      solver.solve(b.data(), x.data());
    };
    if (const auto error = failure_of<SingularMatrix>(call)) {
      if (error->kind() == SingularMatrix::Kind::numerical) {
        EXPECT_THAT(rows, testing::Contains(error->row()));
        EXPECT_THAT(columns, testing::Contains(error->column()));
        EXPECT_EQ(error->dependent_rows(), 1);
      }
    }
    EXPECT_EQ(x, std::vector<double>(b.size(), 5.0));
    expect_usable(solver);
  };
  // Rows 0 and 1 are the same; no b but one of the same kind can be reached.
  refused(from_entries(2, {{0, 0, 1}, {0, 1, 2}, {1, 0, 1}, {1, 1, 2}}), {1, 2}, {0, 1}, {0, 1});
  // The Laplacian without a boundary: all rows sum up to zero.
  std::vector<Entry> entries;
  const std::int64_t n = 20;
  for (std::int64_t i = 0; i < n; ++i) {
    entries.push_back({i, i, 2});
    entries.push_back({i, (i + 1) % n, -1});
    entries.push_back({i, (i + n - 1) % n, -1});
  }
  std::vector<std::int64_t> all(n);
  for (std::int64_t i = 0; i < n; ++i) all[i] = i;
  std::vector<double> b(n, 0.0);
  b[3] = 1;
  refused(from_entries_summed(n, entries), b, all, all);
}

/// Factored, and asked for more than rounding leaves.
Solver too_strict_solver(const SparseMatrix& a) {
  Options options = with_threads(1);
  options.solve.tolerance = 1e-30;
  Solver solver(options);
  solver.factor(a.view());
  return solver;
}

TEST(State, ToleranceOutOfReach) {
  const SparseMatrix a = grid_2d(9, 9);
  Solver solver = too_strict_solver(a);
  const std::vector<double> b = right_hand_sides(a, 1, a.n, 1);
  std::vector<double> x(b.size(), 7.0);
  for (const bool transpose : {false, true}) {
    const auto call = [&] {
      (solver.*(transpose ? &Solver::solve_transpose : &Solver::solve))(b.data(), x.data(), 1, 0, 0);
    };
    if (const auto error = failure_of<AccuracyNotReached>(call)) {
      EXPECT_EQ(error->asked(), 1e-30);
      EXPECT_GT(error->reached(), 1e-30);
      EXPECT_LT(error->reached(), 1e-14);
    }
    EXPECT_EQ(x, std::vector<double>(b.size(), 7.0));
  }
  EXPECT_TRUE(solver.factored());
  const std::vector<double> zero(a.n, 0.0);
  solver.solve(zero.data(), x.data());
  EXPECT_EQ(x, zero);
}

// Columns are solved in blocks of 16: a failure leaves its own block and all later ones of x alone.
TEST(State, FailureInALaterColumnLeavesItsBlockOfX) {
  const SparseMatrix a = grid_2d(6, 6);
  Solver solver = too_strict_solver(a);
  const std::int64_t nrhs = 40;
  std::vector<double> b(static_cast<std::size_t>(a.n * nrhs), 0.0), x(b.size(), 7.0), expected = x;
  for (std::int64_t i = 0; i < a.n; ++i) b[17 * a.n + i] = std::sqrt(1.0 + static_cast<double>(i));
  failure_of<AccuracyNotReached>([&] { solver.solve(b.data(), x.data(), nrhs); });
  std::fill(expected.begin(), expected.begin() + 16 * a.n, 0.0);
  EXPECT_EQ(x, expected);
}

}  // namespace
}  // namespace mfs::test
