// Which runs are given up by what their steps come to.
#include "dae/integrator/step_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace mfs::dae {
namespace {

using Verdict = StepWatch::Verdict;

/// After `most` steps at most, of 0.1 rad each by an angle whose time is given; every tenth is tried again
/// `rejections` times.
Verdict judge(double t_end, int most, const std::function<double(double)>& time_of, int rejections = 0) {
  StepWatch watch(time_of(0.0), t_end);
  for (int number = 1; number <= most; ++number) {
    const double t = time_of(0.1 * number);
    if (t >= t_end) break;
    const Verdict verdict = watch.judge(number, t, number % 10 == 0 ? rejections : 0);
    if (verdict != Verdict::go_on) return verdict;
  }
  return Verdict::go_on;
}

TEST(StepWatch, GivesUpWhatBecomesFasterWithoutBound) {
  const auto exponential = [](double angle) { return std::log(1.0 + angle) / 1000; };
  EXPECT_EQ(judge(1.0, 1 << 15, exponential), Verdict::ever_faster);
  const auto tangent = [](double angle) { return std::atan(angle); };
  EXPECT_EQ(judge(2.0, 1 << 15, tangent), Verdict::ever_faster);
  EXPECT_EQ(judge(1.5, 1 << 15, tangent), Verdict::go_on);  // its end is before the pole
}

TEST(StepWatch, GivesUpWhatWouldTakeYears) {
  const auto even = [](double angle) { return angle; };
  EXPECT_EQ(judge(1e20, 1 << 15, even), Verdict::end_too_far);
  EXPECT_EQ(judge(1e20, 1 << 14, even), Verdict::go_on) << "it may come to rest";
  EXPECT_EQ(judge(1e12, 1 << 20, even), Verdict::go_on);
}

// A rotor brought up to 1e6 rad/s in 1000 s, a chirp by t^3, a motion by sin(1e6 t), a start that is slow.
TEST(StepWatch, LetsWhatTakesLongGoOn) {
  constexpr int kMost = 1 << 20;
  EXPECT_EQ(judge(1e3, kMost, [](double angle) { return std::sqrt(angle / 500); }), Verdict::go_on);
  EXPECT_EQ(judge(1e3, kMost, [](double angle) { return std::cbrt(angle); }), Verdict::go_on);
  EXPECT_EQ(judge(100.0, kMost, [](double angle) { return 1e-6 * angle; }), Verdict::go_on);
  const auto with_start = [](double angle) {
    return angle < 700 ? 1e-3 * angle : 0.7 + 1e-8 * (angle - 700);
  };
  EXPECT_EQ(judge(100.0, kMost, with_start), Verdict::go_on);
}

TEST(StepWatch, GivesUpWhatIsTriedAgainAndHardlyMoves) {
  const auto creeps = [](double angle) { return 1e-9 * angle; };
  EXPECT_EQ(judge(10.0, 4000, creeps, 3), Verdict::forces_jump);
  EXPECT_EQ(judge(10.0, 4000, creeps, 2), Verdict::go_on);
  EXPECT_EQ(judge(1e-4, 4000, creeps, 3), Verdict::go_on);
}

}  // namespace
}  // namespace mfs::dae
