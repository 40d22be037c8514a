// Adds the columns of a child's contribution block to its parent's front. Rows that follow each other go to
// rows that do so as well, because separators keep their order in all borders: a column is added in runs, by
// vectors. Weighted by entries they are 8 to 10 rows long on average (poisson2d:300, convdiff3d:20).
//
//        border    0 1 2 | 3  4 |  5            run: rows from ... from+count-1 of the border
//        map       3 4 5 | 9 10 | 14                 go to rows to ... to+count-1
//
#pragma once

#include "ordering/types.hpp"

namespace mfs {

struct RowRun {
  Vertex from, to, count;
};
/// Runs that are found and added together.
constexpr Vertex kRunsAtOnce = 64;

/// The next runs, at most kRunsAtOnce, of rows [row, rows) of a map that ascends, their targets less `shift`.
/// Returns how many, and moves `row` behind them.
Vertex find_runs(const Vertex* map, Vertex rows, Vertex shift, Vertex& row, RowRun* runs);

/// to(runs, map[j] - shift) += from(runs, j) for columns [begin, end) of `from`; column-major.
template <class Scalar>
void add_runs(const RowRun* runs, Vertex count, const Scalar* from, Offset from_ld, const Vertex* map,
              Vertex begin, Vertex end, Vertex shift, Scalar* to, Offset to_ld);

}  // namespace mfs
