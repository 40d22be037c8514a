// The engine: calls of several threads have teams of their own as long as there are processors for them.
#include <chrono>
#include <condition_variable>
#include <ctime>
#include <future>
#include <mutex>
#include <set>
#include <system_error>
#include <thread>

#include <gtest/gtest.h>
#include <omp.h>

#include "kernels/runtime/dispatch.hpp"
#include "kernels/runtime/engine.hpp"
#include "test/failure/refused_threads.hpp"

namespace mfs::test {
namespace {

/// wait() returns true when `count` threads are in it, false if they do not come.
class Meeting {
 public:
  explicit Meeting(int count) : count_(count) {}
  bool wait() {
    std::unique_lock<std::mutex> lock(mutex_);
    ++here_;
    changed_.notify_all();
    return changed_.wait_for(lock, std::chrono::seconds(60), [this] { return here_ >= count_; });
  }

 private:
  const int count_;
  int here_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
};

void run(int threads, const std::function<void()>& work, const std::function<void()>& idle = {}) {
  Engine::instance().run(threads, work, idle, Needs::threads);
}

TEST(Engine, CallsForWhichThereAreProcessorsMeet) {
  if (available_threads() < 2) GTEST_SKIP() << "a processor alone";
  const int half = available_threads() / 2;
  for (int round = 0; round < 3; ++round) {
    Meeting meeting(2);
    std::thread other([&] { run(half, [&] { EXPECT_TRUE(meeting.wait()); }); });
    run(half, [&] { EXPECT_TRUE(meeting.wait()); });
    other.join();
  }
}

TEST(Engine, CallsThatWantMoreWait) {
  const int all = available_threads();
  std::atomic<int> at_work{0};
  std::vector<std::thread> callers;
  for (int t = 0; t < 6; ++t) {
    callers.emplace_back([&, t] {
      for (int k = 0; k < 20; ++k) {
        const int threads = t % 2 ? all : all + 3;
        run(threads, [&] {
          EXPECT_EQ(++at_work, 1);
          EXPECT_EQ(team_threads(), threads);
          std::this_thread::yield();
          --at_work;
        });
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
}

TEST(Engine, ALoopHasTheThreadsOfItsTeam) {
  for (const int threads : {1, 3, 2, 5, 1}) {
    std::vector<int> by(64, -1);
    run(threads,
        [&] { for_each_index(HostThreads(), "test", 64, [&](Offset i) { by[i] = omp_get_thread_num(); }); });
    EXPECT_EQ(std::set<int>(by.begin(), by.end()).size(), static_cast<std::size_t>(threads));
    EXPECT_EQ(team_threads(), 1) << "outside";
  }
}

TEST(Engine, MaximaAndSumsAreThoseOfPlainLoops) {
  for (const Offset count : {1, 2, 63, 64, 65, 1000}) {
    double sum = 0;
    for (Offset i = 0; i < count; ++i) sum += static_cast<double>(i * i);
    const auto check = [&](const auto& exec) {
      double most = 0;
      find_maximum(
          exec, "test", count,
          [&](Offset i, double& larger) { larger = std::max(larger, i == count / 2 ? -1.0 : -2.0); }, &most);
      EXPECT_EQ(most, -1.0);
      EXPECT_EQ(find_sum<double>(exec, "test", count,
                                 [](Offset i, double& part) { part += static_cast<double>(i * i); }),
                sum);
    };
    run(3, [&] { check(HostThreads()); });
    run(1, [&] { check(HostThreads()); });
    check(OneThread());
  }
}

TEST(Engine, WhatWorkThrowsComesOutAndTheTeamGoesOn) {
  for (int k = 0; k < 10; ++k) {
    EXPECT_THROW(run(2, [] { throw 5; }), int);
    EXPECT_THROW(Engine::instance().run_here([] { throw 5; }), int);
    bool done = false;
    run(2, [&] { done = true; });
    EXPECT_TRUE(done);
  }
}

// A callback may use the solver while the work that it tells of goes on.
TEST(Engine, CallsFromAnIdleCallerFindTheirTeam) {
  if (available_threads() < 2) GTEST_SKIP() << "a processor alone";
  std::promise<void> inner_done;
  auto done = inner_done.get_future();
  bool called = false;
  run(
      1, [&] { EXPECT_EQ(done.wait_for(std::chrono::seconds(60)), std::future_status::ready); },
      [&] {
        if (std::exchange(called, true)) return;
        run(1, [] {});
        inner_done.set_value();
      });
  EXPECT_TRUE(called);
}

// Where the system refuses a further team, a call waits for the one that there is.
TEST(Engine, WaitsForATeamWhereTheSystemRefusesOne) {
  if (available_threads() < 2) GTEST_SKIP() << "a processor alone";
  std::vector<std::thread> callers;
  Meeting meeting(available_threads());
  for (int t = 0; t < available_threads(); ++t)  // as many teams as can ever be at work
    callers.emplace_back([&] { run(1, [&] { EXPECT_TRUE(meeting.wait()); }); });
  for (std::thread& caller : callers) caller.join();
  const RefusedThreads none;
  EXPECT_THROW(run(available_threads() + 7, [] {}), std::system_error);
  bool done = false;
  run(1, [&] { done = true; });
  EXPECT_TRUE(done);
}

TEST(Engine, KokkosAndTeamsWorkAtTheSameTime) {
  if (available_threads() < 2) GTEST_SKIP() << "a processor alone";
  Meeting meeting(2);
  std::thread other([&] {
    Engine::instance().run(1, [&] {
      int sum = 0;
      Kokkos::parallel_reduce(
          "test", Kokkos::RangePolicy<Kokkos::OpenMP>(0, 10), [](int i, int& part) { part += i; }, sum);
      EXPECT_EQ(sum, 45);
      EXPECT_TRUE(meeting.wait());
    });
  });
  run(1, [&] { EXPECT_TRUE(meeting.wait()); });
  other.join();
}

}  // namespace
}  // namespace mfs::test
