// Matrices with so many tiny pivots that a device divides by them: it substitutes with U and solves them
// itself, in one pass for each later factorization. Needs a device; skips where there is none.
#include <cmath>
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

/// Factorizations that a call of factor or refactor took, by the operations that were done.
double passes(const Solver& solver) {
  return solver.report().flops_used.total() / solver.report().flops.total();
}

TEST_F(HostRung, IsNotNeededWhereTinyPivotsAreDividedBy) {
  for (const double mass : {1e-10, 1e-12, 1e-14}) {
    SCOPED_TRACE(mass);
    SparseMatrix a = curl_curl(16, mass);
    const std::vector<double> b = Random(11).vector(a.n);
    Solver solver(options_);
    solver.factor(a.view());
    for (const std::int64_t columns : {1, 3, 16}) expect_solves(solver, a, columns, Rung::factors);
    for (int k = 0; k < 4; ++k) {
      for (double& value : a.values) value *= -1.25;
      solver.refactor(a.view());
      EXPECT_LT(passes(solver), 1.5);
      expect_solves(solver, a, 1, Rung::factors);
    }
  }
}

// Their solutions lose six digits where rows are exchanged, or where products with inverses of L come first:
// that is seen by the first solve, and the next one knows.
TEST_F(HostRung, DefiniteMatricesTakeOneStepOfRefinement) {
  Random random(21);
  for (const std::int64_t side : {40, 100, 200}) {
    SCOPED_TRACE(side);
    SparseMatrix a = penalties(side, 1e12, random);
    const std::vector<double> b = Random(9).vector(16 * a.n);
    std::vector<double> x(b.size());
    Solver solver(options_);
    solver.factor(a.view());
    solver.solve(b.data(), x.data());
    EXPECT_LE(backward_error(a, b.data(), x.data()), kTolerance);
    for (int k = 0; k < 3; ++k) {
      for (const std::int64_t columns : {1, 3, 16}) {
        for (const bool transposed : {false, true}) {
          transposed ? solver.solve_transpose(b.data(), x.data(), columns)
                     : solver.solve(b.data(), x.data(), columns);
          EXPECT_LE(solver.report().refinement_steps, 1);
          for (std::int64_t j = 0; j < columns; ++j)
            EXPECT_LE(backward_error(a, b.data() + j * a.n, x.data() + j * a.n), kTolerance);
        }
      }
      for (double& value : a.values) value *= 1.25;
      solver.refactor(a.view());
      EXPECT_LT(passes(solver), 1.5);
    }
  }
}

TEST_F(HostRung, SubstitutionEndsWithTheAnalysis) {
  Solver solver(options_);
  const SparseMatrix a = curl_curl(16, 1e-12), mild = curl_curl(16, 1);
  for (const SparseMatrix* matrix : {&a, &mild, &a}) {
    solver.analyze(matrix->view());
    solver.factor(matrix->view());
    expect_solves(solver, *matrix, 1, Rung::factors);
    const Determinant found = solver.determinant();  // pivots or their inverses
    Options on_host;
    Solver host(on_host);
    host.factor(matrix->view());
    EXPECT_NEAR(found.log_abs, host.determinant().log_abs, 1e-3 * std::abs(found.log_abs));
  }
}

bool solves(const Options& options, const SparseMatrix& a, Rung& rung) {
  const std::vector<double> b = Random(9).vector(a.n);
  std::vector<double> x(b.size());
  Solver solver(options);
  solver.factor(a.view());
  try {
    solver.solve(b.data(), x.data());
  } catch (const SingularMatrix&) {
    return false;
  }
  EXPECT_LE(backward_error(a, b, x), kTolerance);
  rung = solver.report().rung;
  return true;
}

// Near rounding steps by the device's factors get longer in some numberings, where those of the host reach
// the tolerance at once. Steps together prove that the matrix is regular all the same, and else the host is
// asked before singular is said.
TEST_F(HostRung, IsSeldomAskedWhereTheHostSolvesNearRounding) {
  int asked = 0, solved = 0;
  for (const double mass : {1e-14, 7e-15, 5e-15, 4e-15, 3e-15}) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      SCOPED_TRACE("mass " + std::to_string(1e15 * mass) + "e-15, seed " + std::to_string(seed));
      Random random(seed);
      const SparseMatrix a = renumbered(curl_curl(16, mass), random);
      Rung rung{};
      if (!solves(Options(), a, rung)) continue;
      ++solved;
      EXPECT_TRUE(solves(options_, a, rung));
      asked += rung == Rung::host;
    }
  }
  EXPECT_GT(solved, 5);
  EXPECT_LT(4 * asked, solved);
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
