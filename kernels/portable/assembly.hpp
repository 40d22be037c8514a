// Stage "assemble": a front is cleared, its original entries are put in, and its children's contribution
// blocks are added, one child after the other in the plan's order, so that sums are the same for any team.
// Larger fronts are assembled by many teams, a part each, small enough to stay in a cache while it grows.
#pragma once

#include "kernels/portable/store.hpp"

namespace mfs::portable {

/// Rows [first_row, last_row) of columns [begin, end) of a front: entry (i, j) at at[i + j * ld].
template <class S>
struct Area {
  S* at;
  Offset ld;
  Vertex first_row, last_row, begin, end;
};

template <class Team, class S>
KOKKOS_INLINE_FUNCTION void clear(const Team& team, const Area<S>& area) {
  for_each_entry(team, area.last_row - area.first_row, area.end - area.begin, [&](Vertex i, Vertex j) {
    area.at[area.first_row + i + (area.begin + j) * area.ld] = S(0);
  });
}

/// Which rows and columns of a child's contribution block lie in an area. Found for several children at once,
/// a bound by a thread, as a search waits for memory at each of its steps.
struct ChildSpan {
  Vertex top, bottom, left, right;
};
constexpr Vertex kChildrenAtOnce = 16;

template <class Team, class S, class V>
KOKKOS_INLINE_FUNCTION void add_children(const Team& team, const Store<S, V>& store, Vertex f,
                                         const Area<S>& area, ChildSpan* spans) {
  const FrontStore<S, V>& at = store.fronts;
  const Vertex last = at.child_begin[f + 1];
  for (Vertex first = at.child_begin[f]; first < last; first += kChildrenAtOnce) {
    const Vertex count = kChildrenAtOnce < last - first ? kChildrenAtOnce : last - first;
    for_each(team, 4 * count, [&](Vertex lane) {
      const Vertex child = at.children[first + lane / 4];
      const Vertex* const map = at.border_in_parent + at.border_begin[child];
      const Vertex b = static_cast<Vertex>(at.border_begin[child + 1] - at.border_begin[child]);
      ChildSpan& span = spans[lane / 4];
      if (lane % 4 == 0) span.top = lower_bound(map, b, area.first_row);
      if (lane % 4 == 1) span.bottom = lower_bound(map, b, area.last_row);
      if (lane % 4 == 2) span.left = lower_bound(map, b, area.begin);
      if (lane % 4 == 3) span.right = lower_bound(map, b, area.end);
    });
    team.team_barrier();
    for (Vertex c = 0; c < count; ++c) {
      const Vertex child = at.children[first + c];
      const Vertex* const map = at.border_in_parent + at.border_begin[child];
      const Offset ld =
          leading_dimension(static_cast<Vertex>(at.border_begin[child + 1] - at.border_begin[child]));
      const ChildSpan span = spans[c];
      const S* const block = at.storage + at.contribution_begin[child];
      for_each_entry(team, span.bottom - span.top, span.right - span.left, [&](Vertex i, Vertex j) {
        area.at[map[span.top + i] + map[span.left + j] * area.ld] +=
            block[span.top + i + (span.left + j) * ld];
      });
      team.team_barrier();
    }
  }
}

/// Of larger fronts, a part each.
template <class Exec, class S, class V>
struct AssembleParts {
  Store<S, V> store;
  const AssemblyPart* parts;

