// Triangular solves for one right-hand side, of which a solve has one for each front: pivots come one after
// the other, so what is counted here is how long each lets the next one wait. T is column-major. Results are
// the same bit for bit from call to call, on one kind of processor.
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
