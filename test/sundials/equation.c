/* 4 u_i - 2 u_{i-1} - u_{i+1} + exp(u_i) / 10 = i / n by Newton's method of KINSOL. */
#include <kinsol/kinsol.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <stddef.h>

#include "problems.h"

enum { kSize = 150 };

static int residual(N_Vector vector, N_Vector result, void* user) {
  const sunrealtype* u = N_VGetArrayPointer(vector);
  sunrealtype* f = N_VGetArrayPointer(result);
  (void)user;
  for (int i = 0; i < kSize; ++i)
    f[i] = 4 * u[i] - 2 * (i > 0 ? u[i - 1] : 0) - (i < kSize - 1 ? u[i + 1] : 0) + exp(u[i]) / 10 -
           (double)i / kSize;
  return 0;
}

static int jacobian(N_Vector vector, N_Vector f, SUNMatrix J, void* user, N_Vector w1, N_Vector w2) {
  const int by_columns = SUNSparseMatrix_SparseType(J) == CSC_MAT;
  const sunrealtype* u = N_VGetArrayPointer(vector);
  sunindextype *offsets = SUNSparseMatrix_IndexPointers(J), *indices = SUNSparseMatrix_IndexValues(J),
               count = 0;
  sunrealtype* values = SUNSparseMatrix_Data(J);
  (void)f, (void)user, (void)w1, (void)w2;
  for (int k = 0; k < kSize; ++k) {
    offsets[k] = count;
    for (int other = k - 1; other <= k + 1; ++other) {
      const int lower = by_columns ? other > k : other < k;
      if (other < 0 || other >= kSize) continue;
      indices[count] = other;
      values[count++] = other == k ? 4 + exp(u[k]) / 10 : lower ? -2 : -1;
    }
  }
  offsets[kSize] = count;
  return 0;
}

Course equation(Solver which, int form, SUNContext context) {
  Course course = {0};
  N_Vector u = N_VNew_Serial(kSize, context), scale = N_VNew_Serial(kSize, context);
  void* kinsol = KINCreate(context);
  SUNMatrix J = SUNSparseMatrix(kSize, kSize, 3 * kSize, form, context);
  SUNLinearSolver LS = make_solver(which, u, J, context);
  N_VConst(0, u);
  N_VConst(1, scale);
  KINInit(kinsol, residual, u);
  KINSetFuncNormTol(kinsol, 1e-10);
  KINSetMaxNewtonStep(kinsol, 1000);
  KINSetLinearSolver(kinsol, LS, J);
  KINSetJacFn(kinsol, jacobian);
  course.status = KINSol(kinsol, u, KIN_NONE, scale, scale);
  KINGetNumNonlinSolvIters(kinsol, &course.nonlinear_iterations);
  KINGetNumFuncEvals(kinsol, &course.evaluations);
  KINGetNumJacEvals(kinsol, &course.jacobians);
  course.steps = course.nonlinear_iterations;
  for (int k = 0; k < 3; ++k) course.end[k] = N_VGetArrayPointer(u)[40 * k + 30];
  KINFree(&kinsol);
  course.analyses = analyses_of(which, LS);
  SUNLinSolFree(LS);
  SUNMatDestroy(J);
  N_VDestroy(scale);
  N_VDestroy(u);
  return course;
}
