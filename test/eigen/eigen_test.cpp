// mfs/eigen.hpp beside Eigen's own dense LU: every kind of number, both orders, both widths of indices, new
// values, transposed and adjoint systems, maps and uncompressed matrices, sparse right-hand sides,
// preconditioners, failures.
#include <gmock/gmock.h>

#include <Eigen/Dense>
#include <Eigen/IterativeLinearSolvers>
#include <complex>
#include <limits>
#include <type_traits>
#include <unsupported/Eigen/IterativeSolvers>
#include <vector>

#include <mfs/eigen.hpp>

#include "test/reference/generators.hpp"
#include "test/reference/random.hpp"

namespace mfs::test {
namespace {

template <class Scalar>
Scalar number(Random& random) {
  if constexpr (std::is_floating_point_v<Scalar>)
    return static_cast<Scalar>(random.entry());
  else
    return Scalar(static_cast<typename Scalar::value_type>(random.entry()),
                  static_cast<typename Scalar::value_type>(random.entry()));
}

/// An unsymmetric matrix with zeros on its diagonal: row i meets columns i + 1, i + 3 and one by chance.
template <class Matrix>
Matrix unsymmetric(int n, std::uint64_t seed) {
  using Scalar = typename Matrix::Scalar;
  Random random(seed);
  std::vector<Eigen::Triplet<Scalar, typename Matrix::StorageIndex>> entries;
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, (i + 1) % n, Scalar(4) + number<Scalar>(random));
    entries.emplace_back(i, (i + 3) % n, number<Scalar>(random));
    entries.emplace_back(i, (7 * i + 2) % n, number<Scalar>(random));
  }
  Matrix a(n, n);
  a.setFromTriplets(entries.begin(), entries.end());
  return a;
}

template <class Scalar>
using Dense = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

template <class Scalar>
Dense<Scalar> columns_by_chance(Eigen::Index n, Eigen::Index columns) {
  Random random(77);
  Dense<Scalar> b(n, columns);
  for (Eigen::Index k = 0; k < b.size(); ++k) b.data()[k] = number<Scalar>(random);
  return b;
}

template <class Matrix>
class EigenSolver : public testing::Test {};
#ifdef __SANITIZE_ADDRESS__  // either order and index, real and complex
using Matrices = testing::Types<Eigen::SparseMatrix<double>,
                                Eigen::SparseMatrix<std::complex<double>, Eigen::RowMajor, long>>;
#else
using Matrices = testing::Types<Eigen::SparseMatrix<double>, Eigen::SparseMatrix<double, Eigen::RowMajor>,
                                Eigen::SparseMatrix<float>, Eigen::SparseMatrix<float, Eigen::RowMajor, long>,
                                Eigen::SparseMatrix<std::complex<double>, Eigen::ColMajor, long>,
                                Eigen::SparseMatrix<std::complex<double>, Eigen::RowMajor>,
                                Eigen::SparseMatrix<std::complex<float>>,
                                Eigen::SparseMatrix<std::complex<float>, Eigen::RowMajor>>;
#endif
TYPED_TEST_SUITE(EigenSolver, Matrices);

template <class Solver, class DenseMatrix, class Rhs>
void expect_solved(const Solver& solver, const DenseMatrix& a, const Rhs& b) {
  using Real = typename DenseMatrix::RealScalar;
  const DenseMatrix x = solver.solve(b), expected = a.partialPivLu().solve(DenseMatrix(b));
  EXPECT_EQ(solver.info(), Eigen::Success);
  EXPECT_LT((x - expected).norm(), 1000 * std::numeric_limits<Real>::epsilon() * expected.norm());
}

TYPED_TEST(EigenSolver, SolvesAsEigensDenseOne) {
  using Scalar = typename TypeParam::Scalar;
  const TypeParam a = unsymmetric<TypeParam>(120, 1);
  const Dense<Scalar> dense = a, b = columns_by_chance<Scalar>(120, 3);
  MfsLU<TypeParam> lu(a);
  ASSERT_EQ(lu.info(), Eigen::Success) << lu.lastErrorMessage();
  expect_solved(lu, dense, b);
  expect_solved(lu, dense, b.col(1));
  expect_solved(lu, dense, b + b);  // an expression
  expect_solved(lu.transpose(), Dense<Scalar>(dense.transpose()), b);
  expect_solved(lu.adjoint(), Dense<Scalar>(dense.adjoint()), b);
  const Determinant<Scalar> d = lu.determinant();
  const auto expected = dense.template cast<std::complex<double>>().partialPivLu().determinant();
  EXPECT_NEAR(std::abs(std::complex<double>(d.phase) - expected / std::abs(expected)), 0, 1e-4);
  EXPECT_NEAR(d.log_abs, std::log(std::abs(expected)), 1e-3);
  const TypeParam next = unsymmetric<TypeParam>(120, 2);
  lu.factorize(next);
  expect_solved(lu, Dense<Scalar>(next), b);
  EXPECT_GT(lu.solver().report().time_refactor, 0) << "by the analysis that was there";
}

TYPED_TEST(EigenSolver, TakesRowsAndOtherOrdersOfArrays) {
  using Scalar = typename TypeParam::Scalar;
  const TypeParam a = unsymmetric<TypeParam>(60, 3);
  const Dense<Scalar> dense = a;
  const Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> b =
      columns_by_chance<Scalar>(60, 4);
  MfsLU<TypeParam> lu(a);
  expect_solved(lu, dense, b);
  Dense<Scalar> x = b;
  x = lu.solve(x);
  EXPECT_LT((dense * x - b).norm(), 1e-4 * b.norm());
}

