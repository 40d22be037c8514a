// MFS behind PETSc's factored matrices and behind KSP.
#pragma once

#include <gtest/gtest.h>

#include "test/petsc/petsc_objects.hpp"
#include "test/solver/systems.hpp"

namespace mfs::test {

inline constexpr double kGood = kPromisedFor<PetscScalar>;

inline Sparse scalar_grid(std::int64_t rows, std::int64_t columns) {
  return in_scalar<PetscScalar>(grid_2d(rows, columns));
}

/// A KSP of one process with LU by MFS.
inline Krylov direct_solver(KSPType type = KSPPREONLY, const char* prefix = nullptr,
                            const char* solver = "mfs") {
  Krylov ksp;
  PC pc = nullptr;
  good(KSPCreate(PETSC_COMM_SELF, ksp.place()));
  good(KSPSetOptionsPrefix(ksp, prefix));
  good(KSPSetType(ksp, type));
  good(KSPGetPC(ksp, &pc));
  good(PCSetType(pc, PCLU));
  good(PCFactorSetMatSolverType(pc, solver));
  good(KSPSetFromOptions(ksp));
  return ksp;
}

inline Mat factors_of(KSP ksp) {
  PC pc = nullptr;
  Mat F = nullptr;
  good(KSPGetPC(ksp, &pc));
  good(PCFactorGetMatrix(pc, &F));
  return F;
}

inline MatFactorError factor_error(Mat F) {
  MatFactorError error = MAT_FACTOR_NOERROR;
  good(MatFactorGetError(F, &error));
  return error;
}

inline PetscInt zero_pivot_row(Mat F) {
  PetscReal pivot = 0;
  PetscInt row = -1;
  good(MatFactorGetErrorZeroPivot(F, &pivot, &row));
  return row;
}

inline KSPConvergedReason reason_of(KSP ksp) {
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  good(KSPGetConvergedReason(ksp, &reason));
  return reason;
}

inline std::string view_of(Mat F) {
  return text_of(PETSC_COMM_SELF, [&](PetscViewer viewer) { return MatView(F, viewer); });
}

/// Solves with `ksp`, which has its operators, a system with this right-hand side.
inline std::vector<PetscScalar> solved(KSP ksp, const std::vector<PetscScalar>& b) {
  const Vector rhs = petsc_vector(b), x = petsc_vector(std::vector<PetscScalar>(b.size()));
  good(KSPSolve(ksp, rhs, x));
  return entries_of(x);
}

/// The same, and the solution must be one of `a`, which the operators hold.
inline void expect_solved(KSP ksp, const Sparse& a) {
  const std::vector<PetscScalar> b = right_hand_sides(a, 1, a.n, 3);
  const std::vector<PetscScalar> x = solved(ksp, b);
  EXPECT_GT(reason_of(ksp), 0);
  EXPECT_LE(backward_error(a, b, x), kGood);
}

}  // namespace mfs::test
