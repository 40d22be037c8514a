// LU with row interchanges of a tall panel on one host thread: the part of a factorization that BLAS has no
// routine for, because a pivot that is too small must be replaced, counted and remembered instead of divided
// by.
#pragma once

#include "kernels/dense/pivot_rule.hpp"
#include "ordering/types.hpp"

namespace mfs {

/// What became of the pivots of one panel or front.
struct PivotTally {
  Vertex perturbed = 0;
  Vertex first_nonfinite = -1;  // column of the first pivot that is NaN or infinite
};

/// The block of a front that is factored: its columns from the first one on, with the pivot rows in [0, m)
/// and the border rows, not yet solved for, in [border_begin, border_begin + border_rows).
template <class Scalar>
struct BlockColumns {
  Scalar* a;  // (0, 0) of the block
  Offset lda;
  Vertex border_begin, border_rows;
  Scalar* work;  // one entry per column of the block
};

/// Factors columns [first, first + n) of a block, rows [first, first + m), m >= n, whose left neighbours are
/// factored and have been applied: A = P L U with the pivot of each column searched in all m rows, of which
/// the one that is next counts PivotRule::preference times. interchange[j] = the row, counted from `first`,
/// that was exchanged with row j of the panel. A suspect pivot that may not be accepted becomes pivot /
/// |pivot| * bound, or, where the border of its column holds nothing either (the column depends on those
/// before it), pivot / |pivot| * largest, which keeps the factors well conditioned, so that the correction
/// can tell what the pivot really is; shift[j] = what was added (0 where nothing was). Recursive in the
/// columns (Toledo 1997), so that nearly all work is matrix products.
template <class Scalar>
PivotTally factor_panel(const BlockColumns<Scalar>& block, Vertex first, Vertex m, Vertex n,
                        const PivotRule& rule, Vertex* interchange, Scalar* shift);

/// Exchanges row k with row interchange[k] for k = 0 ... count-1, in this order, in `columns` columns of A.
template <class Scalar>
void exchange_rows(Vertex columns, Scalar* a, Offset lda, const Vertex* interchange, Vertex count);

}  // namespace mfs
