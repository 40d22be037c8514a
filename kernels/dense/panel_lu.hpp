// LU with row interchanges of a tall panel on one host thread: the part of a factorization that BLAS has no
// routine for, because a pivot that is too small must be replaced, counted and remembered instead of divided
// by.
#pragma once

#include <cmath>
#include <limits>

#include "ordering/types.hpp"

namespace mfs {

/// What became of the pivots of one panel or front.
struct PivotTally {
  Vertex perturbed = 0;
  Vertex first_nonfinite = -1;  // column of the first pivot that is NaN or infinite
};

/// When a pivot is too small, and what takes its place. All are absolute.
struct PivotRule {
  double bound = 0;    // below it a pivot is suspect
  double tiny = 0;     // up to it a pivot may be nothing but rounding
  double largest = 1;  // what is large in this matrix
};

/// A suspect pivot is still accepted when it is at least this fraction of what lies below it in the border:
/// then dividing by it lets nothing grow.
constexpr double kBorderThreshold = 0.01;

/// A pivot of at most this many square roots of machine epsilon relative to the largest scaled entry may be a
/// rounded zero: rounding errors are divided by the small pivots before it, so no multiple of epsilon itself
/// is a bound. It is perturbed, and the exact correction of the solve (kernels/correction.hpp) finds out.
/// Accepting pivots from 5000 epsilons on let one singular matrix in 25 000 through.
constexpr double kTinyPivot = 1;

/// The rule for factors of Real.
template <class Real>
PivotRule pivot_rule(double tolerance, double largest) {
  return {tolerance * largest,
          kTinyPivot * std::sqrt(static_cast<double>(std::numeric_limits<Real>::epsilon())) * largest,
          largest};
}

/// A column whose border is below this many times `tiny` holds nothing but rounding there.
constexpr double kEmptyBorder = 10;

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
/// factored and have been applied: A = P L U with the pivot of each column searched in all m rows.
/// interchange[j] = the row, counted from `first`, that was exchanged with row j of the panel. A suspect
/// pivot that may not be accepted becomes pivot / |pivot| * bound, or, where the border of its column holds
/// nothing either (the column depends on those before it), pivot / |pivot| * largest, which keeps the factors
/// well conditioned, so that the correction can tell what the pivot really is; shift[j] = what was added (0
/// where nothing was). Recursive in the columns (Toledo 1997), so that nearly all work is matrix products.
template <class Scalar>
PivotTally factor_panel(const BlockColumns<Scalar>& block, Vertex first, Vertex m, Vertex n,
                        const PivotRule& rule, Vertex* interchange, Scalar* shift);

/// Exchanges row k with row interchange[k] for k = 0 ... count-1, in this order, in `columns` columns of A.
template <class Scalar>
void exchange_rows(Vertex columns, Scalar* a, Offset lda, const Vertex* interchange, Vertex count);

}  // namespace mfs
