// PETSc's headers, of which those for implementers of solvers are not C++ without warnings, and the arrays of
// its objects, held between get and restore.
#pragma once

#include <petsc/private/matimpl.h>

#include <type_traits>

#include <mfs/mfs.hpp>

namespace mfs::petsc {

static_assert(std::is_same_v<PetscReal, double> || std::is_same_v<PetscReal, float>,
              "MFS knows double and single precision");

using Scalar = PetscScalar;

/// What PETSC_SUCCESS is in newer versions.
constexpr PetscErrorCode kSuccess = static_cast<PetscErrorCode>(0);

/// Pattern and values of a MATSEQAIJ, where they lie.
class Rows {
 public:
  PetscErrorCode get(Mat a) {
    PetscBool done = PETSC_FALSE;
    PetscFunctionBegin;
    PetscCall(MatGetRowIJ(a, 0, PETSC_FALSE, PETSC_FALSE, &count_, &offsets_, &columns_, &done));
    PetscCheck(done, PETSC_COMM_SELF, PETSC_ERR_SUP, "MFS: a matrix of type %s shows no compressed rows",
               ((PetscObject)a)->type_name);
    PetscCall(MatSeqAIJGetArrayRead(a, &values_));
    PetscFunctionReturn(kSuccess);
  }
  PetscErrorCode restore(Mat a) {
    PetscBool done = PETSC_FALSE;
    PetscFunctionBegin;
    PetscCall(MatSeqAIJRestoreArrayRead(a, &values_));
    PetscCall(MatRestoreRowIJ(a, 0, PETSC_FALSE, PETSC_FALSE, &count_, &offsets_, &columns_, &done));
    PetscFunctionReturn(kSuccess);
  }
  CsrView<Scalar> view() const { return {count_, count_, offsets_, columns_, values_}; }

 private:
  PetscInt count_ = 0;
  const PetscInt *offsets_ = nullptr, *columns_ = nullptr;
  const PetscScalar* values_ = nullptr;
};

}  // namespace mfs::petsc
