// Plans of segments, followed on the host with limits drawn at random: the factors of a plan of one piece,
// bit for bit, and the solutions of the plain reference.
#include <algorithm>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "plan/segment_order.hpp"
#include "test/stages/dominant_problem.hpp"
#include "test/stages/segment_interpreter.hpp"

namespace mfs::test {
namespace {

constexpr Vertex kTurnRows = 10;
constexpr Vertex kUndivided = std::numeric_limits<Vertex>::max();  // rows of the fronts that stay whole
constexpr double kTolerance = 4000 * std::numeric_limits<double>::epsilon();

std::vector<StageProblem<double>> problems() {
  std::vector<StageProblem<double>> made;
  std::uint64_t seed = 20;
  for (const auto& shapes : {mixed_tree(), broom(), chain(), binary_tree(5, 33, 60), binary_tree(4, 70, 130)})
    made.push_back(column_dominant(artificial_problem(shapes, {seed++})));
  made.push_back(
      column_dominant(artificial_problem(binary_tree(5, 20, 50), {seed++, 1.0, 64, {4, kTurnRows}})));
  return made;
}

std::vector<DeviceLimits> all_limits() {
  DeviceLimits warps, slabs{16, 10, true, 32}, ahead{32, 0, false};
  warps.many_tiny = 1;
  slabs.panelled = 64;
  slabs.panelled_rows = 0;
  slabs.panel = 32;
  slabs.slab = 64;
  slabs.ahead_tiles = 0;
  slabs.many_tiny = 10;
  slabs.solve_steps = 2;
  slabs.crowd = 0;
  ahead.ahead_tiles = 2;
  ahead.many_tiny = 1000;
  ahead.solve_steps = 1;
  ahead.least_root = 1;
  return {warps, slabs, ahead};
}

/// Factors and solutions of one plan for a region.
void check(const StageProblem<double>& problem, const DeviceLimits& limits, const SegmentPlan& segments) {
  const SymbolicPlan& plan = *problem.plan;
  std::vector<FrontBlocks<double>> expected;
  const DevicePlan in_one = make_device_plan(plan, limits);
  ListInterpreter one_piece(problem, in_one, Copies::at_once, limits.waiting_tiles);
  expected.resize(static_cast<std::size_t>(plan.num_fronts));
  one_piece.factor([&](Vertex step) {
    for (Vertex f = plan.depth_begin[step]; f < plan.depth_begin[step + 1]; ++f)
      expected[f] = one_piece.front(f);
  });
  std::vector<double> right_hand_side = Random(3).vector(plan.n), solution = right_hand_side;
  one_piece.solve(solution);
  for (const auto& [copies, early] :
       {std::pair(Copies::at_once, true), std::pair(Copies::late, true), std::pair(Copies::late, false)}) {
    SCOPED_TRACE(copies == Copies::late ? "late" : "at once");
    SCOPED_TRACE(early ? "assembled early" : "");
    SegmentInterpreter interpreter(problem, segments, limits, copies, early);
    Vertex done = 0;
    interpreter.factor([&](Vertex f, const FrontBlocks<double>& blocks) {
      EXPECT_EQ(blocks.lower, expected[f].lower) << "front " << f;
      EXPECT_EQ(blocks.upper, expected[f].upper) << "front " << f;
      EXPECT_EQ(blocks.contribution, expected[f].contribution) << "front " << f;
      ++done;
    });
    EXPECT_EQ(done, plan.num_fronts);
    for (Vertex f = 0; f < plan.num_fronts; ++f) {
      const FrontBlocks<double> left = interpreter.left(f);
      EXPECT_EQ(left.lower, expected[f].lower) << "front " << f << " in the end";
      EXPECT_EQ(left.upper, expected[f].upper) << "front " << f << " in the end";
    }
    for (int solve = 0; solve < 2; ++solve) {
      std::vector<double> v = right_hand_side;
      interpreter.solve(v);
      EXPECT_EQ(v, solution) << "solve " << solve;
    }
  }
}

TEST(Segments, GiveTheFactorsOfOnePieceForAnyLimit) {
  const std::uint64_t seed = std::random_device()();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  for (const StageProblem<double>& problem : problems()) {
    const SymbolicPlan& plan = *problem.plan;
    for (const DeviceLimits& limits : all_limits()) {
      if (plan.has_turns() && limits.small_rows > kTurnRows) continue;  // small fronts have none
      const Offset spare = aligned(static_cast<Offset>(random() % static_cast<std::uint64_t>(plan.n)));
      const Offset least = least_region(plan, spare, limits.small_rows), most = plan.storage_entries + spare;
      for (const Offset region :
           {least, least + static_cast<Offset>(random() % static_cast<std::uint64_t>(most - least + 1))}) {
        SCOPED_TRACE("region " + std::to_string(region) + " of " + std::to_string(plan.storage_entries) +
                     ", spare " + std::to_string(spare));
        const SegmentPlan segments = make_segments(plan, region, spare, limits.small_rows);
        ASSERT_FALSE(segments.empty());
        EXPECT_LE(segments.region_entries, region);
        check(problem, limits, segments);
        if (HasFailure()) return;
      }
    }
  }
}

// For a file: nothing but whole factors leaves, and all of that comes back.
TEST(Segments, ForAFileTheFactorsAloneLeave) {
  const std::uint64_t seed = std::random_device()();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  for (const StageProblem<double>& problem : problems()) {
    const SymbolicPlan& plan = *problem.plan;
    if (plan.has_turns()) continue;
    const Offset spare = aligned(static_cast<Offset>(random() % static_cast<std::uint64_t>(plan.n)));
    const Offset least = least_region(plan, spare, kUndivided, Outside::file),
                 most = plan.storage_entries + spare;
    const Offset for_memory = least_region(plan, spare, kUndivided);
    EXPECT_GE(least, for_memory);
    for (const Offset region :
         {for_memory, least,
          least + static_cast<Offset>(random() % static_cast<std::uint64_t>(most - least + 1))}) {
      SCOPED_TRACE("region " + std::to_string(region) + " of " + std::to_string(plan.storage_entries));
      const SegmentPlan segments = make_segments(plan, region, spare, kUndivided, Outside::file);
      if (region < least && segments.empty()) continue;
      ASSERT_FALSE(segments.empty());
      EXPECT_LE(segments.region_entries, region);
      EXPECT_EQ(segments.blocks_out(), 0);
      EXPECT_FALSE(segments.has_divided());
      for (const Segment& segment : segments.segments) EXPECT_EQ(segment.comes(), !segment.stays());
      check(problem, all_limits().front(), segments);
      if (HasFailure()) return;
    }
  }
}

/// What the device's sums depend on, of every task but its places: kinds of launches, sizes, steps.
std::multiset<std::vector<Vertex>> tasks_of(const DevicePlan& lists) {
  std::multiset<std::vector<Vertex>> tasks;
  const auto add_tiles = [&](const std::vector<SolveLaunch>& launches, Vertex direction) {
    for (const SolveLaunch& launch : launches) {
      for (Offset i = launch.tiny.begin; i < launch.tiny.end; ++i)
        tasks.insert({direction, lists.tiny_fronts[i]});
      for (Offset i = launch.tiles.begin; i < launch.tiles.end; ++i) {
        const SolvePart& part = lists.solve[i];
        tasks.insert(
            {direction, part.front, part.begin, part.first_step, part.last_step, part.rows, part.parts});
      }
    }
  };
  add_tiles(lists.forward, -1);
  add_tiles(lists.backward, -2);
  for (const DepthLaunches& depth : lists.depths) {
    for (const SmallLaunch& launch : depth.small) {
      for (Offset i = launch.fronts.begin; i < launch.fronts.end; ++i)
        tasks.insert({-3, launch.rows, lists.small_fronts[i]});
    }
    for (const auto* launches : {&depth.factor, &depth.update}) {
      for (const Launch& launch : *launches) {
        const auto kind = static_cast<Vertex>(launch.kind);
        for (Offset i = launch.tasks.begin; i < launch.tasks.end; ++i) {
          if (launch.kind == Launch::Kind::diagonal || launch.kind == Launch::Kind::strips) {
            const StepTask& task = lists.steps[i];
            tasks.insert({kind, launch.width, task.front, task.k, task.left, task.begin, task.end});
          } else {
            const ProductTask& task = lists.products[i];
            tasks.insert({kind, task.front, task.m, task.n, task.k, task.lda, task.ldb, task.ldc});
          }
        }
      }
    }
  }
  return tasks;
}

TEST(Segments, HaveTheTasksOfOnePiece) {
  for (const StageProblem<double>& problem : problems()) {
    const SymbolicPlan& plan = *problem.plan;
    const SegmentPlan segments = make_segments(plan, least_region(plan, 0, kUndivided), 0, kUndivided);
    for (const DeviceLimits& limits : all_limits())
      EXPECT_EQ(tasks_of(make_device_plan(placed_by(segments, plan), limits, segments)),
                tasks_of(make_device_plan(plan, limits)));
  }
}

// Beside the interpreter of one piece, which shares its loops: the reference shares nothing.
TEST(Segments, SolveAsThePlainReference) {
  const StageProblem<double> problem = column_dominant(artificial_problem(binary_tree(5, 33, 60), {31}));
  const SymbolicPlan& plan = *problem.plan;
  const std::vector<ReferenceFront<double>> reference = factor(plan, problem.scaled(), ReferenceRule());
  std::vector<double> expected = Random(3).vector(plan.n), v = expected;
  solve_forward(reference, false, expected);
  solve_backward(reference, false, expected);
  DeviceLimits limits;
  SegmentInterpreter interpreter(
      problem, make_segments(plan, least_region(plan, 0, kUndivided), 0, kUndivided), limits, Copies::late);
  interpreter.factor([&](Vertex f, const FrontBlocks<double>& blocks) {
    EXPECT_LT(difference(blocks.lower, blocks_of(reference[f]).lower), kTolerance);
  });
  interpreter.solve(v);
  EXPECT_LT(difference(v, expected), kTolerance);
}

TEST(Segments, DoEveryFrontOnceAndAfterItsChildren) {
  for (const StageProblem<double>& problem : problems()) {
    const SymbolicPlan& plan = *problem.plan;
    for (const Vertex level : {0, 1, 2, 9}) {
      for (const Offset most : {Offset(1), Offset(5000), plan.factor_entries}) {
        const SegmentOrder order = order_segments(plan, level, most);
        std::vector<Vertex> done(static_cast<std::size_t>(plan.num_fronts), -1);
        for (std::size_t t = 0; t < order.step.size(); ++t) {
          Offset entries = 0;
          for (Vertex i = order.begin[t]; i < order.begin[t + 1]; ++i) {
            const Vertex f = order.fronts[i];
            EXPECT_EQ(done[f], -1) << "twice";
            done[f] = static_cast<Vertex>(t);
            EXPECT_TRUE(plan.depth_begin[order.step[t]] <= f && f < plan.depth_begin[order.step[t] + 1]);
            for (Vertex c = plan.child_begin[f]; c < plan.child_begin[f + 1]; ++c) {
              const Vertex child = plan.children[c];
              EXPECT_TRUE(done[child] >= 0 && done[child] < done[f]) << "before its child";
            }
            entries += static_cast<Offset>(plan.pivots(f)) * (plan.rows(f) + plan.border_rows(f));
          }
          const bool one = order.begin[t + 1] - order.begin[t] == 1, roots = t + 1 == order.step.size();
          EXPECT_TRUE(one || roots || entries <= most);
        }
        EXPECT_EQ(std::count(done.begin(), done.end(), -1), 0);
      }
    }
  }
}

// What a limit costs: below the whole region something leaves, and ever more.
TEST(Segments, KeepWhatFits) {
  const StageProblem<double> problem = artificial_problem(binary_tree(6, 60, 150), {41, 0.05});
  const SymbolicPlan& plan = *problem.plan;
  const Offset least = least_region(plan, 0, kUndivided);
  EXPECT_LT(least, plan.storage_entries / 2);
  Offset before = -1;
  for (const double part : {1.5, 1.0, 0.75, 0.5}) {
    const auto region = static_cast<Offset>(part * static_cast<double>(plan.storage_entries));
    const SegmentPlan segments = make_segments(plan, region, 0, kUndivided);
    ASSERT_FALSE(segments.empty());
    EXPECT_GE(segments.host_entries, before);
    before = segments.host_entries;
    EXPECT_TRUE(part < 1.5 || segments.host_entries == 0);
    // At least what does not fit leaves, and less than everything if half fits.
    EXPECT_GE(segments.host_entries, plan.factor_entries - region);
    EXPECT_LT(segments.host_entries, plan.factor_entries);
    EXPECT_GE(segments.entries_back(), segments.host_entries);
    EXPECT_LE(segments.entries_back(), 2 * segments.host_entries);
  }
  EXPECT_EQ(make_segments(plan, plan.storage_entries / 2, 0, kUndivided).blocks_out(), 0);
  EXPECT_GT(make_segments(plan, least, 0, kUndivided).blocks_out(), 0);
  EXPECT_TRUE(make_segments(plan, plan.max_front, 0, 0).empty()) << "no front fits there";
}

// A pass leaves out the triangles of large pivot blocks, and the blocks beside them, that it does not read.
TEST(Segments, WhatAPassDoesNotReadStaysOutside) {
  const StageProblem<double> problem = artificial_problem(binary_tree(4, 300, 200), {41, 0.05});
  const SymbolicPlan& plan = *problem.plan;
  constexpr Vertex kSmall = 20;
  const SegmentPlan segments = make_segments(plan, plan.storage_entries * 6 / 10, 0, kSmall);
  ASSERT_GT(segments.host_entries, 0);
  Vertex twice = 0;
  for (std::size_t t = 0; t < segments.segments.size(); ++t) {
    const Segment& own = segments.segments[t];
    if (own.stays() || own.entries == 0) continue;
    ++twice;
    const auto k = static_cast<Vertex>(t);
    const Offset lower = segments.lower_side.entries(k), upper = segments.upper_side.entries(k);
    // Tiles on the diagonal come in both passes: of 300 pivots, 200 rows and 200 columns beside them, each
    // front has 300 * 700 entries, and no more than 300 * 64 of them in such tiles.
    EXPECT_GE(lower + upper, own.entries);
    EXPECT_LE(static_cast<double>(lower + upper), 1.1 * static_cast<double>(own.entries));
  }
  EXPECT_GT(twice, 0);
  EXPECT_LE(static_cast<double>(segments.entries_back()), 1.1 * static_cast<double>(segments.host_entries));
}

}  // namespace
}  // namespace mfs::test
