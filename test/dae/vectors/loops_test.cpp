// Loops over vectors against plain ones, with lengths around those of the blocks.
#include "dae/vectors/loops.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "test/reference/random.hpp"

namespace mfs::dae {
namespace {

constexpr std::size_t kLengths[] = {0, 1, 100, 4095, 4096, 4097, 8193, 50000};

TEST(VectorLoops, VisitEveryIndexOnce) {
  for (const std::size_t length : kLengths) {
    std::vector<int> visits(length, 0);
    parallel_for(length, 3, [&](std::size_t i) { ++visits[i]; });
    EXPECT_EQ(visits, std::vector<int>(length, 1));
    parallel_for_parts(length, 3, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) ++visits[i];
    });
    EXPECT_EQ(visits, std::vector<int>(length, 2));
  }
}

TEST(VectorLoops, AreSharedWhereTheWorkIsWorthIt) {
  const auto team = [](std::size_t length, std::size_t work) {
    std::vector<int> threads(length);
    parallel_for(
        length, 3, [&](std::size_t i) { threads[i] = omp_get_num_threads(); }, work);
    return threads;
  };
  EXPECT_EQ(team(10000, 0), std::vector<int>(10000, 3));
  EXPECT_EQ(team(100, 0), std::vector<int>(100, 1));
  EXPECT_EQ(team(100, 10000), std::vector<int>(100, 3));
}

TEST(VectorLoops, SharesOfWorkAreVisitedOnceByEachThreadAsMuch) {
  mfs::test::Random random(12);
  for (const int threads : {1, 2, 3, 7})
    for (const std::size_t length : kLengths) {
      std::vector<std::size_t> start{0};
      for (std::size_t i = 0; i < length; ++i) {
        const bool heavy = i > length / 2 && i < length / 2 + 8;  // side by side, as the rows of a frame
        const auto work = static_cast<std::size_t>(random.integer(0, 3));
        start.push_back(start.back() + (heavy ? 3000 : work));
      }
      std::vector<int> visits(length, 0), by(length, 0);
      parallel_for_shares(start, threads, [&](std::size_t i) {
        ++visits[i];
        by[i] = omp_get_thread_num();
      });
      EXPECT_EQ(visits, std::vector<int>(length, 1));
      if (length < 100) continue;
      std::vector<std::size_t> work(static_cast<std::size_t>(threads));
      for (std::size_t i = 0; i < length; ++i)
        work[static_cast<std::size_t>(by[i])] += start[i + 1] - start[i];
      const std::size_t fair = start.back() / static_cast<std::size_t>(threads);
      for (const std::size_t of_thread : work) EXPECT_LE(of_thread, fair + 3001);
    }
}

TEST(VectorLoops, FoldEveryValueOnce) {
  for (const std::size_t length : kLengths) {
    const auto number = [](std::size_t i) { return static_cast<double>(i + 1); };
    EXPECT_EQ(parallel_fold(length, 3, 0.0, number, std::plus<>()), 0.5 * length * (length + 1.0));
    for (const std::size_t place : {std::size_t{0}, length / 2, length - 1}) {
      const auto peak = [&](std::size_t i) { return i == place ? 7.0 : 1.0; };
      const auto larger = [](double a, double b) { return std::max(a, b); };
      if (length > 0) {
        EXPECT_EQ(parallel_fold(length, 3, 0.0, peak, larger), 7.0);
      }
    }
  }
}

struct TwoErrors {
  const double* e;
  MFS_HOST_DEVICE Numbers<2> operator()(std::size_t i) const { return {{2.0 * e[i], e[i]}}; }
};

TEST(VectorLoops, TheErrorNormDoesNotDependOnTheNumberOfThreads) {
  mfs::test::Random random(11);
  for (const std::size_t length : kLengths) {
    const std::vector<double> e = random.vector(static_cast<int>(length));
    std::vector<double> weights(length);
    long double sum = 0.0;
    for (std::size_t i = 0; i < length; ++i) {
      weights[i] = 0.5 + 0.25 * static_cast<double>(i % 7);
      sum += static_cast<long double>(e[i] / weights[i]) * (e[i] / weights[i]);
    }
    const auto norms = [&](int threads) {
      const Executor host(Executor::Place::host, threads);
      return weighted_rms<2>(host, TwoErrors{e.data()}, make_array(host, weights));
    };
    const double expected = length == 0 ? 0.0 : static_cast<double>(std::sqrt(sum / length));
    const Numbers<2> one = norms(1);
    EXPECT_NEAR(one.of[1], expected, 1e-14 * expected) << length;
    EXPECT_EQ(one.of[0], 2.0 * one.of[1]) << length;
    for (const int threads : {2, 3}) {
      EXPECT_EQ(norms(threads).of[0], one.of[0]) << length;
      EXPECT_EQ(norms(threads).of[1], one.of[1]) << length;
    }
  }
}

TEST(Executor, CopiesBetweenItsMemoryAndTheHosts) {
  const Executor host(Executor::Place::host, 2);
  EXPECT_FALSE(host.on_device());
  const std::vector<int> values{3, 1, 4, 1, 5};
  Array<int> array = make_array(host, values);
  EXPECT_EQ(array.on_host(host), values);
  const int* const before = array.data();
  array.resize(host, 5);
  EXPECT_EQ(array.data(), before);
  array.resize(host, 7);
  EXPECT_EQ(array.size(), 7u);
  array.resize(host, 0);
  EXPECT_TRUE(array.on_host(host).empty());
}

}  // namespace
}  // namespace mfs::dae
