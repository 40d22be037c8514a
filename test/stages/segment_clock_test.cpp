// What is foreseen of segments: sums that can be told by hand, and that the plan taken is the least of some.
#include "plan/segment_clock.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "plan/segment_order.hpp"
#include "plan/segment_places.hpp"
#include "test/stages/artificial_problem.hpp"

namespace mfs::test {
namespace {

constexpr Vertex kUndivided = std::numeric_limits<Vertex>::max();
constexpr Offset kLittle = 1, kMuch = Offset(1) << 40;  // entries

/// Three fronts, one below the other, each a segment of its own.
class ClockOfThree : public ::testing::Test {
 protected:
  SegmentPlan plan_of(Vertex count) const {
    SegmentPlan made;
    for (Vertex t = 0; t < count; ++t) {
      Segment segment;
      segment.begin = t;
      segment.end = t + 1;
      made.segments.push_back(segment);
      made.order.push_back(t);
      made.segment.push_back(t);
    }
    return made;
  }
  double seconds(const SegmentPlan& segments) const { return clock_.refactor_seconds(segments); }

  const StageProblem<double> problem_ = artificial_problem({{40, 20, 1}, {30, 30, 2}, {50, 0, -1}}, {41});
  const SegmentClock clock_{*problem_.plan, Outside::memory};
  const SegmentPlan none_ = plan_of(3);
};

TEST_F(ClockOfThree, WhatLeavesMeanwhileTakesNothing) {
  SegmentPlan little = none_;
  little.leaving = {{0, -1, 0, kLittle, 0}};
  EXPECT_DOUBLE_EQ(seconds(little), seconds(none_));
  EXPECT_GT(seconds(none_), seconds(plan_of(2)));
}

TEST_F(ClockOfThree, SegmentsThatAreDepthsTakeAsLongAsAllInOnePiece) {
  EXPECT_DOUBLE_EQ(clock_.whole_refactor_seconds(), seconds(none_));
}

TEST_F(ClockOfThree, TheLastCopyEndsIt) {
  SegmentPlan alone = plan_of(1), three = none_;
  alone.leaving = three.leaving = {{0, -1, 0, kMuch, 0}};
  EXPECT_GT(seconds(alone), 2 * seconds(none_));
  EXPECT_DOUBLE_EQ(seconds(three), seconds(alone)) << "kernels run beside the copy";
}

TEST_F(ClockOfThree, CopiesGoOneAfterTheOther) {
  SegmentPlan one = none_, two = none_;
  one.leaving = {{0, -1, 0, 2 * kMuch, 0}};
  two.leaving = {{0, -1, 0, kMuch, 0}, {1, -1, 0, kMuch, 0}};
  EXPECT_NEAR(seconds(two), seconds(one), 1e-3 * seconds(one));
}

TEST_F(ClockOfThree, ASegmentWaitsForWhatIsInItsWay) {
  SegmentPlan alone = plan_of(1), waits = none_;
  alone.leaving = waits.leaving = {{0, -1, 0, kMuch, 0}};
  waits.segments[1].leaves_first = 1;
  const double after_first = seconds(none_) - seconds(plan_of(1));
  EXPECT_NEAR(seconds(waits) - seconds(alone), after_first, 1e-9 * seconds(alone));
  waits.segments[1].leaves_first = 0;
  waits.segments[2].leaves_first = 1;
  const double after_second = seconds(none_) - seconds(plan_of(2));
  EXPECT_NEAR(seconds(waits) - seconds(alone), after_second, 1e-9 * seconds(alone));
}

TEST_F(ClockOfThree, BlocksReadOverTheLinkTakeAsLongAgain) {
  SegmentPlan factors = none_, block = none_;
  factors.leaving = {{0, -1, 0, kMuch, 0}};
  block.leaving = {{0, 2, 0, kMuch, 0}};
  block.segments[2].leaves_first = 1;
  EXPECT_GT(seconds(block), 2 * seconds(factors));
}

TEST_F(ClockOfThree, WhatIsAssembledEarlyIsReadBesideOthers) {
  SegmentPlan in_turn = none_;
  in_turn.leaving = {{0, 2, 0, kLittle, 0}};
  in_turn.segments[2].leaves_first = 1;
  in_turn.segments[2].assembled_after = 2;
  SegmentPlan early = in_turn;
  early.segments[2].assembled_after = 1;
  EXPECT_GT(seconds(in_turn), seconds(none_));
  EXPECT_DOUBLE_EQ(seconds(early), seconds(none_));
  in_turn.leaving.front().entries = early.leaving.front().entries = kMuch;
  EXPECT_DOUBLE_EQ(seconds(early), seconds(in_turn)) << "the copy takes longer than the segment between";
}

TEST_F(ClockOfThree, ASolveBringsBackWhatHasLeft) {
  SegmentPlan some = none_, twice = none_;
  some.host_entries = kMuch;
  twice.host_entries = 2 * kMuch;
  EXPECT_EQ(clock_.solve_seconds(none_), 0);
  EXPECT_DOUBLE_EQ(clock_.solve_seconds(twice), 2 * clock_.solve_seconds(some));
}

// Beside orders and distances of its own choice.
TEST(SegmentClock, IsLeastForThePlanThatIsTaken) {
  const StageProblem<double> problem = artificial_problem(binary_tree(7, 60, 150), {43, 0.05});
  const SymbolicPlan& plan = *problem.plan;
  const SegmentClock clock(plan, Outside::memory);
  for (const double part : {0.45, 0.55, 0.65, 0.8, 0.95}) {
    const auto region = static_cast<Offset>(part * static_cast<double>(plan.storage_entries));
    const double taken = clock.seconds(make_segments(plan, region, 0, kUndivided));
    int fit = 0;
    for (Vertex level = 0; level < 4; ++level) {
      for (const Offset parts : {12, 40}) {
        const SegmentOrder order = order_segments(plan, level, region / parts);
        SegmentPlaces places(plan, order, {plan.num_fronts, 0, 0, 0}, region, kUndivided, Outside::memory);
        for (Vertex stay = places.count(); stay > 0; --stay) {
          if (places.place(stay, {2, 3, 2, 0}, 0) > region) continue;
          ++fit;
          EXPECT_LE(taken, 1.02 * clock.seconds(places.schedule()));
        }
      }
    }
    EXPECT_TRUE(part < 0.6 || fit > 0);
  }
}

}  // namespace
}  // namespace mfs::test
