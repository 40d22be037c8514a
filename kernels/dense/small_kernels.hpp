// Products and triangular solves of small blocks, where a call of BLAS costs more than its operations: it
// packs its operands, and OpenBLAS' pthread kind takes a lock for the buffer that it packs them into, so
// threads that work on many small fronts wait for each other. Nothing is packed here but the last few rows;
// blocks of C stay in registers while a product runs over all of its terms (Frison and others 2018, BLASFEO,
// do the same). All matrices are column-major. Results are the same bit for bit from call to call, on one
// kind of processor.
#pragma once

#include "ordering/types.hpp"

namespace mfs::small {

/// Triangles may not have more rows, nor C and B more columns: few rows are held in memory of the stack.
constexpr Vertex kMost = 256;

/// C (m x n) -= A (m x k) B (k x n), kMost terms after each other.
template <class Scalar>
void gemm_minus(Vertex m, Vertex n, Vertex k, const Scalar* a, Offset lda, const Scalar* b, Offset ldb,
                Scalar* c, Offset ldc);

/// B (n x columns) := T^-1 B for the unit lower triangle of T.
template <class Scalar>
void solve_unit_lower(Vertex n, Vertex columns, const Scalar* t, Offset ldt, Scalar* b, Offset ldb);

/// B (n x columns) := U^-1 B for the upper triangle of U. False, and nothing is done, where the reciprocal of
/// an entry on the diagonal is not finite.
template <class Scalar>
bool solve_upper(Vertex n, Vertex columns, const Scalar* u, Offset ldu, Scalar* b, Offset ldb);

/// The same from the right: B (rows x n) := B U^-1.
template <class Scalar>
bool solve_upper_right(Vertex rows, Vertex n, const Scalar* u, Offset ldu, Scalar* b, Offset ldb);

}  // namespace mfs::small
