#include "dae/integrator/kept_factors.hpp"

#include <Thyra_MFS_Stratimikos.hpp>

#include <string>
#include <utility>

#include <Thyra_DefaultInverseLinearOp.hpp>
#include <Thyra_DefaultPreconditioner.hpp>
#include <Thyra_LinearOpWithSolveFactoryHelpers.hpp>
#include <Thyra_TpetraThyraWrappers.hpp>
#include <Tpetra_CrsMatrix.hpp>
#include <mfs/version.hpp>

#include "dae/integrator/composition.hpp"
#include "dae/integrator/executor_vector.hpp"
#include "ordering/stopwatch.hpp"

namespace mfs::dae {
namespace {

using Teuchos::Ptr;
using Teuchos::RCP;
using Teuchos::rcp;
using Factory = Thyra::LinearOpWithSolveFactoryBase<double>;
using Source = Thyra::LinearOpSourceBase<double>;
using Vectors = Thyra::MultiVectorBase<double>;
using Matrix = Tpetra::CrsMatrix<double>;
using Convert = Thyra::TpetraOperatorVectorExtraction<double>;
using MfsSolver = Amesos2::MFS<Matrix, Tpetra::MultiVector<double>>;

/// Relative residual at which FGMRES stops. Rows of the matrix differ in size, so it has to be small.
constexpr double kKrylovTolerance = 1e-8;
/// Seconds that FGMRES takes for an entry of the matrix, by which it multiplies on one core of the host
/// (Debian's Trilinos).
constexpr double kSecondsPerMatrixEntry = 1.5e-9;

RCP<Factory> make_strategy(const std::string& type, const Teuchos::ParameterList& parameters) {
  Stratimikos::DefaultLinearSolverBuilder builder;
  Thyra::enableMFS(builder);
  const auto list = Teuchos::parameterList();
  list->set("Linear Solver Type", type);
  list->set("Preconditioner Type", "None");
  list->sublist("Linear Solver Types").sublist(type).setParameters(parameters);
  builder.setParameterList(list);
  return builder.createLinearSolveStrategy("");
}

RCP<Factory> make_mfs(const IntegratorOptions& options) {
  Teuchos::ParameterList parameters;
  parameters.set("Backend", std::string(backend_name(options.backend)));
  parameters.set("Threads", options.threads);
  parameters.set("AnalysisThreads", options.analysis_threads);
  parameters.set("RowFloor", kRowFloor);
  return make_strategy("MFS", parameters);
}

RCP<Factory> make_fgmres(const IntegratorOptions& options) {
  Teuchos::ParameterList parameters;
  parameters.set("Solver Type", "Block GMRES");
  auto& gmres = parameters.sublist("Solver Types").sublist("Block GMRES");
  gmres.set("Flexible Gmres", true);
  gmres.set("Maximum Iterations", options.krylov_steps);
  gmres.set("Num Blocks", options.krylov_steps);
  gmres.set("Convergence Tolerance", kKrylovTolerance);
  gmres.set("Verbosity", 0);
  parameters.sublist("VerboseObject").set("Verbosity Level", "none");
  return make_strategy("Belos", parameters);
}

class KeptSolve : public Thyra::LinearOpWithSolveBase<double> {
 public:
  KeptSolve(RCP<const Factory> direct, RCP<const Factory> krylov, const Executor& executor,
            LinearSolves& solves)
      : direct_(std::move(direct)),
        krylov_(std::move(krylov)),
        executor_(executor),
        factors_(direct_->createOp()),
        solves_(solves) {}

  void take(const RCP<const Source>& source) {
    source_ = source;
    if (solves_.failure != nullptr) std::rethrow_exception(solves_.failure);
    if (!solves_.new_matrix) return;
    solves_.new_matrix = false;
    if (iterating_) krylov_gain_ += krylov_budget_;  // it served the last matrix to the end
    iterating_ = solves_.factored && !solves_.factor_next && krylov_gain_ > -krylov_budget_ &&
                 krylov_spent_ + expected_steps() < krylov_budget_;
    ++matrices_;
    if (iterating_) {
      if (solves_.remote_matrix != nullptr) solves_.bring_values();
      const auto preconditioner = Thyra::unspecifiedPrec<double>(Thyra::inverse<double>(factors_));
      iterative_ = krylov_->createOp();
      krylov_->initializePreconditionedOp(source_, preconditioner, iterative_.get());
    } else {
      factor();
    }
  }
  RCP<const Source> source() const { return source_; }
  void release() { source_ = Teuchos::null; }

