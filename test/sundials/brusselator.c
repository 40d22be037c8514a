/* u' = 1 + u^2 v - 4 u + d u_xx, v' = 3 u - u^2 v + d v_xx in a rod (Hairer and Wanner 1996, IV.10) by CVODE.
 */
#include <arkode/arkode_arkstep.h>
#include <cvode/cvode.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <stdlib.h>

#include "problems.h"

enum { kPoints = 60, kSize = 2 * kPoints };
static const double kDiffusion = 0.02 * (kPoints + 1) * (kPoints + 1);

typedef struct {
  JacobianKind kind;
  int jacobians;
} State;

static double at(const sunrealtype* y, int point, int which) {
  if (point < 0 || point >= kPoints) return which == 0 ? 1 : 3;
  return y[2 * point + which];
}

static int derivative(sunrealtype t, N_Vector vector, N_Vector result, void* user) {
  const sunrealtype* y = N_VGetArrayPointer(vector);
  sunrealtype* f = N_VGetArrayPointer(result);
  (void)t, (void)user;
  for (int i = 0; i < kPoints; ++i) {
    const double u = at(y, i, 0), v = at(y, i, 1);
    f[2 * i] = 1 + u * u * v - 4 * u + kDiffusion * (at(y, i - 1, 0) - 2 * u + at(y, i + 1, 0));
    f[2 * i + 1] = 3 * u - u * u * v + kDiffusion * (at(y, i - 1, 1) - 2 * v + at(y, i + 1, 1));
  }
  return 0;
}

/* Of d f[row] / d y[column]; 0 where there is none. */
static double slope(const sunrealtype* y, int row, int column) {
  const int point = row / 2, of = row % 2, with = column % 2;
  const double u = y[2 * point], v = y[2 * point + 1];
  if (column / 2 != point) return of == with ? kDiffusion : 0;
  if (of == 0) return with == 0 ? 2 * u * v - 4 - 2 * kDiffusion : u * u;
  return with == 0 ? 3 - 2 * u * v : -u * u - 2 * kDiffusion;
}

static int jacobian(sunrealtype t, N_Vector vector, N_Vector f, SUNMatrix J, void* user, N_Vector w1,
                    N_Vector w2, N_Vector w3) {
  State* state = (State*)user;
  const int by_columns = SUNSparseMatrix_SparseType(J) == CSC_MAT, first = state->jacobians++ == 0;
  const sunrealtype* y = N_VGetArrayPointer(vector);
  sunindextype *offsets = SUNSparseMatrix_IndexPointers(J), *indices = SUNSparseMatrix_IndexValues(J),
               count = 0;
  sunrealtype* values = SUNSparseMatrix_Data(J);
  (void)t, (void)f, (void)w1, (void)w2, (void)w3;
  for (int k = 0; k < kSize; ++k) {
    offsets[k] = count;
    for (int other = k - 3; other <= k + 3; ++other) {
      const int neighbour = other >= 0 && other < kSize && abs(other / 2 - k / 2) <= 1;
      const int coupled = neighbour && (other / 2 == k / 2 || other % 2 == k % 2);
      if (!coupled && !(neighbour && first && state->kind == FIRST_HAS_OTHER_PATTERN)) continue;
      indices[count] = other;
      values[count++] = !coupled ? 0 : by_columns ? slope(y, other, k) : slope(y, k, other);
    }
  }
  offsets[kSize] = count;
  if (first && state->kind == FIRST_HAS_NAN) values[5] = NAN;
  return 0;
}

static void start(sunrealtype* y) {
  for (int i = 0; i < kPoints; ++i) {
    y[2 * i] = 1 + sin(6.283185307179586 * (i + 1) / (kPoints + 1));
    y[2 * i + 1] = 3;
  }
}

Course brusselator(Solver which, int form, JacobianKind kind, SUNContext context) {
  Course course = {0};
  State state = {kind, 0};
  N_Vector vector = N_VNew_Serial(kSize, context);
  sunrealtype *y = N_VGetArrayPointer(vector), t = 0;
  void* cvode = CVodeCreate(CV_BDF, context);
  SUNMatrix J = SUNSparseMatrix(kSize, kSize, 8 * kSize, form, context);
  SUNLinearSolver LS = make_solver(which, vector, J, context);
  start(y);
  CVodeInit(cvode, derivative, 0, vector);
  CVodeSStolerances(cvode, 1e-6, 1e-8);
  CVodeSetUserData(cvode, &state);
  CVodeSetLinearSolver(cvode, LS, J);
  CVodeSetJacFn(cvode, jacobian);
  course.status = CVode(cvode, 6, vector, &t, CV_NORMAL);
  CVodeGetNumSteps(cvode, &course.steps);
  CVodeGetNumRhsEvals(cvode, &course.evaluations);
  CVodeGetNumJacEvals(cvode, &course.jacobians);
  CVodeGetNumNonlinSolvIters(cvode, &course.nonlinear_iterations);
  CVodeGetNumErrTestFails(cvode, &course.error_test_failures);
  for (int k = 0; k < 3; ++k) course.end[k] = y[20 * k + 7];
  CVodeFree(&cvode);
  course.analyses = analyses_of(which, LS);
  SUNLinSolFree(LS);
  SUNMatDestroy(J);
  N_VDestroy(vector);
  return course;
}

Course brusselator_by_arkode(Solver which, int form, SUNContext context) {
  Course course = {0};
  State state = {GOOD, 0};
  long int explicit_evaluations = 0;
  N_Vector vector = N_VNew_Serial(kSize, context);
  sunrealtype *y = N_VGetArrayPointer(vector), t = 0;
  start(y);
  void* arkode = ARKStepCreate(NULL, derivative, 0, vector, context);
  SUNMatrix J = SUNSparseMatrix(kSize, kSize, 8 * kSize, form, context);
  SUNLinearSolver LS = make_solver(which, vector, J, context);
  ARKStepSStolerances(arkode, 1e-6, 1e-8);
  ARKStepSetUserData(arkode, &state);
  ARKStepSetLinearSolver(arkode, LS, J);
  ARKStepSetJacFn(arkode, jacobian);
  course.status = ARKStepEvolve(arkode, 6, vector, &t, ARK_NORMAL);
  ARKStepGetNumSteps(arkode, &course.steps);
  ARKStepGetNumRhsEvals(arkode, &explicit_evaluations, &course.evaluations);
  ARKStepGetNumJacEvals(arkode, &course.jacobians);
  ARKStepGetNumNonlinSolvIters(arkode, &course.nonlinear_iterations);
  ARKStepGetNumErrTestFails(arkode, &course.error_test_failures);
  for (int k = 0; k < 3; ++k) course.end[k] = y[20 * k + 7];
  ARKStepFree(&arkode);
  course.analyses = analyses_of(which, LS);
  SUNLinSolFree(LS);
  SUNMatDestroy(J);
  N_VDestroy(vector);
  return course;
}
