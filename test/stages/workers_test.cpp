// The workers of the host (kernels/runtime/workers.hpp), on threads of the test's own: everything is done
// exactly once, lists one after another, tiles before the step after them, by any number of threads, of which
// some may be late or never come.
#include <chrono>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "kernels/runtime/workers.hpp"
#include "test/stages/in_engine.hpp"

namespace mfs::test {
namespace {

constexpr int kLists = 7;

WorkList size_of(std::size_t list) {
  return {static_cast<Vertex>(list % 4), static_cast<Vertex>(3 * list % 10)};  // some with nothing at all
}

// Plain numbers, not atomics: that a thread sees what others wrote before is part of what is tested.
class Ledger {
 public:
  explicit Ledger(int threads) : workers_(threads, kLists) {
    for (std::size_t k = 0; k < kLists; ++k)
      items_.emplace_back(static_cast<std::size_t>(size_of(k).shared + size_of(k).single), 0);
  }
  Workers& workers() { return workers_; }

  /// Each item reads all items of the list before; each step of a shared one all tiles of the step before.
  void item(const Worker& worker, std::size_t list, Vertex i) {
    int before = 0;
    if (list > 0) {
      for (const int times : items_[list - 1]) before += times;
      if (before != static_cast<int>(items_[list - 1].size()) * runs_) ++wrong_;
    }
    if (i < size_of(list).shared) {
      const Vertex count = 40 + 10 * i;
      std::vector<int> tiles(static_cast<std::size_t>(count), 0);
      for (int step = 1; step <= 5; ++step) {
        worker.for_each_tile(count, [&](Vertex tile) {
          if (++tiles[static_cast<std::size_t>(tile)] != step) ++wrong_;
          if (tile % 16 == 0) std::this_thread::yield();
        });
        for (const int times : tiles) {
          if (times != step) ++wrong_;
        }
      }
    }
    ++items_[list][static_cast<std::size_t>(i)];
  }
  void done(std::size_t list) {
    for (const int times : items_[list]) {
      if (times != runs_) ++wrong_;
    }
    ++done_;
  }

  void begin() {
    ++runs_;
    workers_.begin(kLists, size_of);
  }
  void work(std::size_t me) {
    workers_.work(
        me, kLists, size_of, [this](const Worker& w, std::size_t list, Vertex i) { item(w, list, i); },
        [this](std::size_t list) { done(list); });
  }
  void expect_all_done() const {
    for (const std::vector<int>& list : items_) {
      for (const int times : list) EXPECT_EQ(times, runs_);
    }
    EXPECT_EQ(done_, runs_ * kLists);
    EXPECT_EQ(wrong_.load(), 0);
  }

 private:
  Workers workers_;
  std::vector<std::vector<int>> items_;  // how often each was done
  int runs_ = 0, done_ = 0;
  std::atomic<int> wrong_{0};
};

TEST(Workers, DoEverythingOnceAndInOrder) {
  for (const int threads : {1, 2, 3, 8}) {
    SCOPED_TRACE(threads);
    Ledger ledger(threads);
    for (int run = 0; run < 50; ++run) {
      ledger.begin();
      std::vector<std::thread> others;
      for (int k = 1; k < threads; ++k)
        others.emplace_back([&, k] { ledger.work(static_cast<std::size_t>(k)); });
      ledger.work(0);
      for (std::thread& other : others) other.join();
    }
    ledger.expect_all_done();
  }
}

TEST(Workers, OneAloneFinishesEverything) {
  Ledger ledger(4);
  ledger.begin();
  for (const std::size_t worker : {2, 0, 1, 3}) ledger.work(worker);  // one after another: three find nothing
  ledger.expect_all_done();
}

// A thread that is held up in the middle of a tile.
TEST(Workers, OnlyWhatIsTakenWaitsForAThreadThatIsLate) {
  std::atomic<bool> late{true};
  std::atomic<int> others{0};
  Workers workers(2, 1);
  const auto one_shared = [](std::size_t) { return WorkList{1, 20}; };
  workers.begin(1, one_shared);
  const auto item = [&](const Worker& worker, std::size_t, Vertex i) {
    if (i > 0) {
      ++others;  // the single items, and
    } else {
      worker.for_each_tile(30, [&](Vertex tile) {
        if (tile == 0) {
          while (late) std::this_thread::yield();
        } else {
          ++others;  // all other tiles
        }
      });
    }
  };
  std::thread second([&] { workers.work(1, 1, one_shared, item, [](std::size_t) {}); });
  std::thread first([&] { workers.work(0, 1, one_shared, item, [](std::size_t) {}); });
  while (others < 20 + 29) std::this_thread::yield();
  late = false;
  first.join();
  second.join();
  EXPECT_EQ(others, 20 + 29);
}

template <class Exec>
void check_run_on(int threads) {
  in_engine(threads, [&] {
    Workers workers(threads, kLists);
    std::vector<std::atomic<int>> done(kLists);
    std::atomic<int> items{0}, tiles{0};
    for (int run = 0; run < 20; ++run) {
      workers.run(
          Exec(), "mfs::test", kLists, size_of,
          [&](const Worker& worker, std::size_t, Vertex) {
            worker.for_each_tile(9, [&](Vertex) { ++tiles; });
            ++items;
          },
          [&](std::size_t list) { ++done[list]; });
    }
    int expected = 0;
    for (std::size_t k = 0; k < kLists; ++k) {
      expected += size_of(k).shared + size_of(k).single;
      EXPECT_EQ(done[k], 20);
    }
    EXPECT_EQ(items, 20 * expected);
    EXPECT_EQ(tiles, 20 * 9 * expected);
  });
}

TEST(Workers, RunOnTheSpacesOfKokkos) {
  check_run_on<Kokkos::Serial>(1);
  for (const int threads : {1, 2, 5}) check_run_on<Kokkos::OpenMP>(threads);
}

}  // namespace
}  // namespace mfs::test