  RCP<const Thyra::VectorSpaceBase<double>> range() const override {
    return source_.is_null() ? Teuchos::null : source_->getOp()->range();
  }
  RCP<const Thyra::VectorSpaceBase<double>> domain() const override {
    return source_.is_null() ? Teuchos::null : source_->getOp()->domain();
  }

 protected:
  bool opSupportedImpl(Thyra::EOpTransp transpose) const override {
    return Thyra::opSupported(*source_->getOp(), transpose);
  }
  void applyImpl(const Thyra::EOpTransp transpose, const Vectors& x, const Ptr<Vectors>& y,
                 const double alpha, const double beta) const override {
    source_->getOp()->apply(transpose, x, y, alpha, beta);
  }
  bool solveSupportsImpl(Thyra::EOpTransp transpose) const override { return transpose == Thyra::NOTRANS; }
  bool solveSupportsSolveMeasureTypeImpl(Thyra::EOpTransp transpose,
                                         const Thyra::SolveMeasureType&) const override {
    return transpose == Thyra::NOTRANS;
  }
  Thyra::SolveStatus<double> solveImpl(
      const Thyra::EOpTransp /*transpose*/, const Vectors& h, const Ptr<Vectors>& x,
      const Ptr<const Thyra::SolveCriteria<double>> /*criteria*/) const override {
    make_room();
    ++solved_;
    solves_.right_side(ExecutorVector::of(h).data(), right_side());
    if (iterating_ && (krylov_spent_ >= krylov_budget_ || !iterate())) {
      iterating_ = false;
      factor();
    }
    if (!iterating_) noting_failure([&] { timed(solves_.time_solve, [&] { solve_directly(); }); });
    solves_.correct(solution(), ExecutorVector::of(*x).data());
    Thyra::SolveStatus<double> status;
    status.solveStatus = Thyra::SOLVE_STATUS_CONVERGED;
    return status;
  }

 private:
  template <class Work>
  void noting_failure(const Work& work) const {
    try {
      work();
    } catch (...) {
      solves_.failure = std::current_exception();
      throw;
    }
  }
  template <class Work>
  static void timed(double& seconds, const Work& work) {
    const Stopwatch watch;
    work();
    seconds += watch.seconds();
  }

  void factor() const {
    solves_.factored = false;
    double seconds = 0.0;
    noting_failure([&] {
      timed(seconds, [&] {
        give_values();
        direct_->initializeOp(source_, factors_.get());
      });
    });
    solves_.factored = true;
    ++solves_.factorizations;
    krylov_spent_ = 0;
    const Report& report = solver()->report();
    const int analyses = solver()->getStatus().getNumSymbolicFact();
    const double analysis = analyses > analyses_ ? report.time_order + report.time_symbolic : 0.0;
    solves_.analyses += analyses - analyses_;
    analyses_ = analyses;
    solves_.time_analysis += analysis;
    solves_.time_factor += seconds - analysis;
    solves_.bytes = report.bytes_used;
    const BackendInfo backend = backend_info(report.backend);
    krylov_budget_ = report.flops.total() /
                     (backend.flops_per_entry * static_cast<double>(report.nnz_factor) +
                      kSecondsPerMatrixEntry * backend.factor_rate * static_cast<double>(report.nnz));
  }
  /// Of FGMRES with the next matrix, if that is like those before; at least, where none was tried.
  double expected_steps() const {
    const auto tried = static_cast<double>(solves_.krylov_solves);
    const double of_a_solve = tried > 0 ? krylov_steps_ / tried : 1.0;
    return of_a_solve * static_cast<double>(solved_) / static_cast<double>(matrices_);
  }

  /// Null before the first factorization.
  MfsSolver* solver() const {
    return dynamic_cast<MfsSolver*>(
        dynamic_cast<Thyra::Amesos2LinearOpWithSolve<double>&>(*factors_).get_amesos2Solver().get());
  }

  /// Where the values are on a device, they go from there to the solver if it can take them.
  void give_values() const {
    if (solves_.remote_matrix == nullptr) return;
    if (solver() != nullptr && solver()->takesDeviceValues())
      solver()->setDeviceValues(solves_.remote_matrix->values(), solves_.remote_matrix->stream());
    else
      solves_.bring_values();
  }

  void make_room() const {
    if (b_.is_null()) {
      b_ = Thyra::createMember(range());
      x_ = Thyra::createMember(range());
    }
    if (!executor_.on_device()) return;
    right_side_.resize(executor_, size());
    solution_.resize(executor_, size());
  }
  std::size_t size() const { return static_cast<std::size_t>(b_->space()->dim()); }
  static double* numbers(const RCP<Thyra::VectorBase<double>>& vector) {
    return Convert::getTpetraVector(vector)->getDataNonConst().getRawPtr();
  }
  /// With the executor.
  double* right_side() const { return executor_.on_device() ? right_side_.data() : numbers(b_); }
  double* solution() const { return executor_.on_device() ? solution_.data() : numbers(x_); }

