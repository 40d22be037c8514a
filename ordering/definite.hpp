// Whether a matrix looks definite, so that pivots on the diagonal let nothing grow.
#pragma once

#include "ordering/types.hpp"

namespace mfs {

/// Whether A = A^H but for rounding, its diagonal is of one sign, and |a_ij|^2 <= a_ii a_jj for all entries,
/// as in every definite matrix (Horn and Johnson, Matrix Analysis, 2013, section 7.1). Others may pass, too.
/// `values` [pattern.nnz()]. The same for any number of threads.
template <class Scalar>
bool looks_definite(const Pattern& pattern, const Scalar* values, int threads);

}  // namespace mfs
