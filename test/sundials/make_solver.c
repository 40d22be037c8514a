/* sunlinsol_mfs.h in a unit of C99. */
#include <sunlinsol_mfs.h>

#include <sunlinsol/sunlinsol_klu.h>

#include "problems.h"

SUNLinearSolver make_solver(Solver which, N_Vector y, SUNMatrix A, SUNContext context) {
  SUNLinearSolver S = which == BY_MFS ? SUNLinSol_MFS(y, A, context) : SUNLinSol_KLU(y, A, context);
  if (which == BY_MFS && S != NULL) SUNLinSol_MFSSetOption(S, "threads", "1");
  return S;
}

long int analyses_of(Solver which, SUNLinearSolver S) {
  return which == BY_MFS ? SUNLinSol_MFSGetNumAnalyses(S) : 0;
}
