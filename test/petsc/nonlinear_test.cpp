// MFS below Newton's method and time steps: new values for one pattern, and factorizations that fail on the
// way.
#include <gmock/gmock.h>
#include <petscts.h>

#include "test/petsc/factored.hpp"

namespace mfs::test {
namespace {

using testing::HasSubstr;
using Nonlinear = Held<SNES, SNESDestroy>;
using Stepper = Held<TS, TSDestroy>;

// ---- SNES: -laplace(u) = lambda exp(u) on a square, zero at the boundary (Bratu), as in SNES tutorial ex5
// ----

constexpr PetscInt kPoints = 24;
constexpr double kLambda = 6.0;

/// Calls visit(row, column) for each neighbour of a point inside of the square.
template <class Visit>
void neighbours(PetscInt row, const Visit& visit) {
  const PetscInt x = row % kPoints, y = row / kPoints;
  if (x > 0) visit(row - 1);
  if (x < kPoints - 1) visit(row + 1);
  if (y > 0) visit(row - kPoints);
  if (y < kPoints - 1) visit(row + kPoints);
}

constexpr double kSource = kLambda / ((kPoints + 1) * (kPoints + 1));

PetscErrorCode bratu(SNES, Vec u, Vec f, void*) {
  const std::vector<PetscScalar> at = entries_of(u);
  PetscScalar* out = nullptr;
  good(VecGetArray(f, &out));
  for (PetscInt i = 0; i < kPoints * kPoints; ++i) {
    out[i] = 4.0 * at[i] - kSource * PetscExpScalar(at[i]);
    neighbours(i, [&](PetscInt j) { out[i] -= at[j]; });
  }
  good(VecRestoreArray(f, &out));
  return static_cast<PetscErrorCode>(0);
}

PetscErrorCode bratu_jacobian(SNES, Vec u, Mat J, Mat, void*) {
  const std::vector<PetscScalar> at = entries_of(u);
  for (PetscInt i = 0; i < kPoints * kPoints; ++i) {
    good(MatSetValue(J, i, i, 4.0 - kSource * PetscExpScalar(at[i]), INSERT_VALUES));
    neighbours(i, [&](PetscInt j) { good(MatSetValue(J, i, j, -1.0, INSERT_VALUES)); });
  }
  good(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  good(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  return static_cast<PetscErrorCode>(0);
}

struct NewtonResult {
  PetscInt iterations = 0;
  PetscReal residual = 0;
  std::vector<PetscScalar> u;
  std::string view;
};

NewtonResult solve_bratu(const char* solver) {
  const Option pc("-pc_type", "lu"), ksp_type("-ksp_type", "preonly"),
      type("-pc_factor_mat_solver_type", solver);
  const PetscInt n = kPoints * kPoints;
  Nonlinear snes;
  Matrix J;
  good(MatCreateSeqAIJ(PETSC_COMM_SELF, n, n, 5, nullptr, J.place()));
  const Vector u = petsc_vector(std::vector<PetscScalar>(n)), f = petsc_vector(std::vector<PetscScalar>(n));
  good(SNESCreate(PETSC_COMM_SELF, snes.place()));
  good(SNESSetFunction(snes, f, bratu, nullptr));
  good(SNESSetJacobian(snes, J, J, bratu_jacobian, nullptr));
  good(SNESSetTolerances(snes, 1e-12, 1e-13, 0, 50, 1000));
  good(SNESSetFromOptions(snes));
  good(SNESSolve(snes, nullptr, u));
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  KSP ksp = nullptr;
  NewtonResult result;
  good(SNESGetConvergedReason(snes, &reason));
  EXPECT_GT(reason, 0) << solver;
  good(SNESGetIterationNumber(snes, &result.iterations));
  good(SNESGetFunctionNorm(snes, &result.residual));
  good(SNESGetKSP(snes, &ksp));
  result.view = view_of(factors_of(ksp));
  result.u = entries_of(u);
  return result;
}

TEST(PetscNonlinear, NewtonsMethodAnalysesOnce) {
  const NewtonResult mfs = solve_bratu("mfs"), petsc = solve_bratu("petsc");
  EXPECT_EQ(mfs.iterations, petsc.iterations);
  EXPECT_GE(mfs.iterations, 3);
  double distance = 0;
  for (std::size_t i = 0; i < mfs.u.size(); ++i)
    distance = std::max<double>(distance, std::abs(mfs.u[i] - petsc.u[i]));
  EXPECT_LE(distance, 1e-12);
  EXPECT_THAT(mfs.view, HasSubstr("analyses 1, factorizations " + std::to_string(mfs.iterations) + ","));
}

// ---- TS: u' = 2 u, five times over. Backward Euler's matrix is 1/dt - 2: singular for dt = 1/2 ----

constexpr PetscInt kUnknowns = 5;

PetscErrorCode growth(TS, PetscReal, Vec u, Vec rate, Vec f, void*) {
  good(VecCopy(rate, f));
  good(VecAXPY(f, -2.0, u));
  return static_cast<PetscErrorCode>(0);
}

PetscErrorCode growth_jacobian(TS, PetscReal, Vec, Vec, PetscReal shift, Mat J, Mat, void*) {
  for (PetscInt i = 0; i < kUnknowns; ++i) good(MatSetValue(J, i, i, shift - 2.0, INSERT_VALUES));
  good(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  good(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  return static_cast<PetscErrorCode>(0);
}

struct Steps {
  PetscInt taken = 0, failed = 0;
  TSConvergedReason reason = TS_CONVERGED_ITERATING;
  std::vector<PetscScalar> u;
};

Steps grow(const char* solver) {
  const Option pc("-pc_type", "lu"), ksp_type("-ksp_type", "preonly"),
      type("-pc_factor_mat_solver_type", solver);
  Stepper ts;
  Matrix J;
  good(MatCreateSeqAIJ(PETSC_COMM_SELF, kUnknowns, kUnknowns, 1, nullptr, J.place()));
  const Vector u = petsc_vector(std::vector<PetscScalar>(kUnknowns, 1.0));
  good(TSCreate(PETSC_COMM_SELF, ts.place()));
  good(TSSetType(ts, TSBEULER));
  good(TSSetIFunction(ts, nullptr, growth, nullptr));
  good(TSSetIJacobian(ts, J, J, growth_jacobian, nullptr));
  good(TSSetTimeStep(ts, 0.5));
  good(TSSetMaxTime(ts, 1.0));
  good(TSSetMaxSNESFailures(ts, -1));
  good(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  good(TSSetFromOptions(ts));
  good(TSSolve(ts, u));
  Steps steps;
  good(TSGetConvergedReason(ts, &steps.reason));
  good(TSGetStepNumber(ts, &steps.taken));
  good(TSGetSNESFailures(ts, &steps.failed));
  steps.u = entries_of(u);
  return steps;
}

TEST(PetscNonlinear, TimeStepsGetShorterWhereTheMatrixIsSingular) {
  const Steps mfs = grow("mfs"), petsc = grow("petsc");
  EXPECT_GT(mfs.reason, 0);
  EXPECT_GE(mfs.failed, 1) << "the first step has a singular matrix";
  EXPECT_EQ(mfs.failed, petsc.failed);
  EXPECT_EQ(mfs.taken, petsc.taken);
  for (PetscInt i = 0; i < kUnknowns; ++i)
    EXPECT_LE(std::abs(mfs.u[i] - petsc.u[i]), 1e-12 * std::abs(petsc.u[i]));
}

}  // namespace
}  // namespace mfs::test
