// The execution of scalar programs in spaces of Kokkos: as test/stages/lanes_test.cpp has it for the host,
// and what is different there: arrays in another memory, more systems than there is room for.
#include <gmock/gmock.h>

#include "kernels/lanes/space_lanes_def.hpp"
#include "test/stages/in_engine.hpp"
#include "test/stages/lane_problems.hpp"
#ifdef MFS_CUDA
#include "kernels/cuda/cuda_factors.hpp"
#endif

namespace mfs::test {
namespace {

using lanes::LaneOutcome;

template <class Exec_, class Scalar_>
struct InSpace {
  using Exec = Exec_;
  using Scalar = Scalar_;
};
using Spaces =
    testing::Types<InSpace<Kokkos::Serial, double>, InSpace<Kokkos::OpenMP, double>,
                   InSpace<Kokkos::Serial, std::complex<double>>, InSpace<Kokkos::OpenMP, float>,
                   InSpace<Kokkos::OpenMP, std::complex<float>>
#ifdef MFS_CUDA
                   ,
                   InSpace<Kokkos::Cuda, double>, InSpace<Kokkos::Cuda, float>,
                   InSpace<Kokkos::Cuda, std::complex<double>>, InSpace<Kokkos::Cuda, std::complex<float>>
#endif
                   >;

template <class In>
class SpaceLanesOf : public testing::Test {
 protected:
  using Scalar = typename In::Scalar;
  using Made = lanes::SpaceLanesIn<typename In::Exec, Scalar>;

