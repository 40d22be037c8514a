// Stage "assemble": original entries and the children's contribution blocks come into the fronts of one
// depth.
//
// A parent pulls: it adds its children's contribution blocks one after another, in the order of the plan, so
// no two threads ever add to the same entry, nothing is atomic, and the result is the same bit for bit from
// run to run. border_in_parent is ascending, so each column of a child's contribution block falls apart at
// most once:
//
//      child column j goes to parent column J = map[j]
//        J < p  ->  column J of [P; L]
//        J >= p ->  rows with map[i] < p into column J-p of U, the rest into column J-p of C
//
// The work is cut by columns of the parent: a small front is one piece, a large one many.
#pragma once

#include <algorithm>

#include "kernels/dense/row_runs.hpp"
#include "kernels/stages/front_store.hpp"

namespace mfs {

template <class Scalar>
void clear_columns(const Front<Scalar>& front, Vertex begin, Vertex end) {
  const Offset p = front.pivots, ld = front.lower_ld, contribution_ld = front.contribution_ld;
  const Offset lower_begin = begin < p ? begin : p, lower_end = end < p ? end : p;
  const Offset right_begin = begin < p ? 0 : begin - p, right_end = end < p ? 0 : end - p;
  std::fill(front.lower + lower_begin * ld, front.lower + lower_end * ld, Scalar(0));
  std::fill(front.upper + right_begin * p, front.upper + right_end * p, Scalar(0));
  std::fill(front.contribution + right_begin * contribution_ld,
            front.contribution + right_end * contribution_ld, Scalar(0));
}

/// First entry of front f that lies in front column `column` or beyond: the entries ascend by column.
template <class Scalar, class Value>
Offset first_entry(const FrontStore<Scalar, Value>& store, Vertex f, Vertex column) {
  const Front<Scalar> front = store.front(f);
  const Offset target =
      store.planned_lower[f] + (column < front.pivots
                                    ? static_cast<Offset>(column) * front.lower_ld
                                    : store.upper_begin[f] - store.lower_begin[f] +
                                          static_cast<Offset>(column - front.pivots) * front.pivots);
  Offset begin = store.entry_begin[f], count = store.entry_begin[f + 1] - begin;
  while (count > 0) {
    const Offset half = count / 2;
    if (store.entry_target[begin + half] < target) {
      begin += half + 1;
      count -= half + 1;
    } else {
      count = half;
    }
  }
  return begin;
}

/// Entries of front f. Its U follows its [P; L] as in the plan, wherever the two lie.
template <class Scalar, class Value>
void scatter_entries(const FrontStore<Scalar, Value>& store, Vertex f, Offset begin, Offset end) {
  Scalar* const lower = store.storage + store.lower_begin[f];
  const Offset planned = store.planned_lower[f];
  for (Offset e = begin; e < end; ++e)
    lower[store.entry_target[e] - planned] = store.scaled_entry(e, store.entry_row[e]);
}

/// Adds rows [row, rows) of columns [begin, end) of a contribution block, which lie `row_shift` and
/// `column_shift` before map has them.
template <class Scalar>
void add_part(const Front<Scalar>& source, const Vertex* map, Vertex row, Vertex rows, Vertex row_shift,
              Vertex begin, Vertex end, Vertex column_shift, Scalar* to, Offset to_ld) {
  RowRun runs[kRunsAtOnce];
  while (begin < end && row < rows) {
    const Vertex count = find_runs(map, rows, row_shift, row, runs);
    add_runs(runs, count, source.contribution, source.contribution_ld, map, begin, end, column_shift, to,
             to_ld);
  }
}

/// Adds what the contribution block of a child (`source`, whose border goes to the rows `map` of its parent's
/// front) has for columns [begin, end) of that front.
template <class Scalar>
void extend_add(const Front<Scalar>& parent, const Front<Scalar>& source, const Vertex* map, Vertex begin,
                Vertex end) {
  const Vertex b = source.border, p = parent.pivots;
  const Vertex split = lower_bound(map, b, p);  // rows before it go to pivot rows
  const Vertex first = lower_bound(map, b, begin), last = lower_bound(map, b, end);
  const Vertex middle = std::clamp(split, first, last);
  add_part(source, map, 0, b, 0, first, middle, 0, parent.lower, parent.lower_ld);
  add_part(source, map, 0, split, 0, middle, last, p, parent.upper, p);
  add_part(source, map, split, b, p, middle, last, p, parent.contribution, parent.contribution_ld);
}

/// Columns [begin, end) of front f, of those that `fronts` gives.
template <class Fronts, class Scalar, class Value>
void assemble_columns(const FrontStore<Scalar, Value>& store, const Fronts& fronts, Vertex f, Vertex begin,
                      Vertex end) {
  const Front<Scalar> front = fronts(f);
  const bool whole = begin == 0 && end == front.rows();
  clear_columns(front, begin, end);
  scatter_entries(store, f, whole ? store.entry_begin[f] : first_entry(store, f, begin),
                  end == front.rows() ? store.entry_begin[f + 1] : first_entry(store, f, end));
  for (Vertex c = store.child_begin[f]; c < store.child_begin[f + 1]; ++c) {
    const Vertex child = store.children[c];
    extend_add(front, fronts(child), store.border_in_parent + store.border_begin[child], begin, end);
  }
}

}  // namespace mfs
