// What a factored matrix of PETSc holds: the solver, and the rules of when a pattern is analysed.
//
//   MatLUFactorSymbolic   analyses. If the object has an analysis already (-pc_factor_reuse_ordering), it is
//                         kept, and serves if the pattern of the next numeric phase is the same
//   MatLUFactorNumeric    first time: factors; later: refactors, which repeats nothing and allocates nothing.
//                         Another pattern is refused with its first row, unless MatLUFactorSymbolic has
//                         announced one
#pragma once

#include <utility>
#include <vector>

#include "failure.hpp"

namespace mfs::petsc {

class Factor {
 public:
  /// Throws InvalidInput, BackendError: options that make no sense.
  explicit Factor(Options options) : solver_(std::move(options)) {}

  /// Throws as BasicSolver::analyze does; the next factorize then tries again.
  void analyze(const CsrView<Scalar>& a);
  /// Throws as BasicSolver::factor does, and SingularMatrix where pivots were perturbed and no solution comes
  /// out: PETSc asks after a factorization whether it is good, not after a solve.
  void factorize(const CsrView<Scalar>& a);

  BasicSolver<Scalar>& solver() { return solver_; }
  PetscInt analyses() const { return analyses_; }
  PetscInt factorizations() const { return factorizations_; }

  PetscBool strict = PETSC_FALSE;  ///< MatSetErrorIfFailure of the matrix that was factored last

 private:
  void analyze_now(const CsrView<Scalar>& a);
  void try_to_solve(const CsrView<Scalar>& a);

  BasicSolver<Scalar> solver_;
  bool pattern_may_differ_ = false;
  PetscInt analyses_ = 0, factorizations_ = 0;
  std::vector<Scalar> trial_;
};

/// The options -mat_mfs_... with the prefix of `F`; a wrong value is an error, and so is a name that begins
/// as they do and is none of them.
PetscErrorCode read_options(Mat F, Options* options);

/// Parameters and figures for -ksp_view. `factor` may be null.
PetscErrorCode view_factor(Factor* factor, PetscViewer viewer);

}  // namespace mfs::petsc