using Matrix = Eigen::SparseMatrix<double>;
using RowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

TEST(Eigen, UncompressedMatricesMapsAndExpressionsAreTaken) {
  Matrix a = unsymmetric<Matrix>(40, 5);
  const Dense<double> dense = a, b = columns_by_chance<double>(40, 1);
  a.uncompress();
  a.reserve(Eigen::VectorXi::Constant(40, 9));
  ASSERT_FALSE(a.isCompressed());
  expect_solved(MfsLU<Matrix>(a), dense, b);
  a.makeCompressed();
  const Eigen::Map<const Matrix> map(40, 40, a.nonZeros(), a.outerIndexPtr(), a.innerIndexPtr(),
                                     a.valuePtr());
  expect_solved(MfsLU<Matrix>(map), dense, b);
  expect_solved(MfsLU<Matrix>(a + a), Dense<double>(2 * dense), b);
  expect_solved(MfsLU<Matrix>(RowMatrix(a)), dense, b);  // copied into the other order
}

TEST(Eigen, SparseRightHandSidesAreSolved) {
  const Matrix a = unsymmetric<Matrix>(40, 6), b = unsymmetric<Matrix>(40, 7);
  const MfsLU<Matrix> lu(a);
  const Matrix x = lu.solve(b);
  EXPECT_LT((a * x - b).norm(), 1e-12 * b.norm());
}

TEST(Eigen, PreconditionsIterativeSolvers) {
  const Matrix a = unsymmetric<Matrix>(90, 8), near = a + 0.01 * unsymmetric<Matrix>(90, 9);
  const Eigen::VectorXd b = columns_by_chance<double>(90, 1);
  Eigen::BiCGSTAB<Matrix, MfsLU<Matrix>> of_itself(a);
  Eigen::VectorXd x = of_itself.solve(b);
  EXPECT_EQ(of_itself.info(), Eigen::Success);
  EXPECT_LE(of_itself.iterations(), 1);
  EXPECT_LT((a * x - b).norm(), 1e-12 * b.norm());
  Eigen::GMRES<RowMatrix, MfsLU<RowMatrix>> gmres;
  Options options;
  options.factor.precision = Precision::single;
  gmres.preconditioner().setOptions(options);
  gmres.compute(near);
  x = gmres.solve(b);
  EXPECT_EQ(gmres.info(), Eigen::Success);
  EXPECT_LT((near * x - b).norm(), 1e-9 * b.norm());
}

template <class M>
void expect_failure(const MfsLU<M>& lu, Eigen::ComputationInfo info, const std::string& part) {
  EXPECT_EQ(lu.info(), info);
  EXPECT_THAT(lu.lastErrorMessage(), testing::HasSubstr(part));
}

TEST(Eigen, FailuresAreInfos) {
  RowMatrix a = unsymmetric<RowMatrix>(30, 10);
  const RowMatrix good = a;
  const Eigen::VectorXd b = columns_by_chance<double>(30, 1);
  MfsLU<RowMatrix> lu(a);
  ASSERT_EQ(lu.info(), Eigen::Success);
  a.coeffRef(4, 5) = std::numeric_limits<double>::quiet_NaN();
  lu.factorize(a);
  expect_failure(lu, Eigen::InvalidInput, "row 4");
  lu.compute(a);
  expect_failure(lu, Eigen::InvalidInput, "row 4");
  lu.compute(good);
  RowMatrix more = good;
  more.coeffRef(2, 2) = 1;
  lu.factorize(more);
  expect_failure(lu, Eigen::InvalidInput, "row 2");
  lu.factorize(good);
  EXPECT_EQ(lu.info(), Eigen::Success) << "good again";
  Eigen::VectorXd wrong = b;
  wrong[3] = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(lu.solve(wrong).eval().array().isNaN().all());
  expect_failure(lu, Eigen::InvalidInput, "");
  lu.compute(RowMatrix(30, 29));
  expect_failure(lu, Eigen::InvalidInput, "square");
}

TEST(Eigen, SingularMatricesAreNumericalIssues) {
  RowMatrix a = unsymmetric<RowMatrix>(30, 11);
  RowMatrix zero_row = a, pattern = 0 * a;
  for (RowMatrix::InnerIterator it(zero_row, 12); it; ++it) it.valueRef() = 0;
  MfsLU<RowMatrix> lu;
  lu.analyzePattern(pattern);
  EXPECT_EQ(lu.info(), Eigen::Success) << "values may come later";
  lu.factorize(a);
  EXPECT_EQ(lu.info(), Eigen::Success);
  lu.compute(zero_row);
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(30);
  if (lu.info() == Eigen::Success) {
    EXPECT_TRUE(lu.solve(b).eval().array().isNaN().all());
  }
  expect_failure(lu, Eigen::NumericalIssue, "row 12");
  RowMatrix empty_row(3, 3);
  empty_row.insert(0, 0) = 1;
  empty_row.insert(2, 2) = 1;
  lu.compute(empty_row);
  expect_failure(lu, Eigen::NumericalIssue, "row 1");
}

}  // namespace
}  // namespace mfs::test
