// Determinant and condition number by factors that were not made for them: values far from those of the
// analysis, scales of a right-hand side that was refused, numbers near the ends of the range. The reference
// is Gauss-Jordan elimination with complete pivoting in long double.
#include <algorithm>
#include <cmath>
#include <complex>
#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "test/reference/random.hpp"
#include "test/solver/systems.hpp"

namespace mfs::test {
namespace {

using Wide = std::complex<long double>;

struct Exact {
  Wide phase = 1;
  long double log_abs = 0, condition = 0;
};

// Rows and columns are divided by powers of two of their largest entries first, so that pivots are compared.
template <class Scalar>
Exact exact(const BasicSparseMatrix<Scalar>& a) {
  const std::size_t n = static_cast<std::size_t>(a.n);
  std::vector<std::vector<Wide>> m(n, std::vector<Wide>(2 * n)), plain(n, std::vector<Wide>(n));
  for (std::size_t i = 0; i < n; ++i) {
    for (std::int64_t k = a.offsets[i]; k < a.offsets[i + 1]; ++k) {
      const std::complex<double> value(a.values[k]);
      plain[i][a.columns[k]] += Wide(value.real(), value.imag());
    }
  }
  std::vector<long double> row(n, 1), column(n, 1);
  const auto scaled = [&](std::size_t i, std::size_t j) { return plain[i][j] * row[i] * column[j]; };
  for (int pass = 0; pass < 4; ++pass) {
    for (std::size_t i = 0; i < n; ++i) {
      long double most = 0;
      for (std::size_t j = 0; j < n; ++j) most = std::max(most, std::abs(scaled(i, j)));
      row[i] = std::ldexp(row[i], -std::ilogb(most));
    }
    for (std::size_t j = 0; j < n; ++j) {
      long double most = 0;
      for (std::size_t i = 0; i < n; ++i) most = std::max(most, std::abs(scaled(i, j)));
      column[j] = std::ldexp(column[j], -std::ilogb(most));
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) m[i][j] = scaled(i, j);
    m[i][n + i] = 1;
  }
  Exact found;
  std::vector<std::size_t> unknown(n);
  for (std::size_t k = 0; k < n; ++k) unknown[k] = k;
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t r = k, c = k;
    for (std::size_t i = k; i < n; ++i) {
      for (std::size_t j = k; j < n; ++j) {
        if (std::abs(m[i][j]) > std::abs(m[r][c])) r = i, c = j;
      }
    }
    if (r != k) found.phase = -found.phase, std::swap(m[r], m[k]);
    if (c != k) {
      found.phase = -found.phase;
      for (std::size_t i = 0; i < n; ++i) std::swap(m[i][c], m[i][k]);
      std::swap(unknown[c], unknown[k]);
    }
    const Wide pivot = m[k][k];
    found.phase *= pivot / std::abs(pivot);
    found.log_abs += std::log(std::abs(pivot)) - std::log(row[k]) - std::log(column[k]);
    for (Wide& entry : m[k]) entry /= pivot;
    for (std::size_t i = 0; i < n; ++i) {
      const Wide factor = i == k ? Wide(0) : m[i][k];
      for (std::size_t j = 0; j < 2 * n && factor != Wide(0); ++j) m[i][j] -= factor * m[k][j];
    }
  }
  long double norm = 0, inverse = 0;
  for (std::size_t j = 0; j < n; ++j) {
    long double own = 0, other = 0;
    for (std::size_t i = 0; i < n; ++i) {
      own += std::abs(plain[i][j]);
      other += std::abs(m[i][n + j]) * column[unknown[i]] * row[j];
    }
    norm = std::max(norm, own);
    inverse = std::max(inverse, other);
  }
  found.condition = norm * inverse;
  return found;
}

template <class Scalar>
void expect_right(BasicSolver<Scalar>& solver, const BasicSparseMatrix<Scalar>& a, double tolerance) {
  const Exact right = exact(a);
  const Determinant<Scalar> found = solver.determinant();
  const Wide phase(std::complex<double>(found.phase).real(), std::complex<double>(found.phase).imag());
  const Wide ratio = phase / right.phase * std::exp(static_cast<long double>(found.log_abs) - right.log_abs);
  EXPECT_LE(std::abs(ratio - Wide(1)), tolerance) << "determinant";
  const double condition = solver.condition_estimate();
  EXPECT_LE(condition, 1.01 * static_cast<double>(right.condition));
  EXPECT_GE(condition, 0.1 * static_cast<double>(right.condition));
}

template <class Scalar>
class Estimates : public testing::Test {};
using Scalars = testing::Types<float, double, std::complex<float>, std::complex<double>>;
TYPED_TEST_SUITE(Estimates, Scalars);

template <class Scalar>
BasicSparseMatrix<Scalar> two_by_two() {
  return from_entries<Scalar>(
      2, {{0, 0, Scalar(0.1f)}, {0, 1, Scalar(0.01f)}, {1, 0, Scalar(0.02f)}, {1, 1, Scalar(0.1f)}});
}

// Its solution is beyond the range. What was tried for it is forgotten by all that comes after.
TYPED_TEST(Estimates, ARefusedRightHandSideChangesNothing) {
  using Real = decltype(std::abs(TypeParam()));
  const std::string folder = std::filesystem::temp_directory_path();
  for (const std::string& files : {std::string(), folder}) {
    const auto a = two_by_two<TypeParam>();
    Options options = with_threads(1);
    options.out_of_core_dir = files;
    BasicSolver<TypeParam> solver(options);
    solver.factor(a.view());
    std::vector<TypeParam> huge(2 * 17, TypeParam(std::numeric_limits<Real>::max() / 2)), x(huge.size());
    EXPECT_THROW(solver.solve(huge.data(), x.data(), 17), AccuracyNotReached);
    expect_right(solver, a, 1e3 * std::numeric_limits<Real>::epsilon());
    EXPECT_THROW(solver.solve_transpose(huge.data(), x.data(), 17), AccuracyNotReached);
    expect_solves(solver, a, 17);
  }
}

TYPED_TEST(Estimates, AnalysisNearTheEndsOfTheRange) {
  using Real = decltype(std::abs(TypeParam()));
  const auto a = in_scalar<TypeParam>(random_diagonally_dominant(18, 4, 3));
  for (const Real factor : {std::numeric_limits<Real>::max() / 64, std::numeric_limits<Real>::min() * 64}) {
    SCOPED_TRACE(factor);
    BasicSparseMatrix<TypeParam> extreme = a;
    for (TypeParam& value : extreme.values) value *= factor;
    BasicSolver<TypeParam> solver(with_threads(1));
    solver.factor(extreme.view());
    expect_right(solver, extreme, 1e5 * std::numeric_limits<Real>::epsilon());
    solver.refactor(a.values.data());
    expect_right(solver, a, 1e4 * std::numeric_limits<Real>::epsilon());
  }
}

// Most entries become noise beside those that stay, so pivots of the old scales are perturbed.
TYPED_TEST(Estimates, ValuesFarFromThoseOfTheAnalysis) {
  using Real = decltype(std::abs(TypeParam()));
  const Real epsilon = std::numeric_limits<Real>::epsilon();
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const std::int64_t n = 2 + static_cast<std::int64_t>(seed % 7);
    std::vector<BasicEntry<TypeParam>> entries;
    for (std::int64_t i = 0; i < n; ++i) {
      for (std::int64_t j = 0; j < n; ++j) {
        if (i == j || random.entry() > 0) entries.push_back({i, j, random.vector<TypeParam>(1)[0]});
      }
    }
    const auto first = from_entries(n, entries);
    auto later = first;
    // A triangle of which each row has its own size stays regular, whatever the others are.
    for (std::int64_t i = 0; i < n; ++i) {
      const Real size = random.entry() > 0 ? Real(1) : epsilon;
      for (std::int64_t k = later.offsets[i]; k < later.offsets[i + 1]; ++k) {
        const Real other = later.columns[k] == i ? Real(4) : later.columns[k] < i ? Real(1) : epsilon;
        later.values[k] *= size * other;
      }
    }
    BasicSolver<TypeParam> solver(with_threads(1));
    solver.factor(first.view());
    solver.refactor(later.values.data());
    const Exact right = exact(later);
    BasicSolver<TypeParam> fresh(with_threads(1));
    fresh.factor(later.view());
    const Determinant<TypeParam> found = solver.determinant(), anew = fresh.determinant();
    EXPECT_NEAR(anew.log_abs, static_cast<double>(right.log_abs), 1e-3) << "fresh";
    EXPECT_NEAR(found.log_abs, anew.log_abs, 1e5 * epsilon);
    EXPECT_LE(std::abs(found.phase - anew.phase), 1e5 * epsilon);
    const double condition = solver.condition_estimate();
    EXPECT_LE(condition, 1.1 * static_cast<double>(right.condition));
    EXPECT_GE(condition, 0.1 * static_cast<double>(right.condition));
  }
}

