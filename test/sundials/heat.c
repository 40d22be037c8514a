/* u' = u_xx + u_yy on a grid of kSide x kSide points by IDA: rows of inner points are differential, those of
   the boundary algebraic (u = 0). Backward differences; the Jacobian dF/dy + c dF/dy' is sparse. */
#include <ida/ida.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <stddef.h>

#include "problems.h"

enum { kSide = 14, kSize = kSide * kSide };

static int is_boundary(int k) {
  const int i = k / kSide, j = k % kSide;
  return i == 0 || j == 0 || i == kSide - 1 || j == kSide - 1;
}

static int residual(sunrealtype t, N_Vector y, N_Vector yp, N_Vector r, void* user) {
  const sunrealtype *u = N_VGetArrayPointer(y), *up = N_VGetArrayPointer(yp);
  sunrealtype* f = N_VGetArrayPointer(r);
  const double h2 = (kSide - 1) * (kSide - 1);
  (void)t, (void)user;
  for (int k = 0; k < kSize; ++k)
    f[k] =
        is_boundary(k) ? u[k] : up[k] - h2 * (u[k - kSide] + u[k - 1] + u[k + 1] + u[k + kSide] - 4 * u[k]);
  return 0;
}

/* The matrix is symmetric but for rows of the boundary, so that CSR and CSC differ. */
static int jacobian(sunrealtype t, sunrealtype c, N_Vector y, N_Vector yp, N_Vector r, SUNMatrix J,
                    void* user, N_Vector w1, N_Vector w2, N_Vector w3) {
  const int by_columns = SUNSparseMatrix_SparseType(J) == CSC_MAT;
  const int distance[] = {-kSide, -1, 0, 1, kSide};
  const double h2 = (kSide - 1) * (kSide - 1);
  sunindextype *offsets = SUNSparseMatrix_IndexPointers(J), *indices = SUNSparseMatrix_IndexValues(J),
               count = 0;
  sunrealtype* values = SUNSparseMatrix_Data(J);
  (void)t, (void)y, (void)yp, (void)r, (void)user, (void)w1, (void)w2, (void)w3;
  for (int k = 0; k < kSize; ++k) {
    offsets[k] = count;
    for (int d = 0; d < 5; ++d) {
      const int other = k + distance[d], row = by_columns ? other : k;
      if (other < 0 || other >= kSize) continue;
      if (is_boundary(row) && distance[d] != 0) continue;
      indices[count] = other;
      values[count++] = is_boundary(row) ? 1 : distance[d] == 0 ? c + 4 * h2 : -h2;
    }
  }
  offsets[kSize] = count;
  return 0;
}

Course heat(Solver which, int form, SUNContext context) {
  Course course = {0};
  N_Vector y = N_VNew_Serial(kSize, context), yp = N_VNew_Serial(kSize, context);
  sunrealtype *u = N_VGetArrayPointer(y), t = 0;
  void* ida = IDACreate(context);
  SUNMatrix J = SUNSparseMatrix(kSize, kSize, 5 * kSize, form, context);
  SUNLinearSolver LS = make_solver(which, y, J, context);
  for (int k = 0; k < kSize; ++k) {
    const double a = (double)(k / kSide) / (kSide - 1), b = (double)(k % kSide) / (kSide - 1);
    u[k] = is_boundary(k) ? 0 : 16 * a * (1 - a) * b * b * (1 - b);
  }
  N_VConst(0, yp);
  N_Vector r = N_VClone(y);
  residual(0, y, yp, r, NULL);
  N_VScale(-1, r, yp);
  for (int k = 0; k < kSize; ++k)
    if (is_boundary(k)) N_VGetArrayPointer(yp)[k] = 0;
  IDAInit(ida, residual, 0, y, yp);
  IDASStolerances(ida, 1e-6, 1e-9);
  IDASetLinearSolver(ida, LS, J);
  IDASetJacFn(ida, jacobian);
  for (double end = 0.01; end < 0.4; end *= 2) {
    course.status = IDASolve(ida, end, &t, y, yp, IDA_NORMAL);
    if (course.status < 0) break;
  }
  IDAGetNumSteps(ida, &course.steps);
  IDAGetNumResEvals(ida, &course.evaluations);
  IDAGetNumJacEvals(ida, &course.jacobians);
  IDAGetNumNonlinSolvIters(ida, &course.nonlinear_iterations);
  IDAGetNumErrTestFails(ida, &course.error_test_failures);
  for (int k = 0; k < 3; ++k) course.end[k] = u[(3 + k) * kSide + 5];
  IDAFree(&ida);
  course.analyses = analyses_of(which, LS);
  SUNLinSolFree(LS);
  SUNMatDestroy(J);
  N_VDestroy(r);
  N_VDestroy(y);
  N_VDestroy(yp);
  return course;
}
