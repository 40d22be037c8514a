// What becomes of a front's state from one factorization to the next, and which fronts a repeated one has
// strict.
#include "kernels/stages/strict_fronts.hpp"

#include <gtest/gtest.h>

namespace mfs::test {
namespace {

/// The front over a factorization that finds it, or in which it needs to be strict, or neither.
class FrontState {
 public:
  bool strict() const { return state_ & kStrict; }
  void found() {
    state_ = settled_state(state_ | kBecomesStrict, true);
    EXPECT_TRUE(strict());
  }
  void factored(bool needs) {
    state_ = settled_state(state_ | (needs && strict() ? kNeedsStrict : 0), false);
  }
  void repeated(bool needs) { state_ = settled_state(state_ | (needs && strict() ? kNeedsStrict : 0), true); }

 private:
  int state_ = 0;
};

TEST(StrictFronts, StayStrictAsLongAsTheyNeedTo) {
  FrontState front;
  front.factored(false);
  EXPECT_FALSE(front.strict());
  front.found();
  for (int k = 0; k < 200; ++k) {
    front.factored(true);
    EXPECT_TRUE(front.strict());
  }
  front.factored(false);
  EXPECT_FALSE(front.strict());
}

TEST(StrictFronts, AreReleasedAtOnceTheFirstTimeAndLateAfterThat) {
  FrontState front;
  front.found();
  front.repeated(false);  // what a factorization that is repeated shows is nothing
  EXPECT_TRUE(front.strict());
  front.factored(false);
  EXPECT_FALSE(front.strict());
  front.found();
  for (int round = 0; round < 3; ++round) {
    for (int k = 1; k < kPatience; ++k) {
      front.factored(false);
      EXPECT_TRUE(front.strict());
    }
    if (round < 2) front.factored(true);  // begins anew
  }
  front.factored(false);
  EXPECT_FALSE(front.strict());
  front.found();
  front.factored(false);
  EXPECT_TRUE(front.strict());
}

TEST(StrictFronts, AncestorsOfThoseThatAreFoundAreStrictInTheRepetition) {
  SymbolicPlan plan;
  plan.num_fronts = 6;
  plan.parent = {3, 3, 4, 5, 5, -1};
  std::vector<int> states(6, 0);
  states[1] = kBecomesStrict;
  states[3] = kStrict;
  make_ancestors_strict(plan, states);
  EXPECT_EQ(states, (std::vector<int>{0, kBecomesStrict, 0, kStrict, 0, kStrict}));
}

// What is left out is looked at before a pivot is taken for no more than rounding, and else afterwards.
TEST(StrictFronts, TinyPivotsOfTilesAreTakenAsTheyAre) {
  const PivotRule noise = pivot_rule<double>(1e-8, 2.0),
                  data = pivot_rule<double>({1e-8, TinyPivots::data, 1e-8}, 2.0);
  EXPECT_EQ(rule_of_tiles(noise, false).bound, noise.bound);
  EXPECT_EQ(most_left_out(noise, false), kMostGrowth);
  EXPECT_LT(rule_of_tiles(data, true).bound, 1e-14);
  EXPECT_GT(rule_of_tiles(data, true).bound, data.tiny);
  EXPECT_EQ(most_left_out(data, true), 1 / data.border_part);
}

TEST(StrictFronts, NeedToBeWhereTheTileHasMuchLessOrNothing) {
  const PivotRule rule{1e-8, 1e-8, 1, kBorderThreshold};
  EXPECT_FALSE(needs_strict(99.0, 1.0, rule));
  EXPECT_TRUE(needs_strict(101.0, 1.0, rule));
  EXPECT_TRUE(needs_strict(2e-9, 1e-9, rule));
  EXPECT_TRUE(needs_strict(1.0, std::nan(""), rule));
}

}  // namespace
}  // namespace mfs::test
