// The public class with backend kokkos: families of matrices around the sizes of tiles, all four scalars and
// single precision factors, many right-hand sides, the transposed system, other values, what is refused and
// how, and memory that is not there.
#include <sys/resource.h>

#include <cmath>
#include <complex>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numeric>
#include <string>

#include "solver/program/matrix_market.hpp"
#include "test/failure/counted_memory.hpp"
#include "test/failure/fresh_solver.hpp"
#include "test/solver/family_members.hpp"

namespace mfs::test {
namespace {

bool is_there() {
  const std::vector<Backend> usable = backends();
  return std::find(usable.begin(), usable.end(), Backend::kokkos) != usable.end();
}
/// A default space on a device has its factors there.
bool on_host() {
  const std::vector<Backend> usable = backends();
  return std::find(usable.begin(), usable.end(), Backend::cuda) == usable.end();
}

Options kokkos(int threads) {
  Options options;
  options.threads = threads;
  options.backend = Backend::kokkos;
  return options;
}

class Portable : public testing::Test {
 protected:
  void SetUp() override {
    if (!is_there()) GTEST_SKIP() << "no device";
  }
};
template <class Scalar>
class PortableScalars : public Portable {};
using Scalars = testing::Types<float, double, std::complex<float>, std::complex<double>>;
TYPED_TEST_SUITE(PortableScalars, Scalars, );

TYPED_TEST(PortableScalars, FamiliesOfEverySize) {
  for (const std::int64_t n : {1, 2, 31, 32, 33, 65, 257, 600}) {
    for (const NamedMatrix& named : family_members(n)) {
      SCOPED_TRACE(named.name + ", n = " + std::to_string(n));
      const auto a = in_scalar<TypeParam>(named.matrix);
      for (const int threads : {1, 2}) {
        for (const Precision precision : {Precision::full, Precision::single}) {
          Options options = kokkos(threads);
          options.factor.precision = precision;
          BasicSolver<TypeParam> solver(options);
          solver.factor(a.view());
          expect_solves(solver, a, 3);
        }
      }
    }
  }
}

TYPED_TEST(PortableScalars, ManyRightHandSidesAndOtherValues) {
  auto a = in_scalar<TypeParam>(grid_2d(40, 41));
  BasicSolver<TypeParam> solver(kokkos(2));
  solver.factor(a.view());
  Random random(1);
  for (const std::int64_t nrhs : {1, 16, 17, 33}) {
    expect_solves(solver, a, nrhs);
    for (TypeParam& v : a.values) v *= static_cast<TypeParam>(1 + 0.3 * random.entry());
    solver.refactor(a.values.data());
  }
  expect_solves(solver, a);
}

// [ 0  3 ]
// [ 2  s ]   with s the unit that is not real, where there is one
TYPED_TEST(PortableScalars, DeterminantAndCondition) {
  TypeParam unit(1);
  if constexpr (!std::is_floating_point_v<TypeParam>) unit = TypeParam(0, 1);
  const auto a = from_entries<TypeParam>(2, {{0, 1, TypeParam(3)}, {1, 0, TypeParam(2)}, {1, 1, unit}});
  const double small = kTolerance<TypeParam>;
  BasicSolver<TypeParam> solver(kokkos(1));
  solver.factor(a.view());
  const Determinant<TypeParam> determinant = solver.determinant();
  EXPECT_LT(std::abs(determinant.phase - TypeParam(-1)), small);
  EXPECT_NEAR(determinant.log_abs, std::log(6), small);
  EXPECT_NEAR(solver.condition_estimate(), 2, 10 * small);
}

TEST_F(Portable, ProvesThatAMatrixIsSingular) {
  std::vector<Entry> entries = entries_of(grid_2d(20, 20));
  for (Entry& e : entries) {
    if (e.row == 77) e.value = e.column == 77 ? 1e-30 : 0.0;
  }
  for (const auto& e : entries_of(grid_2d(20, 20)))
    if (e.row == 78) entries.push_back({77, e.column, e.value});
  const SparseMatrix a = from_entries_summed(400, entries);
  Solver solver(kokkos(2));
  solver.factor(a.view());
  std::vector<double> b(400, 1.0), x(400);
  const auto error = failure_of<SingularMatrix>([&] { solver.solve(b.data(), x.data()); });
  ASSERT_TRUE(error);
  EXPECT_TRUE(error->row() == 77 || error->row() == 78) << error->row();
  expect_usable(solver);
}

TEST_F(Portable, SaddlePointsNeedPivotsBelowTheDiagonal) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const SparseMatrix a = adversarial_matrix("saddle point renumbered", seed);
    for (const Matching matching : {Matching::automatic, Matching::never}) {
      Options options = kokkos(2);
      options.analysis.matching = matching;
      Solver solver(options);
      solver.factor(a.view());
      expect_solves(solver, a, 2);
    }
  }
}

