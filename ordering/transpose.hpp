// The pattern by columns.
#pragma once

#include "ordering/raw_vector.hpp"
#include "ordering/types.hpp"

namespace mfs {

/// The pattern of A^T: entry k of row j is entry (columns[k], j) of A, in slots[k] of A's pattern.
struct TransposedPattern {
  std::vector<Offset> offsets;  // n + 1
  RawVector<Vertex> columns;    // nnz, ascending in each row
  RawVector<Offset> slots;      // nnz
};
/// The same for any number of threads.
TransposedPattern transpose(const Pattern& pattern, int threads);

}  // namespace mfs
