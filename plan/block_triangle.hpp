// What a plan of diagonal blocks (ordering/diagonal_blocks.hpp) has beside its fronts: the entries of A
// between the blocks, and the order in which a solve goes through these.
//
//   forward and backward substitution of one block after the other; before that, each of its rows subtracts
//   what its couplings make of unknowns that are solved for. With A^T it is the same in opposite order, by
//   columns.
//
// Blocks of one level couple to those of levels before only.
#pragma once

#include <vector>

#include "ordering/raw_vector.hpp"
#include "ordering/types.hpp"

namespace mfs {

struct SymbolicPlan;
struct DiagonalBlocks;

struct BlockTriangle {
  /// Entries between blocks, by the position of their row or of their column: others[k] is the position of
  /// the column or row, number[k] the coupling.
  struct Couplings {
    std::vector<Offset> begin;  // n + 1
    RawVector<Vertex> others;
    RawVector<Offset> number;
  };
  Couplings by_row, by_column;
  RawVector<Offset> slot;  // by coupling, ascending by row of the plan: of A's pattern

  std::vector<Vertex> front;        // block after block, children before parents
  std::vector<Vertex> block_begin;  // blocks + 1, into front
  std::vector<Vertex> level_begin;  // levels + 1, into the blocks

  bool empty() const { return slot.empty(); }
  Offset couplings() const { return static_cast<Offset>(slot.size()); }
  Vertex blocks() const { return block_begin.empty() ? 0 : static_cast<Vertex>(block_begin.size()) - 1; }
  Vertex levels() const { return level_begin.empty() ? 0 : static_cast<Vertex>(level_begin.size()) - 1; }
};

/// Of a plan that was made of blocks.pattern, whose fronts each belong to one block. `pattern`: of A.
BlockTriangle make_block_triangle(const SymbolicPlan& plan, const Pattern& pattern,
                                  const DiagonalBlocks& blocks);

}  // namespace mfs
