// Right-hand sides for a matrix, and the check that a solver's answer is one.
#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <mfs/mfs.hpp>

#include "test/reference/generators.hpp"
#include "test/reference/random.hpp"
#include "test/reference/sparse.hpp"

namespace mfs::test {

/// What the solver promises by default, and a little for the rounding of its own measurement.
constexpr double kPromised = 1e-12 + 1e-14;

/// Right-hand sides whose solutions have entries of the given sizes (empty: one): n x nrhs with leading
/// dimension ld, NaN between.
inline std::vector<double> right_hand_sides(const SparseMatrix& a, std::int64_t nrhs, std::int64_t ld,
                                            std::uint64_t seed, const std::vector<double>& sizes = {}) {
  Random random(seed);
  std::vector<double> b(static_cast<std::size_t>(ld * nrhs), std::numeric_limits<double>::quiet_NaN());
  for (std::int64_t j = 0; j < nrhs; ++j) {
    std::vector<double> x = random.vector(a.n);
    for (std::size_t i = 0; i < sizes.size(); ++i) x[i] *= sizes[i];
    const std::vector<double> column = multiply(a, x);
    std::copy(column.begin(), column.end(), b.begin() + j * ld);
  }
  return b;
}

/// Largest backward error of the columns of x.
inline double worst_error(const SparseMatrix& a, const std::vector<double>& b, std::int64_t ldb,
                          const std::vector<double>& x, std::int64_t ldx, std::int64_t nrhs) {
  double worst = 0;
  for (std::int64_t j = 0; j < nrhs; ++j) {
    worst = std::max(worst, backward_error(a, b.data() + j * ldb, x.data() + j * ldx));
  }
  return worst;
}

/// Solves for `nrhs` right-hand sides, plain and transposed; every column must be as good as promised.
inline void expect_solves(Solver& solver, const NamedMatrix& named, std::int64_t nrhs = 1) {
  const SparseMatrix& a = named.matrix;
  const SparseMatrix at = transposed(a);
  for (const bool transpose : {false, true}) {
    const SparseMatrix& matrix = transpose ? at : a;
    const std::vector<double> b = right_hand_sides(
        matrix, nrhs, a.n, 7, transpose ? named.transposed_solution_sizes : named.solution_sizes);
    std::vector<double> x(b.size());
    if (transpose) {
      solver.solve_transpose(b.data(), x.data(), nrhs);
    } else {
      solver.solve(b.data(), x.data(), nrhs);
    }
    const double error = worst_error(matrix, b, a.n, x, a.n, nrhs);
    EXPECT_LE(error, kPromised) << (transpose ? "transposed" : "plain");
    EXPECT_LE(solver.report().backward_error, 1e-12);
    EXPECT_NEAR(solver.report().backward_error, error, 1e-13);
  }
}
inline void expect_solves(Solver& solver, const SparseMatrix& a, std::int64_t nrhs = 1) {
  expect_solves(solver, NamedMatrix{"", a}, nrhs);
}

inline Options with_threads(int threads) {
  Options options;
  options.threads = threads;
  return options;
}

}  // namespace mfs::test
