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

#include "kernels/dispatch.hpp"
#include "kernels/front_store.hpp"

namespace mfs {

template <class TeamMember, class Scalar>
void clear_columns(const TeamMember& team, const Front<Scalar>& front, Vertex begin, Vertex end) {
  const Offset p = front.pivots, ld = front.lower_ld, contribution_ld = front.contribution_ld;
  const Offset lower_begin = begin < p ? begin : p, lower_end = end < p ? end : p;
  const Offset right_begin = begin < p ? 0 : begin - p, right_end = end < p ? 0 : end - p;
  team_range(team, lower_begin * ld, lower_end * ld, [&](Offset i) { front.lower[i] = Scalar(0); });
  team_range(team, right_begin * p, right_end * p, [&](Offset i) { front.upper[i] = Scalar(0); });
  team_range(team, right_begin * contribution_ld, right_end * contribution_ld,
             [&](Offset i) { front.contribution[i] = Scalar(0); });
}

/// First entry of front f that lies in front column `column` or beyond: the entries ascend by column.
template <class Scalar, class Value>
KOKKOS_INLINE_FUNCTION Offset first_entry(const FrontStore<Scalar, Value>& store, Vertex f, Vertex column) {
  const Front<Scalar> front = store.front(f);
  const Offset target =
      column < front.pivots
          ? store.lower_begin[f] + static_cast<Offset>(column) * front.lower_ld
          : store.upper_begin[f] + static_cast<Offset>(column - front.pivots) * front.pivots;
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

template <class TeamMember, class Scalar, class Value>
void scatter_entries(const TeamMember& team, const FrontStore<Scalar, Value>& store, Offset begin,
                     Offset end) {
  team_range(team, begin, end,
             [&](Offset e) { store.storage[store.entry_target[e]] = store.scaled_entry(e); });
}

/// Adds what the contribution block of `child` has for columns [begin, end) of its parent's front.
template <class TeamMember, class Scalar, class Value>
void extend_add(const TeamMember& team, const FrontStore<Scalar, Value>& store, const Front<Scalar>& parent,
                Vertex child, Vertex begin, Vertex end) {
  const Vertex* map = store.border_in_parent + store.border_begin[child];
  const Front<Scalar> source = store.front(child);
  const Vertex b = source.border, p = parent.pivots;
  const Vertex split = lower_bound(map, b, p);  // rows before it go to pivot rows
  const Vertex last = lower_bound(map, b, end);
  for (Vertex j = lower_bound(map, b, begin); j < last; ++j) {
    const Scalar* column = source.contribution + static_cast<Offset>(j) * source.contribution_ld;
    const Offset target = map[j];
    if (target < p) {
      Scalar* lower = parent.lower + target * parent.lower_ld;
      team_range(team, 0, b, [&](Offset i) { lower[map[i]] += column[i]; });
    } else {
      Scalar* upper = parent.upper + (target - p) * p;
      Scalar* contribution = parent.contribution + (target - p) * parent.contribution_ld;
      team_range(team, 0, split, [&](Offset i) { upper[map[i]] += column[i]; });
      team_range(team, split, b, [&](Offset i) { contribution[map[i] - p] += column[i]; });
    }
  }
}

/// Columns [begin, end) of front f, by one team.
template <class TeamMember, class Scalar, class Value>
void assemble_columns(const TeamMember& team, const FrontStore<Scalar, Value>& store, Vertex f, Vertex begin,
                      Vertex end) {
  const Front<Scalar> front = store.front(f);
  clear_columns(team, front, begin, end);
  team.team_barrier();
  scatter_entries(team, store, first_entry(store, f, begin),
                  end == front.rows() ? store.entry_begin[f + 1] : first_entry(store, f, end));
  for (Vertex c = store.child_begin[f]; c < store.child_begin[f + 1]; ++c) {
    team.team_barrier();
    extend_add(team, store, front, store.children[c], begin, end);
  }
  team.team_barrier();
}

/// One large front, its columns shared by all teams.
template <class Exec, class Scalar, class Value>
void assemble_large_front(const Exec& exec, const FrontStore<Scalar, Value>& store, Vertex f, Vertex rows,
                          Vertex tile_columns) {
  const Vertex tiles = (rows + tile_columns - 1) / tile_columns;
  for_each_team(exec, "mfs::assemble", tiles, [=](const Team<Exec>& team, Vertex tile) {
    const Vertex begin = tile * tile_columns;
    assemble_columns(team, store, f, begin, begin + tile_columns < rows ? begin + tile_columns : rows);
  });
}

}  // namespace mfs
