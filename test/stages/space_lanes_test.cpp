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

template <class Exec_, class Scalar_, int kLanes_ = lanes::kSpaceLanes<Exec_>>
struct InSpace {
  using Exec = Exec_;
  using Scalar = Scalar_;
  static constexpr int kLanes = kLanes_;
};
// Groups of 32 lanes are those of devices.
using Spaces =
    testing::Types<InSpace<Kokkos::Serial, double>, InSpace<Kokkos::Serial, double, 32>,
                   InSpace<Kokkos::OpenMP, double>, InSpace<Kokkos::Serial, std::complex<double>, 32>,
                   InSpace<Kokkos::Serial, float, 32>, InSpace<Kokkos::OpenMP, std::complex<float>, 4>
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
  using Made = lanes::SpaceLanesIn<typename In::Exec, Scalar, In::kLanes>;

  void SetUp() override {
#ifdef MFS_CUDA
    if (!kOnHost<typename In::Exec> && !cuda::device_found()) GTEST_SKIP() << "no device";
#endif
  }
  // Room for two groups at most, as what surrounds their arrays is in it, too.
  static Offset bytes_for_few(const LaneProblem<Scalar>& problem) {
    Offset bytes = 0;
    in_engine(2, [&] {
      Space<typename In::Exec>::start();
      bytes = 2 * Made(problem.program, problem.rules, problem.nrhs, 1, 1 << 30).bytes();
    });
    return bytes;
  }
  // Twice with the same memory, which gives the same.
  static std::vector<LaneOutcome> solve(LaneProblem<Scalar>& problem, int count,
                                        Offset most_bytes = 1 << 30) {
    std::vector<LaneOutcome> outcome(static_cast<std::size_t>(count));
    in_engine(2, [&] {
      Space<typename In::Exec>::start();
      Made space(problem.program, problem.rules, problem.nrhs, count, most_bytes);
      EXPECT_EQ(space.capacity() < count, most_bytes < 1 << 30);
      space.solve(problem.systems(0, count), false, nullptr, outcome.data());
      const auto first = problem.x;
      space.solve(problem.systems(0, count), false, nullptr, outcome.data());
      EXPECT_TRUE(same_bits(first, problem.x));
    });
    return outcome;
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
  LaneProblem<Scalar> whole(grid_2d(7, 9), 70, 2, 1), parts(grid_2d(7, 9), 70, 2, 1);
  this->solve(whole, 70);
  this->solve(parts, 70, this->bytes_for_few(parts));
  EXPECT_TRUE(same_bits(whole.x, parts.x));
}

// Parts of stages, by threads of their own, give what one after the other gives.
TYPED_TEST(SpaceLanesOf, StagesGiveWhatOnePartDoes) {
  using Scalar = typename TypeParam::Scalar;
  const SparseMatrix pattern = grid_2d(13, 11);
  for (const int most : {1, 2, 5, 16}) {
    LaneProblem<Scalar> one(pattern, 40), staged(pattern, 40);
    staged.program.program = one.program.program = staged_program(pattern, most);
    EXPECT_EQ(staged.program.program.stage_begin.back() > 1, most > 1);
    one.program.program.part_begin = {0, static_cast<Vertex>(one.n)};
    one.program.program.stage_begin = {0, 1};
    for (const LaneOutcome& lane : this->solve(one, 40)) EXPECT_TRUE(lane.solved);
    this->solve(staged, 40);
    EXPECT_TRUE(same_bits(one.x, staged.x));
    spoil(staged);
    const auto outcome = this->solve(staged, 40);
    // What the third divides may be small in this order.
    for (int k = 0; k < 40; ++k) EXPECT_TRUE(k == 3 || outcome[k].solved == (k == 0 || k > 6)) << k;
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

TYPED_TEST(SpaceLanesOf, EntriesMayRepeatAndRowsMayBeLong) {
  using Scalar = typename TypeParam::Scalar;
  LaneProblem<Scalar> problem(long_rows(), 35, 1, 0);
  for (const LaneOutcome& lane : this->solve(problem, 35)) EXPECT_TRUE(lane.solved);
  for (int k = 0; k < 35; ++k) EXPECT_LE(problem.error_of(k), problem.rules.tolerance * 1.01);
}

}  // namespace
}  // namespace mfs::test
