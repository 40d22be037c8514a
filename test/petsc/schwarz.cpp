// mfs_petsc_schwarz: convection and diffusion in a cube, spread by rows over the ranks, solved by GMRES with
// PETSc's preconditioners of subdomains, whose matrices MFS factors, beside other solvers. Not linked with
// the plug-in, and nothing of it is named here:
//   mpiexec -n 4 mfs_petsc_schwarz -dll_append .../libmfs_petsc.so -pc_type asm -solvers mfs,petsc,mumps
// -n: points per edge; -option_of_solver: which option, without its hyphen, takes the name of the solver;
// -singular: the last rank has a row of zeros. Prints a line per solver and set of values, ends with 1 where
// the solvers do not agree.
#include <petscksp.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

namespace {

struct Cube {
  Mat a = nullptr;
  Vec b = nullptr, x = nullptr, r = nullptr;
};

/// Values for the pattern of `cube`; `strength` of the convection.
PetscErrorCode fill(Cube& cube, PetscInt n, double strength, bool singular) {
  PetscInt first = 0, last = 0;
  PetscFunctionBegin;
  PetscCall(MatGetOwnershipRange(cube.a, &first, &last));
  for (PetscInt i = first; i < last; ++i) {
    const PetscInt place[] = {i % n, i / n % n, i / (n * n)}, step[] = {1, n, n * n};
    const bool zero = singular && i == n * n * n - 7;
    PetscCall(MatSetValue(cube.a, i, i, zero ? 0.0 : 6.0, INSERT_VALUES));
    for (int d = 0; d < 3; ++d) {
      const double up = zero ? 0.0 : -1.0 + strength * (d + 1) / 4,
                   down = zero ? 0.0 : -1.0 - strength * (d + 1) / 4;
      if (place[d] > 0) PetscCall(MatSetValue(cube.a, i, i - step[d], down, INSERT_VALUES));
      if (place[d] < n - 1) PetscCall(MatSetValue(cube.a, i, i + step[d], up, INSERT_VALUES));
    }
  }
  PetscCall(MatAssemblyBegin(cube.a, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(cube.a, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(static_cast<PetscErrorCode>(0));
}

PetscErrorCode make(Cube& cube, PetscInt n) {
  PetscFunctionBegin;
  PetscCall(MatCreateAIJ(PETSC_COMM_WORLD, PETSC_DECIDE, PETSC_DECIDE, n * n * n, n * n * n, 7, nullptr, 6,
                         nullptr, &cube.a));
  PetscCall(MatCreateVecs(cube.a, &cube.x, &cube.b));
  PetscCall(VecDuplicate(cube.b, &cube.r));
  PetscCall(VecSet(cube.b, 1.0));
  PetscFunctionReturn(static_cast<PetscErrorCode>(0));
}

struct Outcome {
  PetscInt iterations = 0, reason = 0;
  double residual = 0;  ///< |b - A x| / |b|
  double seconds = 0;
};

PetscErrorCode solve(KSP ksp, Cube& cube, Outcome& outcome) {
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscReal size = 0, distance = 0;
  double start = 0;
  PetscFunctionBegin;
  start = MPI_Wtime();
  PetscCall(KSPSolve(ksp, cube.b, cube.x));
  outcome.seconds = MPI_Wtime() - start;
  PetscCall(KSPGetConvergedReason(ksp, &reason));
  PetscCall(KSPGetIterationNumber(ksp, &outcome.iterations));
  PetscCall(MatMult(cube.a, cube.x, cube.r));
  PetscCall(VecAYPX(cube.r, -1.0, cube.b));
  PetscCall(VecNorm(cube.b, NORM_2, &size));
  PetscCall(VecNorm(cube.r, NORM_2, &distance));
  outcome.reason = reason;
  outcome.residual = distance / size;
  PetscFunctionReturn(static_cast<PetscErrorCode>(0));
}

/// A first solve, one with new values, and how often subdomains were analysed meanwhile, by -ksp_view.
PetscErrorCode run(const std::string& solver, PetscInt n, bool singular, Outcome outcomes[2]) {
  Cube cube;
  KSP ksp = nullptr;
  char option[128] = "sub_pc_factor_mat_solver_type";
  PetscFunctionBegin;
  PetscCall(PetscOptionsGetString(nullptr, nullptr, "-option_of_solver", option, sizeof option, nullptr));
  PetscCall(PetscOptionsSetValue(nullptr, (std::string("-") + option).c_str(), solver.c_str()));
  PetscCall(make(cube, n));
  PetscCall(KSPCreate(PETSC_COMM_WORLD, &ksp));
  PetscCall(KSPSetOperators(ksp, cube.a, cube.a));
  PetscCall(KSPSetTolerances(ksp, 1e-10, PETSC_DEFAULT, PETSC_DEFAULT, 1000));
  PetscCall(KSPSetFromOptions(ksp));
  for (int k = 0; k < 2; ++k) {
    PetscCall(fill(cube, n, k == 0 ? 0.3 : 0.5, singular));
    PetscCall(solve(ksp, cube, outcomes[k]));
  }
  PetscCall(KSPDestroy(&ksp));
  PetscCall(MatDestroy(&cube.a));
  for (Vec* v : {&cube.b, &cube.x, &cube.r}) PetscCall(VecDestroy(v));
  PetscFunctionReturn(static_cast<PetscErrorCode>(0));
}

std::vector<std::string> parts_of(const char* list) {
  std::vector<std::string> parts(1);
  for (; *list != '\0'; ++list)
    if (*list == ',')
      parts.emplace_back();
    else
      parts.back().push_back(*list);
  return parts;
}

/// Whether an outcome is what the problem should give, and on all ranks.
bool right(const Outcome& outcome, bool singular) {
  PetscInt mine = outcome.reason, least = 0, most = 0;
  MPI_Allreduce(&mine, &least, 1, MPIU_INT, MPI_MIN, PETSC_COMM_WORLD);
  MPI_Allreduce(&mine, &most, 1, MPIU_INT, MPI_MAX, PETSC_COMM_WORLD);
  if (least != most) return false;
  return singular ? mine == KSP_DIVERGED_PC_FAILED : mine > 0 && outcome.residual < 1e-8;
}

PetscErrorCode compare(bool* agree) {
  PetscInt n = 12;
  PetscBool singular = PETSC_FALSE;
  PetscMPIInt ranks = 1;
  char solvers[256] = "mfs";
  Outcome first[2];
  PetscFunctionBegin;
  PetscCall(PetscOptionsGetInt(nullptr, nullptr, "-n", &n, nullptr));
  PetscCall(PetscOptionsGetString(nullptr, nullptr, "-solvers", solvers, sizeof solvers, nullptr));
  PetscCall(PetscOptionsHasName(nullptr, nullptr, "-singular", &singular));
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  const std::vector<std::string> names = parts_of(solvers);
  for (const std::string& name : names) {
    Outcome outcomes[2];
    PetscCall(run(name, n, singular == PETSC_TRUE, outcomes));
    for (int k = 0; k < 2; ++k) {
      if (&name == &names.front()) first[k] = outcomes[k];
      *agree = *agree && right(outcomes[k], singular) && outcomes[k].iterations == first[k].iterations;
      PetscCall(PetscPrintf(PETSC_COMM_WORLD,
                            "%d ranks, %" PetscInt_FMT " unknowns, %s, values %d: reason %" PetscInt_FMT
                            ", %" PetscInt_FMT " iterations, residual %.1e, %.3f s\n",
                            ranks, n * n * n, name.c_str(), k + 1, outcomes[k].reason, outcomes[k].iterations,
                            outcomes[k].residual, outcomes[k].seconds));
    }
  }
  PetscFunctionReturn(static_cast<PetscErrorCode>(0));
}

}  // namespace

int main(int argc, char** argv) {
  bool agree = true;
  MPI_Init(&argc, &argv);
  PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
  PetscCall(compare(&agree));
  PetscCall(PetscFinalize());
  // Once more in the same process: PETSc has forgotten the plug-in and loads it again.
  PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
  PetscCall(compare(&agree));
  PetscCall(PetscFinalize());
  MPI_Finalize();
  return agree ? 0 : 1;
}
