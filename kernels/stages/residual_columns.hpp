// The residual of several columns at once, on the host: each entry of the matrix is read once for all of
// them, and sums of different columns do not wait for each other.
#pragma once

#include "kernels/stages/residual.hpp"

namespace mfs {

/// Columns that are taken together.
constexpr Vertex kResidualColumns = 8;

/// R = B - A X and its backward error, as kernels/stages/residual.hpp has them for one column, for rows
/// [begin, end) and kResidualColumns columns. B and R are column-major with leading dimension n, X has its
/// columns side by side: entry (j, c) is x[j * kResidualColumns + c]. error[c] is the worst of these rows.
template <class Scalar>
void residual_rows(const RowAccess<Scalar>& a, Offset begin, Offset end, Offset n, const Scalar* b,
                   const Scalar* x, Scalar* r, double* error);

}  // namespace mfs
