// Newton's method of NOX with MFS, chosen by parameter list.
//
// Bratu's problem -lap(u) = lambda exp(u) on a square, u = 0 at its border, by five-point differences: lambda
// is raised in steps, each started from the solution before. Stratimikos makes the linear solver named by
// "Linear Solver Type"; one symbolic factorization serves all Newton steps of all lambdas.
//
// An error of the linear solver (a singular Jacobian: --grid=1 --lambda=48) is a failed step, not the end of
// the program: NOX' "Catch Throws During Solve". Exit codes: 0 converged, 1 failed.
#include <Thyra_MFS_Stratimikos.hpp>

#include <cmath>
#include <iostream>

#include <NOX.H>
#include <NOX_Thyra.H>
#include <Teuchos_CommandLineProcessor.hpp>
#include <Thyra_StateFuncModelEvaluatorBase.hpp>
#include <Thyra_TpetraThyraWrappers.hpp>
#include <Tpetra_Core.hpp>

namespace {

using Teuchos::RCP;
using Teuchos::rcp;
using Matrix = Tpetra::CrsMatrix<double>;
using Vector = Tpetra::Vector<double>;
using Map = Tpetra::Map<>;
using Ordinal = Map::global_ordinal_type;
using Evaluator = Thyra::ModelEvaluatorBase;
using Convert = Thyra::TpetraOperatorVectorExtraction<double>;

/// F(u) = L u - lambda h^2 exp(u) and its Jacobian L - diag(lambda h^2 exp(u)), L = h^2 times minus the
/// Laplacian.
class Bratu : public Thyra::StateFuncModelEvaluatorBase<double> {
 public:
  Bratu(int n, RCP<const Thyra::LinearOpWithSolveFactoryBase<double>> solver_factory)
      : h_squared_(1.0 / ((n + 1.0) * (n + 1.0))),
        laplacian_(make_laplacian(n)),
        space_(Thyra::createVectorSpace<double>(laplacian_->getRowMap())),
        solver_factory_(std::move(solver_factory)) {}

  void set_lambda(double lambda) { lambda_ = lambda; }
  RCP<Thyra::VectorBase<double>> zero() const {
    const auto u = Thyra::createMember(space_);
    Thyra::assign(u.ptr(), 0.0);
    return u;
  }

  RCP<const Thyra::VectorSpaceBase<double>> get_x_space() const override { return space_; }
  RCP<const Thyra::VectorSpaceBase<double>> get_f_space() const override { return space_; }
  RCP<const Thyra::LinearOpWithSolveFactoryBase<double>> get_W_factory() const override {
    return solver_factory_;
  }
  RCP<Thyra::LinearOpBase<double>> create_W_op() const override {
    const RCP<Tpetra::Operator<double>> jacobian = rcp(new Matrix(*laplacian_, Teuchos::Copy));
    return Thyra::createLinearOp(jacobian, space_, space_);
  }
  Evaluator::InArgs<double> createInArgs() const override {
    Evaluator::InArgsSetup<double> arguments;
    arguments.setModelEvalDescription("Bratu");
    arguments.setSupports(Evaluator::IN_ARG_x);
    return arguments;
  }
  Evaluator::InArgs<double> getNominalValues() const override {
    auto arguments = createInArgs();
    arguments.set_x(zero());
    return arguments;
  }

 private:
  Evaluator::OutArgs<double> createOutArgsImpl() const override {
    Evaluator::OutArgsSetup<double> arguments;
    arguments.setModelEvalDescription("Bratu");
    arguments.setSupports(Evaluator::OUT_ARG_f);
    arguments.setSupports(Evaluator::OUT_ARG_W_op);
    return arguments;
  }

  void evalModelImpl(const Evaluator::InArgs<double>& in,
                     const Evaluator::OutArgs<double>& out) const override {
    const RCP<const Vector> u = Convert::getConstTpetraVector(in.get_x());
    Vector reaction(laplacian_->getRowMap());
    {
      const auto from = u->getLocalViewHost(Tpetra::Access::ReadOnly);
      const auto to = reaction.getLocalViewHost(Tpetra::Access::OverwriteAll);
      for (std::size_t i = 0; i < from.extent(0); ++i) to(i, 0) = lambda_ * h_squared_ * std::exp(from(i, 0));
    }
    if (!out.get_f().is_null()) {
      const RCP<Vector> f = Convert::getTpetraVector(out.get_f());
      laplacian_->apply(*u, *f);
      f->update(-1.0, reaction, 1.0);
    }
    if (!out.get_W_op().is_null()) {
      const auto jacobian =
          Teuchos::rcp_dynamic_cast<Matrix>(Convert::getTpetraOperator(out.get_W_op()), true);
      jacobian->resumeFill();
      const auto from = laplacian_->getLocalMatrixHost();
      const auto r = reaction.getLocalViewHost(Tpetra::Access::ReadOnly);
      for (int row = 0; row < from.numRows(); ++row) {
        const auto entries = from.rowConst(row);
        for (int k = 0; k < entries.length; ++k) {
          const bool diagonal = laplacian_->getColMap()->getGlobalElement(entries.colidx(k)) ==
                                laplacian_->getRowMap()->getGlobalElement(row);
          const double value = entries.value(k) - (diagonal ? r(row, 0) : 0.0);
          jacobian->replaceLocalValues(row, Teuchos::tuple<int>(entries.colidx(k)), Teuchos::tuple(value));
        }
      }
      jacobian->fillComplete();
    }
  }

