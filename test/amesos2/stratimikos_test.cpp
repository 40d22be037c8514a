// The strategy "MFS" of Stratimikos: which work it keeps from one matrix to the next, and its parameters. NOX
// with it is the example nox_bratu.
#include <Thyra_MFS_Stratimikos.hpp>

#include <gtest/gtest.h>

#include <Thyra_DefaultLinearOpSource.hpp>
#include <Thyra_TpetraThyraWrappers.hpp>

#include "test/amesos2/systems.hpp"

namespace {

using namespace mfs::test;
using Factory = Thyra::LinearOpWithSolveFactoryBase<double>;
using Operator = Thyra::LinearOpWithSolveBase<double>;

constexpr double kSmall = 1e-11;

/// The builder's list with this filled into the sublist of MFS.
RCP<Factory> make_factory(const std::function<void(Teuchos::ParameterList&)>& fill) {
  Stratimikos::DefaultLinearSolverBuilder builder;
  Thyra::enableMFS(builder);
  const auto list = Teuchos::parameterList();
  list->set("Linear Solver Type", "MFS");
  list->set("Preconditioner Type", "None");
  fill(list->sublist("Linear Solver Types").sublist("MFS"));
  builder.setParameterList(list);
  return builder.createLinearSolveStrategy("");
}

class StrategyMFS : public ::testing::Test {
 protected:
  void initialize(const RCP<const Matrix>& a) {
    const RCP<const Tpetra::Operator<double>> plain = a;
    const auto source = Thyra::defaultLinearOpSource<double>(Thyra::createConstLinearOp(plain));
    EXPECT_TRUE(factory_->isCompatible(*source));
    factory_->initializeOp(source, operator_.get(), Thyra::SUPPORT_SOLVE_UNSPECIFIED);
  }
  double solve_error(const Matrix& a) {
    const RCP<const Vector> b = image(a, 2);
    const auto x = rcp(new Vector(a.getDomainMap(), 2));
    const auto thyra_b = Thyra::createConstMultiVector<double>(b);
    const auto thyra_x = Thyra::createMultiVector<double>(x);
    const auto status = Thyra::solve<double>(*operator_, Thyra::NOTRANS, *thyra_b, thyra_x.ptr());
    EXPECT_EQ(status.solveStatus, Thyra::SOLVE_STATUS_CONVERGED);
    return distance_from_samples(*x);
  }
  const Amesos2::Status& status() {
    return dynamic_cast<Thyra::Amesos2LinearOpWithSolve<double>&>(*operator_)
        .get_amesos2Solver()
        ->getStatus();
  }
  const mfs::Report& report() {
    const auto solver =
        dynamic_cast<Thyra::Amesos2LinearOpWithSolve<double>&>(*operator_).get_amesos2Solver();
    return dynamic_cast<const Amesos2::MFS<Matrix, Vector>&>(*solver).report();
  }

  RCP<Factory> factory_ = make_factory([](auto& list) {
    list.set("Threads", 1);
    list.set("Backend", "serial");
  });
  RCP<Operator> operator_ = factory_->createOp();
};

TEST_F(StrategyMFS, SolvesWithItsParameters) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  initialize(a);
  EXPECT_LT(solve_error(*a), kSmall);
  if (world()->getRank() > 0) return;  // rank 0 has the figures
  EXPECT_EQ(report().threads, 1);
  EXPECT_EQ(report().backend, mfs::Backend::serial);
}

TEST_F(StrategyMFS, NewValuesKeepTheAnalysis) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  initialize(a);
  a->resumeFill();
  a->scale(2.0);
  a->fillComplete();
  initialize(a);
  EXPECT_LT(solve_error(*a), kSmall);
  EXPECT_EQ(status().getNumSymbolicFact(), 1);
  EXPECT_EQ(status().getNumNumericFact(), 2);
}

TEST_F(StrategyMFS, AnotherMatrixOfThePatternKeepsTheAnalysis) {
  initialize(assemble(grid_entries(6, 5), even_map(30)));
  const double analysis = report().time_symbolic;
  const auto next = assemble(grid_entries(6, 5), even_map(30));
  next->resumeFill();
  next->scale(-3.0);
  next->fillComplete();
  initialize(next);
  EXPECT_LT(solve_error(*next), kSmall);
  EXPECT_EQ(status().getNumSymbolicFact(), 1);
  EXPECT_EQ(report().time_symbolic, analysis);
}

TEST_F(StrategyMFS, AnotherPatternIsAnalysedAgain) {
  initialize(assemble(grid_entries(6, 5), even_map(30)));
  const auto other = assemble(grid_entries(5, 6), even_map(30));
  initialize(other);
  EXPECT_LT(solve_error(*other), kSmall);
  const auto bigger = assemble(grid_entries(7, 6), even_map(42));
  initialize(bigger);
  EXPECT_LT(solve_error(*bigger), kSmall);
}

TEST_F(StrategyMFS, ASingularMatrixIsAnExceptionAndNotTheEnd) {
  const auto a = assemble(grid_entries(6, 5), even_map(30));
  initialize(a);
  const auto zero = assemble(grid_entries(6, 5), even_map(30));
  zero->resumeFill();
  zero->setAllToScalar(0.0);
  zero->fillComplete();
  EXPECT_THROW(
      {
        initialize(zero);
        solve_error(*zero);
      },
      mfs::SingularMatrix);
  initialize(a);
  EXPECT_LT(solve_error(*a), kSmall);
}

TEST(StrategyMFSParameters, AreThoseOfAmesos2) {
  const auto factory = make_factory([](auto& list) { list.set("Tolerance", 1e-13); });
  const auto valid = factory->getValidParameters();
  EXPECT_EQ(valid->numParams(), Amesos2::mfs_valid_parameters()->numParams() + 1);  // and "VerboseObject"
  EXPECT_EQ(factory->getParameterList()->get<double>("Tolerance"), 1e-13);
  EXPECT_EQ(factory->description(), "Thyra::MFSLinearOpWithSolveFactory");
}

TEST(StrategyMFSParameters, WrongOnesAreRefused) {
  EXPECT_THROW(make_factory([](auto& list) { list.set("Tolerence", 1e-13); }), std::logic_error);
  EXPECT_THROW(make_factory([](auto& list) { list.set("Tolerance", 1); }), std::logic_error);
  EXPECT_THROW(make_factory([](auto& list) { list.set("Backend", "gpu"); }), std::logic_error);
}

}  // namespace
