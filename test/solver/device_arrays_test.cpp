// Matrices, right-hand sides and solutions in the memory of the device. Needs a device; skips where there is
// none.
#include <algorithm>
#include <chrono>
#include <cstring>
#include <limits>
#include <numeric>
#include <thread>
#include <utility>

#include "perf/device_array.hpp"
#include "test/failure/fresh_solver.hpp"
#include "test/solver/on_device.hpp"

namespace mfs::test {
namespace {

using perf::check;
using perf::DeviceArray;

template <class T>
std::vector<T> to_host(const DeviceArray<T>& from, std::size_t count) {
  std::vector<T> to(count);
  check(cudaMemcpy(to.data(), from.get(), count * sizeof(T), cudaMemcpyDeviceToHost), "cudaMemcpy");
  return to;
}

/// A stream that does nothing for a while and then copies: who does not wait for it finds what was before.
class LateStream {
 public:
  LateStream() { check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "cudaStreamCreate"); }
  ~LateStream() { cudaStreamDestroy(stream_); }
  LateStream(const LateStream&) = delete;
  LateStream& operator=(const LateStream&) = delete;

  template <class T>
  void copy_late(T* to, const T* from, std::size_t count) {
    const auto sleep = [](void*) { std::this_thread::sleep_for(std::chrono::milliseconds(30)); };
    check(cudaLaunchHostFunc(stream_, sleep, nullptr), "cudaLaunchHostFunc");
    check(cudaMemcpyAsync(to, from, count * sizeof(T), cudaMemcpyDeviceToDevice, stream_), "cudaMemcpyAsync");
  }
  cudaStream_t get() const { return stream_; }

