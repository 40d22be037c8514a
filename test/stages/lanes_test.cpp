// Scalar programs, and their execution for many systems at a time: against plain loops, with lanes that fail
// beside others.
#include <gmock/gmock.h>

#include <cstring>
#include <set>

#include "kernels/lanes/host_lanes.hpp"
#include "ordering/matrix_check.hpp"
#include "test/stages/lane_problems.hpp"

namespace mfs::test {
namespace {

using lanes::kHostLanes;
using lanes::LaneOutcome;

SparseMatrix pattern_of(Vertex n) {
  return n < 3 ? tridiagonal(n) : random_diagonally_dominant(n, 3, n);
}

// Elimination of the dense pattern, column by column.
std::vector<std::set<Vertex>> eliminated(const SparseMatrix& a, const ScalarProgram& program) {
  const Vertex n = program.n;
  std::vector<Vertex> position(static_cast<std::size_t>(n)), column_at(position.size());
  for (Vertex k = 0; k < n; ++k) {
    position[program.row_of[k]] = k;
    column_at[program.column_of[k]] = k;
  }
  std::vector<std::vector<char>> there(position.size(), std::vector<char>(position.size()));
  for (const Entry& e : entries_of(a)) there[position[e.row]][column_at[e.column]] = 1;
  for (Vertex k = 0; k < n; ++k) {
    for (Vertex i = k + 1; i < n; ++i) {
      for (Vertex j = k + 1; j < n; ++j) there[i][j] |= there[i][k] & there[k][j];
    }
  }
  std::vector<std::set<Vertex>> columns(position.size());
  for (Vertex i = 0; i < n; ++i) {
    for (Vertex j = 0; j < n; ++j) {
      if (there[i][j]) columns[j].insert(i);
    }
  }
  return columns;
}

TEST(ScalarProgram, HasTheEntriesOfElimination) {
  for (const Vertex n : {1, 2, 31, 32, 33, 65}) {
    const LaneProblem<double> problem(pattern_of(n), 1);
    const ScalarProgram& program = problem.program.program;
    const auto columns = eliminated(problem.matrices[0], program);
    Offset products = 0, filled = 0;
    std::set<Vertex> places(program.place.begin(), program.place.end());
    ASSERT_EQ(places.size(), program.place.size());
    for (Vertex k = 0; k < n; ++k) {
      const auto begin = program.row.begin() + program.column_begin[k],
                 end = program.row.begin() + program.column_begin[k + 1];
      EXPECT_TRUE(std::is_sorted(begin, end));
      EXPECT_EQ(std::set<Vertex>(begin, end), columns[k]) << "column " << k << " of " << n;
      EXPECT_EQ(program.row[program.pivot[k]], k);
      for (const Vertex j : columns[k]) {
        if (j < k)
          products += static_cast<Offset>(std::distance(columns[j].upper_bound(j), columns[j].end()));
      }
    }
    EXPECT_EQ(program.products, products);
    for (const Vertex entry : program.fill) filled += places.insert(entry).second;
    EXPECT_EQ(filled, static_cast<Offset>(program.fill.size()));
    EXPECT_EQ(static_cast<Offset>(places.size()), program.entries());
  }
}

TEST(ScalarProgram, IsNotMadeBeyondItsLimits) {
  const SparseMatrix a = grid_2d(8, 8);
  const Pattern pattern = check_pattern(a.view(), 1);
  std::vector<Vertex> order(64);
  std::iota(order.begin(), order.end(), 0);
  const auto made = [&](Offset entries, Offset products) {
    return make_scalar_program(pattern, order, order, {entries, products});
  };
  const auto program = made(10000, 100);
  ASSERT_TRUE(program);
  const Offset entries = program->entries(), ratio = program->products / entries;
  EXPECT_TRUE(made(entries, ratio + 1));
  EXPECT_FALSE(made(entries - 1, ratio + 1));
  EXPECT_FALSE(made(entries, ratio));
  // No pivot where the matrix and elimination leave nothing.
  const SparseMatrix swapped = from_entries(2, {{0, 1, 1}, {1, 0, 1}});
  EXPECT_FALSE(make_scalar_program(check_pattern(swapped.view(), 1), {0, 1}, {0, 1}, {100, 100}));
  EXPECT_TRUE(make_scalar_program(check_pattern(swapped.view(), 1), {1, 0}, {0, 1}, {100, 100}));
}

template <class Scalar>
class HostLanesOf : public testing::Test {};
using Scalars = testing::Types<double, float, std::complex<double>, std::complex<float>>;
TYPED_TEST_SUITE(HostLanesOf, Scalars);

template <class Scalar>
std::vector<LaneOutcome> solve_on_host(LaneProblem<Scalar>& problem, int first, int count) {
  lanes::HostLanes<Scalar> host(problem.program.view(), problem.rules, problem.nrhs);
  std::vector<LaneOutcome> outcome(static_cast<std::size_t>(count));
  host.solve(problem.systems(first, count), outcome.data());
  return outcome;
}

TYPED_TEST(HostLanesOf, SystemsAreSolvedWhateverTheirNumber) {
  for (const Vertex n : {1, 2, 31, 32, 33, 65}) {
    for (const int count : {1, 7, 8}) {
      LaneProblem<TypeParam> problem(pattern_of(n), count, 2, 3);
      const auto outcome = solve_on_host(problem, 0, count);
      for (int k = 0; k < count; ++k) {
        ASSERT_TRUE(outcome[k].solved);
        EXPECT_LE(problem.error_of(k), problem.rules.tolerance * 1.01);
        EXPECT_NEAR(outcome[k].backward_error, problem.error_of(k), 0.1 * problem.rules.tolerance);
        EXPECT_TRUE(problem.near_reference(k)) << n << " unknowns";
      }
      EXPECT_TRUE(problem.gaps_are_untouched());
    }
  }
}

TYPED_TEST(HostLanesOf, ALaneComputesWhatItWouldAlone) {
  LaneProblem<TypeParam> together(grid_2d(7, 9), 8, 2, 1), alone(grid_2d(7, 9), 8, 2, 1);
  solve_on_host(together, 0, 8);
  for (int k = 0; k < 8; ++k) solve_on_host(alone, k, 1);
  EXPECT_TRUE(same_bits(together.x, alone.x));
}

TYPED_TEST(HostLanesOf, ALaneThatFailsSpoilsNoOther) {
  LaneProblem<TypeParam> good(grid_2d(7, 9), 8, 1, 1), spoilt(grid_2d(7, 9), 8, 1, 1);
  const auto well = solve_on_host(good, 0, 8);
  spoil(spoilt);
  const auto outcome = solve_on_host(spoilt, 0, 8);
  for (int k = 0; k < 8; ++k) {
    SCOPED_TRACE(k);
    EXPECT_TRUE(well[k].solved);
    EXPECT_EQ(outcome[k].solved, k == 0 || k == 7);
    EXPECT_EQ(spoilt.untouched(k), !outcome[k].solved);
    if (outcome[k].solved) {
      EXPECT_TRUE(spoilt.same_solution(k, good));
      EXPECT_EQ(outcome[k].backward_error, well[k].backward_error);
    }
  }
}

// Also where it divides nothing: A may be singular.
TYPED_TEST(HostLanesOf, APivotThatMayBeRoundingFails) {
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < 5; ++i) entries.push_back({i, i, 3.0 + static_cast<double>(i)});
  LaneProblem<TypeParam> problem(from_entries(5, entries), 3);
  const double tiny = std::sqrt(LaneProblem<TypeParam>::kEpsilon);
  problem.first_pivot(1) = static_cast<TypeParam>(0.4 * tiny * problem.largest(1));
  problem.first_pivot(2) = static_cast<TypeParam>(2 * tiny * problem.largest(2));
  problem.put_values();
  const auto outcome = solve_on_host(problem, 0, 3);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(outcome[k].solved, k != 1);
}

// A weak pivot grows what is divided by it, and costs digits that refinement brings back; the
// other lanes are as they were.
TYPED_TEST(HostLanesOf, OnlyLanesThatNeedItAreRefined) {
  using Real = decltype(std::abs(TypeParam()));
  LaneProblem<TypeParam> good(grid_2d(7, 9), 8, 1, 1), weak(grid_2d(7, 9), 8, 1, 1);
  const double epsilon = std::numeric_limits<Real>::epsilon();
  for (LaneProblem<TypeParam>* problem : {&good, &weak}) problem->rules.tolerance = 5 * epsilon;
  weak.first_pivot(3) = static_cast<TypeParam>(2 * std::sqrt(epsilon) * weak.largest(3));
  weak.put_values();
  const auto well = solve_on_host(good, 0, 8), outcome = solve_on_host(weak, 0, 8);
  for (int k = 0; k < 8; ++k) {
    EXPECT_TRUE(outcome[k].solved);
    EXPECT_EQ(outcome[k].steps > 0, k == 3);
    EXPECT_LE(weak.error_of(k), weak.rules.tolerance * 1.1);
    EXPECT_TRUE(k == 3 || weak.same_solution(k, good));
  }
  weak.rules.max_steps = 0;
  std::fill(weak.x.begin(), weak.x.end(), weak.none());
  const auto refused = solve_on_host(weak, 0, 8);
  for (int k = 0; k < 8; ++k) EXPECT_EQ(refused[k].solved, k != 3);
  EXPECT_TRUE(weak.untouched(3));
  // What no lane can reach is refused, and not tried for ever.
  weak.rules.max_steps = 1000;
  weak.rules.tolerance = 1e-30;
  for (const LaneOutcome& lane : solve_on_host(weak, 0, 8)) EXPECT_FALSE(lane.solved);
}

// Repeated entries are summed; rows longer than a block of the residual's sum.
TYPED_TEST(HostLanesOf, EntriesMayRepeatAndRowsMayBeLong) {
  LaneProblem<TypeParam> problem(long_rows(), 5, 1, 0);
  for (const LaneOutcome& lane : solve_on_host(problem, 0, 5)) EXPECT_TRUE(lane.solved);
  for (int k = 0; k < 5; ++k) EXPECT_LE(problem.error_of(k), problem.rules.tolerance * 1.01);
}

}  // namespace
}  // namespace mfs::test
