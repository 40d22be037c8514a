// mfs::BatchSolver: many systems with one pattern, each with values and right-hand sides of its own, as
// parameter studies, power flow and chemical kinetics have them.
//
//   mfs::BatchSolver solver;
//   solver.analyze(a);                         // the pattern, and values that are typical of the batch
//   solver.solve({count, values, 0, b, x});    // A_k x_k = b_k, k = 0 ... count-1
//   solver.systems()[k].status;                // what became of each
//
// There is one analysis. Where fronts would be small and the values of the analysis have good pivots, the
// factorization is a fixed list of operations on single entries, which is executed for many systems at the
// same time, eight by a thread of the host or hundreds by a device. Otherwise each thread of the host
// factors one system after another in memory that it keeps, and solves with the factors while they are in its
// cache; they are not kept. Every solution has a checked backward error, as one of mfs::Solver, or is not
// written. A system that the common plan does not serve, as its values are too far from those of the
// analysis, is solved by itself on the host, with an analysis of its own and every rung of the ladder. What
// is computed for a system depends on nothing but its own numbers and those of the analysis: neither on the
// number of threads nor on the other systems, of which any may be singular.
//
// With a backend of a device (Backend::cuda, or kokkos there), solve copies host arrays to the device and
// back, and solve_device takes arrays that lie there. Systems for which the list is too long, or of an
// analysis without values, are solved by the host's threads all the same.
// Threads, errors of the whole call and processes made by fork are as with mfs::Solver.
#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <mfs/csr_view.hpp>
#include <mfs/error.hpp>
#include <mfs/export.hpp>
#include <mfs/options.hpp>
#include <mfs/report.hpp>

namespace mfs {

/// What became of one system. Each but the first is the class of mfs/error.hpp that mfs::Solver would throw.
enum class SystemStatus {
  solved,                ///< its solution is written
  singular,              ///< SingularMatrix
  accuracy_not_reached,  ///< AccuracyNotReached
  invalid_input,         ///< InvalidInput: NaN or infinity in its values or right-hand sides
  out_of_memory,         ///< OutOfMemory
  failed,                ///< any other
};

/// The name of the enumerator, "unknown" for any other value.
MFS_API const char* status_name(SystemStatus status);

struct SystemReport {
  SystemStatus status = SystemStatus::solved;
  double backward_error = 0;  ///< componentwise, of the worst column; 0 where there is no solution
  Rung rung = Rung::factors;  ///< at least `reanalysis` where the common plan was not enough
  std::int64_t row = -1;      ///< that the error names, of the matrix or of b; -1: none
  std::int64_t column = -1;   ///< likewise
  std::string error;          ///< text of the error; empty if solved
};

/// Systems A_k X_k = B_k, k = 0 ... count-1, in memory of the host, or of the device for solve_device.
/// Numbers that are 0 stand for the least that is possible: arrays without gaps.
template <class Scalar>
struct Batch {
  std::int64_t count = 0;
  /// Of A_k: values + k * values_stride, in the order of the entries of the matrix that was analysed.
  const Scalar* values = nullptr;
  std::int64_t values_stride = 0;  ///< at least the number of those entries
  /// B_k = b + k * b_stride and X_k = x + k * x_stride, n x nrhs each, column-major with leading dimensions
  /// ldb and ldx. All of x may be all of b, with the same strides; else they must not overlap.
  const Scalar* b = nullptr;
  Scalar* x = nullptr;
  std::int64_t nrhs = 1;
  std::int64_t ldb = 0, ldx = 0;            ///< at least n
  std::int64_t b_stride = 0, x_stride = 0;  ///< at least nrhs * ldb and nrhs * ldx
};

template <class Scalar>
class MFS_API BasicBatchSolver {
 public:
  /// Throws InvalidInput for an option that makes no sense, and for a dump_prefix, an out_of_core_dir and, on
  /// the host, a memory_limit, which no batch obeys; BackendError for a backend that is not present.
  /// Options::memory_limit is what the arrays of a device may take: a large batch is solved in parts that
  /// fit.
  explicit BasicBatchSolver(Options options = {});
  ~BasicBatchSolver();
  BasicBatchSolver(BasicBatchSolver&&) noexcept;
  BasicBatchSolver& operator=(BasicBatchSolver&&) noexcept;

  /// Orders the pattern of `a` (n x n). Where `a` has values, they decide about matching, scaling and which
  /// pivots share a block; take those of a system of the batch. Earlier analyses are forgotten. Throws as
  /// BasicSolver::factor.
  void analyze(const CsrView<Scalar>& a);

  /// Solves all systems, each by one thread. Those that fail are told of in systems(), and their places in x
  /// stay as they are. From the second call on with the same nrhs nothing is allocated but what systems()
  /// and systems solved by themselves need. Throws StateError before analyze, InvalidInput for pointers,
  /// numbers and strides that cannot be, OutOfMemory, BackendError, and what the progress callback throws;
  /// then some solutions may have been written.
  void solve(const Batch<Scalar>& batch);

  /// The same for arrays in the memory of the device, without a copy of them. `stream` is a cudaStream_t of
  /// the caller (null: the default stream). What was put into it before is waited for on the device, and the
  /// results are complete when the call returns. Throws StateError where systems are not solved on a device.
  void solve_device(const Batch<Scalar>& batch, void* stream = nullptr);

  /// What became of each system of the last solve; empty before.
  const std::vector<SystemReport>& systems() const;
  /// How many of them were not solved.
  std::int64_t failed() const;
  /// Of the analysis, and the time of the last solve (time_solve).
  const Report& report() const;

 private:
  struct MFS_HIDDEN Impl;
  MFS_HIDDEN Impl& impl() const;
  std::unique_ptr<Impl> impl_;
};

extern template class BasicBatchSolver<float>;
extern template class BasicBatchSolver<double>;
extern template class BasicBatchSolver<std::complex<float>>;
extern template class BasicBatchSolver<std::complex<double>>;

using BatchSolver = BasicBatchSolver<double>;
using ComplexBatchSolver = BasicBatchSolver<std::complex<double>>;
using SingleBatchSolver = BasicBatchSolver<float>;
using SingleComplexBatchSolver = BasicBatchSolver<std::complex<float>>;

}  // namespace mfs
