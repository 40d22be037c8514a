// Loops over vectors against plain ones, with lengths around those of the blocks.
#include "dae/integrator/vector_loops.hpp"

#include <gtest/gtest.h>

#include "test/reference/random.hpp"

namespace mfs::dae {
namespace {

constexpr std::size_t kLengths[] = {0, 1, 100, 4095, 4096, 4097, 8193, 50000};

TEST(VectorLoops, VisitEveryIndexOnce) {
  for (const std::size_t length : kLengths) {
    std::vector<int> visits(length, 0);
    parallel_for(length, 3, [&](std::size_t i) { ++visits[i]; });
    EXPECT_EQ(visits, std::vector<int>(length, 1));
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
    const auto norm = [&](int threads) {
      return weighted_rms([&](std::size_t i) { return e[i]; }, weights, threads);
    };
    const double expected = length == 0 ? 0.0 : static_cast<double>(std::sqrt(sum / length));
    EXPECT_NEAR(norm(1), expected, 1e-14 * expected) << length;
    EXPECT_EQ(norm(2), norm(1)) << length;
    EXPECT_EQ(norm(3), norm(1)) << length;
  }
}

}  // namespace
}  // namespace mfs::dae
