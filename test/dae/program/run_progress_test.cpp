// What a log and a terminal are told of a run, by a clock that is not asked.
#include "dae/program/run_progress.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace mfs::dae {
namespace {

/// Seconds at which something is told of a run of 1 s that takes `wall` s, in steps of 10 ms of the clock.
std::vector<double> told(RunProgress& progress, double wall) {
  std::vector<double> times;
  for (int i = 1; i <= 100 * wall; ++i)
    if (!progress.after_step(i, i / (100 * wall), 0.01 * i).empty()) times.push_back(0.01 * i);
  return times;
}

TEST(RunProgress, InALogIsToldMoreAndMoreSeldom) {
  RunProgress in_log(1.0, false);
  EXPECT_EQ(told(in_log, 59.9), std::vector<double>());
  RunProgress longer(1.0, false);
  EXPECT_EQ(told(longer, 479.0), (std::vector<double>{60.0, 120.0, 240.0}));
}

TEST(RunProgress, OnATerminalGoesOn) {
  RunProgress on_terminal(1.0, true);
  EXPECT_NEAR(static_cast<double>(told(on_terminal, 10.0).size()), 10.0 / RunProgress::kOnTerminal, 3.0);
}

// sin(1e6 t) for 1 s: by the last steps, which are slower than those before.
TEST(RunProgress, SaysHowLongItTakes) {
  RunProgress progress(1.0, false);
  EXPECT_EQ(progress.after_step(70000, 0.05, 60.0), "step 70000, t = 0.05 of 1 s, 19 min to go");
  EXPECT_EQ(progress.after_step(70001, 0.051, 119.9), "");
  EXPECT_EQ(progress.after_step(100000, 0.07, 120.0), "step 100000, t = 0.07 of 1 s, 46 min to go");
  // An output within that step, and one at which nothing has been done.
  EXPECT_EQ(progress.after_step(100000, 0.06, 240.0), "step 100000, t = 0.06 of 1 s, 63 min to go");
  EXPECT_EQ(progress.after_step(100000, 0.0, 480.0), "step 100000, t = 0 of 1 s");
  RunProgress on_terminal(1.0, true);
  EXPECT_EQ(on_terminal.after_step(70000, 0.05, 60.0), "step 70000, 19 min to go");
  EXPECT_EQ(duration_text(99.4), "99 s");
  EXPECT_EQ(duration_text(100.0), "2 min");
  EXPECT_EQ(duration_text(6000.0), "2 h");
  EXPECT_EQ(duration_text(864000.0), "10 d");
}

}  // namespace
}  // namespace mfs::dae
