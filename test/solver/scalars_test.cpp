// The public class in each of its four scalars: families of matrices at sizes around those of warps and
// tiles, many right-hand sides, the transposed system, refactorization, determinant and condition.
#include <cmath>
#include <complex>
#include <limits>
#include <string>

#include "test/solver/family_members.hpp"
#include "test/solver/systems.hpp"

namespace mfs::test {
namespace {

template <class Scalar>
class Scalars : public testing::Test {};
using All = testing::Types<float, double, std::complex<float>, std::complex<double>>;
TYPED_TEST_SUITE(Scalars, All, );

constexpr std::int64_t kSizes[] = {1, 2, 31, 32, 33, 65, 257};

TYPED_TEST(Scalars, FamiliesOfEverySize) {
  for (const std::int64_t n : kSizes) {
    for (const NamedMatrix& named : family_members(n)) {
      SCOPED_TRACE(named.name + ", n = " + std::to_string(n));
      const auto a = in_scalar<TypeParam>(named.matrix);
      for (const int threads : {1, 2}) {
        BasicSolver<TypeParam> solver(with_threads(threads));
        solver.factor(a.view());
        expect_solves(solver, a);
        EXPECT_EQ(solver.report().n, n);
      }
    }
  }
}

TYPED_TEST(Scalars, ManyRightHandSidesWithGaps) {
  const auto a = in_scalar<TypeParam>(grid_2d(12, 11));
  const auto at = transposed(a);
  BasicSolver<TypeParam> solver(with_threads(2));
  solver.factor(a.view());
  for (const std::int64_t nrhs : {2, 16, 17, 33}) {
    const std::int64_t ldb = a.n + 3, ldx = a.n + 5;
    for (const bool transpose : {false, true}) {
      SCOPED_TRACE(std::to_string(nrhs) + (transpose ? " transposed" : ""));
      const auto& matrix = transpose ? at : a;
      const auto b = right_hand_sides(matrix, nrhs, ldb, 3);
      std::vector<TypeParam> x(static_cast<std::size_t>(ldx * nrhs), TypeParam(-4));
      if (transpose)
        solver.solve_transpose(b.data(), x.data(), nrhs, ldb, ldx);
      else
        solver.solve(b.data(), x.data(), nrhs, ldb, ldx);
      EXPECT_LE(worst_error(matrix, b, ldb, x, ldx, nrhs), kPromisedFor<TypeParam>);
      for (std::int64_t j = 0; j < nrhs; ++j)
        for (std::int64_t i = a.n; i < ldx; ++i) EXPECT_EQ(x[j * ldx + i], TypeParam(-4)) << "the gap";
    }
  }
}

TYPED_TEST(Scalars, RefactorWithOtherValues) {
  auto a = in_scalar<TypeParam>(random_diagonally_dominant(200, 4, 9));
  BasicSolver<TypeParam> solver(with_threads(1));
  solver.factor(a.view());
  Random random(1);
  for (int step = 0; step < 4; ++step) {
    for (TypeParam& v : a.values) v *= static_cast<TypeParam>(1 + 0.3 * random.entry());
    if (step % 2 == 0) {
      solver.refactor(a.view());
    } else {
      solver.refactor(a.values.data());
    }
    expect_solves(solver, a, 2);
  }
}

TYPED_TEST(Scalars, AskedForMoreAccuracyThanUsual) {
  const auto a = in_scalar<TypeParam>(grid_2d(12, 11));
  const double strict = 10 * std::numeric_limits<decltype(std::real(TypeParam()))>::epsilon();
  Options options = with_threads(1);
  options.solve.tolerance = strict;
  BasicSolver<TypeParam> solver(options);
  solver.factor(a.view());
  const auto b = right_hand_sides(a, 1, a.n, 3);
  std::vector<TypeParam> x(b.size());
  solver.solve(b.data(), x.data());
  EXPECT_LE(backward_error(a, b, x), 2 * strict);
}

// [ 0  3 ]
// [ 2  s ]   with s the unit that is not real, where there is one
TYPED_TEST(Scalars, DeterminantAndCondition) {
  TypeParam unit(1);
  if constexpr (!std::is_floating_point_v<TypeParam>) unit = TypeParam(0, 1);
  const auto a = from_entries<TypeParam>(2, {{0, 1, TypeParam(3)}, {1, 0, TypeParam(2)}, {1, 1, unit}});
  const double small = kTolerance<TypeParam>;
  BasicSolver<TypeParam> solver(with_threads(1));
  solver.factor(a.view());
  const Determinant<TypeParam> determinant = solver.determinant();
  EXPECT_LT(std::abs(determinant.phase - TypeParam(-1)), small);
  EXPECT_NEAR(determinant.log_abs, std::log(6), small);
  // Columns of A sum up to 2 and 4, those of its inverse, [-s/6 1/2; 1/3 0], to 1/2 and 1/2.
  EXPECT_NEAR(solver.condition_estimate(), 2, 10 * small);
}

}  // namespace
}  // namespace mfs::test
