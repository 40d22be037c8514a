// Whether a matrix looks such that pivots on the diagonal let nothing grow: definite, or its diagonal
// dominant.
#pragma once

#include <vector>

#include "ordering/types.hpp"

namespace mfs {

/// Whether A = A^H but for rounding, its diagonal is of one sign, and |a_ij|^2 <= a_ii a_jj for all entries,
/// as in every definite matrix (Horn and Johnson, Matrix Analysis, 2013, section 7.1). Others may pass, too.
/// `values` [pattern.nnz()]. The same for any number of threads.
template <class Scalar>
bool looks_definite(const Pattern& pattern, const Scalar* values, int threads);

/// Whether in each row the entry of the column that it is matched with is as large as all others together,
/// but for rounding. Then what elimination makes of the rows stays below twice their largest entries (Higham,
/// Accuracy and Stability of Numerical Algorithms, 2002, theorem 9.9). `row_order` [n]: column -> row that it
/// is matched with; empty: the same. The same for any number of threads.
template <class Scalar>
bool rows_are_dominated(const Pattern& pattern, const std::vector<Vertex>& row_order, const Scalar* values,
                        int threads);

}  // namespace mfs
