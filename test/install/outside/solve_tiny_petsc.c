/* A program of PETSc that is linked with the plug-in and registers it itself. */
#include <mfs_petsc.h>
#include <petscksp.h>

int main(int argc, char** argv) {
  const PetscInt row_offsets[] = {0, 2, 5, 7}, columns[] = {0, 1, 0, 1, 2, 1, 2};
  PetscScalar values[] = {4, -1, -1, 4, -1, -1, 4};
  const PetscScalar right_hand_side[] = {3, 2, 3}, *solution;
  KSP ksp;
  PC pc;
  Mat a, factors;
  MatSolverType solver;
  Vec b, x;
  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(MatSolverTypeRegister_MFS());
  PetscCall(MatCreateSeqAIJWithArrays(PETSC_COMM_SELF, 3, 3, (PetscInt*)row_offsets, (PetscInt*)columns, values, &a));
  PetscCall(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, 3, right_hand_side, &b));
  PetscCall(VecCreateSeq(PETSC_COMM_SELF, 3, &x));
  PetscCall(KSPCreate(PETSC_COMM_SELF, &ksp));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPSetOperators(ksp, a, a));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCLU));
  PetscCall(PCFactorSetMatSolverType(pc, MATSOLVERMFS));
  PetscCall(KSPSolve(ksp, b, x));
  PetscCall(PCFactorGetMatrix(pc, &factors));
  PetscCall(MatFactorGetSolverType(factors, &solver));
  PetscCall(VecGetArrayRead(x, &solution));
  PetscCall(PetscPrintf(PETSC_COMM_SELF, "x = %g %g %g, by %s\n", (double)PetscRealPart(solution[0]),
                        (double)PetscRealPart(solution[1]), (double)PetscRealPart(solution[2]), solver));
  PetscCall(VecRestoreArrayRead(x, &solution));
  PetscCall(KSPDestroy(&ksp));
  PetscCall(MatDestroy(&a));
  PetscCall(VecDestroy(&b));
  PetscCall(VecDestroy(&x));
  PetscCall(PetscFinalize());
  return 0;
}