TEST_F(Portable, GivesTheSameBitsFromRunToRun) {
  const SparseMatrix a = grid_2d(60, 61);
  std::vector<double> expected;
  for (int run = 0; run < 3; ++run) {
    Solver solver(kokkos(2));
    solver.factor(a.view());
    if (run == 2) solver.refactor(a.values.data());
    const std::vector<double> b = right_hand_sides(a, 3, a.n, 1);
    std::vector<double> x(b.size());
    solver.solve(b.data(), x.data(), 3);
    if (run == 0) expected = x;
    EXPECT_EQ(x, expected);
  }
}

TEST_F(Portable, RefusesWhatCannotBe) {
  SparseMatrix a = grid_2d(9, 8);
  Solver solver(kokkos(2));
  expect_not_factored(solver, a);
  Options blocks = kokkos(1);
  blocks.analysis.max_block_size = 512;
  expect_invalid([&] { Solver refused(blocks); }, "max_block_size");
  solver.factor(a.view());
  std::vector<double> b(72, 1.0), x(72);
  b[5] = std::nan("");
  expect_invalid([&] { solver.solve(b.data(), x.data()); }, "b", 5, 0);
  if (on_host()) failure_of<StateError>([&] { solver.refactor_device(a.values.data()); });
  a.values[3] = std::numeric_limits<double>::infinity();
  failure_of<InvalidInput>([&] { solver.refactor(a.view()); });
  expect_usable(solver);
}

struct Interrupted {};
TEST_F(Portable, TellsProgressAndCanBeInterrupted) {
  const SparseMatrix a = grid_2d(50, 50);
  Options options = kokkos(2);
  bool interrupt = false;
  double last = 0;
  options.progress = [&](const Progress& progress) {
    if (std::string(progress.phase) != "factor") return;
    last = progress.fraction;
    if (interrupt) throw Interrupted();
  };
  Solver solver(options);
  solver.factor(a.view());
  EXPECT_EQ(last, 1);
  interrupt = true;
  EXPECT_THROW(solver.refactor(a.values.data()), Interrupted);
  interrupt = false;
  solver.refactor(a.values.data());
  expect_solves(solver, a);
}

// Large enough for tiles where there are threads, and small.
TEST_F(Portable, AllocatesNothingInANewtonStep) {
  for (const SparseMatrix& a : {grid_2d(12, 13), grid_2d(130, 131), dense(400)}) {
    for (const int threads : {1, 2}) {
      SCOPED_TRACE("n = " + std::to_string(a.n) + ", threads " + std::to_string(threads));
      Solver solver(kokkos(threads));
      solver.factor(a.view());
      const std::vector<double> b = right_hand_sides(a, 16, a.n, 1);
      std::vector<double> x(b.size());
      const auto step = [&] {
        solver.refactor(a.values.data());
        solver.solve(b.data(), x.data(), 16);
        solver.solve_transpose(b.data(), x.data());
      };
      step();
      start_counting();
      step();
      EXPECT_EQ(stop_counting(), 0);
    }
  }
}

