#include "failure.hpp"

#include <cstdio>
#include <exception>
#include <new>
#include <string>

namespace mfs::petsc {
namespace {

Failure failure_of(MatFactorError factor_error, int code, const char* text, std::int64_t row = -1) {
  Failure failure;
  failure.happened = true;
  failure.factor_error = factor_error;
  failure.code = static_cast<PetscErrorCode>(code);
  failure.row = static_cast<PetscInt>(row);
  std::snprintf(failure.text, sizeof failure.text, "%s", text);
  return failure;
}

Failure describe(const InvalidInput& e) {
  // NaN and infinity come from functions outside of their range, where SNES and TS shorten the step. PETSc's
  // own LU calls them zero pivots, too.
  if (e.argument() == "values")
    return failure_of(MAT_FACTOR_NUMERIC_ZEROPIVOT, PETSC_ERR_FP, e.what(), e.row());
  Failure failure = failure_of(MAT_FACTOR_NOERROR, PETSC_ERR_ARG_OUTOFRANGE, e.what(), e.row());
  failure.of_right_hand_side = e.argument() == "b";
  if (failure.of_right_hand_side) failure.code = static_cast<PetscErrorCode>(PETSC_ERR_FP);
  return failure;
}

}  // namespace

Failure describe_current_exception() noexcept {
  try {
    throw;
  } catch (const SingularMatrix& e) {
    return failure_of(MAT_FACTOR_NUMERIC_ZEROPIVOT, PETSC_ERR_MAT_LU_ZRPVT, e.what(), e.row());
  } catch (const AccuracyNotReached& e) {
    return failure_of(MAT_FACTOR_NUMERIC_ZEROPIVOT, PETSC_ERR_CONV_FAILED, e.what());
  } catch (const OutOfMemory& e) {
    return failure_of(MAT_FACTOR_OUTMEMORY, PETSC_ERR_MEM, e.what());
  } catch (const std::bad_alloc&) {
    return failure_of(MAT_FACTOR_OUTMEMORY, PETSC_ERR_MEM, "out of host memory");
  } catch (const PatternChanged& e) {
    return failure_of(MAT_FACTOR_NOERROR, PETSC_ERR_ARG_WRONGSTATE, e.what(), e.row());
  } catch (const InvalidInput& e) {
    return describe(e);
  } catch (const BackendError& e) {
    return failure_of(MAT_FACTOR_OTHER, PETSC_ERR_LIB, e.what());
  } catch (const std::exception& e) {
    return failure_of(MAT_FACTOR_NOERROR, PETSC_ERR_LIB, e.what());
  } catch (...) {
    return failure_of(MAT_FACTOR_NOERROR, PETSC_ERR_LIB, "unknown exception");
  }
}

PetscErrorCode leave_failure(Mat F, const Failure& failure, PetscBool strict) {
  PetscFunctionBegin;
  PetscCheck(!strict && failure.factor_error != MAT_FACTOR_NOERROR, PETSC_COMM_SELF, failure.code, "MFS: %s",
             failure.text);
  F->factorerrortype = failure.factor_error;
  F->factorerror_zeropivot_value = 0;
  F->factorerror_zeropivot_row = failure.row;
  PetscCall(PetscInfo(F, "MFS: %s\n", failure.text));
  PetscFunctionReturn(kSuccess);
}

}  // namespace mfs::petsc
