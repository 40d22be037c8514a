#include "dae/integrator/newton.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <NOX.H>
#include <NOX_Thyra.H>
#include <Teuchos_DefaultSerialComm.hpp>
#include <Teuchos_oblackholestream.hpp>
#include <Thyra_StateFuncModelEvaluatorBase.hpp>
#include <Thyra_TpetraThyraWrappers.hpp>
#include <Thyra_VectorStdOps.hpp>
#include <Tpetra_CrsMatrix.hpp>

#include <mfs/error.hpp>

#include "dae/integrator/condensed_newton.hpp"
#include "dae/integrator/executor_vector.hpp"
#include "dae/integrator/initial_conditions.hpp"
#include "dae/integrator/kept_factors.hpp"
#include "dae/integrator/newton_norms.hpp"
#include "dae/integrator/newton_progress.hpp"
#include "dae/mechanics/turning_bodies.hpp"
#include "dae/vectors/host_loops.hpp"
#include "ordering/stopwatch.hpp"

namespace mfs::dae {
namespace {

using Teuchos::RCP;
using Teuchos::rcp;
using Matrix = Tpetra::CrsMatrix<double>;
using Map = Tpetra::Map<>;
using Evaluator = Thyra::ModelEvaluatorBase;

/// A correction, in units of the local error allowed, that may be rounding.
constexpr double kRounding = 1e-4;
/// A rate that is expected of a kept matrix becomes less by this each time that a new one is taken because
/// of it, until one is kept again and shows what it is.
constexpr double kForgotten = 0.7;
/// q_by_a of the kept matrix / q_by_a: between these its factors still are a preconditioner.
constexpr double kRelatedRates[] = {0.25, 4.0};

/// An array of Kokkos that holds f(0), f(1) ..., each written first by the thread that will use it.
template <class View, class F>
View make_view(const std::string& label, std::size_t length, int threads, const F& f) {
  const View view(Kokkos::view_alloc(Kokkos::WithoutInitializing, label), length);
  const auto on_host = Kokkos::create_mirror_view(view);
  parallel_for(length, threads, [&](std::size_t i) { on_host(i) = f(i); });
  Kokkos::deep_copy(view, on_host);
  return view;
}

/// All zero. The matrix takes these arrays as they are: given any others, it would copy them by one thread.
RCP<Matrix> make_matrix(const Pattern& pattern, int threads) {
  using Graph = Matrix::local_graph_device_type;
  const RCP<const Teuchos::Comm<int>> comm = rcp(new Teuchos::SerialComm<int>());
  const auto map = rcp(new Map(static_cast<Tpetra::global_size_t>(pattern.rows), 0, comm));
  const auto offsets = make_view<Graph::row_map_type::non_const_type>(
      "row starts", pattern.row_start.size(), threads, [&](std::size_t i) { return pattern.row_start[i]; });
  const auto columns = make_view<Graph::entries_type::non_const_type>(
      "columns", pattern.entries(), threads, [&](std::size_t k) { return pattern.column[k]; });
  const auto values = make_view<Matrix::local_matrix_device_type::values_type>(
      "values", pattern.entries(), threads, [](std::size_t) { return 0.0; });
  const auto matrix = rcp(new Matrix(map, map, offsets, columns, values));
  // Nothing is to be sorted, merged or renumbered: fillComplete would take as long as several factorizations.
  matrix->expertStaticFillComplete(map, map);
  return matrix;
}

/// The problem that NOX sees, at one time.
class StepModel : public Thyra::StateFuncModelEvaluatorBase<double> {
 public:
  StepModel(const StepEquations& equations, RCP<const Thyra::LinearOpWithSolveFactoryBase<double>> solver,
            LinearSolves& solves, IntegrationReport& report, const Executor& executor)
      : equations_(equations),
        matrix_(make_matrix(equations.pattern(), executor.threads())),
        space_(Thyra::tpetraVectorSpace<double>(matrix_->getRowMap())),
        solver_(std::move(solver)),
        solves_(solves),
        report_(report),
        executor_(executor) {}

  void set_relation(const StepRelation& relation) { relation_ = &relation; }
  /// The next Jacobian that NOX asks for is evaluated; otherwise the old one stays.
  void want_jacobian() { wanted_ = true; }

