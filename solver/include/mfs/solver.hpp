// mfs::Solver: a sparse direct solver for square, unsymmetric matrices, real (mfs::Solver) or complex
// (mfs::ComplexSolver), in double or single precision.
//
//   mfs::Solver solver;                        // all cores
//   solver.factor(A);                          // analyses A's pattern, then factors its values
//   solver.solve(b, x);                        // x with a checked backward error, or an exception
//   solver.refactor(A_next);                   // same pattern, new values: no analysis, no allocation
//   solver.solve_transpose(b, x);
//
// One object belongs to one thread at a time; objects are independent of each other. One that was moved from
// is neither analyzed nor factored and throws StateError from every other call but assignment. So does every
// phase in a process forked after the library's first use: the threads it works with are not there. No call
// prints, changes the environment or lets a foreign exception type out. Every failure is one of the classes
// of mfs/error.hpp; BackendError also where the system refuses threads that were asked for.
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
  explicit BasicSolver(Options options = {});
  ~BasicSolver();
  BasicSolver(BasicSolver&&) noexcept;
  BasicSolver& operator=(BasicSolver&&) noexcept;

  /// Orders the pattern of `a` and computes the symbolic plan. `a.values`, where given, decide about matching
  /// and scaling. Forgets any earlier analysis and factorization.
  /// Throws InvalidInput (not square, empty, out of range, NaN or Inf with its place), SingularMatrix
  /// (structural), OutOfMemory.
  void analyze(const CsrView<Scalar>& a);

  /// Factors the values of `a`; analyses first if that was not done.
  /// Throws PatternChanged if `a` is not of the analysed pattern, InvalidInput, OutOfMemory, BackendError.
  void factor(const CsrView<Scalar>& a);

  /// The same for an object that has been factored before: allocates nothing and repeats nothing.
  /// Throws StateError before the first factor.
  void refactor(const CsrView<Scalar>& a);
  /// `values` in the order of the entries of the matrix last given to analyze or factor.
  void refactor(const Scalar* values);

  /// Solves A X = B. `b` and `x` are n x nrhs, column-major, leading dimensions ldb and ldx (0 takes n); they
  /// may be the same array (ldb = ldx), but not overlap otherwise. On return each column's backward error is
  /// at most the asked tolerance. Throws StateError, InvalidInput, SingularMatrix (numerical),
  /// AccuracyNotReached, OutOfMemory; x is then unchanged, but for whole blocks of 16 columns that were
  /// solved before the failure.
  void solve(const Scalar* b, Scalar* x, std::int64_t nrhs = 1, std::int64_t ldb = 0, std::int64_t ldx = 0);
  /// Solves A^T X = B.
  void solve_transpose(const Scalar* b, Scalar* x, std::int64_t nrhs = 1, std::int64_t ldb = 0,
                       std::int64_t ldx = 0);

  /// The same for arrays in the memory of the device, with Backend::cuda, when nothing needs to go through
  /// the host: values in the order of the entries of the matrix last given to analyze or factor, b and x as
  /// above. `stream` is a cudaStream_t of the caller (null: the default stream): what was put into it before
  /// is waited for on the device; the results are there when the call returns. Steps of the accuracy ladder
  /// beyond refinement make their way through the host. Throw StateError where the factors are not on a
  /// device.
  void refactor_device(const Scalar* values, void* stream = nullptr);
  void solve_device(const Scalar* b, Scalar* x, std::int64_t nrhs = 1, std::int64_t ldb = 0,
                    std::int64_t ldx = 0, void* stream = nullptr);
  void solve_transpose_device(const Scalar* b, Scalar* x, std::int64_t nrhs = 1, std::int64_t ldb = 0,
                              std::int64_t ldx = 0, void* stream = nullptr);

  /// Estimate of the condition number |A|_1 |A^-1|_1 (Higham and Tisseur 2000; rarely below a third of it),
  /// by a few solves. Infinite if A is singular. Throws StateError, OutOfMemory, and AccuracyNotReached where
  /// more pivots were perturbed than can be taken back.
  double condition_estimate();
  /// The determinant of A, from the pivots: with Precision::single, six digits of it. Throws StateError, and
  /// AccuracyNotReached where more pivots were perturbed than can be taken back.
  Determinant<Scalar> determinant();

  bool analyzed() const;
  bool factored() const;
  const Report& report() const;
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
