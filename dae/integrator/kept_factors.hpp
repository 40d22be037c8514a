// A linear solver strategy for Newton's method that keeps a factorization as long as it pays (modified
// Newton). It stands between NOX and the strategy that factors: NOX announces a matrix before every
// iteration; as long as that is the matrix it knows, nothing is done. A new matrix is solved by FGMRES with
// the factors of an older one as preconditioner, until the steps spent so would have paid a new
// factorization, or until FGMRES has not converged in the few steps it may take: then it is factored. It is
// factored at once where its systems, if they are as many as those of matrices before, would take more steps
// than that, and where FGMRES has lost a factorization in all.
#pragma once

#include <cstdint>
#include <exception>
#include <functional>

#include <Thyra_LinearOpWithSolveFactoryBase.hpp>

#include <mfs/report.hpp>

#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/constrained_system.hpp"
#include "dae/vectors/executor.hpp"

namespace mfs::dae {

/// What Newton's method and its linear solver tell each other.
struct LinearSolves {
  // Told by Newton's method.
  bool new_matrix = false;                ///< the matrix has got new values; set back when they are taken
  RemoteMatrix* remote_matrix = nullptr;  ///< where it has got them, if that is not the matrix itself
  std::function<void()> bring_values;     ///< puts them into the matrix itself
  bool factor_next = true;                ///< a new matrix is not to be solved by FGMRES
  /// Makes the right-hand side b of a system with the matrix from the residual h.
  std::function<void(const double* h, double* b)> right_side;
  /// Makes the correction x of a solution.
  std::function<void(const double* solution, double* x)> correct;
  // Told by the solver.
  bool factored = false;       ///< there are factors of some matrix
  std::exception_ptr failure;  ///< what an evaluation, a factorization or a solve threw last
  std::int64_t factorizations = 0, analyses = 0, krylov_solves = 0;
  std::int64_t bytes = 0;
  double time_analysis = 0, time_factor = 0, time_solve = 0;  ///< s
};

/// `executor`, whose vectors all are, and `solves`, shared with Newton's method, have to live as long. There
/// is one matrix, so createOp() returns the same object each time.
Teuchos::RCP<Thyra::LinearOpWithSolveFactoryBase<double>> make_kept_factors(const IntegratorOptions& options,
                                                                            const Executor& executor,
                                                                            LinearSolves& solves);

}  // namespace mfs::dae
