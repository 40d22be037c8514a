/* y' = -1000 (y - z), 0 = y + z - 2 by IDA with the linear solver of sunlinsol_mfs.h, and a matrix without a
 * solution. */
#include <ida/ida.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <stdio.h>
#include <sunlinsol_mfs.h>

static int residual(sunrealtype t, N_Vector u, N_Vector rate, N_Vector result, void* user) {
  const sunrealtype *y = N_VGetArrayPointer(u), *dy = N_VGetArrayPointer(rate);
  sunrealtype* f = N_VGetArrayPointer(result);
  (void)t, (void)user;
  f[0] = dy[0] + 1000 * (y[0] - y[1]);
  f[1] = y[0] + y[1] - 2;
  return 0;
}

static void set(SUNMatrix J, sunrealtype a, sunrealtype b, sunrealtype c, sunrealtype d) {
  const sunrealtype values[] = {a, b, c, d};
  for (int k = 0; k < 4; ++k) {
    SUNSparseMatrix_Data(J)[k] = values[k];
    SUNSparseMatrix_IndexValues(J)[k] = k % 2;
  }
  for (int k = 0; k < 3; ++k) SUNSparseMatrix_IndexPointers(J)[k] = 2 * k;
}

static int jacobian(sunrealtype t, sunrealtype alpha, N_Vector u, N_Vector rate, N_Vector f, SUNMatrix J,
                    void* user, N_Vector w1, N_Vector w2, N_Vector w3) {
  (void)t, (void)u, (void)rate, (void)f, (void)user, (void)w1, (void)w2, (void)w3;
  set(J, alpha + 1000, -1000, 1, 1);
  return 0;
}

int main(void) {
  SUNContext context;
#if SUNDIALS_VERSION_MAJOR >= 7
  SUNContext_Create(SUN_COMM_NULL, &context);
#else
  SUNContext_Create(NULL, &context);
#endif
  N_Vector u = N_VNew_Serial(2, context), rate = N_VNew_Serial(2, context);
  sunrealtype *y = N_VGetArrayPointer(u), *dy = N_VGetArrayPointer(rate), t = 0;
  y[0] = 0, y[1] = 2, dy[0] = 2000, dy[1] = -2000;
  SUNMatrix J = SUNSparseMatrix(2, 2, 4, CSR_MAT, context);
  SUNLinearSolver LS = SUNLinSol_MFS(u, J, context);
  void* ida = IDACreate(context);
  long int steps = 0;
  int bad = LS == NULL || IDAInit(ida, residual, 0, u, rate) || IDASStolerances(ida, 1e-8, 1e-10) ||
            IDASetLinearSolver(ida, LS, J) || IDASetJacFn(ida, jacobian) ||
            IDASolve(ida, 1, &t, u, rate, IDA_NORMAL) < 0 || IDAGetNumSteps(ida, &steps);
  printf("y = %g %g after %ld steps\n", y[0], y[1], steps);
  bad = bad || fabs(y[0] - 1) > 1e-6 || fabs(y[1] - 1) > 1e-6;
  set(J, 0, 0, 0, 0);
  const int refused = SUNLinSolSetup(LS, J) > 0 || SUNLinSolSolve(LS, J, u, rate, 0) > 0; /* recoverable */
  IDAFree(&ida);
  SUNLinSolFree(LS);
  SUNMatDestroy(J);
  N_VDestroy(rate);
  N_VDestroy(u);
  SUNContext_Free(&context);
  return bad ? 1 : refused ? 0 : 2;
}