  RCP<ExecutorVector> make_vector() const {
    const auto x = rcp(new ExecutorVector(space_, executor_));
    x->assign(0.0);
    return x;
  }
  /// x of the prediction, in the one array for it.
  RCP<Thyra::VectorBase<double>> predicted(const Array<double>& lambda) {
    if (predicted_.is_null()) predicted_ = make_vector();
    equations_.pack(*relation_, lambda.data(), predicted_->data());
    return predicted_;
  }
  void evaluate_jacobian(const StepState& state, const StepRelation& relation) const {
    equations_.jacobian(state, relation, matrix_values());
    jacobian_time_ = state.t;
    solves_.new_matrix = true;
    ++report_.jacobians;
  }
  /// The matrix for initial accelerations takes the place of the Jacobian.
  void evaluate_initial() {
    equations_.initial_jacobian(matrix_values());
    solves_.new_matrix = true;
  }
  /// Of the last Jacobian.
  double jacobian_time() const { return jacobian_time_; }
  /// Of the matrix that NOX and the solver know.
  double* matrix_values() const { return matrix_->getLocalMatrixHost().values.data(); }
  /// Where H was evaluated last: once NOX has given an iterate to be tested, that iterate.
  const StepState& state() const { return state_; }
  /// Gives it away for another one, whose arrays are used again.
  void exchange_state(StepState& other) { std::swap(state_, other); }

  RCP<const Thyra::VectorSpaceBase<double>> get_x_space() const override { return space_; }
  RCP<const Thyra::VectorSpaceBase<double>> get_f_space() const override { return space_; }
  RCP<const Thyra::LinearOpWithSolveFactoryBase<double>> get_W_factory() const override { return solver_; }
  RCP<Thyra::LinearOpBase<double>> create_W_op() const override {
    const RCP<Tpetra::Operator<double>> jacobian = matrix_;
    return Thyra::createLinearOp<double>(jacobian, space_, space_);
  }
  Evaluator::InArgs<double> createInArgs() const override {
    Evaluator::InArgsSetup<double> arguments;
    arguments.setModelEvalDescription("step");
    arguments.setSupports(Evaluator::IN_ARG_x);
    return arguments;
  }
  Evaluator::InArgs<double> getNominalValues() const override {
    auto arguments = createInArgs();
    arguments.set_x(make_vector());
    return arguments;
  }

 private:
  Evaluator::OutArgs<double> createOutArgsImpl() const override {
    Evaluator::OutArgsSetup<double> arguments;
    arguments.setModelEvalDescription("step");
    arguments.setSupports(Evaluator::OUT_ARG_f);
    arguments.setSupports(Evaluator::OUT_ARG_W_op);
    return arguments;
  }

  void evalModelImpl(const Evaluator::InArgs<double>& in,
                     const Evaluator::OutArgs<double>& out) const override {
    const bool jacobian = !out.get_W_op().is_null() && wanted_;
    if (out.get_f().is_null() && !jacobian) return;
    const Stopwatch watch;
    try {
      equations_.unpack(ExecutorVector::of(*in.get_x()).data(), *relation_, state_);
      if (!out.get_f().is_null())
        equations_.residual(ExecutorVector::of(*in.get_x()).data(), state_, *relation_,
                            ExecutorVector::of(*out.get_f()).data());
      if (jacobian) {
        evaluate_jacobian(state_, *relation_);
        wanted_ = false;
      }
    } catch (...) {
      // NOX does not survive what an evaluation throws (its group goes on asking for the Jacobian, and its
      // solver for a norm): a residual that is no number ends the search, a missing Jacobian is thrown when
      // the solver is to take it.
      solves_.failure = std::current_exception();
      if (!out.get_f().is_null()) spoil(*out.get_f());
    }
    report_.time_assembly += watch.seconds();
  }

  /// Makes it no number. Where the device fails even here, the failure that was noted ends the search.
  static void spoil(Thyra::VectorBase<double>& f) {
    try {
      Thyra::assign(Teuchos::ptrFromRef(f), std::numeric_limits<double>::quiet_NaN());
    } catch (const Error&) {
    }
  }

