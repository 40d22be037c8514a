// The symbolic plan: every front, row list, child-to-parent map, offset, flop and byte of the factorization,
// known before any number is computed. It is made once per pattern by make_symbolic_plan, never changed, and
// may be shared by several factorizations.
//
// Fronts are numbered in the order in which they are done: deepest depth first, root last. All arrays that
// belong to fronts are indexed by that number; positions are places in the elimination order, so that the
// pivots of front f are the positions [pivot_begin[f], pivot_begin[f+1]).
//
// Storage of front f with p pivots and b border rows, column-major:
//
//              p            b                factors:        [ P ]  (p+b) x p at lower_begin[f], lower_ld(f)
//          +-------+-----------------+                       [ L ]
//        p |   P   |        U        |                        U     p x b     at upper_begin[f], ld p
//          +-------+-----------------+       contribution block:
//        b |   L   |        C        |                        C     b x b     at contribution_begin[f],
//          +-------+-----------------+                              contribution_ld(f)
//
// Leading dimensions of large blocks are multiples of 16, and so are the pivots of large fronts
// (plan/alignment.hpp).
//
// One region holds them all. Factors lie in it in the order of their fronts, from the left. A contribution
// block lives from its own step to the next one, so it may lie where factors of later steps will be: behind
// those of that next step, in gaps that blocks of the steps before and after it leave. Where the blocks of a
// step are assembled in turns, those of later turns may also lie where blocks are that earlier turns read.
//
//        | factors of steps 0 ... k+1 | C of step k | C of step k-1, then of k+1 | C of step k | ...
//
#pragma once

#include <vector>

#include <mfs/analysis_options.hpp>
#include "ordering/raw_vector.hpp"
#include "ordering/types.hpp"
#include "plan/alignment.hpp"
#include "plan/block_triangle.hpp"

namespace mfs {

/// Multiplications and additions of each kind of operation on a block of `pivots` columns with `rest` rows
/// and columns beyond it (real arithmetic; LAPACK Working Note 41 for the lower-order terms of getrf).
struct BlockFlops {
  double getrf, trsm, gemm;
  double total() const { return getrf + trsm + gemm; }
};
BlockFlops block_flops(double pivots, double rest);

/// How the contribution blocks of one step are assembled, once all else of its fronts is: those of fronts
/// with more than `rows` rows in up to `most` turns, one after the other. Others belong to the first turn,
/// and what they read is kept through all.
struct AssemblyTurns {
  Vertex most = 1, rows = 0;
};

struct SymbolicPlan {
  Vertex n = 0;
  Offset nnz = 0;
  Vertex num_fronts = 0;
  Vertex num_depths = 0;
  Vertex max_block_size = 0;

  std::vector<Vertex> row_of;     // n: position -> row of A
  std::vector<Vertex> column_of;  // n: position -> column of A

  std::vector<Vertex> pivot_begin;     // num_fronts + 1
  std::vector<Offset> border_begin;    // num_fronts + 1, into border and border_in_parent
  RawVector<Vertex> border;            // positions, ascending in each front
  RawVector<Vertex> border_in_parent;  // row of the parent's front that each border row is added to
  std::vector<Vertex> parent;          // num_fronts, -1 for a root
  std::vector<Vertex> child_begin;     // num_fronts + 1, into children
  std::vector<Vertex> children;        // ascending in each front: the fixed order of extend-add
  std::vector<Vertex> depth_begin;     // num_depths + 1: step k holds the fronts of depth num_depths - 1 - k

  std::vector<Offset> lower_begin, upper_begin, contribution_begin;  // num_fronts, entries
  std::vector<Vertex> assembly_turn;                                 // num_fronts: in which C is assembled
  Offset factor_entries = 0;   // of the region: the factors, alignment included
  Offset storage_entries = 0;  // the whole region

  // Original entries by front: entry number entry_in_row[e] of row entry_row[e] of A goes to entry_target[e]
  // of the region (every original entry lies in P, L or U of the front of the earlier of its row and column,
  // or in the triangle). Within a front they ascend by column, and so do their targets' columns.
  std::vector<Offset> entry_begin;  // num_fronts + 1
  RawVector<Offset> entry_target;
  RawVector<Vertex> entry_row, entry_in_row;

  BlockTriangle triangle;  // of entries that no front has; empty where fronts have all

  std::vector<double> front_flops;  // num_fronts: all operations, what the schedule balances
  BlockFlops flops{0, 0, 0};
  Offset nnz_factor = 0;  // entries of L and U, the diagonal once
  Vertex max_front = 0;

  Vertex pivots(Vertex f) const { return pivot_begin[f + 1] - pivot_begin[f]; }
  /// Whether some contribution block waits for a later turn.
  bool has_turns() const;
  Vertex border_rows(Vertex f) const { return static_cast<Vertex>(border_begin[f + 1] - border_begin[f]); }
  Vertex rows(Vertex f) const { return pivots(f) + border_rows(f); }
  Vertex lower_ld(Vertex f) const { return leading_dimension(rows(f)); }
  Vertex contribution_ld(Vertex f) const { return leading_dimension(border_rows(f)); }
  /// Blocks into which the pivot block of a front is divided: ceil(p / max_block_size), as equal as can be.
  Vertex block_width(Vertex pivots) const;
  BlockFlops flops_of(Vertex f) const;
  /// n: row or column of A -> position.
  std::vector<Vertex> position_of_rows() const;
  std::vector<Vertex> position_of_columns() const;
};

/// Makes the plan of `pattern` with its rows permuted by `row_order` (empty: identity) for the given tree.
/// The same for any number of threads. Throws InvalidInput("tree", row, column) when an entry joins two
/// branches of the tree.
SymbolicPlan make_symbolic_plan(const Pattern& pattern, const std::vector<Vertex>& row_order,
                                const SeparatorTree& tree, Vertex max_block_size, int threads,
                                const AssemblyTurns& turns = {});

/// The same for a tree of diagonal blocks of `pattern`. Null: of all of it.
SymbolicPlan make_symbolic_plan(const Pattern& pattern, const DiagonalBlocks* blocks,
                                const std::vector<Vertex>& row_order, const SeparatorTree& tree,
                                Vertex max_block_size, int threads, const AssemblyTurns& turns);

}  // namespace mfs
