// Where a device's products with inverses of pivot blocks lose too much, the host solves. Needs a device;
// skips where there is none.
#include <string>

#include "test/adversarial/engineering_matrices.hpp"
#include "test/reference/random.hpp"
#include "test/solver/on_device.hpp"

namespace mfs::test {
namespace {

constexpr double kTolerance = 1e-12;

class HostRung : public OnDevice {
 protected:
  static void expect_solves(Solver& solver, const SparseMatrix& a, std::int64_t columns, Rung rung) {
    SCOPED_TRACE(std::to_string(columns) + " columns");
    const std::vector<double> b = Random(9).vector(a.n * columns);
    for (const bool transposed : {false, true}) {  // A is symmetric
      std::vector<double> x(b.size());
      transposed ? solver.solve_transpose(b.data(), x.data(), columns)
                 : solver.solve(b.data(), x.data(), columns);
      for (std::int64_t j = 0; j < columns; ++j)
        EXPECT_LE(backward_error(a, b.data() + j * a.n, x.data() + j * a.n), kTolerance);
      EXPECT_EQ(solver.report().rung, rung);
    }
  }
};

TEST_F(HostRung, SolvesWhereInversesDoNot) {
  SparseMatrix a = curl_curl(16, 1e-12);
  const std::vector<double> b = Random(11).vector(a.n);
  Solver solver(options_);
  solver.factor(a.view());
  expect_solves(solver, a, 1, Rung::host);
  expect_solves(solver, a, 3, Rung::host);
  for (double& value : a.values) value *= -3;
  solver.refactor(a.view());
  for (const bool transposed : {false, true}) {  // by the device or by the host
    std::vector<double> x(b.size());
    transposed ? solver.solve_transpose(b.data(), x.data()) : solver.solve(b.data(), x.data());
    EXPECT_LE(backward_error(a, b, x), kTolerance);
  }
  EXPECT_EQ(solver.report().backend, Backend::cuda);
}

TEST_F(HostRung, EndsWithTheAnalysis) {
  Solver solver(options_);
  const SparseMatrix a = curl_curl(16, 1e-12), mild = curl_curl(16, 1);
  solver.factor(a.view());
  expect_solves(solver, a, 1, Rung::host);
  solver.analyze(mild.view());
  solver.factor(mild.view());
  expect_solves(solver, mild, 1, Rung::factors);
  solver.analyze(a.view());
  solver.factor(a.view());
  expect_solves(solver, a, 1, Rung::host);
}

TEST_F(HostRung, ProvesSingular) {
  const SparseMatrix a = curl_curl(12, 0);
  Solver solver(options_);
  solver.factor(a.view());
  const std::vector<double> b = Random(10).vector(a.n);
  std::vector<double> x(b.size());
  try {
    solver.solve(b.data(), x.data());
    ADD_FAILURE() << "not refused";
  } catch (const SingularMatrix& error) {
    EXPECT_EQ(error.kind(), SingularMatrix::Kind::numerical);
  }
}

}  // namespace
}  // namespace mfs::test
