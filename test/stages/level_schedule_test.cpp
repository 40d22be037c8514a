// Schedules of scalar programs, executed by plain loops: against elimination of the dense matrix.
#include <gmock/gmock.h>

#include <algorithm>
#include <set>

#include "ordering/clique_tree.hpp"
#include "ordering/graph.hpp"
#include "plan/level_schedule.hpp"
#include "test/stages/lane_problems.hpp"

namespace mfs::test {
namespace {

constexpr std::uint64_t kMask = (std::uint64_t{1} << Packed::kNumber) - 1;

using Numbers = std::vector<double>;
using Dense = std::vector<Numbers>;

/// Executes levels; all tasks of a level find what the levels before it have left.
void run(const LevelSchedule& schedule, Vertex first, Vertex last, const Numbers* factors, Numbers& out) {
  for (Vertex level = first; level < last; ++level) {
    const Numbers before = out, &from = factors ? *factors : before;
    std::set<std::uint64_t> targets;
    for (Vertex t = schedule.level_begin[level]; t < schedule.level_begin[level + 1]; ++t) {
      const std::uint64_t task = schedule.tasks[t], target = task & kMask;
      if (task == 0) continue;
      ASSERT_TRUE(targets.insert(target).second) << "two tasks for one target";
      const std::uint64_t count = task >> (Packed::kNumber + 1) & ((std::uint64_t{1} << Packed::kCount) - 1);
      const std::uint64_t row = task >> (Packed::kNumber + 1 + Packed::kCount);
      for (std::uint64_t k = 0; k < count; ++k) {
        const std::uint64_t product = schedule.products[(row + k) * kSliceTasks + t % kSliceTasks];
        out[target] -= from[product & kMask] * from[product >> Packed::kNumber & kMask] *
                       before[product >> (2 * Packed::kNumber)];
      }
      if (task >> Packed::kNumber & 1) out[target] = 1 / out[target];
    }
  }
}

/// The matrix in the order of the program, eliminated without dividing columns by their pivots.
Dense eliminated(const SparseMatrix& a, const ScalarProgram& program) {
  const auto n = static_cast<std::size_t>(program.n);
  std::vector<Vertex> position(n), column_at(n);
  for (Vertex k = 0; k < program.n; ++k) position[program.row_of[k]] = column_at[program.column_of[k]] = k;
  Dense d(n, Numbers(n));
  for (const Entry& e : entries_of(a)) d[position[e.row]][column_at[e.column]] = e.value;
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = k + 1; i < n; ++i) {
      for (std::size_t j = k + 1; j < n; ++j) d[i][j] -= d[i][k] / d[k][k] * d[k][j];
    }
  }
  return d;
}

struct Scheduled {
  Scheduled(const SparseMatrix& a, int together)
      : program(lane_program_of(a).program),
        schedule(make_level_schedule(program, together)),
        dense(eliminated(a, program)),
        factors(program.row.size()) {
    for (std::size_t slot = 0; slot < program.place.size(); ++slot)
      factors[program.place[slot]] = a.values[slot];
    run(schedule, 0, schedule.factor_levels, nullptr, factors);
  }
  ScalarProgram program;
  LevelSchedule schedule;
  Dense dense;
  Numbers factors;
};

SparseMatrix pattern_of(Vertex n) {
  return n < 3 ? tridiagonal(n) : n < 66 ? random_diagonally_dominant(n, 3, n) : grid_2d(9, 11);
}

TEST(LevelSchedule, EliminatesWhateverIsTakenTogether) {
  for (const Vertex n : {1, 2, 31, 32, 33, 65, 99}) {
    for (const int together : {1, 2, 4, 100}) {
      SCOPED_TRACE(testing::Message() << n << " unknowns, " << together << " together");
      const Scheduled made(pattern_of(n), together);
      const ScalarProgram& program = made.program;
      for (Vertex k = 0; k < n; ++k) {
        for (Vertex e = program.column_begin[k]; e < program.column_begin[k + 1]; ++e) {
          const double expected = made.dense[program.row[e]][k];
          EXPECT_NEAR(made.factors[e], e == program.pivot[k] ? 1 / expected : expected, 1e-12);
        }
      }
    }
  }
}

TEST(LevelSchedule, Substitutes) {
  for (const Vertex n : {1, 2, 31, 32, 33, 65, 99}) {
    SCOPED_TRACE(n);
    const Scheduled made(pattern_of(n), 4);
    const LevelSchedule& schedule = made.schedule;
    Random random(7);
    Numbers x = random.vector<double>(n), b(x.size()), y;
    for (std::size_t i = 0; i < x.size(); ++i) {  // b = L U x: U first, then L with pivots for the diagonal
      for (std::size_t j = i; j < x.size(); ++j) b[i] += made.dense[i][j] * x[j];
    }
    for (std::size_t i = x.size(); i-- > 0;) {
      for (std::size_t j = 0; j < i; ++j) b[i] += made.dense[i][j] / made.dense[j][j] * b[j];
    }
    y = b;
    run(schedule, schedule.factor_levels, schedule.levels, &made.factors, y);
    for (Vertex k = 0; k < n; ++k) EXPECT_NEAR(y[k] * made.factors[made.program.pivot[k]], x[k], 1e-12);
  }
}

// Products together are fewer tasks in the same levels, and threads may look beyond the last one.
TEST(LevelSchedule, HasFewTasksInFewLevels) {
  const Scheduled alone(grid_2d(9, 11), 1), together(grid_2d(9, 11), 4);
  const auto tasks = [](const LevelSchedule& schedule) {
    return std::count_if(schedule.tasks.begin(), schedule.tasks.end(), [](auto task) { return task != 0; });
  };
  EXPECT_LT(2 * tasks(together.schedule), tasks(alone.schedule) + 2 * 99);
  EXPECT_EQ(together.schedule.factor_levels, alone.schedule.factor_levels);
  EXPECT_LT(alone.schedule.factor_levels, 99);
  for (const LevelSchedule* schedule : {&alone.schedule, &together.schedule}) {
    const auto& begin = schedule->level_begin;
    ASSERT_EQ(begin.size(), static_cast<std::size_t>(schedule->levels + 1 + kLevelsAhead));
    EXPECT_TRUE(std::is_sorted(begin.begin(), begin.end()));
    for (const Vertex task : begin) EXPECT_EQ(task % kSliceTasks, 0);
    EXPECT_EQ(begin[schedule->levels], static_cast<Vertex>(schedule->tasks.size()));
  }
}

// By which orders are compared before there is a list (ordering/order_matrix.cpp).
TEST(LevelSchedule, HasTheLevelsAndProductsThatTheEliminationTreeSays) {
  for (const SparseMatrix& a : {tridiagonal(40), grid_2d(9, 11), grid_3d(4), arrow(50, 3)}) {
    const Pattern pattern = check_pattern(a.view(), 1);
    const Scheduled made(a, 4);
    const Graph graph = build_graph(pattern, {}, trivial_partition(pattern.n), 1);
    const EliminationTree tree = elimination_tree(graph, made.program.row_of, 1);
    Offset products = 0;
    for (const Offset count : tree.count) products += (count - 1) * (count - 1);
    EXPECT_EQ(made.program.products, products);
    EXPECT_EQ(made.schedule.factor_levels, height_of(graph, tree));
    EXPECT_EQ(made.schedule.levels, 3 * height_of(graph, tree) - 2);
  }
}

}  // namespace
}  // namespace mfs::test