  const StepEquations& equations_;
  RCP<Matrix> matrix_;
  RCP<const ExecutorVector::Space> space_;
  RCP<const Thyra::LinearOpWithSolveFactoryBase<double>> solver_;
  LinearSolves& solves_;
  IntegrationReport& report_;
  const Executor& executor_;
  RCP<ExecutorVector> predicted_;
  const StepRelation* relation_ = nullptr;
  // Evaluation is const for Thyra.
  mutable StepState state_;
  mutable bool wanted_ = true;
  mutable double jacobian_time_ = 0.0;
};

/// Ends the search, or asks for a new Jacobian.
class NewtonTest : public NOX::StatusTest::Generic {
 public:
  NewtonTest(const StepEquations& equations, StepModel& model, const IntegratorOptions& options,
             const Executor& executor)
      : equations_(equations),
        model_(model),
        executor_(executor),
        progress_(options, executor, kRounding, CondensedNewton::is_of_joints(equations.system())) {}

  /// Before a search; as NewtonProgress::start.
  void start(const Array<double>& weights, const StepRelation& relation, bool fresh, double rate) {
    weights_ = &weights;
    progress_.start(relation, fresh, rate);
  }

  NOX::StatusTest::StatusType checkStatus(const NOX::Solver::Generic& solver,
                                          NOX::StatusTest::CheckType /*type*/) override {
    const auto& residual = dynamic_cast<const NOX::Thyra::Vector&>(solver.getSolutionGroup().getF());
    const double* const h = ExecutorVector::of(residual.getThyraVector()).data();
    const NewtonNorms norms = newton_norms(executor_, equations_, h, model_.state(), *weights_, before_);
    const auto verdict = progress_.judge(norms, solver.getNumIterations());
    if (progress_.wants_jacobian()) model_.want_jacobian();
    return status_ = verdict == NewtonProgress::Verdict::go_on       ? NOX::StatusTest::Unconverged
                     : verdict == NewtonProgress::Verdict::converged ? NOX::StatusTest::Converged
                                                                     : NOX::StatusTest::Failed;
  }
  NOX::StatusTest::StatusType getStatus() const override { return status_; }
  std::ostream& print(std::ostream& stream, int /*indent*/) const override { return stream; }

  const NewtonProgress& progress() const { return progress_; }

 private:
  const StepEquations& equations_;
  StepModel& model_;
  const Executor& executor_;
  const Array<double>* weights_ = nullptr;
  Array<double> before_;  ///< [q, v, F] before the last correction
  NOX::StatusTest::StatusType status_ = NOX::StatusTest::Unevaluated;
  NewtonProgress progress_;
};

RCP<Teuchos::ParameterList> newton_parameters() {
  const auto parameters = Teuchos::parameterList();
  parameters->set("Nonlinear Solver", "Line Search Based");
  parameters->sublist("Direction").set("Method", "Newton");
  parameters->sublist("Line Search").set("Method", "Full Step");
  const RCP<std::ostream> nowhere = rcp(new Teuchos::oblackholestream());
  parameters->sublist("Printing").set("Output Information", 0);
  parameters->sublist("Printing").set("Output Stream", nowhere);
  parameters->sublist("Printing").set("Error Stream", nowhere);
  parameters->sublist("Solver Options").set("Status Test Check Type", "Complete");
  parameters->set("Catch Throws During Solve", true);
  return parameters;
}

}  // namespace

class Newton::Impl {
 public:
  Impl(const StepEquations& equations, const IntegratorOptions& options, const Executor& executor,
       IntegrationReport& report)
      : equations_(equations),
        options_(options),
        report_(report),
        has_meshes_(!turning_bodies_of(equations.system()).empty()),
        model_(rcp(new StepModel(equations, make_kept_factors(options, executor, solves_), solves_, report,
                                 executor))),
        test_(rcp(new NewtonTest(equations, *model_, options, executor))) {
    solves_.correct = [this](const double* solution, double* x) {
      equations_.correct(*relation_, solution, x);
    };
    solves_.remote_matrix = equations.remote_matrix();
    solves_.bring_values = [this] { equations_.remote_matrix()->read(model_->matrix_values()); };
  }

