// MFS as a linear solver strategy of Stratimikos, chosen by parameter list.
//
//   Stratimikos::DefaultLinearSolverBuilder builder;
//   Thyra::enableMFS(builder);
//   builder.setParameterList(parameters);    //  "Linear Solver Type" = "MFS"
//                                            //  "Linear Solver Types" -> "MFS" -> "Tolerance" = 1e-13, ...
//
// The parameters are those of the sublist "MFS" of Amesos2 (Amesos2::mfs_valid_parameters); an operator takes
// them when it is initialized for the first time. A matrix of known
// pattern is refactored without a new analysis; a new pattern is analysed again. Errors come as exceptions,
// on every rank; with NOX' "Catch Throws During Solve" they become a failed step.
//
// All of it is inline: link mfs::amesos2 and Stratimikos (libstratimikos, libstratimikosamesos2).
#pragma once

#include "Amesos2_MFS.hpp"

#include <string>

#include <Stratimikos_DefaultLinearSolverBuilder.hpp>
#include <Teuchos_AbstractFactoryStd.hpp>
#include <Teuchos_VerboseObjectParameterListHelpers.hpp>
#include <Teuchos_dyn_cast.hpp>
#include <Thyra_Amesos2LinearOpWithSolveFactory_decl.hpp>

#include <mfs/error.hpp>

namespace Thyra {

/// Makes operators that solve by MFS. Solvers of the base class other than MFS are out of its reach.
class MFSLinearOpWithSolveFactory : public Amesos2LinearOpWithSolveFactory<double> {
 public:
  using Base = Amesos2LinearOpWithSolveFactory<double>;
  using LinearOp = Amesos2LinearOpWithSolve<double>;

  /// Factors the matrix of `source`, a Tpetra::CrsMatrix behind a Thyra::TpetraLinearOp.
  void initializeOp(const Teuchos::RCP<const LinearOpSourceBase<double>>& source,
                    LinearOpWithSolveBase<double>* op, const ESupportSolveUse /*use*/) const override {
    const Teuchos::RCP<const LinearOpBase<double>> forward = source->getOp();
    const auto matrix =
        Teuchos::rcp_dynamic_cast<const MAT>(ConverterT::getConstTpetraOperator(forward), true);
    LinearOp& linear_op = Teuchos::dyn_cast<LinearOp>(*op);
    const Teuchos::RCP<Solver> solver = solver_for(matrix, linear_op);
    // Before factoring: where that fails, the analysis is kept for the next attempt.
    linear_op.initialize(forward, source, solver);
    linear_op.setOStream(this->getOStream());
    linear_op.setVerbLevel(this->getVerbLevel());
    try {
      solver->numericFactorization();
    } catch (const mfs::PatternChanged&) {
      solver->setA(matrix);
      solver->numericFactorization();
    }
  }

  void setParameterList(const Teuchos::RCP<Teuchos::ParameterList>& parameters) override {
    parameters->validateParameters(*getValidParameters());
    parameters_ = parameters;
    Teuchos::readVerboseObjectSublist(parameters_.get(), this);
  }
  Teuchos::RCP<Teuchos::ParameterList> getNonconstParameterList() override { return parameters_; }
  Teuchos::RCP<Teuchos::ParameterList> unsetParameterList() override {
    const auto parameters = parameters_;
    parameters_ = Teuchos::null;
    return parameters;
  }
  Teuchos::RCP<const Teuchos::ParameterList> getParameterList() const override { return parameters_; }
  Teuchos::RCP<const Teuchos::ParameterList> getValidParameters() const override {
    const auto valid = Teuchos::parameterList(*::Amesos2::mfs_valid_parameters());
    Teuchos::setupVerboseObjectSublist(valid.get());
    return valid;
  }
  std::string description() const override { return "Thyra::MFSLinearOpWithSolveFactory"; }

 private:
  /// The solver that `linear_op` has, with the new matrix and as much of its work as can be kept, or a new
  /// one.
  Teuchos::RCP<Solver> solver_for(const Teuchos::RCP<const MAT>& matrix, LinearOp& linear_op) const {
    const Teuchos::RCP<Solver> known = linear_op.get_amesos2Solver();
    if (!known.is_null()) {
      const auto old =
          Teuchos::rcp_dynamic_cast<const MAT>(ConverterT::getConstTpetraOperator(linear_op.get_fwdOp()));
      if (old == matrix) return known;
      const bool keep = known->getStatus().symbolicFactorizationDone() &&
                        old->getGlobalNumRows() == matrix->getGlobalNumRows();
      known->setA(matrix, keep ? ::Amesos2::SYMBFACT : ::Amesos2::CLEAN);
      return known;
    }
    const Teuchos::RCP<Solver> solver = ::Amesos2::create<MAT, MV>("MFS", matrix);
    if (!parameters_.is_null()) {
      const auto list = Teuchos::parameterList("Amesos2");
      list->sublist("MFS").setParameters(*parameters_);
      list->sublist("MFS").remove("VerboseObject", false);
      solver->setParameters(list);
    }
    return solver;
  }

  Teuchos::RCP<Teuchos::ParameterList> parameters_;
};

/// Adds the strategy to a builder, before its parameters are set.
inline void enableMFS(Stratimikos::DefaultLinearSolverBuilder& builder, const std::string& name = "MFS") {
  builder.setLinearSolveStrategyFactory(
      Teuchos::abstractFactoryStd<LinearOpWithSolveFactoryBase<double>, MFSLinearOpWithSolveFactory>(), name);
}

}  // namespace Thyra
