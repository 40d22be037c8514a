// What the stages work on: the plan and the arena, as plain pointers that any execution space can follow.
#pragma once

#include <Kokkos_Core.hpp>

#include "kernels/factor_status.hpp"
#include "kernels/runtime/scalars.hpp"
#include "plan/symbolic_plan.hpp"

namespace mfs {

/// One front, where its blocks lie (drawing in plan/symbolic_plan.hpp).
template <class Scalar>
struct Front {
  Vertex pivots, border;
  Vertex lower_ld, contribution_ld;
  Scalar* lower;         // [P; L], (pivots + border) x pivots
  Scalar* upper;         // U, pivots x border
  Scalar* contribution;  // C, border x border

  KOKKOS_INLINE_FUNCTION Vertex rows() const { return pivots + border; }
};

/// The plan (SymbolicPlan has the meaning of each array) and the numbers of one factorization in Scalar of a
/// matrix whose values are given as Value (the same, or wider: mixed precision).
template <class Scalar, class Value = Scalar>
struct FrontStore {
  Vertex n;
  Vertex max_block_size;
  const Vertex* row_of;
  const Vertex* column_of;
  const Vertex* pivot_begin;
  const Offset* border_begin;
  const Vertex* border;
  const Vertex* border_in_parent;
  const Vertex* child_begin;
  const Vertex* children;
  const Offset* lower_begin;
  const Offset* upper_begin;
  const Offset* contribution_begin;
  const Offset* entry_begin;
  const Offset* entry_target;   // on the host only, as entry_row is
  const Offset* planned_lower;  // the same: where the targets of a front's entries count its [P; L] from
  const Vertex* entry_row;
  const Vertex* entry_in_row;

  const Offset* matrix_offsets;  // n + 1, rows of A
  const Vertex* matrix_columns;

  Value* matrix_values;  // nnz, in the order of matrix_columns
  double* row_scale;     // n, by row of A
  double* column_scale;  // n, by column of A
  Scalar* storage;       // the region of factors and contribution blocks
  Vertex* interchange;   // n: row exchanges of each block of a pivot block, as factor_panel gives them
  Vertex* local_row;     // n: local_row[pivot_begin + i] = row of the pivot block that came to place i
  Scalar* shift;         // n: what was added to the pivot at each position
  Scalar* work;          // n
  FactorStatus* status;

  KOKKOS_INLINE_FUNCTION Front<Scalar> front(Vertex f) const {
    Front<Scalar> view;
    view.pivots = pivot_begin[f + 1] - pivot_begin[f];
    view.border = static_cast<Vertex>(border_begin[f + 1] - border_begin[f]);
    view.lower_ld = leading_dimension(view.rows());
    view.contribution_ld = leading_dimension(view.border);
    view.lower = storage + lower_begin[f];
    view.upper = storage + upper_begin[f];
    view.contribution = storage + contribution_begin[f];
    return view;
  }
  /// The entry of A in this slot of its pattern, which lies in `row`, scaled.
  KOKKOS_INLINE_FUNCTION Scalar scaled_slot(Offset slot, Vertex row) const {
    const double scale = row_scale[row] * column_scale[matrix_columns[slot]];
    return static_cast<Scalar>(matrix_values[slot] * static_cast<RealOf<Value>>(scale));
  }
  /// Original entry e of the plan, which lies in `row` of A, scaled.
  KOKKOS_INLINE_FUNCTION Scalar scaled_entry(Offset e, Vertex row) const {
    return scaled_slot(matrix_offsets[row] + entry_in_row[e], row);
  }
  /// The same for one that goes to row i of front f, whose pivots are so many.
  KOKKOS_INLINE_FUNCTION Scalar scaled_entry(Offset e, Vertex f, Vertex i, Vertex pivots) const {
    const Vertex position = i < pivots ? pivot_begin[f] + i : border[border_begin[f] + i - pivots];
    return scaled_entry(e, row_of[position]);
  }
};

/// Calls take(pointer, array) for what every executor reads of a plan and its pattern.
template <class Scalar, class Value, class Take>
void for_each_plan_array(FrontStore<Scalar, Value>& store, const SymbolicPlan& plan, const Pattern& pattern,
                         const Take& take) {
  take(store.row_of, plan.row_of);
  take(store.column_of, plan.column_of);
  take(store.pivot_begin, plan.pivot_begin);
  take(store.border_begin, plan.border_begin);
  take(store.border, plan.border);
  take(store.border_in_parent, plan.border_in_parent);
  take(store.child_begin, plan.child_begin);
  take(store.children, plan.children);
  take(store.lower_begin, plan.lower_begin);
  take(store.upper_begin, plan.upper_begin);
  take(store.contribution_begin, plan.contribution_begin);
  take(store.entry_begin, plan.entry_begin);
  take(store.entry_in_row, plan.entry_in_row);
  take(store.matrix_offsets, pattern.offsets);
  take(store.matrix_columns, pattern.columns);
}

/// Calls put(pointer, entries, nullptr) for what a factorization changes, on executors with one region.
template <class Scalar, class Value, class Put>
void for_each_numeric_array(FrontStore<Scalar, Value>& store, const SymbolicPlan& plan, const Put& put) {
  put(store.storage, plan.storage_entries, nullptr);
  put(store.matrix_values, plan.nnz, nullptr);
  put(store.row_scale, plan.n, nullptr);
  put(store.column_scale, plan.n, nullptr);
  put(store.local_row, plan.n, nullptr);
  put(store.shift, plan.n, nullptr);
}

/// First index of a sorted array that is not below `value`.
KOKKOS_INLINE_FUNCTION Vertex lower_bound(const Vertex* sorted, Vertex count, Vertex value) {
  Vertex begin = 0;
  while (count > 0) {
    const Vertex half = count / 2;
    if (sorted[begin + half] < value) {
      begin += half + 1;
      count -= half + 1;
    } else {
      count = half;
    }
  }
  return begin;
}

}  // namespace mfs
