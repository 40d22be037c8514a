// Where large blocks begin. Columns of a block with many rows begin at multiples of 128 bytes (of doubles),
// and so does each block: products whose operands lie otherwise take cuBLAS 1.4 times as long.
#pragma once

#include <vector>

#include "ordering/types.hpp"

namespace mfs {

/// What large blocks of the factors begin at multiples of, in entries.
constexpr Vertex kAlignment = 16;

/// Columns of blocks with at least kAlignedRows rows begin at multiples of kAlignment entries.
constexpr Vertex kAlignedRows = 512;
#if defined(__CUDACC__) || defined(__HIPCC__)  // kernels read the places of a plan by the same rule
__host__ __device__
#endif
    constexpr Vertex
    leading_dimension(Vertex rows) {
  return rows < kAlignedRows ? rows : (rows + kAlignment - 1) / kAlignment * kAlignment;
}

inline Offset aligned(Offset entries) {
  return (entries + kAlignment - 1) / kAlignment * kAlignment;
}

/// Nodes with at least kAlignedUnknowns get a multiple of kAlignment of them, roots excepted: the last few
/// move to the parent, which leaves the order of elimination as it is. Then the blocks of a front are aligned
/// as well, which is worth more than the few zeros that are stored for it. `pair` (MatchedScaling::pair):
/// pairs stay together; a node for which that would take more than kMostMoved moves stays as it is.
constexpr Vertex kAlignedUnknowns = 256, kMostMoved = 4 * kAlignment;
SeparatorTree align_nodes(const SeparatorTree& tree, const std::vector<Vertex>& pair);

}  // namespace mfs
