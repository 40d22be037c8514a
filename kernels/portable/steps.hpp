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

/// A multiplier beyond this, of a row that the pivot search left out, makes its front strict. Ten times what
/// kBorderThreshold allows, as a repeated factorization costs more than refinement does.
constexpr double kMostGrowth = 10 / kBorderThreshold;

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

template <class S>
constexpr Offset diagonal_bytes(Vertex tile) {
  return static_cast<Offset>(sizeof(Candidates) + sizeof(Vertex) * 2 * tile + sizeof(S) * tile * tile) + 48;
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
    const Vertex f = task.front, k = task.k;
    const FrontStore<S, V>& fronts = store.fronts;
    const Front<S> front = fronts.front(f);
    const Vertex left = front.pivots - k, s = tile < left ? tile : left, first = fronts.pivot_begin[f] + k;
    const Offset ld = front.lower_ld;
    const bool all_rows = Dense::kSearchesAll || store.is_strict(f);
    S *const diagonal = front.lower + k + k * ld, *const border = diagonal + left;
    Candidates* const found = scratch<Candidates>(team, 1);
    Vertex* const held_rows = scratch<Vertex>(team, 2 * static_cast<Offset>(tile));
    Vertex* const local_row = fronts.local_row + first;
    if (k == 0) for_each(team, front.pivots, [&](Vertex i) { local_row[i] = i; });
    S *a = diagonal, *held = nullptr;
    if (!all_rows) {
      a = held = scratch<S>(team, static_cast<Offset>(s) * s);
      for_each_entry(team, s, s, [&](Vertex i, Vertex j) { held[i + j * s] = diagonal[i + j * ld]; });
    }
    team.team_barrier();
    const PanelTally tally =
        dense.factor_panel(team, a, all_rows ? ld : s, all_rows ? left : s, s, border, ld,
                           BorderRows{left, front.border, !all_rows && s < left}, store.rule(),
                           fronts.interchange + first, fronts.shift + first, fronts.work + first, found);
    if (!all_rows) {
      for_each_entry(team, s, s, [&](Vertex i, Vertex j) { diagonal[i + j * ld] = held[i + j * s]; });
    }
    team.team_barrier();
    once(team, [&]() {
      store.note(tally);
      if (tally.undecided) store.make_strict(f);
      combine_moves(first, s);
    });
    team.team_barrier();
    const RowMoves moves = store.moves(f, k);
    move_rows(team, moves, 1, local_row, 0, held_rows, 2 * static_cast<Offset>(tile));
    if (!Dense::kSearchesAll && all_rows) exchange_whole_rows(team, front, k, s, moves);
  }

 private:
  // Columns right of a panel, and those left of the tile, take part in later products with the rows as they
  // are then: so the rows of strict fronts, which are exchanged across tiles, are exchanged as a whole at
  // once.
  KOKKOS_INLINE_FUNCTION void exchange_whole_rows(const TeamOf<Exec>& team, const Front<S>& front, Vertex k,
                                                  Vertex s, const RowMoves& moves) const {
    const Offset ld = front.lower_ld, room = static_cast<Offset>(tile) * tile;
    S* const held = scratch<S>(team, room);
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
    dense.solve_upper_right(team, end - begin, s, diagonal, ld, rows, ld, held, room);
    if (all_rows || begin >= rest) return;
    team.team_barrier();
    for_each_entry(team, (rest < end ? rest : end) - begin, s, [&](Vertex i, Vertex j) {
      if (magnitude(rows[i + j * ld]) > kMostGrowth) store.make_strict(task.front);
    });
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
    dense.solve_unit_lower_strip(team, s, columns, diagonal, front.lower_ld, block, block_ld, held, room);
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
