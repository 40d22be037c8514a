// sunlinsol_mfs.h: integrators take the same course with MFS and with KLU, and what they are told of systems
// that cannot be solved.
#include <gmock/gmock.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol_mfs.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "problems.h"

namespace {

class Sundials : public testing::Test {
 protected:
#ifdef SUN_COMM_NULL  // since version 7
  Sundials() {
    SUNContext_Create(SUN_COMM_NULL, &context_);
  }
#else
  Sundials() {
    SUNContext_Create(nullptr, &context_);
  }
#endif
  ~Sundials() override {
    SUNContext_Free(&context_);
  }
  SUNContext context_ = nullptr;
};

void expect_same_course(const Course& mfs, const Course& klu) {
  EXPECT_EQ(mfs.status, 0);
  EXPECT_EQ(klu.status, 0);
  EXPECT_GT(klu.steps, 2);
  EXPECT_EQ(mfs.steps, klu.steps);
  EXPECT_EQ(mfs.evaluations, klu.evaluations);
  EXPECT_EQ(mfs.jacobians, klu.jacobians);
  EXPECT_EQ(mfs.nonlinear_iterations, klu.nonlinear_iterations);
  EXPECT_EQ(mfs.error_test_failures, klu.error_test_failures);
  EXPECT_EQ(mfs.analyses, 1);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(mfs.end[k], klu.end[k], 1e-9);
    EXPECT_GT(std::fabs(klu.end[k]), 1e-6);
  }
}

TEST_F(Sundials, IdaTakesTheSameStepsAsWithKlu) {
  for (const int form : {CSR_MAT, CSC_MAT})
    expect_same_course(heat(BY_MFS, form, context_), heat(BY_KLU, form, context_));
}

TEST_F(Sundials, CvodeTakesTheSameStepsAsWithKlu) {
  for (const int form : {CSR_MAT, CSC_MAT})
    expect_same_course(brusselator(BY_MFS, form, GOOD, context_), brusselator(BY_KLU, form, GOOD, context_));
}

TEST_F(Sundials, ArkodeTakesTheSameStepsAsWithKlu) {
  for (const int form : {CSR_MAT, CSC_MAT})
    expect_same_course(brusselator_by_arkode(BY_MFS, form, context_),
                       brusselator_by_arkode(BY_KLU, form, context_));
}

TEST_F(Sundials, KinsolTakesTheSameIterationsAsWithKlu) {
  for (const int form : {CSR_MAT, CSC_MAT})
    expect_same_course(equation(BY_MFS, form, context_), equation(BY_KLU, form, context_));
}

TEST_F(Sundials, APatternThatChangesIsAnalysedAnew) {
  const Course good = brusselator(BY_MFS, CSR_MAT, GOOD, context_);
  const Course course = brusselator(BY_MFS, CSR_MAT, FIRST_HAS_OTHER_PATTERN, context_);
  EXPECT_EQ(course.status, 0);
  EXPECT_EQ(course.analyses, 2);
  EXPECT_EQ(course.steps, good.steps);
}

TEST_F(Sundials, ABadJacobianIsRecoverable) {
  const Course good = brusselator(BY_MFS, CSR_MAT, GOOD, context_);
  const Course course = brusselator(BY_MFS, CSR_MAT, FIRST_HAS_NAN, context_);
  EXPECT_EQ(course.status, 0);
  EXPECT_NEAR(course.end[1], good.end[1], 1e-3);
}

/// A = (4 1 0; 0 3 0; 0 0 2) in either form, with a solver and vectors.
class Small {
 public:
  Small(int form, SUNContext context)
      : b(N_VNew_Serial(3, context)),
        x(N_VNew_Serial(3, context)),
        a(SUNSparseMatrix(3, 3, 4, form, context)) {
    const sunindextype rows[][4] = {{0, 2, 3, 4}, {0, 1, 1, 2}}, columns[][4] = {{0, 1, 3, 4}, {0, 0, 1, 2}};
    const sunrealtype numbers[] = {4, 1, 3, 2};  // in both orders
    const auto& shape = form == CSR_MAT ? rows : columns;
    std::copy(shape[0], shape[0] + 4, SUNSparseMatrix_IndexPointers(a));
    std::copy(shape[1], shape[1] + 4, SUNSparseMatrix_IndexValues(a));
    std::copy(numbers, numbers + 4, values());
    solver = SUNLinSol_MFS(b, a, context);
    N_VConst(7, x);
    N_VConst(1, b);
  }
  ~Small() {
    SUNLinSolFree(solver);
    SUNMatDestroy(a);
    N_VDestroy(x);
    N_VDestroy(b);
  }
  sunrealtype* values() { return SUNSparseMatrix_Data(a); }
  int setup() { return SUNLinSolSetup(solver, a); }
  int solve() { return SUNLinSolSolve(solver, a, x, b, 0); }
  double unknown(int i) { return N_VGetArrayPointer(x)[i]; }

