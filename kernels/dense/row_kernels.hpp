// Products and triangular solves for the right-hand sides of a solve. B and C have few columns, and the
// entries of one row lie beside each other: an entry of A is read once and meets a row that a register or two
// hold, and rows that are gathered or scattered are whole lines of cache. A and T are column-major; A^T is
// not A^H. Results are the same bit for bit from call to call, on one kind of processor.
#pragma once

#include "ordering/types.hpp"

namespace mfs::rows {

/// Entries that a row of so many columns has, 1 <= columns <= 16, those behind the columns being of no use.
constexpr Vertex width_of(Vertex columns) {
  return columns == 1 ? 1 : columns <= 4 ? 4 : columns <= 8 ? 8 : 16;
}

/// C (m x width) -= op(A) B, B of k rows; A is m x k, or transposed k x m. Here and below width is more
/// than 1.
template <class Scalar>
void gemm_minus(bool transposed, Vertex m, Vertex width, Vertex k, const Scalar* a, Offset lda,
                const Scalar* b, Scalar* c);

/// B (n x width) := op(T)^-1 B for the upper or the unit lower triangle of T.
template <class Scalar>
void solve_triangle(bool upper, bool transposed, Vertex n, Vertex width, const Scalar* t, Offset ldt,
                    Scalar* b);

/// to(i) = from(row[i]), i < count. From here on width may be 1.
template <class Scalar>
void gather(Vertex count, Vertex width, const Vertex* row, const Scalar* from, Scalar* to);

/// to(row[i]) = from(i), i < count.
template <class Scalar>
void scatter(Vertex count, Vertex width, const Vertex* row, const Scalar* from, Scalar* to);

/// to(row[i] - first) += from(i), i < count.
template <class Scalar>
void scatter_add(Vertex count, Vertex width, const Vertex* row, Vertex first, const Scalar* from, Scalar* to);

}  // namespace mfs::rows
