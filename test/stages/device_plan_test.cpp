// The lists by which the device works, done by plain loops, give the factors and solutions of the plain
// reference, and name every tile, pivot and border row once.
#include <algorithm>
#include <set>
#include <string>

#include "plan/device_flops.hpp"
#include "test/stages/dominant_problem.hpp"
#include "test/stages/list_interpreter.hpp"

namespace mfs::test {
namespace {

constexpr double kTolerance = 4000 * std::numeric_limits<double>::epsilon();

DeviceLimits for_double() {
  DeviceLimits limits;
  limits.many_tiny = 1;
  limits.waiting_tiles = 0;
  return limits;
}

DeviceLimits for_complex_double_with_tiles_ahead() {
  DeviceLimits limits{64, 96, false, 64};
  limits.ahead_tiles = 0;
  limits.many_tiny = 10;
  limits.solve_steps = 1;
  return limits;
}

DeviceLimits with_slabs_and_tall_tiles() {
  DeviceLimits limits{16, 10, true, 32};
  limits.panelled = 64;
  limits.panelled_rows = 0;
  limits.panel = 32;
  limits.slab = 96;
  limits.ahead_tiles = 0;
  limits.many_tiny = 1;
  limits.solve_steps = 2;
  limits.waiting_tiles = 1;
  limits.crowd = 0;
  return limits;
}

DeviceLimits without_small_fronts() {
  DeviceLimits limits{32, 0, false};
  limits.panelled = 33;
  limits.panelled_rows = 200;
  limits.panel = limits.slab = 64;
  limits.ahead_tiles = 2;
  limits.many_tiny = 1000;
  limits.solve_steps = 3;
  limits.waiting_tiles = 5;
  return limits;
}

DeviceLimits with_short_panels() {
  DeviceLimits limits{64, 96, true};
  limits.panelled = limits.panel = limits.slab = 256;
  limits.panelled_rows = 0;
  limits.many_tiny = 1;
  limits.solve_steps = 4;
  limits.waiting_tiles = 3;
  return limits;
}

const std::vector<DeviceLimits> kLimits{for_double(), for_complex_double_with_tiles_ahead(),
                                        with_slabs_and_tall_tiles(), without_small_fronts()};

void check(const StageProblem<double>& problem, const DeviceLimits& limits) {
  const SymbolicPlan& plan = *problem.plan;
  const std::vector<ReferenceFront<double>> reference = factor(plan, problem.scaled(), ReferenceRule());
  const DevicePlan lists = make_device_plan(plan, limits);
  ASSERT_EQ(lists.depths.size(), static_cast<std::size_t>(plan.num_depths));
  std::vector<double> expected = Random(3).vector(plan.n);
  const std::vector<double> right_hand_side = expected;
  solve_forward(reference, false, expected);
  solve_backward(reference, false, expected);
  for (const auto concurrent : {ListInterpreter::Concurrent::at_once, ListInterpreter::Concurrent::late}) {
    SCOPED_TRACE(concurrent == ListInterpreter::Concurrent::late ? "late" : "at once");
    ListInterpreter interpreter(problem, lists, concurrent, limits.waiting_tiles);
    interpreter.factor([&](Vertex step) {
      for (Vertex f = plan.depth_begin[step]; f < plan.depth_begin[step + 1]; ++f) {
        SCOPED_TRACE("front " + std::to_string(f));
        const FrontBlocks<double> actual = interpreter.front(f), wanted = blocks_of(reference[f]);
        for (Vertex i = 0; i < plan.pivots(f); ++i) ASSERT_EQ(reference[f].row_at[i], i);
        EXPECT_LT(difference(actual.lower, wanted.lower), kTolerance) << "P and L";
        EXPECT_LT(difference(actual.upper, wanted.upper), kTolerance) << "U";
        EXPECT_LT(difference(actual.contribution, wanted.contribution), kTolerance) << "C";
      }
    });
    const DeviceFlops counted = count_flops(plan, lists, false);
    EXPECT_EQ(interpreter.flops().getrf, counted.done.getrf);
    EXPECT_EQ(interpreter.flops().trsm, counted.done.trsm);
    EXPECT_EQ(interpreter.flops().gemm, counted.done.gemm + counted.padding);
    std::vector<double> v = right_hand_side;
    interpreter.solve(v);
    EXPECT_LT(difference(v, expected), kTolerance);
  }
}

TEST(DevicePlan, ListsGiveTheFactorsOfFrontsOfAllSizes) {
  for (const DeviceLimits& limits : kLimits) {
    for (const Vertex p : {1, 2, 31, 32, 33, 65, 257}) {
      for (const Vertex b : {0, 1, 33, 65, 257}) {
        SCOPED_TRACE(std::to_string(p) + " pivots, border " + std::to_string(b) + ", tile " +
                     std::to_string(limits.tile));
        check(column_dominant(artificial_problem(leaf_and_root(p, b), {static_cast<std::uint64_t>(p + b)})),
              limits);
        if (HasFailure()) return;
      }
    }
  }
}

TEST(DevicePlan, ListsGiveTheFactorsOfTrees) {
  for (const DeviceLimits& limits : kLimits) {
    for (const auto& shapes : {mixed_tree(), broom(), chain()}) {
      SCOPED_TRACE("tile " + std::to_string(limits.tile));
      check(column_dominant(artificial_problem(shapes, {4})), limits);
    }
  }
}

TEST(DevicePlan, BlocksAreAssembledInTurns) {
  const std::pair<DeviceLimits, Vertex> cases[] = {
      {for_double(), 350}, {with_slabs_and_tall_tiles(), 10}, {with_slabs_and_tall_tiles(), 350}};
  for (const auto& [limits, rows] : cases) {
    SCOPED_TRACE("tile " + std::to_string(limits.tile) + ", more than " + std::to_string(rows) + " rows");
    const StageProblem<double> problem =
        column_dominant(artificial_problem(fork(), {12, 1.0, 64, {4, rows}}));
    ASSERT_TRUE(problem.plan->has_turns());
    check(problem, limits);
  }
}

TEST(DevicePlan, TilesOfOneStepAreTallWhereBordersAreCrowded) {
  const StageProblem<double> problem = artificial_problem(crowd(), {13, 0.2});
  const SymbolicPlan& plan = *problem.plan;
  Vertex tiles = 0;
  for (Vertex f = 0; f + 1 < plan.num_fronts; ++f)
    tiles += (plan.border_rows(f) + kSolveTile - 1) / kSolveTile;
  for (const Vertex room : {tiles - 1, tiles}) {
    DeviceLimits limits = for_double();
    limits.many_tiny = DeviceLimits().many_tiny;
    limits.crowd = room;
    const DevicePlan lists = make_device_plan(plan, limits);
    std::vector<Vertex> covered(static_cast<std::size_t>(plan.num_fronts), 0);
    for (const SolveLaunch& launch : lists.forward) {
      for (Offset i = launch.tiles.begin; i < launch.tiles.end; ++i) {
        const SolvePart& part = lists.solve[i];
        const Vertex p = plan.pivots(part.front);
        covered[part.front] += part.rows;
        const bool tall = room < tiles && part.begin >= p && p <= kSolveTile;
        const Vertex left = (part.begin < p ? p : p + plan.border_rows(part.front)) - part.begin;
        EXPECT_EQ(part.rows, std::min(left, tall ? kTallTile : kSolveTile));
      }
    }
    for (Vertex f = 0; f < plan.num_fronts; ++f) EXPECT_EQ(covered[f], plan.pivots(f) + plan.border_rows(f));
  }
}

/// One by one: each pivot divides what is below it, and subtracts a product from all entries right of that.
double operations_of(Vertex pivots, Vertex rows) {
  double sum = 0;
  for (Vertex k = 0; k < pivots; ++k) sum += (rows - k - 1) + 2.0 * (rows - k - 1) * (rows - k - 1);
  return sum;
}

TEST(DevicePlan, AllDivisionsIntoTilesCountAsManyOperations) {
  std::vector<StageProblem<double>> problems;
  for (const auto& shapes : {mixed_tree(), chain(), leaf_and_root(270, 1030), leaf_and_root(501, 0)})
    problems.push_back(artificial_problem(shapes, {14, 0.05}));
  for (const StageProblem<double>& problem : problems) {
    const SymbolicPlan& plan = *problem.plan;
    double expected = 0, roots = 0;
    for (Vertex f = 0; f < plan.num_fronts; ++f) {
      const double front = operations_of(plan.pivots(f), plan.pivots(f) + plan.border_rows(f));
      expected += front;
      if (plan.border_rows(f) == 0) roots += front;
    }
    for (DeviceLimits limits : kLimits) {
      const DevicePlan lists = make_device_plan(plan, limits);
      EXPECT_NEAR(count_flops(plan, lists, false).done.total(), expected, 1e-12 * expected);
      limits.least_root = 1;
      const DevicePlan with_roots = make_device_plan(plan, limits);
      const DeviceFlops by_tiles = count_flops(plan, with_roots, false),
                        as_a_whole = count_flops(plan, with_roots, true);
      EXPECT_NEAR(by_tiles.done.total(), expected, 1e-12 * expected);
      EXPECT_NEAR(as_a_whole.done.total(), expected, 1e-12 * expected);
      if (with_roots.roots.empty()) continue;
      EXPECT_GE(as_a_whole.done.getrf, roots * (1 - 1e-12));
    }
  }
}

// Many enough for wide tiles, and deep enough for the library.
TEST(DevicePlan, ListsGiveTheFactorsOfLargeFronts) {
  const StageProblem<double> problem = column_dominant(artificial_problem(leaf_and_root(270, 1030), {5}));
  for (const DeviceLimits& limits : {for_double(), with_short_panels()}) {
    const DevicePlan lists = make_device_plan(*problem.plan, limits);
    std::set<Launch::Kind> kinds;
    for (const auto& depth : lists.depths) {
      for (const auto* launches : {&depth.factor, &depth.update}) {
        for (const Launch& launch : *launches) kinds.insert(launch.kind);
      }
    }
    EXPECT_EQ(kinds.count(Launch::Kind::vendor_gemm), 1u);
    check(problem, limits);
  }
}

TEST(DevicePlan, CutsManyDeepProductsWide) {
  const auto kind = [&](Vertex pivots, bool wide) {
    const StageProblem<double> problem =
        artificial_problem({{pivots, 900, 3}, {pivots, 900, 3}, {pivots, 900, 3}, {1000, 0, -1}}, {5, 0.01});
    return make_device_plan(*problem.plan, {128, 160, wide}).depths[0].update[0].kind;
  };
  EXPECT_EQ(kind(260, true), Launch::Kind::wide_products);
  EXPECT_EQ(kind(250, true), Launch::Kind::products);
  EXPECT_EQ(kind(260, false), Launch::Kind::products);
}

// What runs beside diagonal tiles: nothing in small steps, and nothing in fronts with panels, which have
// their own.
TEST(DevicePlan, LooksAheadWhereStepsAreLargeAndThereAreNoPanels) {
  const StageProblem<double> problem = artificial_problem(leaf_and_root(200, 300), {5, 0.01});
  const auto concurrent_launches = [&](Offset ahead_tiles, Vertex panelled_rows) {
    DeviceLimits limits{64, 96, false};
    limits.panelled = limits.panel = 128;
    limits.slab = 256;
    limits.ahead_tiles = ahead_tiles;
    limits.panelled_rows = panelled_rows;
    const DevicePlan lists = make_device_plan(*problem.plan, limits);
    const auto& launches = lists.depths[0].factor;
    return std::count_if(launches.begin(), launches.end(),
                         [](const Launch& launch) { return launch.order == Order::concurrent; });
  };
  EXPECT_EQ(concurrent_launches(0, 501), 3);  // all but the last of four steps
  // The steps have 8 x 8 - 5 x 5, 7 x 7 - 5 x 5 and 6 x 6 - 5 x 5 tiles, those of L and of U apart.
  EXPECT_EQ(concurrent_launches(30, 501), 1);
  EXPECT_EQ(concurrent_launches(1000, 501), 0);
  EXPECT_EQ(concurrent_launches(0, 500), concurrent_launches(1000, 500));
}

// Rows of a block that are exchanged later must be exchanged in all blocks left of it.
TEST(DevicePlan, ExchangesRowsOfEveryBlockLeftOfTheDiagonal) {
  const StageProblem<double> problem = artificial_problem(mixed_tree(), {6});
  const SymbolicPlan& plan = *problem.plan;
  constexpr Vertex kTile = 32, kSmall = 40;
  const DevicePlan lists = make_device_plan(plan, {kTile, kSmall, true});
  for (Vertex step = 0; step < plan.num_depths; ++step) {
    std::set<std::tuple<Vertex, Vertex, Vertex>> expected, listed;
    for (Vertex f = plan.depth_begin[step]; f < plan.depth_begin[step + 1]; ++f) {
      if (plan.pivots(f) + plan.border_rows(f) <= kSmall) continue;
      for (Vertex i = kTile; i < plan.pivots(f); i += kTile) {
        for (Vertex j = 0; j < i; j += kTile) expected.insert({f, i, j});
      }
    }
    const Range& range = lists.depths[step].exchange;
    for (Offset k = range.begin; k < range.end; ++k)
      listed.insert({lists.exchange[k].front, lists.exchange[k].begin, lists.exchange[k].column});
    EXPECT_EQ(listed, expected);
    EXPECT_EQ(static_cast<Offset>(listed.size()), range.count());
  }
}

// What a launch of the forward pass leaves is read by itself and the next one, and the next but one may write
// there.
TEST(DevicePlan, TheLibraryHasRootsIfAllThatAreNotSmallHaveItsSize) {
  const std::vector<FrontShape> shapes = {{20, 3, 1}, {45, 0, -1}, {77, 0, -1}, {9, 0, -1}};
  const StageProblem<double> problem = artificial_problem(shapes, {17});
  const SymbolicPlan& plan = *problem.plan;
  struct Sizes {
    Vertex least, most;
    bool library;
  };
  for (const auto& [least, most, library] :
       {Sizes{45, 77, true}, {1, 100, true}, {46, 77, false}, {45, 76, false}, {kNoRoots, 100, false}}) {
    SCOPED_TRACE(std::to_string(least) + " to " + std::to_string(most));
    DeviceLimits limits = with_slabs_and_tall_tiles();
    limits.least_root = least;
    limits.most_root = most;
    const DevicePlan lists = make_device_plan(plan, limits);
    std::vector<std::pair<Offset, Vertex>> roots, expected;
    for (const RootTask& root : lists.roots) {
      roots.emplace_back(root.at, root.pivots);
      EXPECT_EQ(root.ld, plan.lower_ld(root.pivots == 45 ? 1 : 2));
    }
    if (library) expected = {{plan.lower_begin[1], 45}, {plan.lower_begin[2], 77}};
    EXPECT_EQ(roots, expected);
    std::set<std::tuple<Vertex, Vertex, Vertex>> tiles, all;
    for (const Vertex f : {1, 2}) {
      for (Vertex i = 0; library && i < plan.pivots(f); i += limits.tile)
        for (Vertex j = 0; j <= i; j += limits.tile) all.emplace(f, i, j);
    }
    const auto list = [&](const Range& range, bool on_diagonal) {
      for (Offset i = range.begin; i < range.end; ++i) {
        const FrontPart& part = lists.unpivoted[i];
        EXPECT_EQ(part.begin == part.column, on_diagonal);
        EXPECT_TRUE(tiles.emplace(part.front, part.begin, part.column).second);
      }
    };
    list(lists.on_diagonal, true);
    list(lists.below_diagonal, false);
    EXPECT_EQ(tiles, all);
  }
}

TEST(DevicePlan, BordersOfALaunchAndTheNextHavePlacesOfTheirOwn) {
  for (const auto& shapes : {mixed_tree(), chain()}) {
    const StageProblem<double> problem = artificial_problem(shapes, {7});
    const SymbolicPlan& plan = *problem.plan;
    for (const Vertex many_tiny : {1, std::numeric_limits<Vertex>::max()}) {
      DeviceLimits limits{128, 160, true};
      limits.many_tiny = many_tiny;
      const DevicePlan lists = make_device_plan(plan, limits);
      Offset left = 0, most = 0;
      for (std::size_t i = 0; i < lists.forward.size(); ++i) {
        const Range& own = lists.forward[i].border;
        left += own.count();
        most = std::max(most, own.end);
        if (i > 0) {
          const Range& before = lists.forward[i - 1].border;
          EXPECT_TRUE(own.end <= before.begin || before.end <= own.begin);
        }
        std::set<Offset> places;
        for (const Vertex f : fronts_of(lists, lists.forward[i])) {
          for (Offset k = plan.border_begin[f]; k < plan.border_begin[f + 1]; ++k)
            places.insert(lists.destination[k]);
        }
        ASSERT_EQ(static_cast<Offset>(places.size()), own.count());
        EXPECT_TRUE(places.empty() || (*places.begin() == own.begin && *places.rbegin() == own.end - 1));
      }
      EXPECT_EQ(left, static_cast<Offset>(plan.border.size()));
      EXPECT_EQ(lists.border_places, most);
    }
  }
}

// Depths follow each other in one launch, but those whose tiny fronts warps solve with.
TEST(DevicePlan, SolvesDepthsWithoutTinyFrontsInOneLaunch) {
  const StageProblem<double> problem = artificial_problem(mixed_tree(), {8});
  DeviceLimits limits{128, 160, true};
  limits.many_tiny = std::numeric_limits<Vertex>::max();
  const DevicePlan merged = make_device_plan(*problem.plan, limits);
  EXPECT_EQ(merged.forward.size(), 1u);
  EXPECT_EQ(merged.backward.size(), 1u);
  limits.many_tiny = 1;
  const DevicePlan parted = make_device_plan(*problem.plan, limits);
  for (const auto* launches : {&parted.forward, &parted.backward}) {
    bool before = true;
    for (const SolveLaunch& launch : *launches) {
      const bool tiny = launch.tiny.count() > 0;
      EXPECT_TRUE(tiny || before) << "two launches that could be one";
      before = tiny;
    }
  }
  EXPECT_GT(parted.forward.size(), 1u);
}

TEST(DevicePlan, InvertsTilesOfMoreThanOneBlock) {
  const StageProblem<double> problem = artificial_problem(mixed_tree(), {7});
  const SymbolicPlan& plan = *problem.plan;
  std::set<std::pair<Vertex, Vertex>> expected, listed;
  for (Vertex f = 0; f < plan.num_fronts; ++f) {
    for (Vertex k = 0; k < plan.pivots(f); k += 64) {
      if (plan.pivots(f) - k > 32) expected.insert({f, k});
    }
  }
  ASSERT_FALSE(expected.empty());
  for (const FrontPart& tile : make_device_plan(plan, {128, 160, true}).wide_tiles) {
    EXPECT_EQ(tile.begin, tile.column);
    EXPECT_TRUE(listed.insert({tile.front, tile.begin}).second) << "twice";
  }
  EXPECT_EQ(listed, expected);
}

}  // namespace
}  // namespace mfs::test
