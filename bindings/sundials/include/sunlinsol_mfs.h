/* MFS as a SUNLinearSolver of SUNDIALS (6 or 7): the direct solver of IDA, CVODE, ARKODE, KINSOL and their
   variants with sensitivities, for SUNMATRIX_SPARSE matrices in CSR or CSC form and vectors whose data lie in
   one array of the host.

     SUNMatrix A = SUNSparseMatrix(n, n, nonzeros, CSR_MAT, context);
     SUNLinearSolver LS = SUNLinSol_MFS(y, A, context);
     SUNLinSol_MFSSetOption(LS, "threads", "4");
     IDASetLinearSolver(ida, LS, A);

   It is used as SUNLinSol_KLU is, and needs no other call where the pattern changes: the matrix is then
   analysed anew. The header is C99 and C++, and belongs to the program: libmfs is built without SUNDIALS.
   Link mfs::mfs and SUNDIALS.

   What setup and solve return, and SUNLinSolLastFlag:
     0                          all is well
     SUNLS_LUFACT_FAIL          the matrix is singular: recoverable, so that integrators shorten the step
     SUNLS_PACKAGE_FAIL_REC     NaN or infinity in the matrix or the right-hand side, or a solution that
   missed the tolerance: recoverable, too MFS_SUNLS_UNRECOVERABLE    anything else: memory, threads, a device,
   a matrix that is none; mfs_last_error (mfs/mfs.h) has its text */
#ifndef SUNLINSOL_MFS_H
#define SUNLINSOL_MFS_H

#include <stdlib.h>
#include <string.h>

#include <mfs/mfs.h>
#include <sundials/sundials_config.h>
#include <sundials/sundials_linearsolver.h>
#include <sunmatrix/sunmatrix_sparse.h>

#if SUNDIALS_VERSION_MAJOR < 6
#error "MFS works with SUNDIALS 6 and 7"
#endif
#if defined(SUNDIALS_EXTENDED_PRECISION)
#error "MFS has no numbers of extended precision"
#endif
#if SUNDIALS_VERSION_MAJOR >= 7
#define MFS_SUNLS_UNRECOVERABLE SUN_ERR_EXT_FAIL
typedef SUNErrCode MfsSunError;
#else
#define MFS_SUNLS_UNRECOVERABLE SUNLS_PACKAGE_FAIL_UNREC
typedef int MfsSunError;
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* The content of a SUNLinearSolver. */
typedef struct {
  mfs_solver* solver;
  int analysed;      /* the pattern below is that of the last matrix */
  int transposed;    /* the matrix was in CSC form, which is the transposed one in CSR form */
  sunindextype flag; /* of the last call */
  long int analyses;
} MfsSunContent;

static inline MfsSunContent* mfs_sun_content(SUNLinearSolver S) {
  return (MfsSunContent*)S->content;
}

/* Keeps and returns the flag for a status of MFS. */
static inline int mfs_sun_flag(SUNLinearSolver S, int status) {
  const char* argument = mfs_last_error_argument();
  const int of_numbers = strcmp(argument, "values") == 0 || strcmp(argument, "b") == 0;
  int flag = MFS_SUNLS_UNRECOVERABLE;
  if (status == MFS_OK)
    flag = 0;
  else if (status == MFS_SINGULAR_MATRIX)
    flag = SUNLS_LUFACT_FAIL;
  else if (status == MFS_ACCURACY_NOT_REACHED || (status == MFS_INVALID_INPUT && of_numbers))
    flag = SUNLS_PACKAGE_FAIL_REC;
  mfs_sun_content(S)->flag = flag;
  return flag;
}

static inline SUNLinearSolver_Type mfs_sun_type(SUNLinearSolver S) {
  (void)S;
  return SUNLINEARSOLVER_DIRECT;
}
static inline SUNLinearSolver_ID mfs_sun_id(SUNLinearSolver S) {
  (void)S;
  return SUNLINEARSOLVER_CUSTOM;
}

/* The next setup analyses. */
static inline MfsSunError mfs_sun_initialize(SUNLinearSolver S) {
  mfs_sun_content(S)->analysed = 0;
  mfs_sun_content(S)->flag = 0;
  return 0;
}