  // The first matrix is what ordering, matching and scales are made for. By the initial one alone, where
  // nothing is stiff, the inertia of a light rigid body may be rounding to a matrix of later steps.
  void find_accelerations(StepState& state, double h) {
    const Stopwatch watch;
    StepRelation some_step;
    some_step.v_by_a = some_step.q_by_v = h;
    equations_.set_directions(view(state));
    model_->evaluate_jacobian(state, some_step);
    report_.time_assembly += watch.seconds();
    const auto op = model_->get_W_factory()->createOp();
    const auto factor = [&] {
      Thyra::initializeOp<double>(*model_->get_W_factory(), model_->create_W_op(), op.ptr());
    };
    const auto name = [this](int unknown) { return equations_.unknown_name(unknown); };
    naming_start(name, factor);
    const StepRelation no_time;
    relation_ = &no_time;
    model_->evaluate_initial();
    solves_.right_side = [&](const double*, double* b) { equations_.initial_right_side(state, b); };
    const auto x = model_->make_vector(), nothing = model_->make_vector();
    naming_start(name, [&] {
      factor();
      Thyra::solve<double>(*op, Thyra::NOTRANS, *nothing, x.ptr());
    });
    equations_.change_accelerations(x->data(), state);
    account();
  }

  NewtonOutcome solve(const StepRelation& relation, const Array<double>& lambda, const Array<double>& weights,
                      StepState& state) {
    relation_ = &relation;
    model_->set_relation(relation);
    solves_.right_side = [this](const double* h, double* b) { equations_.scale_rows(*relation_, h, b); };
    NewtonOutcome outcome;
    if (!set_directions(outcome)) return outcome;
    const bool fresh = choose_matrix();
    const double age = age_of_jacobian();
    bool converged = search(lambda, weights, fresh, outcome);
    if (const double rate = std::min(test_->progress().kept_rate(), 1.0); rate > 0.0 && age > 0.0)
      ageing_ = std::max(rate - expected_rate_, 0.0) / age;
    if (!converged && !(fresh && solves_.factor_next)) {
      model_->want_jacobian();
      solves_.factor_next = true;
      converged = search(lambda, weights, true, outcome);
    }
    outcome.converged = converged;
    if (converged) model_->exchange_state(state);
    account();
    return outcome;
  }

  bool filter_error(const StepState& state, Array<double>& e) {
    if (!solves_.factored || equations_.all_prescribed()) return false;
    solves_.right_side = [&](const double*, double* b) {
      const Stopwatch watch;
      equations_.error_right_side(state, *relation_, e, b);
      report_.time_assembly += watch.seconds();
    };
    if (filtered_.is_null()) filtered_ = model_->make_vector();
    bool solved = true;
    try {
      const auto op = model_->get_W_factory()->createOp();
      Thyra::initializeOp<double>(*model_->get_W_factory(), model_->create_W_op(), op.ptr());
      Thyra::solve<double>(*op, Thyra::NOTRANS, *filtered_, filtered_.ptr());
    } catch (...) {  // the step is rejected, as it would be without this
      solved = false;
    }
    account();
    if (solved) equations_.take_velocities(*relation_, filtered_->data(), e.data());
    return solved;
  }

 private:
  /// Those of the prediction. False: there are none.
  bool set_directions(NewtonOutcome& outcome) const {
    const Stopwatch watch;
    try {
      equations_.set_directions(
          {relation_->t, relation_->q.data(), relation_->v.data(), relation_->a.data()});
    } catch (...) {
      outcome.thrown = std::current_exception();
    }
    report_.time_assembly += watch.seconds();
    return outcome.thrown == nullptr;
  }

