// Block triangular form (Duff and Reid 1978): where unknowns of Ahat depend on each other in one direction
// only, just the blocks on the diagonal have to be factored, and a solve puts what is known already into the
// blocks that come later.
//
//        [ A11           ]     x1 = A11^-1 b1
//        [ A21  A22      ]     x2 = A22^-1 (b2 - A21 x1)
//        [ A31  A32  A33 ]     x3 = A33^-1 (b3 - A31 x1 - A32 x2)
//
// The tree and the fronts are those of A11, A22, A33. Entries between blocks make no fill.
#pragma once

#include <memory>

#include "ordering/types.hpp"

namespace mfs {

/// Blocks are in the order of a solve: an entry of A between two lies in a row of the later one. Those of a
/// level depend on blocks of levels before only.
struct DiagonalBlocks {
  std::vector<Vertex> level_begin;        // levels + 1
  std::vector<Vertex> of_row, of_column;  // n: block of a row or column of A
  Pattern pattern;                        // of A without the entries between blocks
  RawVector<Vertex> in_row;               // by slot of that pattern: which entry of its row of A it is

  Vertex count() const { return level_begin.back(); }
};

/// The strongly connected components of Ahat (Tarjan 1972), each in block[i] of its unknowns i, numbered so
/// that entry (i, j) of Ahat has block[j] <= block[i]. Unknowns of a pair are in one. Linear time, without
/// recursion.
std::vector<Vertex> strong_components(const Pattern& pattern, const MatchedScaling& matched);

/// Null where no entry lies between two blocks, or one of them has more than this part of the unknowns.
std::shared_ptr<const DiagonalBlocks> find_diagonal_blocks(const Pattern& pattern,
                                                           const MatchedScaling& matched,
                                                           double largest_part = 1);

/// The tree with the nodes of a depth in the order of their blocks, so that a solve that goes through small
/// blocks goes through memory, too.
SeparatorTree in_block_order(const SeparatorTree& tree, const DiagonalBlocks& blocks);

}  // namespace mfs
