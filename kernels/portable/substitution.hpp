// Stage "solve", depth after depth: forward from the deepest one up, backward down again. Vectors are in
// elimination order, n x columns, column-major. Fronts of few pivots are solved with by one team each. Of
// larger ones the pivot block is taken in tiles, a launch after the other: in each, a team does for the rows
// of one tile what the tile before them has for them, and the team of the tile next to that solves with its
// diagonal block. What a border row adds to its ancestors is left at a place of its own, and a parent gathers
// its children's in the plan's order: nothing is atomic.
#pragma once

#include "kernels/portable/dense.hpp"
#include "kernels/portable/store.hpp"

namespace mfs::portable {

/// Rows of a front from `begin` on: the tile before which a step's tile is, a chunk of its pivots or border.
struct SolveTask {
  Vertex front, begin;
};

template <class S>
struct Vectors {
  Vertex columns;
  S *v, *y;   // n x columns
  S* border;  // places x columns
};

/// How many rows of a border a task has, and how many of them, or of its columns, a team takes at a time.
struct SolveSizes {
  Vertex tile, border, chunk;
};

/// What all kernels of a solve share.
template <class S, class V, class Dense>
struct Substitution {
  FrontStore<S, V> fronts;
  const Offset* row_begin;
  const Vertex *source_begin, *destination;
  Offset places;  // of border rows
  Vectors<S> at;
  SolveSizes sizes;
  bool transposed;
  Dense dense;

  // After chunk x columns entries of scratch memory, those that products need.
  KOKKOS_INLINE_FUNCTION S* beside(S* held) const {
    return held + static_cast<Offset>(sizes.chunk) * at.columns;
  }
  KOKKOS_INLINE_FUNCTION Offset held_entries() const {
    return static_cast<Offset>(sizes.chunk) * at.columns + Dense::few_entries(at.columns);
  }
  KOKKOS_INLINE_FUNCTION Transpose op() const { return transposed ? Transpose::yes : Transpose::no; }
  KOKKOS_INLINE_FUNCTION S* y_of(Vertex f) const { return at.y + fronts.pivot_begin[f]; }

  // What the children left for a row of a front.
  KOKKOS_INLINE_FUNCTION S of_children(Offset row, Vertex j) const {
    const S* const from = at.border + j * places;
    S sum(0);
    for (Vertex s = source_begin[row]; s < source_begin[row + 1]; ++s) sum += from[s];
    return sum;
  }

  // y = v for pivots [begin, end), in the order that the exchanges left, with what the children have.
  template <class Team>
  KOKKOS_INLINE_FUNCTION void gather(const Team& team, Vertex f, Vertex begin, Vertex end) const {
    const Vertex first = fronts.pivot_begin[f];
    for_each_entry(team, end - begin, at.columns, [&](Vertex k, Vertex j) {
      const Vertex i = begin + k, source = transposed ? i : fronts.local_row[first + i];
      const Offset column = j * static_cast<Offset>(fronts.n);
      at.y[first + i + column] = at.v[first + source + column] + of_children(row_begin[f] + source, j);
    });
  }

  // The border rows [begin, end): what the children left less what the front's pivots take.
  template <class Team>
  KOKKOS_INLINE_FUNCTION void leave_border(const Team& team, Vertex f, const Front<S>& front, Vertex begin,
                                           Vertex end, S* z) const {
    for (; begin < end; begin += sizes.chunk)
      leave_chunk(team, f, front, begin, begin + sizes.chunk < end ? begin + sizes.chunk : end, z);
  }
  template <class Team>
  KOKKOS_INLINE_FUNCTION void leave_chunk(const Team& team, Vertex f, const Front<S>& front, Vertex begin,
                                          Vertex end, S* z) const {
    const Vertex rows = end - begin, p = front.pivots;
    for_each_entry(team, rows, at.columns, [&](Vertex i, Vertex j) {
      z[i + j * rows] = of_children(row_begin[f] + p + begin + i, j);
    });
    team.team_barrier();
    const S* const block =
        transposed ? front.upper + static_cast<Offset>(begin) * p : front.lower + p + begin;
    dense.multiply_few(team, op(), rows, at.columns, p, block, transposed ? p : front.lower_ld, y_of(f),
                       fronts.n, z, rows, beside(z));
    team.team_barrier();
    const Vertex* const to = destination + fronts.border_begin[f] + begin;
    for_each_entry(team, rows, at.columns,
                   [&](Vertex i, Vertex j) { at.border[to[i] + j * places] = z[i + j * rows]; });
    team.team_barrier();
  }

