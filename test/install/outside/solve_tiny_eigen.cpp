// The example of the README with Eigen: a matrix of each order, a preconditioner, and a singular matrix.
#include <cstdio>
#include <vector>

#include <Eigen/Sparse>
#include <mfs/eigen.hpp>

namespace {

template <class Matrix>
Matrix tiny(double last) {
  const std::vector<Eigen::Triplet<double>> entries{{0, 0, 4},  {0, 1, -1}, {1, 0, -1},  {1, 1, 4},
                                                    {1, 2, -1}, {2, 1, -1}, {2, 2, last}};
  Matrix a(3, 3);
  a.setFromTriplets(entries.begin(), entries.end());
  return a;
}

bool is_ones(const Eigen::VectorXd& x) {
  return (x - Eigen::VectorXd::Ones(3)).norm() < 1e-13;
}

template <class Matrix>
bool solves() {
  const Matrix a = tiny<Matrix>(4);
  const Eigen::VectorXd b = a * Eigen::VectorXd::Ones(3);
  mfs::MfsLU<Matrix> lu(a);
  const Eigen::VectorXd x = lu.solve(b);
  std::printf("x = %g %g %g\n", x[0], x[1], x[2]);
  Eigen::BiCGSTAB<Matrix, mfs::MfsLU<Matrix>> preconditioned(a);
  return lu.info() == Eigen::Success && is_ones(x) && is_ones(preconditioned.solve(b)) &&
         preconditioned.iterations() <= 1;
}

}  // namespace

int main() {
  using ByColumns = Eigen::SparseMatrix<double>;
  if (!solves<ByColumns>() || !solves<Eigen::SparseMatrix<double, Eigen::RowMajor, long>>()) return 1;
  ByColumns zero = tiny<ByColumns>(4);
  zero.coeffs().setZero();
  const mfs::MfsLU<ByColumns> lu(zero);
  std::printf("%s\n", lu.lastErrorMessage().c_str());
  return lu.info() == Eigen::NumericalIssue ? 0 : 2;
}
