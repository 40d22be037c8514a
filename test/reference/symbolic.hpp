// Symbolic elimination as its definition, on a full table of booleans: which borders the fronts of a tree
// have, and how many entries the factors of a matrix fill.
#pragma once

#include <vector>

#include "ordering/types.hpp"

namespace mfs::test {

/// by position: filled[i][j] where A + A^T, rows permuted by `row_order` (empty: identity), has an entry.
inline std::vector<std::vector<bool>> symmetric_pattern(const Pattern& pattern,
                                                        const std::vector<Vertex>& row_order,
                                                        const std::vector<Vertex>& order) {
  const Vertex n = pattern.n;
  std::vector<std::vector<bool>> filled(n, std::vector<bool>(n, false));
  for (Vertex i = 0; i < n; ++i) {
    const Vertex row = row_order.empty() ? order[i] : row_order[order[i]];
    for (Vertex j = 0; j < n; ++j) {
      for (Offset k = pattern.offsets[row]; k < pattern.offsets[row + 1]; ++k) {
        if (pattern.columns[k] == order[j]) filled[i][j] = filled[j][i] = true;
      }
    }
    filled[i][i] = true;
  }
  return filled;
}

/// Eliminates the pivots of each front at once: they and all that they touch become one full block. Returns
/// the border of each front, ascending.
inline std::vector<std::vector<Vertex>> eliminate_fronts(std::vector<std::vector<bool>> filled,
                                                         const std::vector<Vertex>& pivot_begin) {
  const auto n = static_cast<Vertex>(filled.size());
  std::vector<std::vector<Vertex>> borders;
  for (std::size_t f = 0; f + 1 < pivot_begin.size(); ++f) {
    std::vector<Vertex> border;
    for (Vertex j = pivot_begin[f + 1]; j < n; ++j) {
      bool touched = false;
      for (Vertex i = pivot_begin[f]; i < pivot_begin[f + 1]; ++i) touched = touched || filled[i][j];
      if (touched) border.push_back(j);
    }
    for (const Vertex i : border) {
      for (const Vertex j : border) filled[i][j] = true;
    }
    borders.push_back(border);
  }
  return borders;
}

/// Entries of L and U, the diagonal once, when unknowns are eliminated one by one.
inline Offset factor_entries(const std::vector<std::vector<bool>>& filled) {
  std::vector<Vertex> one_by_one;
  for (std::size_t i = 0; i <= filled.size(); ++i) one_by_one.push_back(static_cast<Vertex>(i));
  Offset entries = 0;
  for (const std::vector<Vertex>& border : eliminate_fronts(filled, one_by_one)) {
    entries += 1 + 2 * static_cast<Offset>(border.size());
  }
  return entries;
}

}  // namespace mfs::test