  // y(begin ... end) -= what the border's unknowns take there.
  template <class Team>
  KOKKOS_INLINE_FUNCTION void take_border(const Team& team, Vertex f, const Front<S>& front, Vertex begin,
                                          Vertex end, S* x) const {
    const Vertex p = front.pivots;
    const Offset ld = front.lower_ld;
    for (Vertex k = 0; k < front.border; k += sizes.chunk) {
      const Vertex depth = sizes.chunk < front.border - k ? sizes.chunk : front.border - k;
      const Vertex* const rows = fronts.border + fronts.border_begin[f] + k;
      for_each_entry(team, depth, at.columns, [&](Vertex i, Vertex j) {
        x[i + j * depth] = at.v[rows[i] + j * static_cast<Offset>(fronts.n)];
      });
      team.team_barrier();
      const S* const block =
          transposed ? front.lower + p + k + begin * ld : front.upper + begin + k * static_cast<Offset>(p);
      dense.multiply_few(team, op(), end - begin, at.columns, depth, block, transposed ? ld : p, x, depth,
                         y_of(f) + begin, fronts.n, beside(x));
      team.team_barrier();
    }
  }

  // Solves with the diagonal block of pivots [begin, end), forward or backward. Ends with a barrier.
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_diagonal(const Team& team, Vertex f, const Front<S>& front, Vertex begin,
                                             Vertex end, bool forward, S* held) const {
    const S* const block = front.lower + begin + begin * static_cast<Offset>(front.lower_ld);
    S* const y = y_of(f) + begin;
    if (forward != transposed) {
      dense.solve_unit_lower(team, op(), end - begin, at.columns, block, front.lower_ld, y, fronts.n, held);
    } else {
      dense.solve_upper(team, op(), end - begin, at.columns, block, front.lower_ld, y, fronts.n, held);
    }
    team.team_barrier();
  }

  // y(rows from `begin` on) -= block(rows, unknowns from k on) y(k ...): both in the pivot block.
  template <class Team>
  KOKKOS_INLINE_FUNCTION void take_tile(const Team& team, Vertex f, const Front<S>& front, Vertex begin,
                                        Vertex rows, Vertex k, Vertex depth, S* held) const {
    const Offset ld = front.lower_ld;
    const S* const block = transposed ? front.lower + k + begin * ld : front.lower + begin + k * ld;
    dense.multiply_few(team, op(), rows, at.columns, depth, block, ld, y_of(f) + k, fronts.n, y_of(f) + begin,
                       fronts.n, beside(held));
    team.team_barrier();
  }

  // v = y for pivots [begin, end).
  template <class Team>
  KOKKOS_INLINE_FUNCTION void scatter(const Team& team, Vertex f, Vertex begin, Vertex end) const {
    const Vertex first = fronts.pivot_begin[f];
    for_each_entry(team, end - begin, at.columns, [&](Vertex k, Vertex j) {
      const Vertex i = begin + k, target = transposed ? fronts.local_row[first + i] : i;
      const Offset column = j * static_cast<Offset>(fronts.n);
      at.v[first + target + column] = at.y[first + i + column];
    });
  }
  KOKKOS_INLINE_FUNCTION Vertex tile_end(const Front<S>& front, Vertex begin) const {
    return begin + sizes.tile < front.pivots ? begin + sizes.tile : front.pivots;
  }
};

/// A whole front, forward or backward.
template <class Exec, class S, class V, class Dense>
struct SolveWhole {
  Substitution<S, V, Dense> all;
  const Vertex* list;
  bool forward;