// Each allocation of a phase is made to fail once: OutOfMemory, and an object that still does its work.
TEST_F(Portable, EveryAllocationMayFail) {
  const SparseMatrix a = grid_2d(14, 13);
  for (const bool prepared : {false, true}) {
    bool reached = true;
    long n = 0;
    for (; reached && n < 2000 && !HasFailure(); ++n) {
      Solver solver(kokkos(1));
      if (prepared) solver.factor(a.view());
      const std::vector<double> b = right_hand_sides(a, 20, a.n, 1);
      std::vector<double> x(b.size());
      start_counting(n);
      try {
        if (prepared) {
          solver.solve(b.data(), x.data(), 20);
        } else {
          solver.factor(a.view());
        }
      } catch (const OutOfMemory&) {
      } catch (const std::exception& error) {
        stop_counting();
        ADD_FAILURE() << "allocation " << n << " gives " << error.what();
      }
      stop_counting();
      reached = one_has_failed();
      solver.factor(a.view());
      expect_solves(solver, a);
    }
    EXPECT_GT(n, 1);
  }
}

// One front of all unknowns: n^2 entries.
TEST_F(Portable, RefusesAPlanThatCannotFit) {
  const std::int64_t n = 2000000;  // 32 TB
  const SparseMatrix a = tridiagonal(n);
  Options options = kokkos(1);
  options.analysis.permutation.resize(static_cast<std::size_t>(n));
  std::iota(options.analysis.permutation.begin(), options.analysis.permutation.end(), 0);
  options.analysis.tree = {{0, n}, {-1}};
  Solver solver(options);
  if (const auto error = failure_of<OutOfMemory>([&] { solver.factor(a.view()); })) {
    EXPECT_EQ(error->space(), on_host() ? MemorySpace::host : MemorySpace::device);
    EXPECT_GE(error->needed(), 8 * static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
  }
  EXPECT_FALSE(solver.factored());
}

/// Solves with the real matrices of a folder; what its manifest calls solvable must be.
TEST_F(Portable, RealMatrices) {
  const char* folder = std::getenv("MFS_MATRIX_DIR");
  if (!folder || !std::filesystem::is_directory(folder)) GTEST_SKIP() << "MFS_MATRIX_DIR is not set";
  int solved = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (file.path().extension() != ".gz" || std::filesystem::file_size(file) > (1 << 20)) continue;
    SCOPED_TRACE(file.path().filename().string());
    const io::MatrixMarket read = io::read_matrix_market(file.path());
    std::visit(
        [&](const auto& content) {
          using Content = std::decay_t<decltype(content)>;
          if constexpr (std::is_same_v<Content, io::CsrMatrix<double>> ||
                        std::is_same_v<Content, io::CsrMatrix<std::complex<double>>>) {
            using Scalar = typename decltype(content.values)::value_type;
            if (read.header.rows != read.header.columns) return;
            BasicSparseMatrix<Scalar> a;
            a.n = read.header.rows;
            a.offsets.assign(content.offsets.begin(), content.offsets.end());
            a.columns.assign(content.column_indices.begin(), content.column_indices.end());
            a.values = content.values;
            Options by_host;
            by_host.threads = 2;
            const auto outcome = [&](const Options& options, bool& right) {
              try {
                BasicSolver<Scalar> solver(options);
                solver.factor(a.view());
                const std::vector<Scalar> b(static_cast<std::size_t>(a.n), Scalar(1));
                std::vector<Scalar> x(b.size());
                solver.solve(b.data(), x.data());
                right = backward_error(a, b, x) <= kPromised;
                return 1;
              } catch (const SingularMatrix&) {
                return 2;
              } catch (const AccuracyNotReached&) {
                return 3;
              }
            };
            bool right = true, right_by_host = true;
            const int found = outcome(kokkos(2), right);
            EXPECT_EQ(found, outcome(by_host, right_by_host)) << "1 solved, 2 singular, 3 inaccurate";
            EXPECT_TRUE(right) << "a solution that is none";
            solved += found == 1;
          }
        },
        read.content);
  }
  EXPECT_GT(solved, 0);
}

}  // namespace
}  // namespace mfs::test
