// Scaling for one right-hand side. The backward error measures row i of a residual by (|A| |x| + |b|)_i.
// Where that differs by many decades between rows, pivots chosen in rows of equal size leave errors in which
// small rows drown, and no refinement brings them back. With rows scaled by that very size, elimination
// itself makes errors that are small beside it (Skeel 1979).
//
// An approximate x would not do: entries of it may have vanished by underflow just because rows were scaled
// as they were. So the sizes come from A and b alone, by max-plus algebra (Hook and Tisseur 2017), on
// logarithms, which have range enough. The maximum product matching scales A to H, where matched entries are
// 1 and none is larger; equation i, solved for the unknown m(i) that it is matched to, says
//
//   y_m(i) = b_i - sum_j H_ij y_j        in sizes:  Y_m(i) = max(|b_i|, max_j |H_ij| Y_j)
//
// Y_m(i) is the size of equation i, and the largest product of entries along a path from an entry of b to it:
// shortest paths by Dijkstra's algorithm with lengths -log2 |H_ij| >= 0. Terms that cancel make it too large.
#pragma once

#include "ordering/scaling.hpp"

namespace mfs {

/// Rows of A by the reciprocals of the sizes of (|A| |x| + |b|)_i, where A x = b, columns so that the largest
/// entry of each is about 1, all by powers of two; of A^T instead of A with `transposed`. Rows in which all
/// of x and b is zero are scaled like columns. `values` by slot of the pattern; b of n entries.
template <class Scalar>
PowerScaling scaling_by_size(const Pattern& pattern, const Scalar* values, const Scalar* b, bool transposed,
                             int threads);

}  // namespace mfs
