// The thread that writes: order, what a failure does, how much may wait.
#include <atomic>
#include <future>
#include <stdexcept>

#include <gmock/gmock.h>

#include "dae/output/output_thread.hpp"

namespace {

using mfs::dae::OutputThread;
using testing::ElementsAre;

TEST(OutputThread, DoesJobsInTheirOrderBesideTheCaller) {
  std::vector<int> done;
  std::promise<void> go;
  OutputThread thread(100);
  thread.give(1, [&] { go.get_future().wait(); });  // the caller goes on while it waits
  for (int i = 0; i < 50; ++i) thread.give(1, [&done, i] { done.push_back(i); });
  EXPECT_TRUE(done.empty());
  go.set_value();
  thread.wait();
  ASSERT_EQ(done.size(), 50U);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
}

TEST(OutputThread, ThrowsWhatAJobThrewAndLeavesTheRest) {
  OutputThread thread(100);
  bool later = false;
  std::promise<void> go;
  thread.give(1, [&] { go.get_future().wait(); });
  thread.give(1, [] { throw std::runtime_error("disk full"); });
  thread.give(1, [&] { later = true; });
  go.set_value();
  EXPECT_THROW(thread.wait(), std::runtime_error);
  EXPECT_THROW(thread.give(1, [&] { later = true; }), std::runtime_error);
  EXPECT_THROW(thread.wait(), std::runtime_error);
  EXPECT_FALSE(later);
}

// A job of any size is taken alone; together they stay within the bound.
TEST(OutputThread, KeepsWithinItsMemory) {
  std::atomic<int> waiting{0}, most{0};
  {
    OutputThread thread(10);
    for (const int bytes : {25, 4, 4, 4, 30, 1}) {
      const int size = bytes;
      thread.give(static_cast<std::size_t>(size), [&waiting, size] { waiting -= size; });
      // What was given and is not done; more than that can not wait.
      const int now = waiting += size;
      if (size < 10) most = std::max(most.load(), now);
    }
  }
  EXPECT_EQ(waiting, 0);
  EXPECT_LE(most, 10);
}

TEST(OutputThread, DoesWhatIsLeftWhenItEnds) {
  std::vector<int> done;
  {
    OutputThread thread(100);
    for (int i = 0; i < 3; ++i) thread.give(1, [&done, i] { done.push_back(i); });
  }
  EXPECT_THAT(done, ElementsAre(0, 1, 2));
}

}  // namespace
