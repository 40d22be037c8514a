// METIS as MFS compiles it: the same result from any thread, the process left alone, and an error instead of
// an abort when memory runs out.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <random>
#include <set>
#include <thread>
#include <vector>

#include "ordering/metis/vertex_separator.h"

namespace {

// Allocations of METIS, counted; the one numbered `failing` and all later ones fail.
thread_local bool counting = false;
thread_local long allocations = 0, failing = -1;
thread_local long live = 0;

bool fails() {
  return counting && failing >= 0 && allocations++ >= failing;
}

}  // namespace

extern "C" {
void* __real_malloc(std::size_t);
void* __real_calloc(std::size_t, std::size_t);
void* __real_realloc(void*, std::size_t);
void __real_free(void*);

void* __wrap_malloc(std::size_t bytes) {
  if (fails()) return nullptr;
  if (counting) ++live;
  return __real_malloc(bytes);
}
void* __wrap_calloc(std::size_t count, std::size_t bytes) {  // gcc makes it of malloc and memset
  if (fails()) return nullptr;
  if (counting) ++live;
  return __real_calloc(count, bytes);
}
void* __wrap_realloc(void* block, std::size_t bytes) {
  if (fails()) return nullptr;
  if (counting && block == nullptr) ++live;
  return __real_realloc(block, bytes);
}
void __wrap_free(void* block) {
  if (counting && block != nullptr) --live;
  __real_free(block);
}
}

namespace {

struct TestGraph {
  std::vector<idx_t> offsets, neighbors;
};

// A random graph with `n` vertices on a ring (so it is connected) and n chords.
TestGraph random_graph(idx_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::set<idx_t>> sets(n);
  const auto connect = [&](idx_t a, idx_t b) {
    if (a == b) return;
    sets[a].insert(b);
    sets[b].insert(a);
  };
  for (idx_t v = 0; v < n; ++v) connect(v, (v + 1) % n);
  for (idx_t k = 0; k < n; ++k) connect(random() % n, random() % n);
  TestGraph graph;
  graph.offsets.push_back(0);
  for (const auto& row : sets) {
    graph.neighbors.insert(graph.neighbors.end(), row.begin(), row.end());
    graph.offsets.push_back(static_cast<idx_t>(graph.neighbors.size()));
  }
  return graph;
}

struct Separation {
  int status = 0;
  std::vector<idx_t> part;
  bool operator==(const Separation& other) const { return status == other.status && part == other.part; }
  idx_t size() const { return static_cast<idx_t>(std::count(part.begin(), part.end(), 2)); }
};

void separate(const TestGraph& graph, Separation& result) {
  const idx_t n = static_cast<idx_t>(graph.offsets.size()) - 1;
  static const std::vector<idx_t> ones(10000, 1);
  result.part.assign(n, -1);
  result.status = mfs_metis_vertex_separator(n, graph.offsets.data(), graph.neighbors.data(), ones.data(), 42,
                                             10, result.part.data());
}

TEST(Metis, threads_give_what_one_thread_gives) {
  constexpr int num_threads = 8, rounds = 5;
  std::vector<TestGraph> graphs;
  std::vector<Separation> alone(num_threads);
  for (int t = 0; t < num_threads; ++t) {
    graphs.push_back(random_graph(1000 + 500 * t, 7 + t));
    separate(graphs[t], alone[t]);
    ASSERT_EQ(alone[t].status, METIS_OK);
    ASSERT_GT(alone[t].size(), 0);
  }
  std::atomic<int> differing{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < num_threads; ++t) {
    threads.emplace_back([&, t] {
      for (int round = 0; round < rounds; ++round) {
        Separation result;
        separate(graphs[t], result);
        if (!(result == alone[t])) ++differing;
      }
    });
  }
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(differing, 0);
}

TEST(Metis, separator_separates) {
  TestGraph graph = random_graph(3000, 3);
  Separation result;
  separate(graph, result);
  ASSERT_EQ(result.status, METIS_OK);
  for (idx_t v = 0; v < 3000; ++v) {
    for (idx_t k = graph.offsets[v]; k < graph.offsets[v + 1]; ++k) {
      EXPECT_NE(result.part[v] + result.part[graph.neighbors[k]], 1) << "edge from part 0 to part 1 at " << v;
    }
  }
  EXPECT_GT(result.size(), 0);
  EXPECT_LT(result.size(), 1500);
}

TEST(Metis, leaves_rand_and_signal_handlers_alone) {
  std::srand(5);
  const int first = std::rand(), second = std::rand();
  const auto handler = [](int) {};
  std::signal(SIGTERM, handler);
  TestGraph graph = random_graph(2000, 1);
  Separation result;
  std::srand(5);
  EXPECT_EQ(std::rand(), first);
  separate(graph, result);
  EXPECT_EQ(std::rand(), second);
  EXPECT_EQ(std::signal(SIGTERM, SIG_DFL), static_cast<void (*)(int)>(handler));
}

TEST(Metis, failing_allocation_gives_an_error_silently_and_leaks_nothing) {
  TestGraph graph = random_graph(600, 11);
  Separation expected;
  separate(graph, expected);

  Separation result;
  result.part.reserve(600);
  long failures = 0;
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  std::vector<long> leaks, wrong_status;
  for (long n = 0;; ++n) {
    allocations = live = 0;
    failing = n;
    counting = true;
    separate(graph, result);
    counting = false;
    if (live != 0) leaks.push_back(n);
    if (result.status == METIS_OK) break;
    if (result.status != METIS_ERROR_MEMORY) wrong_status.push_back(n);
    ++failures;
  }
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_GT(failures, 10);
  EXPECT_THAT(leaks, testing::IsEmpty()) << "allocations that leaked when they failed";
  EXPECT_THAT(wrong_status, testing::IsEmpty());
  EXPECT_EQ(result, expected);
  separate(graph, result);
  EXPECT_EQ(result, expected) << "after the failures";
}

}  // namespace
