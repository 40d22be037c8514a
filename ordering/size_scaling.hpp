// Scaling for one solution. The backward error measures row i of a residual by (|A| |x| + |b|)_i. Where that
// differs by many decades between rows, pivots chosen in rows of equal size leave errors in which small rows
// drown, and no refinement brings them back. With rows scaled by that very size, elimination itself makes
// errors that are small beside it (Skeel 1979). x need not be accurate: its sizes are all that is used.
#pragma once

#include "ordering/scaling.hpp"

namespace mfs {

/// Rows of A by the reciprocals of (|A| |x| + |b|)_i, columns so that the largest entry of each is about 1,
/// all by powers of two; of A^T instead of A with `transposed`. Rows in which all of x and b is zero are
/// scaled like columns. `values` by slot of the pattern; b and x of n entries.
template <class Scalar>
PowerScaling scaling_by_size(const Pattern& pattern, const Scalar* values, const Scalar* b, const Scalar* x,
                             bool transposed, int threads);

}  // namespace mfs
