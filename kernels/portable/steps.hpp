// Larger fronts, step by step (drawing in plan/device_plan.hpp): diagonal tiles, strips and products, each of
// all fronts of a depth in one launch.
//
// A tile's pivots are searched in the tile. Where that is not good enough - a pivot is small while rows of
// the pivot block below the tile were left out, or a multiplier there grows - the front becomes strict, and
// the factorization is repeated with its pivots searched in all rows of the pivot block, which one team then
// works on in their place. Spaces of the host search all rows from the start: a thread has its cache for
// them.
#pragma once

#include "kernels/portable/dense.hpp"
#include "kernels/portable/store.hpp"

namespace mfs::portable {

/// The task that `place` belongs to: the last of `count` whose `first` member is not beyond it.
template <class Task>
KOKKOS_INLINE_FUNCTION Vertex find_task(const Task* tasks, Vertex count, Vertex Task::*first, Vertex place) {
  Vertex begin = 0;
  while (count > 1) {
    const Vertex half = count / 2;
    if (tasks[begin + half].*first <= place) {
      begin += half;
      count -= half;
    } else {
      count = half;
    }
  }
  return begin;
}

/// Makes the moves of a step in `columns` columns, by way of `room` entries of scratch memory, at least as
/// many as rows move. Ends with a barrier.
template <class Team, class T>
KOKKOS_INLINE_FUNCTION void move_rows(const Team& team, const RowMoves& moves, Vertex columns, T* a,
                                      Offset lda, T* held, Offset room) {
  if (moves.count == 0) return;
  const Vertex together = static_cast<Vertex>(room / moves.count);
  for (Vertex begin = 0; begin < columns; begin += together) {
    const Vertex width = together < columns - begin ? together : columns - begin;
    T* const from = a + begin * lda;
    for_each_entry(team, moves.count, width, [&](Vertex q, Vertex c) {
      held[q + static_cast<Offset>(c) * moves.count] = from[moves.from[q] + c * lda];
    });
    team.team_barrier();
    for_each_entry(team, moves.count, width, [&](Vertex q, Vertex c) {
      from[moves.to[q] + c * lda] = held[q + static_cast<Offset>(c) * moves.count];
    });
    team.team_barrier();
  }
}

/// Scratch memory of a diagonal tile: itself, its pivots and their inverses, its rows in the order of pivots,
/// and rows that move.
template <class S>
constexpr Offset diagonal_bytes(Vertex tile) {
  const Offset entries = static_cast<Offset>(tile) * tile + 2 * tile;
  return entries * static_cast<Offset>(sizeof(S)) + 3 * tile * static_cast<Offset>(sizeof(Vertex)) + 64;
}

template <class Exec, class S, class V, class Dense>
struct DiagonalTiles {
  Store<S, V> store;
  const StepTask* tasks;
  Vertex tile;
  Dense dense;

  KOKKOS_INLINE_FUNCTION void operator()(const TeamOf<Exec>& team) const { factor(team, team.league_rank()); }
  KOKKOS_INLINE_FUNCTION void factor(const TeamOf<Exec>& team, Vertex place) const {
    const StepTask task = tasks[place];
    const Front<S> front = store.fronts.front(task.front);
    const Vertex left = front.pivots - task.k, s = tile < left ? tile : left;
    if constexpr (Dense::kSearchesAll) {
      factor_by_library(team, task, front, s);
    } else if (store.is_strict(task.front)) {
      factor_all_rows(team, task, front, s);
    } else {
      factor_in_scratch(team, task, front, s);
    }
  }

 private:
  KOKKOS_INLINE_FUNCTION PanelPlace<S> panel_place(const StepTask& task, const Front<S>& front, Vertex s,
                                                   bool all_rows) const {
    const FrontStore<S, V>& fronts = store.fronts;
    const Vertex left = front.pivots - task.k, first = fronts.pivot_begin[task.front] + task.k;
    const S* const border = front.lower + front.pivots + task.k * static_cast<Offset>(front.lower_ld);
    const PivotRule of_tile = store.tile_rule(divides());
    return {border,
            front.lower_ld,
            {left, front.border, !all_rows && s < left},
            all_rows ? store.rule() : of_tile,
            of_tile,
            fronts.shift + first,
            fronts.work + first};
  }
  KOKKOS_INLINE_FUNCTION bool divides() const {
    if constexpr (Dense::kSearchesAll) {
      return false;
    } else {
      return dense.substitutes;
    }
  }
  KOKKOS_INLINE_FUNCTION S* diagonal(const StepTask& task, const Front<S>& front) const {
    return front.lower + task.k + task.k * static_cast<Offset>(front.lower_ld);
  }

