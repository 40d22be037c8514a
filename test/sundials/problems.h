/* Problems for IDA and CVODE with sparse Jacobians, solved by KLU or by MFS. */
#ifndef MFS_TEST_SUNDIALS_PROBLEMS_H
#define MFS_TEST_SUNDIALS_PROBLEMS_H

#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_types.h>
#include <sunmatrix/sunmatrix_sparse.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum { BY_KLU, BY_MFS } Solver;

/* What an integration took, and where it ended. */
typedef struct {
  int status; /* of the last step */
  long int steps, evaluations, jacobians, nonlinear_iterations, error_test_failures;
  long int analyses; /* BY_MFS */
  double end[3];     /* some unknowns at the end */
} Course;

/* A solver for A and y, with one thread. */
SUNLinearSolver make_solver(Solver which, N_Vector y, SUNMatrix A, SUNContext context);

/* SUNLinSol_MFSGetNumAnalyses; 0 of KLU. */
long int analyses_of(Solver which, SUNLinearSolver S);

/* Heat in a square as a differential-algebraic system: boundary values are algebraic equations. IDA. */
Course heat(Solver which, int form, SUNContext context);
/* Brusselator in a rod. CVODE. The first Jacobian may have a NaN, or more entries than later ones, which are
 * 0. */
typedef enum { GOOD, FIRST_HAS_NAN, FIRST_HAS_OTHER_PATTERN } JacobianKind;
Course brusselator(Solver which, int form, JacobianKind kind, SUNContext context);
/* The same by an implicit method of Runge and Kutta. ARKODE. */
Course brusselator_by_arkode(Solver which, int form, SUNContext context);
/* A nonlinear system with three unknowns in each row. KINSOL; its iterations count as steps. */
Course equation(Solver which, int form, SUNContext context);

#ifdef __cplusplus
}
#endif

#endif