 private:
  cudaStream_t stream_ = nullptr;
};

template <class Scalar>
class DeviceArrays : public OnDevice {
 protected:
  /// Solves plain and transposed, with gaps between the columns, which must stay as they are.
  static void expect_solves_there(BasicSolver<Scalar>& solver, const BasicSparseMatrix<Scalar>& a,
                                  std::int64_t nrhs, cudaStream_t stream = nullptr) {
    SCOPED_TRACE(std::to_string(nrhs) + " columns");
    const std::int64_t ldb = a.n + 3, ldx = a.n + 5;
    const Scalar untouched(12345);
    for (const bool transpose : {false, true}) {
      const BasicSparseMatrix<Scalar> matrix = transpose ? transposed(a) : a;
      const std::vector<Scalar> b = right_hand_sides(matrix, nrhs, ldb, 7);
      const DeviceArray<Scalar> there(b),
          x(std::vector<Scalar>(static_cast<std::size_t>(ldx * nrhs), untouched));
      transpose ? solver.solve_transpose_device(there.get(), x.get(), nrhs, ldb, ldx, stream)
                : solver.solve_device(there.get(), x.get(), nrhs, ldb, ldx, stream);
      const std::vector<Scalar> found = to_host(x, static_cast<std::size_t>(ldx * nrhs));
      const double error = worst_error(matrix, b, ldb, found, ldx, nrhs);
      EXPECT_LE(error, kPromisedFor<Scalar>) << (transpose ? "transposed" : "plain");
      EXPECT_NEAR(solver.report().backward_error, error, 0.1 * kTolerance<Scalar>);
      for (std::int64_t i = 0; i < ldx * nrhs; ++i) {
        if (i % ldx < a.n) continue;
        EXPECT_EQ(found[i], untouched) << "between the columns";
      }
    }
  }
};
using Scalars = testing::Types<double, float, std::complex<double>, std::complex<float>>;
TYPED_TEST_SUITE(DeviceArrays, Scalars);

std::vector<SparseMatrix> matrices() {
  return {grid_2d(30, 29), random_diagonally_dominant(300, 4, 1), random_diagonally_dominant(40, 30, 2)};
}

TYPED_TEST(DeviceArrays, AreSolvedForAsThoseOfTheHost) {
  for (const SparseMatrix& real : matrices()) {
    BasicSparseMatrix<TypeParam> a = in_scalar<TypeParam>(real);
    BasicSolver<TypeParam> solver(this->options_);
    solver.analyze(a.view());
    solver.factor(a.view());
    for (const double factor : {1.0, -3.0, 0.5}) {
      for (TypeParam& value : a.values) value *= static_cast<TypeParam>(factor);
      const DeviceArray<TypeParam> values(a.values);
      solver.refactor_device(values.get());
      for (const std::int64_t nrhs : {1, 2, 16, 17}) this->expect_solves_there(solver, a, nrhs);
      expect_solves(solver, a, 3);
    }
  }
}

// What is refused leaves the analysis as it was.
TYPED_TEST(DeviceArrays, FirstValuesThatHoldNoNumbersAreRefused) {
  const BasicSparseMatrix<TypeParam> a = in_scalar<TypeParam>(grid_2d(30, 29));
  BasicSparseMatrix<TypeParam> wrong = a;
  wrong.values[static_cast<std::size_t>(a.offsets[9])] = TypeParam(std::numeric_limits<float>::infinity());
  const DeviceArray<TypeParam> values(a.values), bad(wrong.values);
  BasicSolver<TypeParam> solver(this->options_);
  failure_of<StateError>([&] { solver.refactor_device(values.get()); });
  CsrView<TypeParam> pattern = a.view();
  pattern.values = nullptr;
  solver.analyze(pattern);
  failure_of<StateError>([&] { solver.refactor_device(values.get()); });
  solver.analyze(a.view());
  expect_invalid([&] { solver.refactor_device(nullptr); }, "values");
  expect_invalid([&] { solver.refactor_device(bad.get()); }, "values", 9, a.columns[a.offsets[9]]);
  expect_not_factored(solver, a);
  solver.refactor_device(values.get());
  this->expect_solves_there(solver, a, 2);
}

// Right-hand sides and solutions in one array.
TYPED_TEST(DeviceArrays, MayBeOneArray) {
  const BasicSparseMatrix<TypeParam> a = in_scalar<TypeParam>(grid_2d(30, 29));
  BasicSolver<TypeParam> solver(this->options_);
  solver.factor(a.view());
  for (const std::int64_t nrhs : {1, 5}) {
    const std::vector<TypeParam> b = right_hand_sides(a, nrhs, a.n, 3);
    const DeviceArray<TypeParam> both(b);
    solver.solve_device(both.get(), both.get(), nrhs);
    EXPECT_LE(worst_error(a, b, a.n, to_host(both, b.size()), a.n, nrhs), kPromisedFor<TypeParam>);
  }
}

// What the caller's stream has still to write is waited for.
TYPED_TEST(DeviceArrays, FollowTheStreamOfTheCaller) {
  BasicSparseMatrix<TypeParam> a = in_scalar<TypeParam>(grid_2d(30, 29));
  BasicSolver<TypeParam> solver(this->options_);
  solver.factor(a.view());
  const TypeParam nothing(std::numeric_limits<float>::quiet_NaN());
  LateStream stream;
  for (const double factor : {2.0, -1.5}) {
    for (TypeParam& value : a.values) value *= static_cast<TypeParam>(factor);
    const DeviceArray<TypeParam> values(a.values), late(std::vector<TypeParam>(a.values.size(), nothing));
    stream.copy_late(late.get(), values.get(), a.values.size());
    solver.refactor_device(late.get(), stream.get());
    const std::vector<TypeParam> b = right_hand_sides(a, 2, a.n, 5);
    const DeviceArray<TypeParam> there(b), late_b(std::vector<TypeParam>(b.size(), nothing)),
        x(std::vector<TypeParam>(b.size(), nothing));
    stream.copy_late(late_b.get(), there.get(), b.size());
    solver.solve_device(late_b.get(), x.get(), 2, 0, 0, stream.get());
    EXPECT_LE(worst_error(a, b, a.n, to_host(x, b.size()), a.n, 2), kPromisedFor<TypeParam>);
  }
}

// Each entry given in two parts, one at the end of its row: what is given is summed.
TYPED_TEST(DeviceArrays, MayRepeatEntries) {
  const BasicSparseMatrix<TypeParam> a = in_scalar<TypeParam>(random_diagonally_dominant(200, 4, 3));
  BasicSparseMatrix<TypeParam> twice{a.n, {0}, {}, {}};
  for (std::int64_t i = 0; i < a.n; ++i) {
    for (const double part : {0.75, 0.25}) {
      for (std::int64_t k = a.offsets[i]; k < a.offsets[i + 1]; ++k) {
        twice.columns.push_back(a.columns[k]);
        twice.values.push_back(a.values[k] * static_cast<TypeParam>(part));
      }
    }
    twice.offsets.push_back(static_cast<std::int64_t>(twice.columns.size()));
  }
  BasicSolver<TypeParam> solver(this->options_);
  solver.analyze(twice.view());
  BasicSparseMatrix<TypeParam> summed = a;
  for (int again = 0; again < 2; ++again) {
    for (TypeParam& value : twice.values) value *= TypeParam(4);
    for (TypeParam& value : summed.values) value *= TypeParam(4);
    const DeviceArray<TypeParam> values(twice.values);
    solver.refactor_device(values.get());
    this->expect_solves_there(solver, summed, 3);
  }
}

// What is wrong with them is said as of arrays of the host, and the solutions of that block of columns are
// not written. All bits set is what marks an entry of a substitution that has not been done.
TYPED_TEST(DeviceArrays, ThatHoldNoNumbersAreRefused) {
  const BasicSparseMatrix<TypeParam> a = in_scalar<TypeParam>(random_diagonally_dominant(100, 4, 5));
  BasicSolver<TypeParam> solver(this->options_);
  solver.factor(a.view());
  const TypeParam bad(std::numeric_limits<float>::infinity());
  TypeParam all_bits_set;
  std::memset(static_cast<void*>(&all_bits_set), 0xff, sizeof(all_bits_set));
  for (const TypeParam number : {bad, all_bits_set}) {
    for (const int column : {0, 1, 40}) {
      const auto n = static_cast<std::size_t>(a.n), begin = n * static_cast<std::size_t>(column);
      std::vector<TypeParam> b = right_hand_sides(a, column + 1, a.n, 5);
      std::memcpy(&b[begin + 7], &number, sizeof(number));
      const std::vector<TypeParam> ones(b.size(), TypeParam(1));
      const DeviceArray<TypeParam> there(b), x(ones);
      expect_invalid([&] { solver.solve_device(there.get(), x.get(), column + 1); }, "b", 7, column);
      const std::vector<TypeParam> left = to_host(x, b.size());
      EXPECT_TRUE(std::equal(left.begin() + static_cast<std::ptrdiff_t>(begin), left.end(), ones.begin()));
    }
  }
  BasicSparseMatrix<TypeParam> wrong = a;
  wrong.values[static_cast<std::size_t>(a.offsets[9])] = bad;
  const DeviceArray<TypeParam> values(wrong.values);
  expect_invalid([&] { solver.refactor_device(values.get()); }, "values", 9, a.columns[a.offsets[9]]);
  solver.factor(a.view());
  this->expect_solves_there(solver, a, 2);
}

using DeviceArraysOfDoubles = OnDevice;

// A kernel that read them would end the device's work for the whole process.
TEST_F(DeviceArraysOfDoubles, OfTheHostAreRefusedUnlessTheyAreLocked) {
  int reads_any_memory = 0;
  check(cudaDeviceGetAttribute(&reads_any_memory, cudaDevAttrPageableMemoryAccess, 0), "attribute");
  if (reads_any_memory) GTEST_SKIP() << "the device reads all memory of the host";
  const SparseMatrix a = grid_2d(12, 9);
  std::vector<double> b = right_hand_sides(a, 1, a.n, 3), x(b.size(), 1.0);
  const DeviceArray<double> there(b), solution(b);
  for (const Backend backend : {Backend::cuda, Backend::kokkos}) {
    options_.backend = backend;
    Solver solver(options_);
    solver.factor(a.view());
    expect_invalid([&] { solver.refactor_device(a.values.data()); }, "values");
    expect_invalid([&] { solver.solve_device(b.data(), solution.get()); }, "b");
    expect_invalid([&] { solver.solve_device(there.get(), x.data()); }, "x");
    EXPECT_EQ(x, std::vector<double>(b.size(), 1.0));
    check(cudaHostRegister(x.data(), x.size() * sizeof(double), cudaHostRegisterDefault), "cudaHostRegister");
    solver.solve_device(there.get(), x.data());
    check(cudaHostUnregister(x.data()), "cudaHostUnregister");
    EXPECT_LE(worst_error(a, b, a.n, x, a.n, 1), kPromised);
    x.assign(b.size(), 1.0);
  }
}

using Allocate = cudaError_t (*)(void**, std::size_t);
using Free = cudaError_t (*)(void*);

/// A copy of the numbers in memory of another kind than cudaMalloc's.
class OtherArray {
 public:
  OtherArray(const std::vector<double>& from, Allocate allocate, Free free) : free_(free) {
    const std::size_t bytes = from.size() * sizeof(double);
    check(allocate(&numbers_, bytes), "allocation");
    check(cudaMemcpy(numbers_, from.data(), bytes, cudaMemcpyDefault), "cudaMemcpy");
  }
  ~OtherArray() { free_(numbers_); }
  OtherArray(const OtherArray&) = delete;
  OtherArray& operator=(const OtherArray&) = delete;
  double* get() const { return static_cast<double*>(numbers_); }

