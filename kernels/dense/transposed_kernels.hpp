// Products with A^T and solves with T^T for few columns, as solves with the transposed matrix have them: each
// entry of A or T is read once and meets only these, so a call of BLAS, which packs its operands and takes a
// lock (small_kernels.hpp), costs more. Sums run down the columns of A, where its entries lie beside each
// other. All matrices are column-major; A^T is not A^H. Results are the same bit for bit from call to call,
// on one kind of processor.
#pragma once

#include "ordering/types.hpp"

namespace mfs::small {

/// C (m x n) -= A^T B for A (k x m) and B (k x n).
template <class Scalar>
void gemm_minus_transposed(Vertex m, Vertex n, Vertex k, const Scalar* a, Offset lda, const Scalar* b,
                           Offset ldb, Scalar* c, Offset ldc);

/// B (n x columns) := T^-T B for the unit lower triangle of T.
template <class Scalar>
void solve_unit_lower_transposed(Vertex n, Vertex columns, const Scalar* t, Offset ldt, Scalar* b,
                                 Offset ldb);

/// B (n x columns) := T^-T B for the upper triangle of T.
template <class Scalar>
void solve_upper_transposed(Vertex n, Vertex columns, const Scalar* t, Offset ldt, Scalar* b, Offset ldb);

}  // namespace mfs::small
