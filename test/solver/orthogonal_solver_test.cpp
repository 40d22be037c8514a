// The last rung by itself: right for every size and order, never for more than it may take, and a singular
// matrix is told as one.
#include <complex>
#include <numeric>

#include "solver/orthogonal_solver.hpp"
#include "test/solver/systems.hpp"

namespace mfs::test {
namespace {

constexpr double kAllRoom = 1e12;
constexpr SolveControls kControls{1e-12, 10, 0, false};

template <class Scalar>
MatchedScaling scaling_of(const BasicSparseMatrix<Scalar>& a) {
  MatchedScaling scaling;
  scaling.row_scale.assign(static_cast<std::size_t>(a.n), 1);
  scaling.column_scale.assign(static_cast<std::size_t>(a.n), 1);
  for (std::size_t i = 0; i < scaling.row_scale.size(); i += 3) scaling.row_scale[i] = 0.25;
  for (std::size_t j = 0; j < scaling.column_scale.size(); j += 2) scaling.column_scale[j] = 8;
  return scaling;
}

std::vector<Vertex> natural(std::int64_t n) {
  std::vector<Vertex> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

template <class Scalar>
void expect_right(const BasicSparseMatrix<Scalar>& a) {
  for (const bool with_transposed : {false, true}) {
    SCOPED_TRACE(std::to_string(a.n) + (with_transposed ? ", transposed" : ""));
    const auto solver =
        OrthogonalSolver<Scalar>::make(a.view(), with_transposed, scaling_of(a), natural(a.n), kAllRoom);
    ASSERT_TRUE(solver);
    const BasicSparseMatrix<Scalar> solved = with_transposed ? transposed(a) : a;
    const std::vector<Scalar> b = right_hand_sides(solved, 1, a.n, 1);
    std::vector<Scalar> x(b.size());
    SolveControls controls = kControls;
    controls.tolerance = kTolerance<Scalar>;
    const SolveOutcome outcome = solver->solve(b.data(), x.data(), controls);
    EXPECT_LE(outcome.backward_error, kTolerance<Scalar>);
    EXPECT_LE(backward_error(solved, b, x), kPromisedFor<Scalar>);
    EXPECT_GT(solver->smallness(), 1e-7);
  }
}

// What is in range in the numbers of its factors may not be in those of the solution.
TEST(OrthogonalSolver, ASolutionBeyondTheRangeIsNone) {
  using Scalar = std::complex<float>;
  const auto a = from_entries<Scalar>(1, {{0, 0, Scalar(1e-13f, -1e-13f)}});
  const auto solver = OrthogonalSolver<Scalar>::make(a.view(), false, scaling_of(a), natural(1), kAllRoom);
  const Scalar b(-1.5e26f, -2e25f);
  Scalar x;
  EXPECT_EQ(solver->solve(&b, &x, kControls).backward_error, std::numeric_limits<double>::infinity());
}

TEST(OrthogonalSolver, SolvesAnySize) {
  for (const std::int64_t n : {1, 2, 31, 32, 33, 65, 257}) {
    const SparseMatrix a = random_diagonally_dominant(n, std::min<std::int64_t>(n, 4), 7);
    expect_right(a);
    expect_right(in_scalar<float>(a));
    expect_right(in_scalar<std::complex<double>>(a));
    expect_right(in_scalar<std::complex<float>>(a));
  }
  expect_right(grid_2d(20, 17));
}

// Rows by their first column: a cyclic shift has its diagonal nowhere.
TEST(OrthogonalSolver, SolvesWithoutADiagonal) {
  constexpr std::int64_t kRows = 40;
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < kRows; ++i) {
    entries.push_back({i, (i + 7) % kRows, 2.0});
    entries.push_back({i, (i + 20) % kRows, 1.0});
  }
  expect_right(from_entries(kRows, entries));
}

TEST(OrthogonalSolver, TakesNoMoreThanItMay) {
  const SparseMatrix small = grid_2d(20, 17);
  const auto made = [](const SparseMatrix& a, double room) {
    return OrthogonalSolver<double>::make(a.view(), false, scaling_of(a), natural(a.n), room);
  };
  EXPECT_TRUE(made(small, kAllRoom));
  for (const double room : {0.0, 1e5, 2.5e5}) EXPECT_FALSE(made(small, room)) << room;
  const SparseMatrix large = grid_2d(500, 500);  // 1.7e10 operations by a dissection
  EXPECT_FALSE(made(large, kAllRoom));
}

TEST(OrthogonalSolver, SaysSingular) {
  const SparseMatrix grid = grid_2d(12, 11);
  std::vector<Entry> entries;
  std::vector<double> diagonal(static_cast<std::size_t>(grid.n), 0);
  for (const Entry& e : entries_of(grid)) {
    if (e.row == e.column) continue;
    entries.push_back({e.row, e.column, -1.0});
    diagonal[static_cast<std::size_t>(e.row)] += 1;
  }
  for (std::int64_t i = 0; i < grid.n; ++i) entries.push_back({i, i, diagonal[static_cast<std::size_t>(i)]});
  const SparseMatrix a = from_entries(grid.n, entries);  // its rows sum to zero
  const auto solver = OrthogonalSolver<double>::make(a.view(), false, scaling_of(a), natural(a.n), kAllRoom);
  ASSERT_TRUE(solver);
  std::vector<double> b = right_hand_sides(a, 1, a.n, 1), x(b.size());  // consistent
  EXPECT_LE(solver->smallness(), 1e-14);
  EXPECT_GE(solver->dependent_column(), 0);
  EXPECT_LE(solver->solve(b.data(), x.data(), kControls).backward_error, 1e-12);
  EXPECT_LE(backward_error(a, b, x), kPromised);
}

TEST(OrthogonalSolver, TakesNoStructurallySingularMatrix) {
  const SparseMatrix a = from_entries(3, {{0, 0, 1}, {1, 0, 2}, {2, 1, 3}, {2, 2, 1}});
  EXPECT_FALSE(OrthogonalSolver<double>::make(a.view(), false, scaling_of(a), natural(3), kAllRoom));
}

}  // namespace
}  // namespace mfs::test
