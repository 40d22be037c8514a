// The solver "mfs" of PETSc: which function of ours serves which operation of a factored matrix. Every call
// into libmfs goes through attempt (failure.hpp): no exception passes PETSc's frames, which are C.
#include "mfs_petsc.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "factor.hpp"

namespace mfs::petsc {
namespace {

Factor* factor_in(Mat F) {
  return static_cast<Factor*>(F->data);
}

// ---- solve ----

/// After a solve that failed the solution is infinite, as PETSc wants it: norms carry that to all ranks.
PetscErrorCode leave_solve_failure(Mat F, const Failure& failure) {
  PetscFunctionBegin;
  if (failure.of_right_hand_side && !factor_in(F)->strict)
    PetscCall(PetscInfo(F, "MFS: %s\n", failure.text));
  else
    PetscCall(leave_failure(F, failure, factor_in(F)->strict));
  PetscFunctionReturn(kSuccess);
}

/// Of `n` numbers. (VecSetInf is PETSc's own since 3.22.)
void set_infinite(PetscScalar* x, PetscInt n) {
  std::fill_n(x, n, PetscScalar(std::numeric_limits<PetscReal>::infinity()));
}

void solve(Factor& factor, bool transposed, const PetscScalar* b, PetscScalar* x, PetscInt columns,
           PetscInt ldb, PetscInt ldx) {
  if (transposed)
    factor.solver().solve_transpose(b, x, columns, ldb, ldx);
  else
    factor.solver().solve(b, x, columns, ldb, ldx);
}

PetscErrorCode solve_vector(Mat F, Vec b, Vec x, bool transposed) {
  const PetscScalar* from = nullptr;
  PetscScalar* to = nullptr;
  PetscFunctionBegin;
  PetscCall(VecGetArrayRead(b, &from));
  PetscCall(VecGetArrayWrite(x, &to));
  const Failure failure = attempt([&] { solve(*factor_in(F), transposed, from, to, 1, 0, 0); });
  if (failure.happened) set_infinite(to, F->rmap->n);
  PetscCall(VecRestoreArrayWrite(x, &to));
  PetscCall(VecRestoreArrayRead(b, &from));
  if (failure.happened) PetscCall(leave_solve_failure(F, failure));
  PetscFunctionReturn(kSuccess);
}

PetscErrorCode solve_plain(Mat F, Vec b, Vec x) {
  return solve_vector(F, b, x, false);
}
PetscErrorCode solve_transpose(Mat F, Vec b, Vec x) {
  return solve_vector(F, b, x, true);
}

PetscErrorCode solve_dense(Mat F, Mat B, Mat X, bool transposed) {
  const PetscInt n = F->rmap->n;
  const PetscScalar* from = nullptr;
  PetscScalar* to = nullptr;
  PetscInt ldb = 0, ldx = 0, columns = 0;
  Failure failure;
  PetscFunctionBegin;
  PetscCall(MatGetSize(B, nullptr, &columns));
  PetscCall(MatDenseGetLDA(B, &ldb));
  PetscCall(MatDenseGetLDA(X, &ldx));
  PetscCall(MatDenseGetArrayRead(B, &from));
  PetscCall(MatDenseGetArrayWrite(X, &to));
  if (columns > 0 && F->factorerrortype == MAT_FACTOR_NOERROR)
    failure = attempt([&] { solve(*factor_in(F), transposed, from, to, columns, ldb, ldx); });
  if (failure.happened || F->factorerrortype != MAT_FACTOR_NOERROR)
    for (PetscInt j = 0; j < columns; ++j) set_infinite(to + j * ldx, n);
  PetscCall(MatDenseRestoreArrayWrite(X, &to));
  PetscCall(MatDenseRestoreArrayRead(B, &from));
  if (failure.happened) PetscCall(leave_solve_failure(F, failure));
  PetscFunctionReturn(kSuccess);
}

PetscErrorCode solve_many(Mat F, Mat B, Mat X) {
  return solve_dense(F, B, X, false);
}
PetscErrorCode solve_many_transpose(Mat F, Mat B, Mat X) {
  return solve_dense(F, B, X, true);
}

// ---- factor ----

PetscErrorCode numeric(Mat F, Mat A, const MatFactorInfo*) {
  Rows rows;
  PetscFunctionBegin;
  PetscCall(MatFactorClearError(F));
  F->ops->solve = solve_plain;
  F->ops->solvetranspose = solve_transpose;
  F->ops->matsolve = solve_many;
  F->ops->matsolvetranspose = solve_many_transpose;
  if (A->rmap->n == 0) PetscFunctionReturn(kSuccess);
  PetscCall(rows.get(A));
  factor_in(F)->strict = A->erroriffailure;
  const Failure failure = attempt([&] { factor_in(F)->factorize(rows.view()); });
  PetscCall(rows.restore(A));
  if (failure.happened) {
    F->factorerrortype = MAT_FACTOR_OTHER;  // also where an error is raised: the factors are of other values
    PetscCall(leave_failure(F, failure, A->erroriffailure));
  }
  PetscFunctionReturn(kSuccess);
}

/// With options from the database, and its log among PETSc's own (-info).
PetscErrorCode make_factor(Mat F) {
  Options options;
  PetscBool informs = PETSC_FALSE;
  PetscFunctionBegin;
  PetscCall(read_options(F, &options));
  PetscCall(PetscInfoEnabled(MAT_CLASSID, &informs));
  const Failure failure = attempt([&] {
    if (informs) {
      options.verbosity = 2;
      options.log = [F](const std::string& line) {
        static_cast<void>(PetscInfo(F, "MFS: %s\n", line.c_str()));
      };
    }
    F->data = new Factor(std::move(options));
  });
  PetscCheck(!failure.happened, PETSC_COMM_SELF, failure.code, "MFS: %s", failure.text);
  PetscFunctionReturn(kSuccess);
}

PetscErrorCode symbolic(Mat F, Mat A, IS, IS, const MatFactorInfo*) {
  Rows rows;
  PetscFunctionBegin;
  if (A->rmap->n > 0 && F->data == nullptr) PetscCall(make_factor(F));
  F->ops->lufactornumeric = numeric;
  if (A->rmap->n == 0) PetscFunctionReturn(kSuccess);
  PetscCall(rows.get(A));
  const Failure failure = attempt([&] { factor_in(F)->analyze(rows.view()); });
  PetscCall(rows.restore(A));
  // What depends on values is left to the numeric phase, which tries again: PETSc asks here for errors of the
  // pattern, which would stay.
  if (failure.happened && failure.factor_error != MAT_FACTOR_NUMERIC_ZEROPIVOT)
    PetscCall(leave_failure(F, failure, A->erroriffailure));
  PetscFunctionReturn(kSuccess);
}

// ---- the object ----

PetscErrorCode destroy(Mat F) {
  PetscFunctionBegin;
  delete factor_in(F);
  F->data = nullptr;
  PetscCall(PetscObjectComposeFunction((PetscObject)F, "MatFactorGetSolverType_C", nullptr));
  PetscFunctionReturn(kSuccess);
}

PetscErrorCode info(Mat F, MatInfoType, MatInfo* info) {
  PetscFunctionBegin;
  PetscCall(PetscMemzero(info, sizeof *info));
  info->block_size = 1;
  if (factor_in(F) != nullptr && factor_in(F)->solver().analyzed()) {
    const Report& report = factor_in(F)->solver().report();
    info->nz_used = info->nz_allocated = static_cast<PetscLogDouble>(report.nnz_factor);
    info->memory = static_cast<PetscLogDouble>(std::max(report.bytes_used, report.bytes_peak));
    info->fill_ratio_needed = info->nz_used / static_cast<PetscLogDouble>(report.nnz);
  }
  PetscFunctionReturn(kSuccess);
}

PetscErrorCode view(Mat F, PetscViewer viewer) {
  PetscBool ascii = PETSC_FALSE;
  PetscViewerFormat format = PETSC_VIEWER_DEFAULT;
  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare((PetscObject)viewer, PETSCVIEWERASCII, &ascii));
  if (ascii) PetscCall(PetscViewerGetFormat(viewer, &format));
  if (ascii && (format == PETSC_VIEWER_ASCII_INFO || format == PETSC_VIEWER_ASCII_INFO_DETAIL))
    PetscCall(view_factor(factor_in(F), viewer));
  PetscFunctionReturn(kSuccess);
}

PetscErrorCode solver_type(Mat, MatSolverType* type) {
  PetscFunctionBegin;
  *type = MATSOLVERMFS;
  PetscFunctionReturn(kSuccess);
}

PetscErrorCode get_factor(Mat A, MatFactorType type, Mat* result) {
  Mat F = nullptr;
  PetscFunctionBegin;
  PetscCheck(A->rmap->n == A->cmap->n, PETSC_COMM_SELF, PETSC_ERR_ARG_SIZ,
             "MFS: the matrix is not square: %" PetscInt_FMT " rows, %" PetscInt_FMT " columns", A->rmap->n,
             A->cmap->n);
  PetscCall(MatCreate(PetscObjectComm((PetscObject)A), &F));
  PetscCall(MatSetSizes(F, A->rmap->n, A->cmap->n, A->rmap->N, A->cmap->N));
  PetscCall(PetscStrallocpy(MATSOLVERMFS, &((PetscObject)F)->type_name));
  PetscCall(MatSetUp(F));
  F->ops->lufactorsymbolic = symbolic;
  F->ops->destroy = destroy;
  F->ops->getinfo = info;
  F->ops->view = view;
  F->factortype = type;
  F->assembled = F->preallocated = PETSC_TRUE;  // or -ksp_view shows nothing
  PetscCall(PetscFree(F->solvertype));
  PetscCall(PetscStrallocpy(MATSOLVERMFS, &F->solvertype));
  PetscCall(PetscObjectComposeFunction((PetscObject)F, "MatFactorGetSolverType_C", solver_type));
  *result = F;
  PetscFunctionReturn(kSuccess);
}

/// Private headers of PETSc fix where its structures have what, so only the version of the build will do.
PetscErrorCode check_petsc() {
  PetscInt major = 0, minor = 0, subminor = 0, release = 0;
  std::size_t index_bytes = 0;
  PetscDataType scalar = PETSC_DATATYPE_UNKNOWN;
  PetscBool known = PETSC_FALSE;
  PetscFunctionBegin;
  PetscCall(PetscGetVersionNumber(&major, &minor, &subminor, &release));
  PetscCheck(major == PETSC_VERSION_MAJOR && minor == PETSC_VERSION_MINOR, PETSC_COMM_SELF, PETSC_ERR_LIB,
             "MFS was built for PETSc %d.%d, this is %d.%d", PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR,
             static_cast<int>(major), static_cast<int>(minor));
  PetscCall(PetscDataTypeGetSize(PETSC_INT, &index_bytes));
  PetscCall(PetscDataTypeFromString("scalar", &scalar, &known));
  PetscCheck(index_bytes == sizeof(PetscInt) && scalar == PETSC_SCALAR, PETSC_COMM_SELF, PETSC_ERR_LIB,
             "MFS was built for a PETSc with other scalars or integers than this one: each has a plug-in of "
             "its own");
  PetscFunctionReturn(kSuccess);
}

}  // namespace
}  // namespace mfs::petsc

MFS_API PetscErrorCode MatSolverTypeRegister_MFS() {
  PetscFunctionBegin;
  PetscCall(mfs::petsc::check_petsc());
  PetscCall(MatInitializePackage());  // first, or 3.18 forgets all other solvers
  PetscCall(MatSolverTypeRegister(MATSOLVERMFS, MATSEQAIJ, MAT_FACTOR_LU, mfs::petsc::get_factor));
  PetscFunctionReturn(mfs::petsc::kSuccess);
}

/// What PETSc calls after it has loaded the plug-in: the name has that of the file in it.
extern "C" MFS_API PetscErrorCode MFS_PETSC_REGISTER() {
  PetscFunctionBegin;
  PetscCall(MatSolverTypeRegister_MFS());
  PetscFunctionReturn(mfs::petsc::kSuccess);
}
