// The failures of the public class in each of its four scalars: the same classes, the same places, and an
// object that can be used afterwards.
#include <complex>
#include <limits>
#include <numeric>

#include "test/failure/fresh_solver.hpp"

namespace mfs::test {
namespace {

template <class Scalar>
class ScalarFailures : public testing::Test {};
using All = testing::Types<float, double, std::complex<float>, std::complex<double>>;
TYPED_TEST_SUITE(ScalarFailures, All, );

/// A number with this part where it shows last: the imaginary one of a complex number.
template <class Scalar>
Scalar hidden(double part) {
  if constexpr (std::is_floating_point_v<Scalar>) {
    return static_cast<Scalar>(part);
  } else {
    return {1, static_cast<decltype(std::real(Scalar()))>(part)};
  }
}

TYPED_TEST(ScalarFailures, ValuesThatAreNoNumbers) {
  for (const double wrong :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
        -std::numeric_limits<double>::infinity()}) {
    const auto good = in_scalar<TypeParam>(grid_2d(30, 30));
    auto a = good;
    const std::int64_t place = a.offsets[700] + 2;
    a.values[place] = hidden<TypeParam>(wrong);
    BasicSolver<TypeParam> solver(with_threads(2));
    expect_invalid([&] { solver.factor(a.view()); }, "values", 700, a.columns[place]);
    solver.factor(good.view());
    expect_invalid([&] { solver.refactor(a.values.data()); }, "values", 700, a.columns[place]);
    expect_solves(solver, good);  // by the last good factorization

    std::vector<TypeParam> b(2 * 900, TypeParam(1)), x(2 * 900, TypeParam(4));
    b[900 + 17] = hidden<TypeParam>(wrong);
    expect_invalid([&] { solver.solve(b.data(), x.data(), 2); }, "b", 17, 1);
    expect_invalid([&] { solver.solve_transpose(b.data(), x.data(), 2); }, "b", 17, 1);
    EXPECT_EQ(x, std::vector<TypeParam>(2 * 900, TypeParam(4)));
    expect_usable(solver);
  }
}

TYPED_TEST(ScalarFailures, StructurallySingular) {
  BasicSolver<TypeParam> solver(with_threads(1));
  const auto a = in_scalar<TypeParam>(from_entries(3, {{0, 0, 1}, {0, 2, 1}, {2, 0, 1}, {2, 2, 1}}));
  const auto error = failure_of<SingularMatrix>([&] { solver.factor(a.view()); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->kind(), SingularMatrix::Kind::structural);
  EXPECT_EQ(error->row(), 1);
  EXPECT_EQ(error->column(), 1);
  EXPECT_EQ(error->dependent_rows(), 1);
  expect_usable(solver);
}

// In a grid, one row is a multiple of another: the unit of that multiple is not real where there are others.
TYPED_TEST(ScalarFailures, NumericallySingular) {
  for (const bool transpose : {false, true}) {
    const auto grid = in_scalar<TypeParam>(grid_2d(8, 9));
    const std::int64_t row = 40, other = 41;
    std::vector<BasicEntry<TypeParam>> entries;
    for (const auto& e : entries_of(grid)) {
      if (e.row == row) continue;
      entries.push_back(e);
      if (e.row == other) entries.push_back({row, e.column, hidden<TypeParam>(2) * e.value});
    }
    auto a = from_entries_summed<TypeParam>(grid.n, entries);
    if (transpose) a = transposed(a);
    BasicSolver<TypeParam> solver(with_threads(1));
    const std::vector<TypeParam> b = Random(5).vector<TypeParam>(a.n);
    std::vector<TypeParam> x(b.size(), TypeParam(5));
    solver.factor(a.view());
    const auto error = failure_of<SingularMatrix>([&] { solver.solve(b.data(), x.data()); });
    ASSERT_TRUE(error);
    EXPECT_EQ(error->kind(), SingularMatrix::Kind::numerical);
    EXPECT_THAT(transpose ? error->column() : error->row(), testing::AnyOf(row, other));
    EXPECT_EQ(error->dependent_rows(), 1);
    EXPECT_EQ(x, std::vector<TypeParam>(b.size(), TypeParam(5)));
    expect_usable(solver);
  }
}

TYPED_TEST(ScalarFailures, ToleranceOutOfReach) {
  const auto a = in_scalar<TypeParam>(grid_2d(9, 9));
  Options options = with_threads(1);
  options.solve.tolerance = 1e-30;
  BasicSolver<TypeParam> solver(options);
  solver.factor(a.view());
  const auto b = right_hand_sides(a, 1, a.n, 1);
  std::vector<TypeParam> x(b.size(), TypeParam(7));
  if (const auto error = failure_of<AccuracyNotReached>([&] { solver.solve(b.data(), x.data()); })) {
    EXPECT_GT(error->reached(), 1e-30);
    EXPECT_LT(error->reached(), kTolerance<TypeParam>);
  }
  EXPECT_EQ(x, std::vector<TypeParam>(b.size(), TypeParam(7)));
}

TYPED_TEST(ScalarFailures, PhasesOutOfOrderAndAnotherPattern) {
  auto a = in_scalar<TypeParam>(grid_2d(4, 4));
  BasicSolver<TypeParam> solver(with_threads(1));
  expect_not_factored(solver, a);
  solver.analyze(a.view());
  expect_not_factored(solver, a);
  solver.factor(a.view());
  auto other = a;
  other.columns[other.offsets[7]] = 0;
  const auto error = failure_of<PatternChanged>([&] { solver.refactor(other.view()); });
  ASSERT_TRUE(error);
  EXPECT_EQ(error->row(), 7);
  expect_solves(solver, a);
  expect_usable(solver);
}

TYPED_TEST(ScalarFailures, APlanThatDoesNotFitTheMachine) {
  const std::int64_t n = 1000000;  // in one front: n^2 entries
  const auto a = in_scalar<TypeParam>(tridiagonal(n));
  Options options = with_threads(1);
  options.analysis.permutation.resize(static_cast<std::size_t>(n));
  std::iota(options.analysis.permutation.begin(), options.analysis.permutation.end(), 0);
  options.analysis.tree = {{0, n}, {-1}};
  BasicSolver<TypeParam> solver(options);
  const auto bytes = sizeof(TypeParam) * static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
  if (const auto error = failure_of<OutOfMemory>([&] { solver.factor(a.view()); })) {
    EXPECT_EQ(error->space(), MemorySpace::host);
    EXPECT_GE(error->needed(), bytes);
    EXPECT_LT(error->needed(), bytes + bytes / 2);
  }
  EXPECT_FALSE(solver.factored());
}

}  // namespace
}  // namespace mfs::test