 private:
  Free free_;
  void* numbers_ = nullptr;
};

// Libraries of Python and C++ allocate so.
TEST_F(DeviceArraysOfDoubles, MayBeOfManagedMemoryAndOfPools) {
  const SparseMatrix a = grid_2d(12, 9);
  const std::vector<double> b = right_hand_sides(a, 2, a.n, 3);
  const Allocate managed = [](void**to, std::size_t bytes) { return cudaMallocManaged(to, bytes); },
                 pooled = [](void**to, std::size_t bytes) { return cudaMallocAsync(to, bytes, nullptr); };
  const Free free_managed = [](void*array) { return cudaFree(array); },
             free_pooled = [](void*array) { return cudaFreeAsync(array, nullptr); };
  for (const Backend backend : {Backend::cuda, Backend::kokkos}) {
    options_.backend = backend;
    for (const auto& [allocate, free] : {std::pair{managed, free_managed}, std::pair{pooled, free_pooled}}) {
      Solver solver(options_);
      solver.analyze(a.view());
      const OtherArray values(a.values, allocate, free), there(b, allocate, free), x(b, allocate, free);
      solver.refactor_device(values.get());
      solver.solve_device(there.get(), x.get(), 2);
      std::vector<double> found(b.size());
      check(cudaMemcpy(found.data(), x.get(), found.size() * sizeof(double), cudaMemcpyDefault),
            "cudaMemcpy");
      EXPECT_LE(worst_error(a, b, a.n, found, a.n, 2), kPromised);
    }
  }
}

// Single precision factors, double precision solutions.
TEST_F(DeviceArraysOfDoubles, AreRefinedOnTheDeviceForFactorsOfSinglePrecision) {
  options_.factor.precision = Precision::single;
  for (const SparseMatrix& a : matrices()) {
    Solver solver(options_);
    solver.factor(a.view());
    for (const std::int64_t nrhs : {1, 16}) {
      const std::vector<double> b = right_hand_sides(a, nrhs, a.n, 11);
      const DeviceArray<double> there(b), x(b);
      solver.solve_device(there.get(), x.get(), nrhs);
      EXPECT_LE(worst_error(a, b, a.n, to_host(x, b.size()), a.n, nrhs), kPromised);
      EXPECT_TRUE(solver.report().single_precision);
      EXPECT_GT(solver.report().refinement_steps, 0);
    }
  }
}

// The tolerance is below what doubles can have: the device refines, the ladder goes on from what it has found
// and says how far that came; nothing is written.
TEST_F(DeviceArraysOfDoubles, AreLeftAloneByASolveThatMissesItsTolerance) {
  options_.solve.tolerance = 1e-18;
  const SparseMatrix a = random_diagonally_dominant(300, 4, 1);
  Solver solver(options_);
  solver.factor(a.view());
  for (const std::int64_t nrhs : {1, 3}) {
    const std::vector<double> b = right_hand_sides(a, nrhs, a.n, 13), ones(b.size(), 1.0);
    const DeviceArray<double> there(b), x(ones);
    const auto error =
        failure_of<AccuracyNotReached>([&] { solver.solve_device(there.get(), x.get(), nrhs); });
    ASSERT_TRUE(error);
    EXPECT_LE(error->reached(), kPromised);
    EXPECT_EQ(to_host(x, ones.size()), ones);
    EXPECT_EQ(to_host(there, b.size()), b);
    EXPECT_GT(solver.report().refinement_steps, 0);
  }
}

/// Dense. Its pivots are on the diagonal, or, where they are `away`, in the 128th row below or above it,
/// which the pivot search of the first 128 columns does not reach at first.
SparseMatrix with_pivots(bool away) {
  constexpr std::int64_t n = 300, half = 128;
  Random random(31);
  SparseMatrix a{n, {0}, {}, {}};
  for (std::int64_t i = 0; i < n; ++i) {
    const std::int64_t partner = !away ? i : i < half ? i + half : i < 2 * half ? i - half : i;
    for (std::int64_t j = 0; j < n; ++j) {
      const double size = away && i < half && j < half ? 1e-3 : 1.0;
      const double entry = size * random.entry();
      a.columns.push_back(j);
      a.values.push_back(j == partner ? 80.0 : entry);
    }
    a.offsets.push_back(static_cast<std::int64_t>(a.columns.size()));
  }
  return a;
}

/// With more operations than an analysis does on trial.
std::vector<SparseMatrix> large_matrices() {
  const SparseMatrix large = random_diagonally_dominant(5000, 8, 2);
  return {large, with_cancelling_pivots(large, 40)};
}

// The first factorization, of the values of the analysis or of others, does the same as one from the host.
TYPED_TEST(DeviceArrays, MayBeTheFirstValues) {
  std::vector<SparseMatrix> all = matrices();
  all.push_back(with_pivots(true));
  for (SparseMatrix& large : large_matrices()) all.push_back(std::move(large));
  for (const SparseMatrix& real : all) {
    const BasicSparseMatrix<TypeParam> analysed = in_scalar<TypeParam>(real);
    for (const double factor : {1.0, -3.0}) {
      BasicSparseMatrix<TypeParam> a = analysed;
      for (TypeParam& value : a.values) value *= static_cast<TypeParam>(factor);
      BasicSolver<TypeParam> from_host(this->options_), solver(this->options_);
      from_host.analyze(analysed.view());
      from_host.factor(a.view());
      solver.analyze(analysed.view());
      EXPECT_FALSE(solver.factored());
      const DeviceArray<TypeParam> values(a.values);
      solver.refactor_device(values.get());
      EXPECT_TRUE(solver.factored());
      EXPECT_GT(solver.report().time_factor, 0);
      EXPECT_EQ(solver.report().time_refactor, 0);
      EXPECT_EQ(solver.report().reanalyses, from_host.report().reanalyses);
      const std::vector<TypeParam> b = right_hand_sides(a, 1, a.n, 3);
      std::vector<TypeParam> x(b.size()), expected(b.size());
      from_host.solve(b.data(), expected.data());
      solver.solve(b.data(), x.data());
      EXPECT_EQ(x, expected);
      this->expect_solves_there(solver, a, 2);
      solver.factor(analysed.view());
      expect_solves(solver, analysed, 1);
    }
  }
}

// The analysis leaves their values alone, and pivots of some fail.
TEST_F(DeviceArraysOfDoubles, MayBeFirstValuesThatWereNotTried) {
  for (const SparseMatrix& a : large_matrices()) {
    Solver solver(options_);
    solver.analyze(a.view());
    EXPECT_GT(solver.report().flops.total(), 4e6 * static_cast<double>(a.n));
    EXPECT_EQ(solver.report().reanalyses, 0);
    const DeviceArray<double> values(a.values);
    solver.refactor_device(values.get());
    EXPECT_EQ(solver.report().reanalyses, a.n > 5000 ? 1 : 0);
  }
}

// First values for which the matching of those of the analysis is of no use: compared when solves find it
// out.
TEST_F(DeviceArraysOfDoubles, ThatComeFirstAreMatchedAnewWhereTheyMust) {
  const SparseMatrix strong = circulant(4);
  for (const double diagonal : {4.0, 0.0}) {
    const SparseMatrix a = circulant(diagonal);
    Solver solver(options_);
    solver.analyze(strong.view());
    const DeviceArray<double> values(a.values);
    solver.refactor_device(values.get());
    expect_solves(solver, a, 1);
    EXPECT_EQ(solver.report().reanalyses > 0, diagonal == 0);
  }
}

// Of a large matrix with little fill the vectors of 16 columns would take nearly as much as the factors:
// there only a few are solved for at once, from arrays of either memory.
using ManyColumns = DeviceArrays<double>;
TEST_F(ManyColumns, TakeLittleMemory) {
  const SparseMatrix a = grid_2d(1000, 1000);
  Solver solver(options_);
  solver.factor(a.view());
  expect_solves_there(solver, a, 1);
  const std::int64_t column = 8 * a.n, before = solver.report().bytes_used;
  expect_solves_there(solver, a, 16);
  const std::int64_t more = solver.report().bytes_used - before;
  EXPECT_GT(more, 4 * column);
  EXPECT_LT(more, 20 * column) << "16 columns at once take 60 and more";
  expect_solves(solver, a, 17);
  EXPECT_LT(solver.report().bytes_used - before, 24 * column);
}

TEST_F(ManyColumns, OfSmallFactorsAreSolvedForAtOnce) {
  const SparseMatrix a = grid_2d(200, 200);
  Solver solver(options_);
  solver.factor(a.view());
  const std::int64_t before = solver.report().bytes_used;
  expect_solves_there(solver, a, 16);
  EXPECT_GT(solver.report().bytes_used - before, 40 * 8 * a.n);
}

// What the plan says of memory and operations is what is taken and done there, where no library is needed.
using DeviceReport = DeviceArrays<double>;
TEST_F(DeviceReport, FiguresAreThoseOfTheDevice) {
  const SparseMatrix a = grid_2d(160, 161);
  for (const Precision precision : {Precision::full, Precision::single}) {
    options_.factor.precision = precision;
    Solver solver(options_);
    solver.analyze(a.view());
    const Report analysed = solver.report();
    EXPECT_EQ(analysed.bytes_used, 0);
    solver.factor(a.view());
    const Report& factored = solver.report();
    EXPECT_EQ(factored.bytes_used, analysed.bytes_peak) << "predicted exactly";
    EXPECT_GE(factored.bytes_used, analysed.bytes_factor);
    EXPECT_NEAR(factored.flops_used.getrf, analysed.flops.getrf, 1e-12 * analysed.flops.getrf);
    EXPECT_NEAR(factored.flops_used.trsm, analysed.flops.trsm, 1e-12 * analysed.flops.trsm);
    EXPECT_NEAR(factored.flops_used.gemm, analysed.flops.gemm, 1e-12 * analysed.flops.gemm);
    std::vector<double> b(static_cast<std::size_t>(a.n), 1.0), x(b.size());
    solver.solve(b.data(), x.data());
    EXPECT_EQ(solver.report().bytes_used, analysed.bytes_peak);
    Options given = options_;  // trees for a device are lower than those for the host, but for the caller's
    given.analysis.permutation.resize(static_cast<std::size_t>(a.n));
    std::iota(given.analysis.permutation.begin(), given.analysis.permutation.end(), 0);
    Options on_host = given;
    on_host.backend = Backend::serial;
    Solver device(given), host(on_host);
    device.analyze(a.view());
    host.analyze(a.view());
    EXPECT_NEAR(host.report().flops.total(), device.report().flops.total(),
                1e-9 * host.report().flops.total());
  }
}

// Once a front's pivots are searched further, they are so in later factorizations, but not forever: then the
// factors are those of a solver that never had to.
TEST_F(DeviceArraysOfDoubles, ForgetOtherMatrices) {
  const SparseMatrix common = with_pivots(false), rare = with_pivots(true);
  Solver solver(options_);
  solver.factor(common.view());
  const std::vector<double> b = right_hand_sides(common, 1, common.n, 3);
  std::vector<double> first(b.size()), x(b.size()), before;
  solver.solve(b.data(), first.data());
  for (int again = 0; again < 5; ++again) {
    solver.refactor(rare.view());
    solver.solve(b.data(), x.data());
    EXPECT_LE(worst_error(rare, b, rare.n, x, rare.n, 1), kPromised);
    if (again > 0) {
      EXPECT_EQ(x, before) << "the same matrix " << again << " times";
    }
    before = x;
  }
  for (int again = 0; again < 4; ++again) {
    solver.refactor(common.view());
    solver.solve(b.data(), x.data());
    EXPECT_LE(worst_error(common, b, common.n, x, common.n, 1), kPromised);
  }
  EXPECT_EQ(x, first);
}

/// Dense, and just large enough for the library to factor it without pivoting. Large entries are on the
/// diagonal, or, where they are `away`, beside it.
BasicSparseMatrix<std::complex<double>> large_root(bool away) {
  constexpr std::int64_t n = 8192;
  Random random(32);
  BasicSparseMatrix<std::complex<double>> a{n, {0}, {}, {}};
  a.columns.reserve(n * n);
  a.values.reserve(n * n);
  for (std::int64_t i = 0; i < n; ++i) {
    const std::int64_t large = away ? i ^ 1 : i;
    for (std::int64_t j = 0; j < n; ++j) {
      const double real = random.entry();
      a.columns.push_back(j);
      a.values.push_back(j == large ? std::complex<double>(0, 600) : std::complex<double>(real, 1 - real));
    }
    a.offsets.push_back(static_cast<std::int64_t>(a.columns.size()));
  }
  return a;
}

// A root that needs pivots after all gets them, and those that follow are tried without again.
TEST_F(DeviceArraysOfDoubles, LargeRootsDoWithoutPivotsWhereTheyCan) {
  const auto common = large_root(false), rare = large_root(true);
  BasicSolver<std::complex<double>> solver(options_);
  solver.factor(common.view());
  const auto b = right_hand_sides(common, 1, common.n, 3);
  auto first = b, x = b, with_pivots = b;
  solver.solve(b.data(), first.data());
  EXPECT_LE(worst_error(common, b, common.n, first, common.n, 1), kPromised);
  solver.refactor(rare.view());
  solver.solve(b.data(), with_pivots.data());
  EXPECT_LE(worst_error(rare, b, rare.n, with_pivots, rare.n, 1), kPromised);
  solver.refactor(common.view());
  solver.solve(b.data(), x.data());
  EXPECT_EQ(x, first) << "the next factorization is tried without pivots";
  solver.refactor(rare.view());
  solver.solve(b.data(), x.data());
  EXPECT_EQ(x, with_pivots);
}

using DevicePivots = OnDevice;

// The analysis has tried its values: the tree does not change for them any more.
TEST_F(DevicePivots, HaveMovedBeforeTheFirstFactorization) {
  options_.analysis.matching = Matching::never;
  const SparseMatrix a = adversarial_matrix("saddle point renumbered", 1);
  Solver solver(options_);
  solver.analyze(a.view());
  const std::int64_t changes = solver.report().reanalyses;
  EXPECT_GT(changes, 0);
  EXPECT_FALSE(solver.factored());
  EXPECT_THROW(solver.refactor(a.view()), StateError);
  const std::vector<double> b = right_hand_sides(a, 1, a.n, 1);
  std::vector<double> x(b.size()), of_others(b.size());
  EXPECT_THROW(solver.solve(b.data(), x.data()), StateError);
  EXPECT_THROW(solver.determinant(), StateError);
  solver.factor(a.view());
  EXPECT_EQ(solver.report().reanalyses, changes);
  EXPECT_EQ(solver.report().perturbed_pivots, 0);
  solver.solve(b.data(), x.data());
  EXPECT_LE(backward_error(a, b, x), kPromised);
  Solver at_once(options_);  // which tries nothing
  at_once.factor(a.view());
  EXPECT_EQ(at_once.report().reanalyses, changes);
  at_once.solve(b.data(), of_others.data());
  EXPECT_EQ(of_others, x);
}

// What the values of the analysis have told of their pivots is not held against others.
TEST_F(DevicePivots, OfOtherValuesThanThoseOfTheAnalysis) {
  for (const char* const family : {"rows permuted", "zero diagonal", "saddle point", "graded and permuted"}) {
    SCOPED_TRACE(family);
    const SparseMatrix a = adversarial_matrix(family, 1);
    SparseMatrix placeholder = a;
    std::fill(placeholder.values.begin(), placeholder.values.end(), 1.0);
    Solver solver(options_);
    solver.analyze(placeholder.view());
    solver.factor(a.view());
    EXPECT_LE(error_of_solution(solver, a), kPromised);
  }
}

// Exchanges of rows that scaling asks for cost digits.
TEST_F(DevicePivots, StayOnADominantDiagonal) {
  options_.solve.tolerance = 1e-3;  // so that no step of refinement is taken
  for (const std::uint64_t seed : {1, 2, 3}) {
    const SparseMatrix a = resistors(100000, seed);
    Solver solver(options_);
    solver.factor(a.view());
    EXPECT_LE(error_of_solution(solver, a), 1e-9) << "seed " << seed;
    EXPECT_EQ(solver.report().rung, Rung::factors);
  }
}

}  // namespace
}  // namespace mfs::test
