// Products and triangular solves for one right-hand side, as many of which a tree has as fronts. Each entry
// of A or T is used once: what a call of BLAS does beside (OpenBLAS' pthread kind takes a lock for its
// buffer) takes longer than small ones, and threads queue up. Pivots come one after the other, so what counts
// in a triangle is how long each lets the next one wait. A and T are column-major. Results are the same bit
// for bit from call to call, on one kind of processor.
#pragma once

#include "ordering/types.hpp"

namespace mfs::small {

/// y (m) -= A x for A (m x k).
template <class Real>
void subtract_product(Vertex m, Vertex k, const Real* a, Offset lda, const Real* x, Real* y);

/// x (n) := T^-1 x for the upper or the unit lower triangle of T.
template <class Real>
void solve_column(bool upper, Vertex n, const Real* t, Offset ldt, Real* x);

}  // namespace mfs::small
