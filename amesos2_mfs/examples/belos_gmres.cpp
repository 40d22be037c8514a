// GMRES with MFS as exact preconditioner of a nearby matrix: the lagged Jacobian.
//
// A convection grows in time. GMRES solves each step's system; its preconditioner is MFS's factorization of
// an earlier step's matrix. Only when that has become too old (more than --limit iterations) is it made
// again, and then on the same pattern: one symbolic factorization serves the whole run. Exit codes: 0 every
// step converged, 1 one did not.
#include <Amesos2_MFS.hpp>

#include <cmath>
#include <iomanip>
#include <iostream>

#include <BelosLinearProblem.hpp>
#include <BelosPseudoBlockGmresSolMgr.hpp>
#include <BelosTpetraAdapter.hpp>
#include <Teuchos_CommandLineProcessor.hpp>
#include <Tpetra_Core.hpp>

namespace {

using Teuchos::RCP;
using Teuchos::rcp;
using Matrix = Tpetra::CrsMatrix<double>;
using Vector = Tpetra::MultiVector<double>;
using Operator = Tpetra::Operator<double>;
using Map = Tpetra::Map<>;
using Ordinal = Map::global_ordinal_type;
using Solver = Amesos2::Solver<Matrix, Vector>;

/// y = M^-1 x for a matrix M that Amesos2 has factored.
class Inverse : public Operator {
 public:
  Inverse(RCP<const Matrix> matrix, RCP<Solver> solver)
      : matrix_(std::move(matrix)), solver_(std::move(solver)) {}
  RCP<const Map> getDomainMap() const override { return matrix_->getRangeMap(); }
  RCP<const Map> getRangeMap() const override { return matrix_->getDomainMap(); }
  void apply(const Vector& x, Vector& y, Teuchos::ETransp mode, double alpha, double beta) const override {
    if (mode != Teuchos::NO_TRANS) throw std::invalid_argument("Inverse: no transpose");
    Vector solution(y.getMap(), y.getNumVectors());
    solver_->solve(&solution, &x);
    y.update(alpha, solution, beta);
  }

 private:
  RCP<const Matrix> matrix_;
  RCP<Solver> solver_;
};

/// Fills -lap(u) + wind (du/dx + du/dy) on a grid of n^2 unknowns into `a`; the pattern is always the same.
void fill(Matrix& a, int n, double wind) {
  const double c = wind / (2.0 * (n + 1));
  a.resumeFill();
  a.setAllToScalar(0.0);
  const auto map = a.getRowMap();
  for (std::size_t local = 0; local < map->getMyGlobalIndices().extent(0); ++local) {
    const Ordinal row = map->getGlobalElement(static_cast<int>(local)), x = row % n, y = row / n;
    const auto add = [&](bool inside, Ordinal column, double value) {
      if (inside) a.sumIntoGlobalValues(row, Teuchos::tuple(column), Teuchos::tuple(value));
    };
    add(true, row, 4.0);
    add(x > 0, row - 1, -1.0 - c);
    add(x < n - 1, row + 1, -1.0 + c);
    add(y > 0, row - n, -1.0 - c);
    add(y < n - 1, row + n, -1.0 + c);
  }
  a.fillComplete();
}

RCP<Matrix> make_matrix(int n) {
  const auto map = rcp(new Map(static_cast<Tpetra::global_size_t>(n) * n, 0, Tpetra::getDefaultComm()));
  const auto a = rcp(new Matrix(map, 5));
  for (std::size_t local = 0; local < map->getMyGlobalIndices().extent(0); ++local) {
    const Ordinal row = map->getGlobalElement(static_cast<int>(local)), x = row % n, y = row / n;
    const auto insert = [&](bool inside, Ordinal column) {
      if (inside) a->insertGlobalValues(row, Teuchos::tuple(column), Teuchos::tuple(0.0));
    };
    insert(y > 0, row - n);
    insert(x > 0, row - 1);
    insert(true, row);
    insert(x < n - 1, row + 1);
    insert(y < n - 1, row + n);
  }
  a->fillComplete();
  return a;
}

int run(int argc, char** argv) {
  int grid = 40, steps = 8, limit = 14;
  Teuchos::CommandLineProcessor line(false, true, true);
  line.setOption("grid", &grid, "unknowns per side");
  line.setOption("steps", &steps, "time steps");
  line.setOption("limit", &limit, "iterations above which the preconditioner is made again");
  if (line.parse(argc, argv) != Teuchos::CommandLineProcessor::PARSE_SUCCESSFUL) return 2;

  const RCP<Matrix> a = make_matrix(grid), lagged = make_matrix(grid);
  const auto x = rcp(new Vector(a->getDomainMap(), 1)), b = rcp(new Vector(a->getRangeMap(), 1));
  const auto solver = Amesos2::create<Matrix, Vector>("MFS", lagged);
  const auto inverse = rcp(new Inverse(lagged, solver));
  const bool talks = a->getComm()->getRank() == 0;
  const auto refresh = [&](double wind) {
    fill(*lagged, grid, wind);
    solver->numericFactorization();
  };
  refresh(0.0);

  const auto parameters = Teuchos::parameterList();
  parameters->set("Convergence Tolerance", 1e-12);
  parameters->set("Maximum Iterations", 100);
  parameters->set("Num Blocks", 100);
  for (int step = 0; step < steps; ++step) {
    const double wind = 1.0 * step;
    fill(*a, grid, wind);
    b->putScalar(1.0);
    x->putScalar(0.0);
    const auto problem = rcp(new Belos::LinearProblem<double, Vector, Operator>(a, x, b));
    problem->setRightPrec(inverse);
    problem->setProblem();
    Belos::PseudoBlockGmresSolMgr<double, Vector, Operator> gmres(problem, parameters);
    const bool converged = gmres.solve() == Belos::Converged;
    if (talks)
      std::cout << "step " << step << ": " << std::setw(2) << gmres.getNumIters() << " iterations, residual "
                << std::scientific << std::setprecision(1) << gmres.achievedTol()
                << (converged ? "" : " NOT CONVERGED") << "\n";
    if (!converged) return 1;
    if (gmres.getNumIters() > limit) refresh(wind);
  }
  if (talks)
    std::cout << steps << " systems, " << solver->getStatus().getNumSymbolicFact() << " symbolic and "
              << solver->getStatus().getNumNumericFact() << " numeric factorizations\n";
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Tpetra::ScopeGuard scope(&argc, &argv);
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    std::cerr << "belos_gmres: " << e.what() << "\n";
    return 1;
  }
}