// By the scales of the first values, all rows but one are rounding.
TEST(Estimates, RegularAfterAllThatLooksSingular) {
  const SparseMatrix first = from_entries(2, {{0, 0, 1}, {0, 1, 0.5}, {1, 0, 0.3}, {1, 1, 1}});
  SparseMatrix later = first;
  later.values = {0.17561268902399114, -3.7106616e-16, -1.5673604e-15, -1.1225356e-15};
  Solver solver(with_threads(1));
  solver.factor(first.view());
  solver.refactor(later.values.data());
  expect_right(solver, later, 1e-12);
  solver.refactor(later.values.data());
  EXPECT_NEAR(solver.condition_estimate() / static_cast<double>(exact(later).condition), 1, 1e-6);
}

TEST(Estimates, ARowOfZerosIsSingularByAnyFactors) {
  const SparseMatrix first = from_entries(2, {{0, 0, 1}, {0, 1, 0.5}, {1, 0, 0.3}, {1, 1, 1}});
  const std::vector<double> later{0, 0, 0.3, 1};
  for (const bool refactored : {false, true}) {
    Solver solver(with_threads(1));
    solver.factor(first.view());
    solver.refactor(later.data());
    if (refactored) EXPECT_EQ(solver.condition_estimate(), std::numeric_limits<double>::infinity());
    EXPECT_EQ(solver.determinant().phase, 0);
    EXPECT_EQ(solver.determinant().log_abs, -std::numeric_limits<double>::infinity());
    EXPECT_EQ(solver.condition_estimate(), std::numeric_limits<double>::infinity());
    solver.refactor(first.values.data());
    expect_right(solver, first, 1e-14);
  }
}

TEST(Estimates, AConditionBeyondTheRangeIsInfinite) {
  Solver solver(with_threads(1));
  solver.factor(from_entries(2, {{0, 0, 1e200}, {1, 1, 1e-200}}).view());
  EXPECT_EQ(solver.condition_estimate(), std::numeric_limits<double>::infinity());
  EXPECT_NEAR(solver.determinant().log_abs, 0, 1e-12);
}

}  // namespace
}  // namespace mfs::test
