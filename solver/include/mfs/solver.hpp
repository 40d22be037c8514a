// mfs::Solver: a sparse direct solver for square, unsymmetric matrices, real (mfs::Solver) or complex
// (mfs::ComplexSolver), in double or single precision.
//
//   mfs::Solver solver;                        // all cores
//   solver.factor(A);                          // analyses A's pattern, then factors its values
//   solver.solve(b, x);                        // x with a checked backward error, or an exception
//   solver.refactor(A_next);                   // same pattern, new values: no analysis, no allocation
//   solver.solve_transpose(b, x);
//
// One object belongs to one thread at a time; objects are independent of each other. An object that was moved
// from is neither analyzed nor factored, and throws StateError from every other call but assignment. A forked
// process may use the objects of its parent and new ones, on the host: not those on a device, nor where the
// parent was computing when it forked. No call prints, changes the environment or lets a foreign exception
// type out. Every failure is one of the classes of mfs/error.hpp. BackendError also means that the system
// refused threads that were asked for.
#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <vector>

#include <mfs/csr_view.hpp>
#include <mfs/error.hpp>
#include <mfs/export.hpp>
#include <mfs/options.hpp>
#include <mfs/report.hpp>

namespace mfs {

template <class Scalar>
class MFS_API BasicSolver {
 public:
  /// Throws InvalidInput for an option that makes no sense, BackendError for a backend that is not present.
  explicit BasicSolver(Options options = {});
  ~BasicSolver();
  BasicSolver(BasicSolver&&) noexcept;
  BasicSolver& operator=(BasicSolver&&) noexcept;

  /// Orders the pattern of `a` (n x n) and computes the symbolic plan. The values of `a`, where it has some,
  /// decide about matching and scaling, and on a device, where that takes little beside the analysis, about
  /// pivots that fail. Earlier analyses and factorizations are forgotten. Throws
  /// InvalidInput (not square, empty, an index out of range, NaN or infinity with its place), SingularMatrix
  /// (structural), OutOfMemory, BackendError.
  void analyze(const CsrView<Scalar>& a);

  /// Factors the values of `a`. Analyses `a` first if nothing has been analysed, or only a pattern.
  /// Throws PatternChanged if its entries are not those analysed, in their order, InvalidInput (NaN or
  /// infinity), OutOfMemory, BackendError, and what analyze throws.
  void factor(const CsrView<Scalar>& a);

  /// Factors the values of `a` in the memory and by the plan of the last factorization. Nothing is allocated,
  /// unless solves have become so dear that the values are matched anew (FactorOptions::max_reanalyses).
  /// Throws StateError before the first factor, and what factor throws.
  void refactor(const CsrView<Scalar>& a);
  /// The same for `values` in the order of the entries of the matrix last passed to analyze or factor.
  void refactor(const Scalar* values);

  /// Solves A X = B. `b` and `x` are n x nrhs, column-major, with leading dimensions ldb and ldx (0 means n).
  /// They may be the same array (ldb = ldx), but must not overlap otherwise. On return each column's
  /// componentwise backward error is at most SolveOptions::tolerance. Throws StateError, InvalidInput,
  /// SingularMatrix (numerical), AccuracyNotReached, OutOfMemory, BackendError. x is then unchanged, but for
  /// whole blocks of at most 16 columns that were solved before the failure.
  void solve(const Scalar* b, Scalar* x, std::int64_t nrhs = 1, std::int64_t ldb = 0, std::int64_t ldx = 0);
  /// Solves A^T X = B (for complex numbers, too, without conjugation), with arguments and errors as solve.
  void solve_transpose(const Scalar* b, Scalar* x, std::int64_t nrhs = 1, std::int64_t ldb = 0,
                       std::int64_t ldx = 0);

  /// The same for arrays in the memory of the device where the factors lie (Backend::cuda, or kokkos there).
  /// The first factorization of values that were analysed may be a refactor_device, too. Shapes, order and
  /// errors are as above.
  /// `stream` is a cudaStream_t of the caller (null: the default stream). What was put into it before is
  /// waited for on the device, and the results are complete when the call returns. Steps of the accuracy
  /// ladder beyond refinement copy the vectors through the host. Throw StateError where the factors are not
  /// on a device, InvalidInput for arrays that it cannot reach: of the host (unless page-locked), of another
  /// device.
  void refactor_device(const Scalar* values, void* stream = nullptr);
  void solve_device(const Scalar* b, Scalar* x, std::int64_t nrhs = 1, std::int64_t ldb = 0,
                    std::int64_t ldx = 0, void* stream = nullptr);
  void solve_transpose_device(const Scalar* b, Scalar* x, std::int64_t nrhs = 1, std::int64_t ldb = 0,
                              std::int64_t ldx = 0, void* stream = nullptr);

  /// Estimates the condition number |A|_1 |A^-1|_1 by a few solves (Higham and Tisseur 2000; the estimate is
  /// rarely below a third of it). The result is infinite if A is singular. Where the factors do not do,
  /// others are tried as solve does. Throws StateError, OutOfMemory, and AccuracyNotReached where none do.
  double condition_estimate();
  /// The determinant of A from the pivots; six digits are right with Precision::single. Other factors are
  /// tried as above. Throws StateError, OutOfMemory, AccuracyNotReached where pivots leave no digit of it.
  Determinant<Scalar> determinant();

  /// Whether there is an analysis, and whether there are factors that solve can use.
  bool analyzed() const;
  bool factored() const;
  /// What the last calls did; all zero before the first.
  const Report& report() const;
  /// The options that the object was made with.
  const Options& options() const;
  /// The fronts by depth, root first; empty before analyze.
  std::vector<DepthSummary> depths() const;

 private:
  struct MFS_HIDDEN Impl;
  MFS_HIDDEN Impl& impl() const;
  std::unique_ptr<Impl> impl_;
};

extern template class BasicSolver<float>;
extern template class BasicSolver<double>;
extern template class BasicSolver<std::complex<float>>;
extern template class BasicSolver<std::complex<double>>;

using Solver = BasicSolver<double>;
using SingleSolver = BasicSolver<float>;
using ComplexSolver = BasicSolver<std::complex<double>>;
using SingleComplexSolver = BasicSolver<std::complex<float>>;

}  // namespace mfs
