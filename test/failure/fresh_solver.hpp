// What every test of a failure asks at its end: the object can be used as if nothing had happened.
#pragma once

#include <gmock/gmock.h>

#include "test/solver/systems.hpp"

namespace mfs::test {

/// Factors and solves another matrix and then `a` with the same object.
template <class Scalar>
void expect_usable(BasicSolver<Scalar>& solver) {
  for (const SparseMatrix& real : {grid_2d(7, 6), random_diagonally_dominant(60, 3, 1)}) {
    const BasicSparseMatrix<Scalar> a = in_scalar<Scalar>(real);
    solver.analyze(a.view());
    solver.factor(a.view());
    expect_solves(solver, a, 2);
  }
}

/// The error that `call` ends with; a test failure if it is of another class, or none.
template <class Failure, class Call>
std::unique_ptr<Failure> failure_of(const Call& call) {
  try {
    call();
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Failure& error) {
    return std::make_unique<Failure>(error);
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another error: " << error.what();
  }
  return nullptr;
}

template <class Call>
void expect_invalid(const Call& call, const std::string& argument, std::int64_t row = -1,
                    std::int64_t column = -1) {
  SCOPED_TRACE(argument);
  if (const auto error = failure_of<InvalidInput>(call)) {
    EXPECT_EQ(error->argument(), argument) << error->what();
    EXPECT_EQ(error->row(), row) << error->what();
    EXPECT_EQ(error->column(), column) << error->what();
    EXPECT_THAT(error->what(), testing::HasSubstr(argument));
  }
}

}  // namespace mfs::test
