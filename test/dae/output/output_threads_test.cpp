// The threads that write: order, what a failure does, how much may wait.
#include <atomic>
#include <chrono>
#include <future>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gmock/gmock.h>

#include "dae/output/output_threads.hpp"

namespace {

using mfs::dae::OutputThreads;
using testing::ElementsAre;

TEST(OutputThreads, DoesJobsInTheirOrderBesideTheCaller) {
  std::vector<int> done;
  std::promise<void> go;
  OutputThreads threads(100, 3);
  threads.give(1, [&] { go.get_future().wait(); });  // the caller goes on while it waits
  for (int i = 0; i < 50; ++i) threads.give(1, [&done, i] { done.push_back(i); });
  EXPECT_TRUE(done.empty());
  go.set_value();
  threads.wait();
  ASSERT_EQ(done.size(), 50U);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
}

TEST(OutputThreads, ThrowsWhatAJobThrewAndLeavesTheRest) {
  OutputThreads threads(100, 3);
  bool later = false;
  std::promise<void> go;
  threads.give(1, [&] { go.get_future().wait(); });
  threads.give(1, [] { throw std::runtime_error("disk full"); });
  threads.give(1, [&] { later = true; });
  go.set_value();
  EXPECT_THROW(threads.wait(), std::runtime_error);
  EXPECT_THROW(threads.give(1, [&] { later = true; }), std::runtime_error);
  EXPECT_THROW(threads.wait(), std::runtime_error);
  EXPECT_FALSE(later);
}

// A job of any size is taken alone; together they stay within the bound.
TEST(OutputThreads, KeepsWithinItsMemory) {
  std::atomic<int> waiting{0}, most{0};
  {
    OutputThreads threads(10, 3);
    for (const int bytes : {25, 4, 4, 4, 30, 1}) {
      const int size = bytes;
      threads.give(static_cast<std::size_t>(size), [&waiting, size] { waiting -= size; });
      // What was given and is not done; more than that can not wait.
      const int now = waiting += size;
      if (size < 10) most = std::max(most.load(), now);
    }
  }
  EXPECT_EQ(waiting, 0);
  EXPECT_LE(most, 10);
}

TEST(OutputThreads, DoesWhatIsLeftWhenItEnds) {
  std::vector<int> done;
  {
    OutputThreads threads(100, 3);
    for (int i = 0; i < 3; ++i) threads.give(1, [&done, i] { done.push_back(i); });
  }
  EXPECT_THAT(done, ElementsAre(0, 1, 2));
}

TEST(OutputThreads, DoSecondPartsBesideEachOtherAndTheNextJobs) {
  std::atomic<int> met{0};
  std::vector<int> order;
  OutputThreads threads(100, 3);
  // Each second part waits for the other and for a later job: one after another, they would wait for ever.
  const auto meet = [&] {
    ++met;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (met < 3 && std::chrono::steady_clock::now() < end) std::this_thread::yield();
    if (met < 3) throw std::runtime_error("alone");
  };
  threads.give(
      1, [&] { order.push_back(0); }, meet);
  threads.give(
      1, [&] { order.push_back(1); }, meet);
  threads.give(1, [&] {
    order.push_back(2);
    ++met;
  });
  threads.wait();
  EXPECT_THAT(order, ElementsAre(0, 1, 2));
}

TEST(OutputThreads, CountWhatSecondPartsHoldAndThrowWhatTheyThrow) {
  std::promise<void> go;
  std::shared_future<void> gone = go.get_future().share();
  std::atomic<bool> taken{false};
  OutputThreads threads(10, 2);
  threads.give(
      8, [] {},
      [gone] {
        gone.wait();
        throw std::runtime_error("disk full");
      });
  std::thread other([&] {
    EXPECT_THROW(threads.give(8, [] {}), std::runtime_error);  // no room until it has failed
    taken = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_FALSE(taken);
  go.set_value();
  other.join();
  EXPECT_THROW(threads.wait(), std::runtime_error);
}

}  // namespace