  KOKKOS_INLINE_FUNCTION void factor_in_scratch(const TeamOf<Exec>& team, const StepTask& task,
                                                const Front<S>& front, Vertex s) const {
    const Offset ld = front.lower_ld;
    S *const in_place = diagonal(task, front), *const held =
                                                   scratch<S>(team, static_cast<Offset>(tile) * tile);
    S* const pivot = scratch<S>(team, 2 * static_cast<Offset>(tile));
    Vertex* const order = scratch<Vertex>(team, tile);
    const TileInScratch<S> in_scratch{held, s, s, pivot, pivot + tile, order};
    for_each_entry(team, s, s, [&](Vertex i, Vertex j) { held[i + j * s] = in_place[i + j * ld]; });
    team.team_barrier();
    const PanelTally tally = factor_tile(team, in_scratch, panel_place(task, front, s, false));
    write_inverted(
        team, s, dense.substitutes, [&](Vertex i, Vertex j) { return in_scratch.at(i, j); }, in_place, ld);
    const Offset first = store.fronts.pivot_begin[task.front] + static_cast<Offset>(task.k);
    for_each(team, s, [&](Vertex j) {
      store.fronts.local_row[first + j] = task.k + order[j];
      Vertex place = 0;
      for (Vertex i = 0; i < j; ++i) place += order[i] != i;
      if (order[j] != j) {
        store.move_to[2 * first + place] = j;
        store.move_from[2 * first + place] = order[j];
      }
      if (j == s - 1) store.move_count[first] = place + (order[j] != j);
    });
    once(team, [&]() {
      store.note(tally);
      if (tally.undecided) store.make_strict(task.front);
    });
  }

  KOKKOS_INLINE_FUNCTION void factor_all_rows(const TeamOf<Exec>& team, const StepTask& task,
                                              const Front<S>& front, Vertex s) const {
    const Offset ld = front.lower_ld;
    const Vertex first = store.fronts.pivot_begin[task.front] + task.k;
    S *const in_place = diagonal(task, front), *const held =
                                                   scratch<S>(team, static_cast<Offset>(tile) * tile);
    const PanelTally tally = factor_rows(team, in_place, ld, front.pivots - task.k, s,
                                         panel_place(task, front, s, true), store.fronts.interchange + first);
    if (tally.needed_all || (dense.substitutes && tally.perturbed > 0))
      once(team, [&]() { store.need_strict(task.front); });
    note_exchanges(team, task, front, s, tally);
    exchange_whole_rows(team, front, task.k, s, store.moves(task.front, task.k), held);
    for_each_entry(team, s, s, [&](Vertex i, Vertex j) { held[i + j * s] = in_place[i + j * ld]; });
    team.team_barrier();
    write_inverted(
        team, s, dense.substitutes, [&](Vertex i, Vertex j) { return held[i + j * s]; }, in_place, ld);
  }

  KOKKOS_INLINE_FUNCTION void factor_by_library(const TeamOf<Exec>& team, const StepTask& task,
                                                const Front<S>& front, Vertex s) const {
    const Vertex first = store.fronts.pivot_begin[task.front] + task.k;
    const PanelTally tally =
        dense.factor_panel(diagonal(task, front), front.lower_ld, front.pivots - task.k, s,
                           panel_place(task, front, s, true), store.fronts.interchange + first);
    note_exchanges(team, task, front, s, tally);
  }

  // What came where, by exchanges that reach all rows of the pivot block. Ends with a barrier.
  KOKKOS_INLINE_FUNCTION void note_exchanges(const TeamOf<Exec>& team, const StepTask& task,
                                             const Front<S>& front, Vertex s, const PanelTally& tally) const {
    const Vertex first = store.fronts.pivot_begin[task.front] + task.k;
    Vertex* const held_rows = scratch<Vertex>(team, 2 * static_cast<Offset>(tile));
    Vertex* const local_row = store.fronts.local_row + first;
    if (task.k == 0) for_each(team, front.pivots, [&](Vertex i) { local_row[i] = i; });
    once(team, [&]() {
      store.note(tally);
      combine_moves(first, s);
    });
    team.team_barrier();
    move_rows(team, store.moves(task.front, task.k), 1, local_row, 0, held_rows,
              2 * static_cast<Offset>(tile));
  }