  N_Vector b, x;
  SUNMatrix a;
  SUNLinearSolver solver;
};

TEST_F(Sundials, BothFormsAreSolved) {
  for (const int form : {CSR_MAT, CSC_MAT}) {
    Small small(form, context_);
    ASSERT_NE(small.solver, nullptr);
    EXPECT_EQ(SUNLinSolGetType(small.solver), SUNLINEARSOLVER_DIRECT);
    EXPECT_EQ(SUNLinSolInitialize(small.solver), 0);
    EXPECT_EQ(small.setup(), 0);
    EXPECT_EQ(small.solve(), 0);
    EXPECT_NEAR(small.unknown(0), 1.0 / 6, 1e-14);
    EXPECT_NEAR(small.unknown(1), 1.0 / 3, 1e-14);
    double nnz = 0;
    EXPECT_EQ(mfs_report(SUNLinSol_MFSGetSolver(small.solver), "nnz", &nnz), MFS_OK);
    EXPECT_EQ(nnz, 4);
  }
}

TEST_F(Sundials, SingularMatricesNansAndMissedTolerancesAreRecoverable) {
  Small small(CSR_MAT, context_);
  EXPECT_EQ(small.setup(), 0);
  small.values()[3] = 0;
  const int setup = small.setup();
  if (setup == 0) {
    EXPECT_EQ(small.solve(), SUNLS_LUFACT_FAIL);
  } else {
    EXPECT_EQ(setup, SUNLS_LUFACT_FAIL);
  }
  EXPECT_EQ(SUNLinSolLastFlag(small.solver), SUNLS_LUFACT_FAIL);
  EXPECT_EQ(small.unknown(2), 7) << "the solution is untouched";
  small.values()[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(small.setup(), SUNLS_PACKAGE_FAIL_REC);
  small.values()[3] = 2;
  EXPECT_EQ(small.setup(), 0);
  EXPECT_EQ(SUNLinSolLastFlag(small.solver), 0);
  N_VConst(std::numeric_limits<double>::infinity(), small.b);
  EXPECT_EQ(small.solve(), SUNLS_PACKAGE_FAIL_REC);
  N_VConst(1, small.b);
  EXPECT_EQ(small.solve(), 0);
  EXPECT_NEAR(small.unknown(2), 0.5, 1e-15);
}

TEST_F(Sundials, WhatCannotGetBetterIsUnrecoverable) {
  Small small(CSR_MAT, context_);
  EXPECT_EQ(small.solve(), MFS_SUNLS_UNRECOVERABLE) << "solve before setup";
  EXPECT_EQ(SUNLinSol_MFSSetOption(small.solver, "treads", "1"), MFS_INVALID_INPUT);
  EXPECT_EQ(SUNLinSol_MFSSetOption(small.solver, "threads", "1"), MFS_OK);
  SUNSparseMatrix_IndexValues(small.a)[2] = 3;
  EXPECT_EQ(small.setup(), MFS_SUNLS_UNRECOVERABLE);
  EXPECT_LT(MFS_SUNLS_UNRECOVERABLE, 0);
  const char* text = nullptr;
  mfs_last_error(&text, nullptr, nullptr);
  EXPECT_THAT(text, testing::HasSubstr("row 1"));
}

TEST_F(Sundials, MatricesAndVectorsThatDoNotFitGiveNoSolver) {
  N_Vector three = N_VNew_Serial(3, context_), four = N_VNew_Serial(4, context_);
  SUNMatrix square = SUNSparseMatrix(3, 3, 4, CSR_MAT, context_),
            oblong = SUNSparseMatrix(3, 4, 4, CSR_MAT, context_);
  EXPECT_EQ(SUNLinSol_MFS(three, oblong, context_), nullptr);
  EXPECT_EQ(SUNLinSol_MFS(four, square, context_), nullptr);
  EXPECT_EQ(SUNLinSol_MFS(nullptr, square, context_), nullptr);
  EXPECT_EQ(SUNLinSol_MFS(three, nullptr, context_), nullptr);
  SUNMatDestroy(oblong);
  SUNMatDestroy(square);
  N_VDestroy(four);
  N_VDestroy(three);
}

}  // namespace