  /// Whether the search begins with a new Jacobian; says what may be done with it. Where mechanisms turn a
  /// kept one gets worse with time, and a search that has to renew it on the way has made two corrections in
  /// vain. Without meshes these cost next to nothing.
  bool choose_matrix() {
    const double ratio = equations_.ratio(*relation_);
    // Where nothing is integrated the local error does not tell how exact multipliers are.
    const bool known = solves_.factored && options_.keep_factors && !equations_.all_prescribed();
    solves_.factor_next =
        !known || options_.krylov_steps == 0 || ratio < kRelatedRates[0] || ratio > kRelatedRates[1];
    expected_rate_ = std::abs(ratio - 1.0) / (ratio + 1.0);
    const bool too_old = has_meshes_ && ageing_ * age_of_jacobian() > kSlow;
    if (too_old) ageing_ *= kForgotten;
    const bool fresh = !known || too_old || ratio < kKeptRates[0] || ratio > kKeptRates[1];
    if (fresh) model_->want_jacobian();
    return fresh;
  }

  /// A step that is tried again ends before the Jacobian of the last attempt.
  double age_of_jacobian() const { return std::abs(relation_->t - model_->jacobian_time()); }

  bool search(const Array<double>& lambda, const Array<double>& weights, bool fresh, NewtonOutcome& outcome) {
    solves_.failure = nullptr;
    test_->start(weights, *relation_, fresh, expected_rate_);
    const NOX::Thyra::Vector start(model_->predicted(lambda));
    if (solver_.is_null())
      solver_ =
          NOX::Solver::buildSolver(rcp(new NOX::Thyra::Group(start, model_)), test_, newton_parameters());
    else
      solver_->reset(start);
    const auto status = solver_->solve();
    outcome.iterations += solver_->getNumIterations();
    outcome.thrown = solves_.failure;
    outcome.residual = test_->progress().norms().residual;
    outcome.violation = test_->progress().norms().violation;
    return status == NOX::StatusTest::Converged && solves_.failure == nullptr;
  }

  /// Adds what the linear solver has done since the last time to the report.
  void account() {
    const auto add = [](auto& sum, auto value, auto& accounted) {
      sum += value - accounted;
      accounted = value;
    };
    add(report_.factorizations, solves_.factorizations, accounted_.factorizations);
    add(report_.analyses, solves_.analyses, accounted_.analyses);
    add(report_.krylov_solves, solves_.krylov_solves, accounted_.krylov_solves);
    add(report_.time_analysis, solves_.time_analysis, accounted_.time_analysis);
    add(report_.time_factor, solves_.time_factor, accounted_.time_factor);
    add(report_.time_solve, solves_.time_solve, accounted_.time_solve);
    report_.bytes_solver = std::max(report_.bytes_solver, solves_.bytes);
  }

  const StepEquations& equations_;
  const IntegratorOptions& options_;
  IntegrationReport& report_;
  const StepRelation* relation_ = nullptr;
  LinearSolves solves_, accounted_;
  double expected_rate_ = 0.0;  ///< at which corrections by a kept matrix shrink, because of the step alone
  double ageing_ = 0.0;         ///< what its age adds to that, per time
  bool has_meshes_;
  RCP<StepModel> model_;
  RCP<NewtonTest> test_;
  RCP<NOX::Solver::Generic> solver_;
  RCP<ExecutorVector> filtered_;  ///< an error, as a correction of x
};

std::string NewtonOutcome::failure() const {
  if (!thrown) return "Newton's method does not converge";
  try {
    std::rethrow_exception(thrown);
  } catch (const std::exception& e) {
    return e.what();
  } catch (...) {
    return "an unknown exception";
  }
}

void NewtonOutcome::tell(StepReport& line, IntegrationReport& report) const {
  line.residual = residual;
  for (std::size_t level = 0; level < violation.size(); ++level) {
    line.violation[level] = violation[level];
    report.violation[level] = std::max(report.violation[level], violation[level]);
  }
}

Newton::Newton(const StepEquations& equations, const IntegratorOptions& options, const Executor& executor,
               IntegrationReport& report)
    : impl_(std::make_unique<Impl>(equations, options, executor, report)) {}
Newton::~Newton() = default;

void Newton::find_accelerations(StepState& state, double h) {
  impl_->find_accelerations(state, h);
}

bool Newton::filter_error(const StepState& state, Array<double>& e) {
  return impl_->filter_error(state, e);
}

NewtonOutcome Newton::solve(const StepRelation& relation, const Array<double>& lambda,
                            const Array<double>& weights, StepState& state) {
  return impl_->solve(relation, lambda, weights, state);
}

}  // namespace mfs::dae
