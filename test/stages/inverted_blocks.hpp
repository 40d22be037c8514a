// The device leaves the triangles of the diagonal blocks of P inverted in their places.
#pragma once

#include <algorithm>
#include <vector>

#include "kernels/stages/front_store.hpp"

namespace mfs::test {

/// Inverts the unit lower triangle and the upper triangle of a block in place, or only the lower one; plain
/// substitution in double precision. The same call undoes it.
template <class Scalar>
void invert_triangles(Scalar* block, Offset ld, Vertex size, bool keeps_upper) {
  using W = Wide<Scalar>;
  std::vector<W> lower(static_cast<std::size_t>(size) * size), upper = lower;
  const auto at = [&](Vertex i, Vertex j) { return W(block[i + j * ld]); };
  for (Vertex j = 0; j < size; ++j) {
    W* const x = lower.data() + static_cast<Offset>(j) * size;
    x[j] = W(1);
    for (Vertex i = j + 1; i < size; ++i) {
      for (Vertex k = j; k < i; ++k) x[i] -= at(i, k) * x[k];
    }
    W* const y = upper.data() + static_cast<Offset>(j) * size;
    y[j] = W(1) / at(j, j);
    for (Vertex i = j - 1; i >= 0; --i) {
      for (Vertex k = i + 1; k <= j; ++k) y[i] -= at(i, k) * y[k];
      y[i] /= at(i, i);
    }
  }
  for (Vertex j = 0; j < size; ++j) {
    for (Vertex i = keeps_upper ? j + 1 : 0; i < size; ++i)
      block[i + j * ld] = static_cast<Scalar>((i > j ? lower : upper)[i + static_cast<Offset>(j) * size]);
  }
}

/// All diagonal blocks of [P; L] with p pivots.
template <class Scalar>
void invert_diagonal(std::vector<Scalar>& lower, Vertex p, Vertex rows, Vertex block,
                     bool keeps_upper = false) {
  for (Vertex k = 0; k < p; k += block)
    invert_triangles(lower.data() + k + static_cast<Offset>(k) * rows, rows, std::min(block, p - k),
                     keeps_upper);
}

}  // namespace mfs::test
