// Factors that are larger than the device may hold, by limits from the least one on: solutions of those that
// fit, bit for bit, and memory below the limit. Needs a device that no other process uses;
// skips where there is none.
#include <cuda_runtime.h>

#include <complex>
#include <string>

#include "test/solver/answers.hpp"
#include "test/solver/on_device.hpp"

namespace mfs::test {
namespace {

/// Bytes of the device in use, as seen from outside the library.
std::int64_t bytes_in_use() {
  std::size_t free = 0, total = 0;
  EXPECT_EQ(cudaMemGetInfo(&free, &total), cudaSuccess);
  return static_cast<std::int64_t>(total - free);
}

/// Of the context alone; code of kernels comes to that later.
std::int64_t bytes_at_first() {
  static const std::int64_t bytes = bytes_in_use();
  return bytes;
}

using Partial = OnDevice;

/// The least limit that does, as OutOfMemory tells where one does not.
template <class Scalar>
std::int64_t least_limit(Options options, const BasicSparseMatrix<Scalar>& a, std::int64_t refused) {
  options.memory_limit = refused;
  BasicSolver<Scalar> solver(options);
  solver.analyze(a.view());
  try {
    solver.factor(a.view());
  } catch (const OutOfMemory& error) {
    EXPECT_EQ(error.space(), MemorySpace::device);
    EXPECT_GT(error.needed(), static_cast<std::size_t>(refused));
    return static_cast<std::int64_t>(error.needed());
  }
  ADD_FAILURE() << refused << " bytes did";
  return refused;
}

/// All phases with a limit. False where everything fits.
template <class Scalar>
bool solves_within(Options options, const BasicSparseMatrix<Scalar>& a, std::int64_t limit,
                   const Answers<Scalar>& expected) {
  SCOPED_TRACE("limit " + std::to_string(limit));
  const std::int64_t before = bytes_in_use();
  options.memory_limit = limit;
  BasicSolver<Scalar> solver(options);
  solver.factor(a.view());
  expect_same(answers_of(solver, a), expected);
  const bool partial = solver.report().partial;
  EXPECT_EQ(partial, solver.report().segments > 1);
  for (int k = 0; k < 2; ++k) {
    solver.refactor(a.view());
    expect_same(answers_of(solver, a), expected);
  }
  expect_solves(solver, a, 17);
  EXPECT_LE(bytes_in_use() - before, limit - bytes_at_first());
  return partial;
}

/// With the least limit, where fronts are divided and the matrix is on the host, and larger ones.
template <class Scalar>
void check(const Options& options, const SparseMatrix& matrix) {
  bytes_at_first();
  const BasicSparseMatrix<Scalar> a = in_scalar<Scalar>(matrix);
  Answers<Scalar> expected;
  std::int64_t bytes = 0;
  {
    BasicSolver<Scalar> full(options);
    full.factor(a.view());
    EXPECT_FALSE(full.report().partial);
    expected = answers_of(full, a);
    bytes = full.report().bytes_peak;
  }
  const std::int64_t least = least_limit(options, a, 1);
  EXPECT_LE(least_limit(options, a, least - bytes / 5), least);
  int solved = 0;
  for (std::int64_t limit = least; solves_within(options, a, limit, expected); limit += bytes / 10) {
    ++solved;
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GE(solved, 4);
}

TEST_F(Partial, SolutionsAreThoseOfAllFactorsOnTheDevice) {
  check<double>(options_, grid_3d(24));
  check<std::complex<double>>(options_, grid_3d(17));
  check<float>(options_, grid_3d(20));
}

// Beside factors that just fit there is no room for the vectors of 16 columns.
TEST_F(Partial, ManyColumnsKeepToTheLimit) {
  constexpr std::int64_t kStep = std::int64_t(4) << 20;
  const std::int64_t first = bytes_at_first();
  const SparseMatrix a = grid_2d(500, 500);
  Solver full(options_);
  full.analyze(a.view());
  options_.memory_limit = first + full.report().bytes_peak;
  for (bool partial = true; partial;) {
    options_.memory_limit += kStep;
    Solver solver(options_);
    solver.analyze(a.view());
    partial = solver.report().partial;
  }
  const std::int64_t before = bytes_in_use();
  Solver solver(options_);
  solver.factor(a.view());
  ASSERT_FALSE(solver.report().partial);
  expect_solves(solver, a, 17);
  EXPECT_LE(bytes_in_use() - before, options_.memory_limit - first);
}

TEST_F(Partial, FactorsOfSinglePrecisionAreRefined) {
  options_.factor.precision = Precision::single;
  check<double>(options_, grid_3d(24));
}

// In tiles, and where that does not do in all rows of a front: then the factorization is repeated.
TEST_F(Partial, SearchesPivots) {
  SparseMatrix a = grid_3d(20);
  for (std::int64_t row = 0; row < a.n; ++row) {
    for (std::int64_t k = a.offsets[row]; k < a.offsets[row + 1]; ++k) {
      if (a.columns[k] == row && row % 3 == 0) a.values[k] = 1e-2;
    }
  }
  options_.analysis.matching = Matching::never;
  check<double>(options_, a);
}

TEST_F(Partial, IsToldBeforeAnyNumberIsComputed) {
  const SparseMatrix a = grid_3d(24);
  Solver full(options_);
  full.analyze(a.view());
  EXPECT_FALSE(full.report().partial);
  EXPECT_EQ(full.report().bytes_out, 0);
  EXPECT_EQ(full.report().slowdown, 1);
  const std::int64_t least = least_limit(options_, a, 1);
  options_.memory_limit = least + full.report().bytes_peak / 10;
  Solver partial(options_);
  partial.analyze(a.view());
  const Report& report = partial.report();
  EXPECT_TRUE(report.partial);
  EXPECT_LE(report.bytes_peak, options_.memory_limit);
  EXPECT_GT(report.bytes_out, 0);
  EXPECT_LE(report.bytes_back, 2 * report.bytes_out);
  EXPECT_GT(report.slowdown, 1);
  std::int64_t segments = 0;
  for (const DepthSummary& depth : partial.depths()) segments += depth.segments;
  EXPECT_EQ(segments, report.segments);
  options_.memory_limit = least + full.report().bytes_peak;
  Solver enough(options_);
  enough.analyze(a.view());
  EXPECT_FALSE(enough.report().partial);
}

}  // namespace
}  // namespace mfs::test