  KOKKOS_INLINE_FUNCTION void operator()(const TeamOf<Exec>& team) const {
    const Vertex f = list[team.league_rank()];
    const Front<S> front = all.fronts.front(f);
    const Vertex p = front.pivots;
    S* const held = scratch<S>(team, all.held_entries());
    if (forward) {
      all.gather(team, f, 0, p);
      team.team_barrier();
      all.solve_diagonal(team, f, front, 0, p, true, held);
      all.leave_border(team, f, front, 0, front.border, held);
    } else {
      all.take_border(team, f, front, 0, p, held);
      all.solve_diagonal(team, f, front, 0, p, false, held);
      all.scatter(team, f, 0, p);
    }
  }
};

/// Of larger fronts: before the first step of a depth, a tile of rows of a front each.
template <class Exec, class S, class V, class Dense>
struct BeginTiles {
  Substitution<S, V, Dense> all;
  const SolveTask* tasks;
  bool forward;

  KOKKOS_INLINE_FUNCTION void operator()(const TeamOf<Exec>& team) const {
    const SolveTask task = tasks[team.league_rank()];
    const Front<S> front = all.fronts.front(task.front);
    const Vertex begin = task.begin, end = all.tile_end(front, begin);
    S* const held = scratch<S>(team, all.held_entries());
    if (forward) {
      all.gather(team, task.front, begin, end);
    } else {
      all.take_border(team, task.front, front, begin, end, held);
    }
    team.team_barrier();
    if (begin != (forward ? 0 : (front.pivots - 1) / all.sizes.tile * all.sizes.tile)) return;
    all.solve_diagonal(team, task.front, front, begin, end, forward, held);
    if (!forward) all.scatter(team, task.front, begin, end);
  }
};

/// A step: the rows of one tile take what tile `step` has for them, counted from the first one forward and
/// from the last one of each front backward; the tile next to it is then solved for.
template <class Exec, class S, class V, class Dense>
struct StepTiles {
  Substitution<S, V, Dense> all;
  const SolveTask* tasks;
  Vertex step;
  bool forward;

  KOKKOS_INLINE_FUNCTION void operator()(const TeamOf<Exec>& team) const {
    const SolveTask task = tasks[team.league_rank()];
    const Front<S> front = all.fronts.front(task.front);
    const Vertex tile = all.sizes.tile, begin = task.begin, end = all.tile_end(front, begin);
    const Vertex k = forward ? step * tile : ((front.pivots - 1) / tile - step) * tile;
    S* const held = scratch<S>(team, all.held_entries());
    all.take_tile(team, task.front, front, begin, end - begin, k, all.tile_end(front, k) - k, held);
    if (begin != (forward ? k + tile : k - tile)) return;
    all.solve_diagonal(team, task.front, front, begin, end, forward, held);
    if (!forward) all.scatter(team, task.front, begin, end);
  }
};

/// The border rows of larger fronts, a chunk each, when all pivots of the depth are solved for.
template <class Exec, class S, class V, class Dense>
struct LeaveBorders {
  Substitution<S, V, Dense> all;
  const SolveTask* tasks;

  KOKKOS_INLINE_FUNCTION void operator()(const TeamOf<Exec>& team) const {
    const SolveTask task = tasks[team.league_rank()];
    const Front<S> front = all.fronts.front(task.front);
    S* const held = scratch<S>(team, all.held_entries());
    const Vertex after = task.begin + all.sizes.border;
    all.leave_border(team, task.front, front, task.begin, after < front.border ? after : front.border, held);
  }
};

}  // namespace mfs::portable