static inline int mfs_sun_setup(SUNLinearSolver S, SUNMatrix A) {
  MfsSunContent* content = mfs_sun_content(S);
  const int transposed = SM_SPARSETYPE_S(A) == CSC_MAT;
  const int64_t n = SM_NP_S(A);
  const sunindextype *offsets = SM_INDEXPTRS_S(A), *indices = SM_INDEXVALS_S(A);
  int status = MFS_PATTERN_CHANGED;
  if (content->analysed && transposed == content->transposed)
    status = mfs_factor(content->solver, n, offsets, indices, SM_DATA_S(A));
  if (status == MFS_PATTERN_CHANGED) {
    status = mfs_analyze(content->solver, n, offsets, indices, SM_DATA_S(A));
    content->analysed = status == MFS_OK;
    content->transposed = transposed;
    ++content->analyses;
    if (status == MFS_OK) status = mfs_factor(content->solver, n, offsets, indices, SM_DATA_S(A));
  }
  return mfs_sun_flag(S, status);
}

static inline int mfs_sun_solve(SUNLinearSolver S, SUNMatrix A, N_Vector x, N_Vector b,
                                sunrealtype tolerance) {
  MfsSunContent* content = mfs_sun_content(S);
  const sunrealtype* from = N_VGetArrayPointer(b);
  sunrealtype* to = N_VGetArrayPointer(x);
  (void)A;
  (void)tolerance;
  return mfs_sun_flag(S, content->transposed ? mfs_solve_transpose(content->solver, from, to, 1, 0, 0)
                                             : mfs_solve(content->solver, from, to, 1, 0, 0));
}

static inline sunindextype mfs_sun_last_flag(SUNLinearSolver S) {
  return mfs_sun_content(S)->flag;
}

static inline MfsSunError mfs_sun_free(SUNLinearSolver S) {
  if (S == NULL) return 0;
  if (S->content != NULL) mfs_destroy(mfs_sun_content(S)->solver);
  free(S->content);
  S->content = NULL;
  SUNLinSolFreeEmpty(S);
  return 0;
}

/* A solver for systems with A, and for vectors as y; NULL where A is not square or not sparse, where y has
   another length or no array, or without memory. Its matrix is A or another of the same kind and size. */
static inline SUNLinearSolver SUNLinSol_MFS(N_Vector y, SUNMatrix A, SUNContext context) {
  const int scalar = sizeof(sunrealtype) == 4 ? MFS_FLOAT : MFS_DOUBLE;
  SUNLinearSolver S;
  MfsSunContent* content;
  if (y == NULL || A == NULL || SUNMatGetID(A) != SUNMATRIX_SPARSE || SM_ROWS_S(A) != SM_COLUMNS_S(A))
    return NULL;
  if (y->ops->nvgetarraypointer == NULL || N_VGetLength(y) != SM_ROWS_S(A)) return NULL;
  S = SUNLinSolNewEmpty(context);
  if (S == NULL) return NULL;
  S->ops->gettype = mfs_sun_type;
  S->ops->getid = mfs_sun_id;
  S->ops->initialize = mfs_sun_initialize;
  S->ops->setup = mfs_sun_setup;
  S->ops->solve = mfs_sun_solve;
  S->ops->lastflag = mfs_sun_last_flag;
  S->ops->free = mfs_sun_free;
  content = (MfsSunContent*)calloc(1, sizeof *content);
  S->content = content;
  if (content == NULL || mfs_create(scalar, 8 * (int)sizeof(sunindextype), &content->solver) != MFS_OK) {
    mfs_sun_free(S);
    return NULL;
  }
  return S;
}

/* Sets an option of MFS (mfs_set_option of mfs/mfs.h) before the first step. Returns a status of MFS. */
static inline int SUNLinSol_MFSSetOption(SUNLinearSolver S, const char* name, const char* value) {
  return mfs_set_option(mfs_sun_content(S)->solver, name, value);
}
/* The solver itself, for mfs_report and mfs_condition_estimate. It stays S'. */
static inline mfs_solver* SUNLinSol_MFSGetSolver(SUNLinearSolver S) {
  return mfs_sun_content(S)->solver;
}
/* How often a pattern was analysed. */
static inline long int SUNLinSol_MFSGetNumAnalyses(SUNLinearSolver S) {
  return mfs_sun_content(S)->analyses;
}

#ifdef __cplusplus
}
#endif

#endif