  void SetUp() override {
#ifdef MFS_CUDA
    if (!kOnHost<typename In::Exec> && !cuda::device_found()) GTEST_SKIP() << "no device";
#endif
  }
  // Twice with the same memory, which gives the same.
  static std::vector<LaneOutcome> solve(LaneProblem<Scalar>& problem, int count, Offset most_bytes = 1 << 30,
                                        int threads = 0) {
    std::vector<LaneOutcome> outcome(static_cast<std::size_t>(count));
    in_engine(2, [&] {
      Space<typename In::Exec>::start();
      const LevelSchedule levels = make_level_schedule(problem.program.program);
      Made space(problem.program, levels, problem.rules, problem.nrhs, count, most_bytes, threads);
      EXPECT_EQ(space.capacity() < count, most_bytes < 1 << 30);
      space.solve(problem.systems(0, count), false, nullptr, outcome.data());
      const auto first = problem.x;
      space.solve(problem.systems(0, count), false, nullptr, outcome.data());
      EXPECT_TRUE(same_bits(first, problem.x));
    });
    return outcome;
  }
  // Of the memory of one system and one team, a little more.
  static Offset bytes_for_few(const LaneProblem<Scalar>& problem) {
    Offset bytes = 0;
    in_engine(2, [&] {
      Space<typename In::Exec>::start();
      const LevelSchedule levels = make_level_schedule(problem.program.program);
      Made space(problem.program, levels, problem.rules, problem.nrhs, 1, 1 << 30);
      // A device takes values and vectors of a system as well.
      const Offset staged = kOnHost<typename In::Exec> ? 0
                                                       : problem.program.pattern->num_entries +
                                                             2 * problem.program.program.n * problem.nrhs;
      bytes = space.bytes() + staged * static_cast<Offset>(sizeof(Scalar)) + (1 << 10);
    });
    return bytes;
  }
};
TYPED_TEST_SUITE(SpaceLanesOf, Spaces);

TYPED_TEST(SpaceLanesOf, SystemsAreSolvedWhateverTheirNumber) {
  using Scalar = typename TypeParam::Scalar;
  for (const Vertex n : {1, 2, 31, 32, 33, 65}) {
    for (const int count : {1, 31, 32, 33, 70}) {
      const SparseMatrix pattern = n < 3 ? tridiagonal(n) : random_diagonally_dominant(n, 3, n);
      LaneProblem<Scalar> problem(pattern, count, 2, count % 3);
      const auto outcome = this->solve(problem, count);
      for (int k = 0; k < count; ++k) {
        ASSERT_TRUE(outcome[k].solved);
        EXPECT_LE(problem.error_of(k), problem.rules.tolerance * 1.01);
        EXPECT_NEAR(outcome[k].backward_error, problem.error_of(k), 0.1 * problem.rules.tolerance);
        EXPECT_TRUE(problem.near_reference(k)) << n << " unknowns, system " << k << " of " << count;
      }
      EXPECT_TRUE(problem.gaps_are_untouched());
    }
  }
}

TYPED_TEST(SpaceLanesOf, PartsGiveWhatAllAtOnceDo) {
  using Scalar = typename TypeParam::Scalar;
  LaneProblem<Scalar> whole(grid_2d(7, 9), 150, 2, 1), parts(grid_2d(7, 9), 150, 2, 1);
  this->solve(whole, 150);
  this->solve(parts, 150, this->bytes_for_few(parts));
  EXPECT_TRUE(same_bits(whole.x, parts.x));
}

// Whoever has a task, and whichever team has the system.
TYPED_TEST(SpaceLanesOf, ThreadsOfATeamGiveWhatOneDoes) {
  using Scalar = typename TypeParam::Scalar;
  const int most = std::is_same_v<typename TypeParam::Exec, Kokkos::Serial> ? 1
                   : kOnHost<typename TypeParam::Exec>                      ? 2
                                                                            : lanes::kMostTeamThreads;
  LaneProblem<Scalar> alone(grid_2d(7, 9), 5, 2, 1);
  for (const LaneOutcome& lane : this->solve(alone, 5, 1 << 30, 1)) EXPECT_TRUE(lane.solved);
  for (int threads = 2; threads <= most; threads *= 2) {
    LaneProblem<Scalar> together(grid_2d(7, 9), 5, 2, 1);
    this->solve(together, 5, 1 << 30, threads);
    EXPECT_TRUE(same_bits(alone.x, together.x)) << threads;
  }
}

TYPED_TEST(SpaceLanesOf, ALaneThatFailsSpoilsNoOther) {
  using Scalar = typename TypeParam::Scalar;
  LaneProblem<Scalar> good(grid_2d(7, 9), 40, 1, 1), spoilt(grid_2d(7, 9), 40, 1, 1);
  const auto well = this->solve(good, 40);
  spoil(spoilt);
  const auto outcome = this->solve(spoilt, 40);
  for (int k = 0; k < 40; ++k) {
    SCOPED_TRACE(k);
    EXPECT_TRUE(well[k].solved);
    if (k == 3) {  // a small pivot may do
      EXPECT_TRUE(!outcome[k].solved || spoilt.error_of(k) <= spoilt.rules.tolerance * 1.01);
      continue;
    }
    EXPECT_EQ(outcome[k].solved, k == 0 || k > 6);
    EXPECT_EQ(spoilt.untouched(k), !outcome[k].solved);
    EXPECT_TRUE(!outcome[k].solved || spoilt.same_solution(k, good));
  }
}

TYPED_TEST(SpaceLanesOf, OnlyLanesThatNeedItAreRefined) {
  using Scalar = typename TypeParam::Scalar;
  const double epsilon = LaneProblem<Scalar>::kEpsilon;
  LaneProblem<Scalar> good(grid_2d(7, 9), 40, 2, 1), weak(grid_2d(7, 9), 40, 2, 1);
  for (LaneProblem<Scalar>* problem : {&good, &weak}) problem->rules.tolerance = 8 * epsilon;
  weak.first_pivot(3) = static_cast<Scalar>(2 * std::sqrt(epsilon) * weak.largest(3));
  weak.put_values();
  this->solve(good, 40);
  const auto outcome = this->solve(weak, 40);
  for (int k = 0; k < 40; ++k) {
    EXPECT_TRUE(outcome[k].solved);
    EXPECT_EQ(outcome[k].steps > 0, k == 3);
    EXPECT_LE(weak.error_of(k), weak.rules.tolerance * 1.1);
    EXPECT_TRUE(k == 3 || weak.same_solution(k, good));
  }
}

// The last unknown has to do with all others: its pivot takes all their products at once.
TYPED_TEST(SpaceLanesOf, AnEntryMayTakeManyProducts) {
  using Scalar = typename TypeParam::Scalar;
  for (const Vertex n : {5, 6, 9, 10, 14, 300}) {
    std::vector<Entry> entries;
    std::vector<Vertex> order;
    for (Vertex i = 0; i < n; ++i) {
      order.push_back(i);
      entries.push_back({i, i, 3.0 + 0.01 * i});
      if (i + 1 < n) entries.insert(entries.end(), {{i, n - 1, 1.0}, {n - 1, i, 0.1}});
    }
    const SparseMatrix pattern = from_entries(n, entries);
    LaneProblem<Scalar> problem(pattern, 3);
    problem.program.program =
        make_scalar_program(*problem.program.pattern, order, order, {1 << 24, 1 << 12}).value();
    for (const LaneOutcome& lane : this->solve(problem, 3)) EXPECT_TRUE(lane.solved && lane.steps == 0);
    for (int k = 0; k < 3; ++k) EXPECT_LE(problem.error_of(k), problem.rules.tolerance * 1.01);
  }
}

// A pivot that divides nothing may be noise all the same.
TYPED_TEST(SpaceLanesOf, ATinyPivotAloneIsNoise) {
  using Scalar = typename TypeParam::Scalar;
  LaneProblem<Scalar> problem(from_entries(3, {{0, 0, 1}, {1, 1, 1}, {2, 2, 1}}), 2);
  problem.first_pivot(1) = static_cast<Scalar>(0.5 * problem.rules.pivots.tiny * problem.largest(1));
  problem.put_values();
  const auto outcome = this->solve(problem, 2);
  EXPECT_TRUE(outcome[0].solved);
  EXPECT_FALSE(outcome[1].solved);
}

TYPED_TEST(SpaceLanesOf, EntriesMayRepeatAndRowsMayBeLong) {
  using Scalar = typename TypeParam::Scalar;
  LaneProblem<Scalar> problem(long_rows(), 35, 1, 0);
  for (const LaneOutcome& lane : this->solve(problem, 35)) EXPECT_TRUE(lane.solved);
  for (int k = 0; k < 35; ++k) EXPECT_LE(problem.error_of(k), problem.rules.tolerance * 1.01);
}

}  // namespace
}  // namespace mfs::test
