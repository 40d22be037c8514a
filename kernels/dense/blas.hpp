// The one seam to BLAS and LAPACK on the host: the operations that the stages need, each for every scalar
// type, all column-major, all executed by the calling thread alone. No other file names one of their
// routines.
#pragma once

#include <complex>
#include <functional>
#include <string>

#include "ordering/types.hpp"

namespace mfs::blas {

enum class Transpose : char { no = 'N', yes = 'T' };

/// C (m x n) -= op(A) (m x k) B (k x n).
template <class Scalar>
void gemm_minus(Transpose transpose_a, Vertex m, Vertex n, Vertex k, const Scalar* a, Offset lda,
                const Scalar* b, Offset ldb, Scalar* c, Offset ldc);

/// B (n x columns) := op(T)^-1 B for the unit lower or the upper triangle T (n x n).
template <class Scalar>
void solve_unit_lower(Transpose transpose, Vertex n, Vertex columns, const Scalar* t, Offset ldt, Scalar* b,
                      Offset ldb);
template <class Scalar>
void solve_upper(Transpose transpose, Vertex n, Vertex columns, const Scalar* t, Offset ldt, Scalar* b,
                 Offset ldb);

/// B (rows x n) := B U^-1 for the upper triangle U (n x n).
template <class Scalar>
void solve_upper_right(Vertex rows, Vertex n, const Scalar* u, Offset ldu, Scalar* b, Offset ldb);

/// A (n x n) = U diag(singular) V^H; A is overwritten. `v_transposed` holds V^H. Returns LAPACK's info.
template <class Scalar>
int singular_values(Vertex n, Scalar* a, double* singular, Scalar* u, Scalar* v_transposed);

/// Estimate of |B|_1 of an n x n matrix given by `apply` (x := B x) and `apply_adjoint` (x := B^H x):
/// LAPACK's lacn2.
template <class Scalar>
double estimate_norm(Vertex n, const std::function<void(Scalar*)>& apply,
                     const std::function<void(Scalar*)>& apply_adjoint);

/// While one lives, BLAS calls of this process run on their calling thread: MFS runs its own threads, and the
/// two must not multiply. The last one of a process puts back what was set before the first. Where only one
/// thread may call BLAS (many_callers), scopes of other threads wait. Scopes of one thread may be nested.
class SequentialScope {
 public:
  /// `callers` threads call BLAS at the same time. OpenBLAS keeps a buffer of 128 MiB of address space for
  /// each, and looks for it without end where there is no room. So the buffers are taken here, the first time
  /// that so many are needed; throws OutOfMemory where one does not fit.
  explicit SequentialScope(int callers = 1);
  ~SequentialScope();
  SequentialScope(const SequentialScope&) = delete;
  SequentialScope& operator=(const SequentialScope&) = delete;

 private:
  const int callers_;
  int previous_ = 0;
  bool alone_ = false;
};

/// Whether several threads may call BLAS at the same time. OpenBLAS compiled without threads (Debian 12:
/// libopenblas0-serial) keeps its buffers without a lock: two callers get the same one, and wrong results.
bool many_callers();

/// Name and version of the BLAS that was linked, as far as it tells.
std::string library_name();

/// What the environment's OPENBLAS_CORETYPE should say when OpenBLAS is loaded: where it does not know this
/// processor it takes kernels of one without AVX2, which have a third of the speed. Empty where its choice
/// does, or the variable made it.
std::string better_kernels();
/// The same by OpenBLAS' name for the kernels that it took, and by what the processor has.
std::string better_kernels(const std::string& taken, bool avx2, bool avx512);

}  // namespace mfs::blas