  void solve_directly() const {
    if (executor_.on_device())
      solver()->solveDevice(right_side(), solution(), executor_.stream());
    else
      factors_->solve(Thyra::NOTRANS, *b_, x_.ptr());
  }

  bool iterate() const {
    const std::size_t bytes = size() * sizeof(double);
    if (executor_.on_device()) executor_.to_host(numbers(b_), right_side(), bytes);
    Thyra::assign(x_.ptr(), 0.0);
    Thyra::SolveStatus<double> status;
    noting_failure([&] {
      timed(solves_.time_solve, [&] { status = iterative_->solve(Thyra::NOTRANS, *b_, x_.ptr()); });
    });
    if (executor_.on_device()) executor_.from_host(solution(), numbers(x_), bytes);
    ++solves_.krylov_solves;
    const int steps = status.extraParameters->get<int>("Iteration Count");
    const bool converged = status.solveStatus == Thyra::SOLVE_STATUS_CONVERGED;
    krylov_spent_ += steps;
    krylov_steps_ += steps;
    krylov_gain_ -= steps - (converged ? 1 : 0);
    return converged;
  }

  RCP<const Factory> direct_, krylov_;
  const Executor& executor_;
  RCP<Thyra::LinearOpWithSolveBase<double>> factors_, iterative_;
  LinearSolves& solves_;
  RCP<const Source> source_;
  // A solve is const for Thyra, but it may have to factor.
  mutable RCP<Thyra::VectorBase<double>> b_, x_;  ///< Tpetra's, for Belos and the solver on the host
  mutable Array<double> right_side_, solution_;   ///< on a device, for the solver there
  mutable bool iterating_ = false;
  mutable int analyses_ = 0;
  std::int64_t matrices_ = 0;
  mutable std::int64_t solved_ = 0;                      ///< systems with them
  mutable double krylov_steps_ = 0;                      ///< of all solves
  mutable double krylov_spent_ = 0, krylov_budget_ = 0;  ///< steps since, and worth, a factorization
  /// Steps that FGMRES has saved: factorizations, less what it took. It may lose one factorization in all.
  mutable double krylov_gain_ = 0;
};

class KeptFactorsFactory : public Factory {
 public:
  KeptFactorsFactory(const IntegratorOptions& options, const Executor& executor, LinearSolves& solves)
      : direct_(make_mfs(options)),
        op_(rcp(new KeptSolve(direct_, make_fgmres(options), executor, solves))) {}

  bool isCompatible(const Source& source) const override { return direct_->isCompatible(source); }
  RCP<Thyra::LinearOpWithSolveBase<double>> createOp() const override { return op_; }
  void initializeOp(const RCP<const Source>& source, Thyra::LinearOpWithSolveBase<double>* op,
                    const Thyra::ESupportSolveUse /*use*/) const override {
    Teuchos::dyn_cast<KeptSolve>(*op).take(source);
  }
  void uninitializeOp(Thyra::LinearOpWithSolveBase<double>* op, RCP<const Source>* source,
                      RCP<const Thyra::PreconditionerBase<double>>* preconditioner,
                      RCP<const Source>* approximate, Thyra::ESupportSolveUse* use) const override {
    KeptSolve& kept = Teuchos::dyn_cast<KeptSolve>(*op);
    if (source != nullptr) *source = kept.source();
    kept.release();
    if (preconditioner != nullptr) *preconditioner = Teuchos::null;
    if (approximate != nullptr) *approximate = Teuchos::null;
    if (use != nullptr) *use = Thyra::SUPPORT_SOLVE_UNSPECIFIED;
  }

  // It has no parameters of its own.
  void setParameterList(const RCP<Teuchos::ParameterList>& list) override { parameters_ = list; }
  RCP<Teuchos::ParameterList> getNonconstParameterList() override { return parameters_; }
  RCP<Teuchos::ParameterList> unsetParameterList() override {
    return std::exchange(parameters_, Teuchos::null);
  }

 private:
  RCP<const Factory> direct_;
  RCP<KeptSolve> op_;
  RCP<Teuchos::ParameterList> parameters_;
};

}  // namespace

RCP<Factory> make_kept_factors(const IntegratorOptions& options, const Executor& executor,
                               LinearSolves& solves) {
  return rcp(new KeptFactorsFactory(options, executor, solves));
}

}  // namespace mfs::dae
