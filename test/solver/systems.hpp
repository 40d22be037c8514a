// Right-hand sides for a matrix, and the check that a solver's answer is one.
#pragma once

#include <complex>
#include <string>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

#include <mfs/mfs.hpp>

#include "test/reference/generators.hpp"
#include "test/reference/random.hpp"
#include "test/reference/sparse.hpp"

namespace mfs::test {

/// What the solver promises by default, and a little for the rounding of its own measurement.
template <class Scalar>
constexpr double kTolerance = sizeof(std::real(Scalar())) == sizeof(double) ? 1e-12 : 1e-6;
template <class Scalar>
constexpr double kPromisedFor = 1.01 * kTolerance<Scalar>;
constexpr double kPromised = kPromisedFor<double>;

/// The matrix in another scalar: a complex one has the same absolute values, and phases by chance.
template <class Scalar>
BasicSparseMatrix<Scalar> in_scalar(const SparseMatrix& a) {
  BasicSparseMatrix<Scalar> other{a.n, a.offsets, a.columns, {}};
  Random random(static_cast<std::uint64_t>(a.n));
  for (const double value : a.values) {
    if constexpr (std::is_floating_point_v<Scalar>) {
      other.values.push_back(static_cast<Scalar>(value));
    } else {
      other.values.push_back(static_cast<Scalar>(std::polar(value > 0 ? value : -value, 4 * random.entry())));
    }
  }
  return other;
}

/// Right-hand sides whose solutions have entries of the given sizes (empty: one): n x nrhs with leading
/// dimension ld, NaN between.
template <class Scalar>
std::vector<Scalar> right_hand_sides(const BasicSparseMatrix<Scalar>& a, std::int64_t nrhs, std::int64_t ld,
                                     std::uint64_t seed, const std::vector<double>& sizes = {}) {
  Random random(seed);
  std::vector<Scalar> b(static_cast<std::size_t>(ld * nrhs), Scalar(std::numeric_limits<float>::quiet_NaN()));
  for (std::int64_t j = 0; j < nrhs; ++j) {
    std::vector<Scalar> x = random.vector<Scalar>(a.n);
    for (std::size_t i = 0; i < sizes.size(); ++i) x[i] *= static_cast<Scalar>(sizes[i]);
    const std::vector<Scalar> column = multiply(a, x);
    std::copy(column.begin(), column.end(), b.begin() + j * ld);
  }
  return b;
}

/// Largest backward error of the columns of x.
template <class Scalar>
double worst_error(const BasicSparseMatrix<Scalar>& a, const std::vector<Scalar>& b, std::int64_t ldb,
                   const std::vector<Scalar>& x, std::int64_t ldx, std::int64_t nrhs) {
  double worst = 0;
  for (std::int64_t j = 0; j < nrhs; ++j) {
    worst = std::max(worst, backward_error(a, b.data() + j * ldb, x.data() + j * ldx));
  }
  return worst;
}

/// Solves for `nrhs` right-hand sides, plain and transposed, whose solutions have entries of these sizes;
/// every column must be as good as promised.
template <class Scalar>
void expect_solves(BasicSolver<Scalar>& solver, const BasicSparseMatrix<Scalar>& a, std::int64_t nrhs = 1,
                   const std::vector<double>& sizes = {}, const std::vector<double>& transposed_sizes = {}) {
  const BasicSparseMatrix<Scalar> at = transposed(a);
  for (const bool transpose : {false, true}) {
    const BasicSparseMatrix<Scalar>& matrix = transpose ? at : a;
    const std::vector<Scalar> b =
        right_hand_sides(matrix, nrhs, a.n, 7, transpose ? transposed_sizes : sizes);
    std::vector<Scalar> x(b.size());
    if (transpose) {
      solver.solve_transpose(b.data(), x.data(), nrhs);
    } else {
      solver.solve(b.data(), x.data(), nrhs);
    }
    const double error = worst_error(matrix, b, a.n, x, a.n, nrhs);
    EXPECT_LE(error, kPromisedFor<Scalar>) << (transpose ? "transposed" : "plain");
    EXPECT_LE(solver.report().backward_error, kTolerance<Scalar>);
    EXPECT_NEAR(solver.report().backward_error, error, 0.1 * kTolerance<Scalar>);
  }
}
inline void expect_solves(Solver& solver, const NamedMatrix& named, std::int64_t nrhs = 1) {
  expect_solves(solver, named.matrix, nrhs, named.solution_sizes, named.transposed_solution_sizes);
}

/// Backward error of a solution; nothing is expected of it.
inline double error_of_solution(Solver& solver, const SparseMatrix& a) {
  const std::vector<double> b = right_hand_sides(a, 1, a.n, 1);
  std::vector<double> x(b.size());
  solver.solve(b.data(), x.data());
  return backward_error(a, b, x);
}

inline Options with_threads(int threads) {
  Options options;
  options.threads = threads;
  return options;
}

}  // namespace mfs::test
