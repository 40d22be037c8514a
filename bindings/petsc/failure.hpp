// Exceptions of libmfs as PETSc tells of errors. Two kinds: a matrix that cannot be factored is no error of
// the call; MatFactorGetError says so, KSP then ends with KSP_DIVERGED_PC_FAILED, and SNES and TS go on with
// a shorter step. All else is a PetscErrorCode.
#pragma once

#include "petsc_access.hpp"

namespace mfs::petsc {

/// Holds no memory: it is made while exceptions are handled.
struct Failure {
  bool happened = false;
  MatFactorError factor_error = MAT_FACTOR_NOERROR;  ///< of the second kind: none
  bool of_right_hand_side = false;                   ///< it has a NaN or infinity; the factors are good
  PetscErrorCode code = kSuccess;
  PetscInt row = -1;  ///< 0-based; -1: none is known
  char text[512] = "";
};

/// Describes the exception that is being handled.
Failure describe_current_exception() noexcept;

/// Runs `work` and lets nothing out.
template <class Work>
Failure attempt(const Work& work) noexcept {
  try {
    work();
  } catch (...) {
    return describe_current_exception();
  }
  return {};
}

/// Leaves a failure in the factored matrix `F`. An error of PETSc where it is of the second kind, or where
/// `strict` (MatSetErrorIfFailure) asks for one.
PetscErrorCode leave_failure(Mat F, const Failure& failure, PetscBool strict);

}  // namespace mfs::petsc
