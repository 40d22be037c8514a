// Factors that leave memory for a file: the file itself, and factorizations of artificial trees with limits
// drawn at random, which give the numbers of those in memory, bit for bit.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <random>
#include <string>

#include <mfs/error.hpp>

#include "accuracy/factorization.hpp"
#include "accuracy/solve_controls.hpp"
#include "plan/schedule.hpp"
#include "plan/subtrees.hpp"
#include "test/program/temporary_folder.hpp"
#include "test/reference/random.hpp"
#include "test/stages/stage_bench.hpp"

namespace mfs::test {
namespace {

std::vector<char> bytes_of(std::uint64_t seed, Offset count) {
  std::mt19937_64 random(seed);
  std::vector<char> bytes(static_cast<std::size_t>(count));
  for (char& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

/// Of the file that this process has opened last.
int last_descriptor() {
  const int next = dup(0);
  close(next);
  return next - 1;
}

const std::vector<Offset> kExtents{1, 63, 64, 65, 5000, 0, (Offset(4) << 20) + 8, Offset(9) << 20};

TEST(FactorFile, GivesBackWhatWasWritten) {
  const TemporaryFolder folder;
  FactorFile file(folder.path(""), kExtents);
  std::vector<std::vector<char>> written;
  for (int round = 0; round < 2; ++round) {
    written.clear();
    for (std::size_t k = 0; k < kExtents.size(); ++k) {
      written.push_back(bytes_of(10 * round + k, kExtents[k]));
      file.write(k, written.back().data());
    }
    for (std::size_t k = kExtents.size(); k-- > 0;) {
      std::vector<char> read(written[k].size() + 1, 'x');
      file.read(k, read.data());
      EXPECT_EQ(read.back(), 'x');
      read.pop_back();
      EXPECT_EQ(read, written[k]) << "extent " << k;
    }
  }
}

// Any bit, words that change places, and two top bits of one lane, which sums of products would not see.
TEST(FactorFile, SeesEveryChange) {
  const TemporaryFolder folder;
  constexpr Offset kBytes = 203;
  FactorFile file(folder.path(""), {kBytes});
  const int descriptor = last_descriptor();
  const std::vector<char> right = bytes_of(5, kBytes);
  const auto expect_seen = [&](std::vector<char> wrong) {
    file.write(0, right.data());
    ASSERT_EQ(pwrite(descriptor, wrong.data(), wrong.size(), 0), kBytes);
    try {
      file.read(0, wrong.data());
      ADD_FAILURE() << "not seen";
    } catch (const BackendError& error) {
      EXPECT_EQ(error.code(), EBADMSG);
      EXPECT_NE(std::string(error.what()).find("a block 0 of 203 bytes at 0 that is not what was written"),
                std::string::npos)
          << error.what();
    }
  };
  for (Offset at = 0; at < kBytes; ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      std::vector<char> wrong = right;
      wrong[at] = static_cast<char>(wrong[at] ^ (1 << bit));
      expect_seen(wrong);
    }
  }
  for (const Offset other : {8, 64, 72, 128}) {
    std::vector<char> wrong = right;
    std::swap_ranges(wrong.begin(), wrong.begin() + 8, wrong.begin() + other);
    expect_seen(wrong);
  }
  std::vector<char> wrong = right;
  for (const Offset at : {7, 71}) wrong[at] = static_cast<char>(wrong[at] ^ 0x80);
  expect_seen(wrong);
}

std::vector<StageProblem<double>> problems() {
  return {artificial_problem(mixed_tree(), {21, 0.6, 64}),
          artificial_problem(leaf_and_root(330, 200), {22, 1.0, 128}), artificial_problem(broom(), {23}),
          artificial_problem(chain(), {24})};
}

struct Numbers {
  std::vector<double> solutions;
  std::vector<std::complex<double>> pivots;
  FactorStatus status;
  bool operator==(const Numbers& other) const {
    return solutions == other.solutions && pivots == other.pivots &&
           status.perturbed == other.status.perturbed;
  }
};

/// Factored twice, solved with one and with five columns.
Numbers numbers_of(const StageProblem<double>& problem, HostSpace space, int threads,
                   const OutOfCore* outside) {
  Numbers numbers{};
  const Vertex n = problem.plan->n;
  in_engine(threads, [&] {
    const auto factors =
        make_host_factors<double>(space, false, problem.plan, problem.pattern, threads, outside);
    fill(problem, *factors);
    for (int round = 0; round < 2; ++round) {
      numbers.status = factors->factor(1e-8, {}).status;
      for (const Vertex columns : {1, 5}) {
        factors->make_room(columns);
        for (const bool transposed : {false, true}) {
          std::vector<double> x = Random(5).vector(n * columns);
          factors->apply_inverse(x.data(), x.data(), columns, transposed);
          numbers.solutions.insert(numbers.solutions.end(), x.begin(), x.end());
        }
      }
      numbers.pivots.resize(static_cast<std::size_t>(n));
      factors->diagonal_pivots(numbers.pivots.data());
    }
  });
  return numbers;
}

OutOfCore plan_within(const SymbolicPlan& plan, const std::string& folder, Offset available) {
  return plan_out_of_core(
      plan, sizeof(double), sizeof(double), [](Vertex columns) { return Offset{100} * columns; }, folder,
      available);
}

TEST(OutOfCore, NumbersAreThoseOfFactorsInMemoryForAnyLimit) {
  const TemporaryFolder folder;
  const std::uint64_t seed = std::random_device()();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  int partial = 0;
  for (const StageProblem<double>& problem : problems()) {
    const SymbolicPlan& plan = *problem.plan;
    const Offset enough = host_bytes(plan, sizeof(double), sizeof(double), 1).total() + 5000;
    Offset least = 0;
    try {
      plan_within(plan, folder.path(""), 1);
      ADD_FAILURE() << "no bytes do";
    } catch (const OutOfMemory& error) {
      least = static_cast<Offset>(error.needed());
    }
    for (const int threads : {1, 2, 3}) {
      const HostSpace space = threads == 1 ? HostSpace::serial : HostSpace::openmp;
      const Numbers expected = numbers_of(problem, space, threads, nullptr);
      for (int k = 0; k < 4; ++k) {
        const auto more =
            static_cast<Offset>(random() % static_cast<std::uint64_t>(std::max<Offset>(enough - least, 1)));
        const Offset limit = k == 0 ? least : least + more;
        SCOPED_TRACE(std::to_string(limit) + " of " + std::to_string(enough) + " bytes, " +
                     std::to_string(threads) + " threads");
        const OutOfCore outside = plan_within(plan, folder.path(""), limit);
        EXPECT_LE(outside.bytes.total(), limit);
        partial += outside.segments.host_entries > 0;
        EXPECT_TRUE(numbers_of(problem, space, threads, &outside) == expected);
      }
    }
  }
  EXPECT_GT(partial, 12);
}

// What is computed of a front depends on whether it is shared, and by how many.
TEST(OutOfCore, SchedulesShareTheSameFronts) {
  const StageProblem<double> problem = artificial_problem(mixed_tree(), {21, 0.6, 64});
  const SymbolicPlan& plan = *problem.plan;
  const SegmentPlan segments = make_segments(plan, least_region(plan, 0, plan.max_front, Outside::file), 0,
                                             plan.max_front, Outside::file);
  for (const Vertex alone : {0, 1, 2}) {
    const Schedule by_depth = make_schedule(plan, 2),
                   schedule = make_schedule(plan, segments, by_depth, alone, 2);
    std::vector<int> expected(static_cast<std::size_t>(plan.num_fronts), 0), shares = expected,
                                                                             seen = expected;
    for (std::size_t step = static_cast<std::size_t>(alone); step < by_depth.size(); ++step) {
      for (std::size_t i = 0; i < by_depth[step].large.size(); ++i)
        expected[by_depth[step].large[i]] = by_depth[step].share[i];
    }
    ASSERT_EQ(schedule.size(), segments.segments.size());
    for (std::size_t t = 0; t < schedule.size(); ++t) {
      const DepthSchedule& own = schedule[t];
      for (std::size_t i = 0; i < own.large.size(); ++i) shares[own.large[i]] = own.share[i];
      for (const auto* fronts : {&own.large, &own.small}) {
        for (const Vertex f : *fronts) {
          ++seen[f];
          EXPECT_EQ(segments.segment[f], static_cast<Vertex>(t));
        }
      }
      EXPECT_EQ(own.group_begin.back(), static_cast<Vertex>(own.small.size()));
    }
    EXPECT_EQ(shares, expected);
    EXPECT_EQ(seen, std::vector<int>(seen.size(), 1));
  }
}

}  // namespace
}  // namespace mfs::test