  static RCP<const Matrix> make_laplacian(int n) {
    const auto map = rcp(new Map(static_cast<Tpetra::global_size_t>(n) * n, 0, Tpetra::getDefaultComm()));
    const auto a = rcp(new Matrix(map, 5));
    for (std::size_t local = 0; local < map->getMyGlobalIndices().extent(0); ++local) {
      const Ordinal row = map->getGlobalElement(static_cast<int>(local)), x = row % n, y = row / n;
      const auto insert = [&](bool inside, Ordinal column, double value) {
        if (inside) a->insertGlobalValues(row, Teuchos::tuple(column), Teuchos::tuple(value));
      };
      insert(y > 0, row - n, -1.0);
      insert(x > 0, row - 1, -1.0);
      insert(true, row, 4.0);
      insert(x < n - 1, row + 1, -1.0);
      insert(y < n - 1, row + n, -1.0);
    }
    a->fillComplete();
    return a;
  }

  double lambda_ = 1.0, h_squared_;
  RCP<const Matrix> laplacian_;
  RCP<const Thyra::VectorSpaceBase<double>> space_;
  RCP<const Thyra::LinearOpWithSolveFactoryBase<double>> solver_factory_;
};

RCP<Thyra::LinearOpWithSolveFactoryBase<double>> linear_solver(const std::string& type) {
  Stratimikos::DefaultLinearSolverBuilder builder;
  Thyra::enableMFS(builder);
  const auto parameters = Teuchos::parameterList();
  parameters->set("Linear Solver Type", type);
  parameters->set("Preconditioner Type", "None");
  if (type == "MFS") parameters->sublist("Linear Solver Types").sublist("MFS").set("Tolerance", 1e-12);
  builder.setParameterList(parameters);
  return builder.createLinearSolveStrategy("");
}

RCP<Teuchos::ParameterList> newton_parameters() {
  const auto parameters = Teuchos::parameterList();
  parameters->set("Nonlinear Solver", "Line Search Based");
  parameters->sublist("Direction").set("Method", "Newton");
  parameters->sublist("Line Search").set("Method", "Full Step");
  parameters->sublist("Printing").set("Output Information", 0);
  parameters->sublist("Solver Options").set("Status Test Check Type", "Complete");
  // Errors of the linear solver become a failed solve, with which an integrator can cut its step.
  parameters->set("Catch Throws During Solve", true);
  return parameters;
}

RCP<NOX::StatusTest::Generic> newton_test() {
  const auto test = rcp(new NOX::StatusTest::Combo(NOX::StatusTest::Combo::OR));
  test->addStatusTest(rcp(new NOX::StatusTest::NormF(1e-12)));
  test->addStatusTest(rcp(new NOX::StatusTest::MaxIters(20)));
  test->addStatusTest(rcp(new NOX::StatusTest::FiniteValue()));
  return test;
}

/// Symbolic and numeric factorizations so far. Asking for the Jacobian factors it at the solution.
/// Collective.
std::string factorizations(const NOX::Solver::Generic& solver) {
  const auto& group = dynamic_cast<const NOX::Thyra::Group&>(solver.getSolutionGroup());
  const auto jacobian = Teuchos::rcp_dynamic_cast<Thyra::Amesos2LinearOpWithSolve<double>>(
      const_cast<NOX::Thyra::Group&>(group).getNonconstJacobian());
  if (jacobian.is_null() || jacobian->get_amesos2Solver().is_null()) return "";
  const auto& status = jacobian->get_amesos2Solver()->getStatus();
  return std::to_string(status.getNumSymbolicFact()) + " symbolic, " +
         std::to_string(status.getNumNumericFact()) +
         " numeric factorizations, the last one of the Jacobian at the solution";
}

int run(int argc, char** argv) {
  int grid = 30;
  double lambda = 6.0;
  std::string type = "MFS";
  Teuchos::CommandLineProcessor line(false, true, true);
  line.setOption("grid", &grid, "unknowns per side");
  line.setOption("lambda", &lambda, "last lambda");
  line.setOption("solver", &type, "linear solver of Stratimikos");
  if (line.parse(argc, argv) != Teuchos::CommandLineProcessor::PARSE_SUCCESSFUL) return 2;

  const auto model = rcp(new Bratu(grid, linear_solver(type)));
  const auto group = rcp(new NOX::Thyra::Group(NOX::Thyra::Vector(model->zero()), model));
  const auto solver = NOX::Solver::buildSolver(group, newton_test(), newton_parameters());
  const bool talks = Tpetra::getDefaultComm()->getRank() == 0;
  constexpr int kSteps = 3;
  for (int step = 1; step <= kSteps; ++step) {
    model->set_lambda(lambda * step / kSteps);
    solver->reset(solver->getSolutionGroup().getX());
    const bool converged = solver->solve() == NOX::StatusTest::Converged;
    const double largest = solver->getSolutionGroup().getX().norm(NOX::Abstract::Vector::MaxNorm);
    if (talks)
      std::cout << "lambda " << lambda * step / kSteps << ": " << solver->getNumIterations()
                << " Newton iterations, " << (converged ? "converged" : "failed step")
                << ", |u| = " << largest << "\n";
    if (!converged) return 1;
  }
  const std::string count = factorizations(*solver);
  if (talks) std::cout << count << "\n";
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Tpetra::ScopeGuard scope(&argc, &argv);
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    std::cerr << "nox_bratu: " << e.what() << "\n";
    return 1;
  }
}
