/* MFS as a solver of PETSc: MATSOLVERMFS, LU of MATSEQAIJ.

   A program need not know of this header: with
     -dll_append <path>/libmfs_petsc.so -pc_type lu -pc_factor_mat_solver_type mfs
   PETSc loads the plug-in and registers the solver itself. A program that is linked with the plug-in calls
   MatSolverTypeRegister_MFS once, after PetscInitialize. docs/petsc.md lists options and errors. */
#pragma once

#include <petscmat.h>

#define MATSOLVERMFS "mfs"

/* Errors: PETSC_ERR_LIB where the running PETSc is not of the version, the scalars and the indices that the
   plug-in was built for. */
PETSC_EXTERN PetscErrorCode MatSolverTypeRegister_MFS(void);