  // Columns right of a panel, and those left of the tile, take part in later products with the rows as they
  // are then: so the rows of strict fronts, which are exchanged across tiles, are exchanged as a whole at
  // once.
  KOKKOS_INLINE_FUNCTION void exchange_whole_rows(const TeamOf<Exec>& team, const Front<S>& front, Vertex k,
                                                  Vertex s, const RowMoves& moves, S* held) const {
    const Offset ld = front.lower_ld, room = static_cast<Offset>(tile) * tile;
    move_rows(team, moves, k, front.lower + k, ld, held, room);
    move_rows(team, moves, front.pivots - k - s, front.lower + k + (k + s) * ld, ld, held, room);
    move_rows(team, moves, front.border, front.upper + k, front.pivots, held, room);
  }

  // The exchanges of a step as moves of its rows and of those that they were exchanged with.
  KOKKOS_INLINE_FUNCTION void combine_moves(Vertex first, Vertex s) const {
    const Vertex* const interchange = store.fronts.interchange + first;
    Vertex *const off = store.displacement + first,
                  *const to = store.move_to + 2 * static_cast<Offset>(first),
                  *const from = store.move_from + 2 * static_cast<Offset>(first);
    for (Vertex j = 0; j < s; ++j) {
      const Vertex r = interchange[j];
      if (r == j) continue;
      const Vertex of_row = r + off[r];
      off[r] = j + off[j] - r;
      off[j] = of_row - j;
    }
    Vertex count = 0;
    const auto take = [&](Vertex row) {
      if (off[row] == 0) return;
      to[count] = row;
      from[count++] = row + off[row];
      off[row] = 0;
    };
    for (Vertex j = 0; j < s; ++j) take(j);
    for (Vertex j = 0; j < s; ++j) take(interchange[j]);
    store.move_count[first] = count;
  }
};

/// Rows below a tile are solved for by its U, columns right of it by its L, `height` of them by a team; the
/// columns come with the step's exchanges to make.
template <class Exec, class S, class V, class Dense>
struct Strips {
  Store<S, V> store;
  const StepTask* tasks;
  Vertex count, tile, height;
  Offset room;  // entries of scratch memory
  Dense dense;

  KOKKOS_INLINE_FUNCTION void operator()(const TeamOf<Exec>& team) const {
    const Vertex place = team.league_rank();
    const StepTask task = tasks[find_task(tasks, count, &StepTask::first_strip, place)];
    const Front<S> front = store.fronts.front(task.front);
    const Vertex left = front.pivots - task.k, s = tile < left ? tile : left;
    const Vertex below = task.left ? left - s + front.border : 0, strips = (below + height - 1) / height;
    const Vertex strip = place - task.first_strip;
    S* const held = scratch<S>(team, room);
    if (strip < strips) {
      solve_rows(team, task, front, s, strip * height, below, held);
    } else {
      solve_columns(team, task, front, s, task.begin + (strip - strips) * height, held);
    }
  }

 private:
  // Of strict fronts, pivot rows below the tile are multipliers already.
  KOKKOS_INLINE_FUNCTION void solve_rows(const TeamOf<Exec>& team, const StepTask& task,
                                         const Front<S>& front, Vertex s, Vertex begin, Vertex below,
                                         S* held) const {
    const Vertex end = begin + height < below ? begin + height : below, rest = front.pivots - task.k - s;
    const bool all_rows = Dense::kSearchesAll || store.is_strict(task.front);
    if (all_rows && begin < rest) begin = rest;
    if (begin >= end) return;
    const Offset ld = front.lower_ld;
    const S* const diagonal = front.lower + task.k + task.k * ld;
    S* const rows = front.lower + task.k + s + begin + task.k * ld;
    dense.solve_upper_right(team, end - begin, s, diagonal, ld, rows, ld, held);
    if constexpr (!Dense::kSearchesAll) {
      if (all_rows || (begin >= rest && !dense.substitutes)) return;
      const Vertex last = dense.substitutes || end < rest ? end : rest;
      const double most = most_left_out(store.pivots, dense.substitutes);
      for_each_entry(team, last - begin, s, [&](Vertex i, Vertex j) {
        if (magnitude(rows[i + j * ld]) > most) store.make_strict(task.front);
      });
    }
  }

