// Right-hand sides with few entries, as the sources of a circuit have, and matrices that have a block
// triangular form, by factors of the whole matrix: unknowns that are zero stand in rows that meet nothing
// else. And solutions that decay from a source until they are below all numbers.
#include <cmath>
#include <complex>
#include <filesystem>
#include <limits>
#include <string>

#include "test/solver/on_device.hpp"
#include "test/solver/systems.hpp"

namespace mfs::test {
namespace {

/// Blocks whose diagonal is no larger than the rest; some have entries over six decades.
SparseMatrix reducible(Random& random) {
  std::vector<std::int64_t> sizes(static_cast<std::size_t>(random.integer(3, 40)));
  for (std::int64_t& size : sizes) size = random.integer(1, 12);
  SparseMatrix a = permuted_blocks(sizes, static_cast<std::uint64_t>(random.integer(0, 1000)));
  const bool graded = random.chance(0.4);
  for (double& value : a.values)
    value = graded ? random.entry() * std::pow(10, 3 * random.entry()) : random.entry();
  return a;
}

void expect_unit_vectors_are_solved_for(Backend backend) {
  for (int trial = 0; trial < 40; ++trial) {
    SCOPED_TRACE("trial " + std::to_string(trial));
    Random random(static_cast<std::uint64_t>(trial));
    const SparseMatrix a = reducible(random), at = transposed(a);
    Options options;
    options.backend = backend;
    options.threads = 1;
    // As factors in a file are those of the whole matrix.
    if (backend == Backend::serial) options.out_of_core_dir = std::filesystem::temp_directory_path();
    Solver solver(options);
    solver.factor(a.view());
    EXPECT_EQ(solver.report().diagonal_blocks, 1);
    for (int k = 0; k < 4; ++k) {
      std::vector<double> b(static_cast<std::size_t>(a.n), 0.0), x(b.size());
      b[static_cast<std::size_t>(random.integer(0, a.n))] = random.entry();
      solver.solve(b.data(), x.data());
      EXPECT_LE(backward_error(a, b, x), kPromised);
      solver.solve_transpose(b.data(), x.data());
      EXPECT_LE(backward_error(at, b, x), kPromised);
    }
  }
}

TEST(SparseRightSides, AreSolvedForByFactorsOfTheWhole) {
  expect_unit_vectors_are_solved_for(Backend::serial);
}
TEST(SparseRightSides, AreSolvedForByKokkos) {
  expect_unit_vectors_are_solved_for(Backend::kokkos);
}
class SparseRightSidesOnDevice : public OnDevice {};
TEST_F(SparseRightSidesOnDevice, AreSolvedFor) {
  expect_unit_vectors_are_solved_for(Backend::cuda);
}

/// With 1 + k on the diagonal and 1 shared by the neighbours in a grid of rows x columns points.
SparseMatrix decaying(std::int64_t rows, std::int64_t columns, double k) {
  SparseMatrix a = grid_2d(rows, columns);
  for (std::int64_t i = 0; i < a.n; ++i)
    for (std::int64_t e = a.offsets[i]; e < a.offsets[i + 1]; ++e)
      a.values[e] = a.columns[e] == i ? 1 + k : -0.25;
  return a;
}

/// Entries of the solution of a bidiagonal matrix are powers of 0.37.
SparseMatrix bidiagonal(std::int64_t n) {
  SparseMatrix a{n, {0}, {}, {}};
  for (std::int64_t i = 0; i < n; ++i) {
    if (i > 0) {
      a.columns.push_back(i - 1);
      a.values.push_back(-0.37);
    }
    a.columns.push_back(i);
    a.values.push_back(1);
    a.offsets.push_back(static_cast<std::int64_t>(a.columns.size()));
  }
  return a;
}

template <class Scalar>
void expect_decay_is_solved(Backend backend) {
  using Real = decltype(std::abs(Scalar()));
  const double free = 1000 * static_cast<double>(std::numeric_limits<Real>::denorm_min());
  for (const SparseMatrix& real : {decaying(1200, 1, 1), decaying(60, 60, 100), decaying(400, 5, 0.3),
                                   decaying(1, 1500, 0.1), bidiagonal(1200)}) {
    SCOPED_TRACE(std::to_string(real.n) + " unknowns");
    const BasicSparseMatrix<Scalar> a = in_scalar<Scalar>(real), at = transposed(a);
    Options options;
    options.backend = backend;
    options.threads = 1;
    BasicSolver<Scalar> solver(options);
    solver.factor(a.view());
    for (const std::int64_t nrhs : {1, 9}) {
      const auto n = static_cast<std::size_t>(a.n);
      std::vector<Scalar> b(n * static_cast<std::size_t>(nrhs), Scalar(0)), x(b.size());
      for (std::size_t j = 0; j < static_cast<std::size_t>(nrhs); ++j) b[j * n + j * n / 10] = Scalar(3.7f);
      for (const bool transpose : {false, true}) {
        transpose ? solver.solve_transpose(b.data(), x.data(), nrhs) : solver.solve(b.data(), x.data(), nrhs);
        EXPECT_LE(solver.report().backward_error, kTolerance<Scalar>);
        const BasicSparseMatrix<Scalar>& matrix = transpose ? at : a;
        for (std::size_t j = 0; j < static_cast<std::size_t>(nrhs); ++j)
          EXPECT_LE(backward_error(matrix, &b[j * n], &x[j * n], free / kTolerance<Scalar>),
                    kPromisedFor<Scalar>)
              << j;
      }
    }
  }
}

TEST(DecayingSolutions, AreNotRefused) {
  for (const Backend backend : {Backend::serial, Backend::openmp, Backend::kokkos}) {
    SCOPED_TRACE(static_cast<int>(backend));
    expect_decay_is_solved<double>(backend);
    expect_decay_is_solved<float>(backend);
    expect_decay_is_solved<std::complex<double>>(backend);
    expect_decay_is_solved<std::complex<float>>(backend);
  }
}
TEST_F(SparseRightSidesOnDevice, MayDecay) {
  expect_decay_is_solved<double>(Backend::cuda);
  expect_decay_is_solved<float>(Backend::cuda);
  expect_decay_is_solved<std::complex<double>>(Backend::cuda);
  expect_decay_is_solved<std::complex<float>>(Backend::cuda);
}

TEST(DecayingSolutions, HaveTheirDigits) {
  const SparseMatrix a = bidiagonal(1200);
  Solver solver;
  solver.factor(a.view());
  std::vector<double> b(1200, 0.0), x(b);
  b[0] = 1;
  solver.solve(b.data(), x.data());
  long double power = 1;
  for (std::size_t i = 0; i < x.size(); ++i, power *= 0.37L) {
    const auto expected = static_cast<double>(power);
    EXPECT_LE(std::abs(x[i] - expected), 1e-12 * expected + 2e-323) << i;
  }
}

}  // namespace
}  // namespace mfs::test
