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

/// Every call that needs factors is refused.
template <class Scalar>
void expect_not_factored(BasicSolver<Scalar>& solver, const BasicSparseMatrix<Scalar>& a) {
  std::vector<Scalar> b(static_cast<std::size_t>(a.n), Scalar(1)), x(b.size());
  failure_of<StateError>([&] { solver.solve(b.data(), x.data()); });
  failure_of<StateError>([&] { solver.solve_transpose(b.data(), x.data()); });
  failure_of<StateError>([&] { solver.refactor(a.view()); });
  failure_of<StateError>([&] { solver.refactor(a.values.data()); });
  failure_of<StateError>([&] { solver.solve_device(b.data(), x.data()); });
  failure_of<StateError>([&] { solver.solve_transpose_device(b.data(), x.data()); });
  // On a device it may be the first factorization. A solver that was moved from has no options.
  if (!solver.analyzed() || backend_info(solver.options().backend).memory == MemorySpace::host)
    failure_of<StateError>([&] { solver.refactor_device(a.values.data()); });
  failure_of<StateError>([&] { solver.condition_estimate(); });
  failure_of<StateError>([&] { solver.determinant(); });
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