  // Columns count from the tile's right edge; those of P lie in other places than those of U.
  KOKKOS_INLINE_FUNCTION void solve_columns(const TeamOf<Exec>& team, const StepTask& task,
                                            const Front<S>& front, Vertex s, Vertex begin, S* held) const {
    const Vertex end = begin + height < task.end ? begin + height : task.end;
    const Vertex rest = front.pivots - task.k - s, middle = rest < begin ? begin : rest < end ? rest : end;
    const Offset ld = front.lower_ld, p = front.pivots;
    solve_block(team, task, s, middle - begin, front.lower + task.k + (task.k + s + begin) * ld, ld, front,
                held);
    solve_block(team, task, s, end - middle, front.upper + task.k + (middle - rest) * p, p, front, held);
  }
  KOKKOS_INLINE_FUNCTION void solve_block(const TeamOf<Exec>& team, const StepTask& task, Vertex s,
                                          Vertex columns, S* block, Offset block_ld, const Front<S>& front,
                                          S* held) const {
    if (columns <= 0) return;
    if (Dense::kSearchesAll || !store.is_strict(task.front))
      move_rows(team, store.moves(task.front, task.k), columns, block, block_ld, held, room);
    const S* const diagonal = front.lower + task.k + task.k * static_cast<Offset>(front.lower_ld);
    dense.solve_unit_lower_strip(team, s, columns, diagonal, front.lower_ld, block, block_ld, held);
  }
};

/// C -= A B for a list of products, a tile of C by a team.
template <class Exec, class S, class Dense>
struct Products {
  S* storage;
  const ProductTask* tasks;
  Vertex count, rows, columns;  // of a tile
  Dense dense;

  KOKKOS_INLINE_FUNCTION void operator()(const TeamOf<Exec>& team) const {
    subtract(team, team.league_rank());
  }
  KOKKOS_INLINE_FUNCTION void subtract(const TeamOf<Exec>& team, Vertex place) const {
    const ProductTask task = tasks[find_task(tasks, count, &ProductTask::first_tile, place)];
    const Vertex tile = place - task.first_tile, down = (task.m + rows - 1) / rows;
    const Vertex i = tile % down * rows, j = tile / down * columns;
    dense.subtract_product(team, task.m - i < rows ? task.m - i : rows,
                           task.n - j < columns ? task.n - j : columns, task.k, storage + task.a + i,
                           task.lda, storage + task.b + j * static_cast<Offset>(task.ldb), task.ldb,
                           storage + task.c + i + j * static_cast<Offset>(task.ldc), task.ldc);
  }
};

/// The next diagonal tiles, which begin first, beside products that they do not need.
template <class Exec, class S, class V, class Dense>
struct TilesAndProducts {
  DiagonalTiles<Exec, S, V, Dense> tiles;
  Products<Exec, S, Dense> products;
  Vertex first_product;

  KOKKOS_INLINE_FUNCTION void operator()(const TeamOf<Exec>& team) const {
    const Vertex place = team.league_rank();
    if (place < first_product) {
      tiles.factor(team, place);
    } else {
      products.subtract(team, place - first_product);
    }
  }
};

/// The columns of a tile, left of those that rows were exchanged for later: they follow.
struct ColumnTask {
  Vertex front, begin;
};
template <class Exec, class S, class V, class Dense>
struct FollowMoves {
  Store<S, V> store;
  const ColumnTask* tasks;
  Vertex tile;
  Offset room;  // entries of scratch memory

  KOKKOS_INLINE_FUNCTION void operator()(const TeamOf<Exec>& team) const {
    const ColumnTask task = tasks[team.league_rank()];
    if (!Dense::kSearchesAll && store.is_strict(task.front)) return;  // has exchanged whole rows
    const Front<S> front = store.fronts.front(task.front);
    S* const held = scratch<S>(team, room);
    for (Vertex k = task.begin + tile; k < front.pivots; k += tile) {
      S* const rows = front.lower + k + task.begin * static_cast<Offset>(front.lower_ld);
      move_rows(team, store.moves(task.front, k), tile, rows, front.lower_ld, held, room);
    }
  }
};

}  // namespace mfs::portable
