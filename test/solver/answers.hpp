// What a solver says of a matrix, to be compared bit for bit with what another one says.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "test/solver/systems.hpp"

namespace mfs::test {

/// One column of the plain and one of the transposed system, and the determinant.
template <class Scalar>
struct Answers {
  std::vector<Scalar> x, transposed;
  Determinant<Scalar> determinant{};
};

template <class Scalar>
Answers<Scalar> answers_of(BasicSolver<Scalar>& solver, const BasicSparseMatrix<Scalar>& a) {
  const std::vector<Scalar> b = right_hand_sides(a, 1, a.n, 5);
  Answers<Scalar> answers{b, b, {}};
  solver.solve(b.data(), answers.x.data());
  solver.solve_transpose(b.data(), answers.transposed.data());
  answers.determinant = solver.determinant();
  return answers;
}

template <class Scalar>
void expect_same(const Answers<Scalar>& actual, const Answers<Scalar>& expected) {
  EXPECT_EQ(actual.x, expected.x);
  EXPECT_EQ(actual.transposed, expected.transposed);
  EXPECT_EQ(actual.determinant.phase, expected.determinant.phase);
  EXPECT_EQ(actual.determinant.log_abs, expected.determinant.log_abs);
}

}  // namespace mfs::test