  KOKKOS_INLINE_FUNCTION void operator()(const TeamOf<Exec>& team) const {
    const AssemblyPart part = parts[team.league_rank()];
    const Front<S> front = store.fronts.front(part.front);
    const Vertex p = front.pivots;
    ChildSpan* const spans = scratch<ChildSpan>(team, kChildrenAtOnce);
    Area<S> area{front.lower, front.lower_ld, part.first_row, part.last_row, part.begin, part.end};
    if (part.begin >= p) {
      const bool pivot_rows = part.first_row < p;
      area.ld = pivot_rows ? p : front.contribution_ld;
      area.at = pivot_rows ? front.upper - p * area.ld : front.contribution - p * area.ld - p;
    }
    clear(team, area);
    team.team_barrier();
    S* const first_column = area.at + area.first_row + area.begin * area.ld;
    for_each(team, static_cast<Vertex>(part.last_entry - part.first_entry), [&](Vertex k) {
      const Offset e = part.first_entry + k;
      const Vertex place = store.entry_place[e];
      const Vertex i = area.first_row + static_cast<Vertex>(place % area.ld);
      first_column[place] = store.fronts.scaled_entry(e, part.front, i, p);
    });
    team.team_barrier();
    add_children(team, store, part.front, area, spans);
  }
};

/// Where the blocks of one front lie while a team works on it.
template <class S>
struct Blocks {
  Vertex pivots, border;
  S *lower, *upper, *contribution;  // [P; L], U, C
  Offset lower_ld, upper_ld, contribution_ld;
};

// The rows of a child's block before `split` go to pivot rows of the parent, its columns to pivot columns.
// Ends with a barrier.
template <class Team, class S, class V>
KOKKOS_INLINE_FUNCTION void add_child(const Team& team, const Store<S, V>& store, Vertex child,
                                      const Blocks<S>& to) {
  const FrontStore<S, V>& at = store.fronts;
  const Vertex* const map = at.border_in_parent + at.border_begin[child];
  const Vertex b = static_cast<Vertex>(at.border_begin[child + 1] - at.border_begin[child]);
  const Vertex p = to.pivots, split = lower_bound(map, b, p);
  const Offset ld = leading_dimension(b);
  const S* const block = at.storage + at.contribution_begin[child];
  for_each_entry(team, b, split,
                 [&](Vertex i, Vertex j) { to.lower[map[i] + map[j] * to.lower_ld] += block[i + j * ld]; });
  const Vertex* const columns = map + split;
  const Vertex right = b - split;
  const S* const beyond = block + split * ld;
  for_each_entry(team, split, right, [&](Vertex i, Vertex j) {
    to.upper[map[i] + (columns[j] - p) * to.upper_ld] += beyond[i + j * ld];
  });
  for_each_entry(team, right, right, [&](Vertex i, Vertex j) {
    to.contribution[columns[i] - p + (columns[j] - p) * to.contribution_ld] += beyond[split + i + j * ld];
  });
  team.team_barrier();
}

template <class Team, class S, class V>
KOKKOS_INLINE_FUNCTION void assemble_front(const Team& team, const Store<S, V>& store, Vertex f,
                                           const Blocks<S>& to) {
  const FrontStore<S, V>& at = store.fronts;
  const Vertex p = to.pivots, rows = p + to.border;
  const Offset upper_place = p * static_cast<Offset>(leading_dimension(rows));
  clear(team, Area<S>{to.lower, to.lower_ld, 0, rows, 0, p});
  clear(team, Area<S>{to.upper, to.upper_ld, 0, p, 0, to.border});
  clear(team, Area<S>{to.contribution, to.contribution_ld, 0, to.border, 0, to.border});
  team.team_barrier();
  const Offset first = at.entry_begin[f];
  for_each(team, static_cast<Vertex>(at.entry_begin[f + 1] - first), [&](Vertex k) {
    const Vertex place = store.entry_place[first + k];
    const bool lower = place < upper_place;
    const Offset in_block = lower ? place : place - upper_place;
    const Offset ld = lower ? static_cast<Offset>(leading_dimension(rows)) : p;
    const Vertex i = static_cast<Vertex>(in_block % ld);
    const Offset j = in_block / ld;
    S& entry = lower ? to.lower[i + j * to.lower_ld] : to.upper[i + j * to.upper_ld];
    entry = store.fronts.scaled_entry(first + k, f, i, p);
  });
  team.team_barrier();
  for (Vertex c = at.child_begin[f]; c < at.child_begin[f + 1]; ++c)
    add_child(team, store, at.children[c], to);
}

}  // namespace mfs::portable
