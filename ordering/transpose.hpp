// The pattern by columns.
#pragma once

#include "ordering/types.hpp"

namespace mfs {

/// The pattern of A^T: entry k of row j is entry (columns[k], j) of A, in slots[k] of A's pattern.
struct TransposedPattern {
  std::vector<Offset> offsets;  // n + 1
  std::vector<Vertex> columns;  // nnz
  std::vector<Offset> slots;    // nnz
};
TransposedPattern transpose(const Pattern& pattern);

}  // namespace mfs
