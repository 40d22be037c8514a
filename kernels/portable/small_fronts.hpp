// Small fronts, one team each: the stages "assemble", "variable factor" and "variable update" in one go. They
// are made in scratch memory and written once; a library works on them in their place.
#pragma once

#include "kernels/portable/assembly.hpp"
#include "kernels/portable/dense.hpp"

namespace mfs::portable {

/// Which stages a launch runs: production runs all, tests run one.
struct Stages {
  bool assemble = true, factor = true, update = true;
};

/// Leading dimension of U in scratch memory: odd, so that neighbouring columns lie in different banks.
KOKKOS_INLINE_FUNCTION Vertex scratch_ld(Vertex pivots) {
  return pivots | 1;
}
/// Threads of a team, at most.
constexpr Vertex kSmallThreads = 4;
/// Entries that a front of so many rows needs there, at most: its blocks, and a row of the panel for each
/// thread, or for pivots and their inverses.
KOKKOS_INLINE_FUNCTION constexpr Offset small_front_entries(Offset rows) {
  return rows * (rows + 1) + kSmallThreads * rows;
}
template <class S>
constexpr Offset small_front_bytes(Offset rows) {
  return rows * static_cast<Offset>(sizeof(Vertex)) +
         small_front_entries(rows) * static_cast<Offset>(sizeof(S)) + 48;
}

template <class Exec, class S, class V, class Dense>
struct SmallFronts {
  Store<S, V> store;
  const Vertex* list;
  Offset room;  // entries of scratch memory for the blocks
  Stages stages;
  Dense dense;

  KOKKOS_INLINE_FUNCTION void operator()(const TeamOf<Exec>& team) const {
    const Vertex f = list[team.league_rank()];
    const Front<S> front = store.fronts.front(f);
    const Blocks<S> own = own_blocks(front);
    if constexpr (Dense::kSearchesAll) {
      if (stages.assemble) assemble_front(team, store, f, own);
      if (stages.factor) factor_by_library(team, f, own);
      if (stages.update) update(team, own);
    } else {
      S* const memory = scratch<S>(team, room);
      const Blocks<S> at = scratch_blocks(front, memory);
      if (stages.assemble) {
        assemble_front(team, store, f, at);
      } else {
        copy(team, own, at);
        team.team_barrier();
      }
      if (stages.factor) factor(team, f, at, memory + room - kSmallThreads * front.pivots);
      if (stages.update) update(team, at);
      team.team_barrier();
      copy(team, at, own);
      if (!stages.factor) return;
      team.team_barrier();
      write_inverted(
          team, at.pivots, dense.substitutes,
          [&](Vertex i, Vertex j) { return at.lower[i + j * at.lower_ld]; }, own.lower, own.lower_ld);
    }
  }

 private:
  KOKKOS_INLINE_FUNCTION static Blocks<S> own_blocks(const Front<S>& front) {
    return {front.pivots,       front.border,   front.lower,  front.upper,
            front.contribution, front.lower_ld, front.pivots, front.contribution_ld};
  }
  KOKKOS_INLINE_FUNCTION static Blocks<S> scratch_blocks(const Front<S>& front, S* memory) {
    const Offset p = front.pivots, b = front.border, upper_ld = scratch_ld(front.pivots);
    S *const upper = memory + (p + b) * p, *const contribution = upper + upper_ld * b;
    return {front.pivots, front.border, memory, upper, contribution, p + b, upper_ld, b};
  }
  KOKKOS_INLINE_FUNCTION static void copy(const TeamOf<Exec>& team, const Blocks<S>& from,
                                          const Blocks<S>& to) {
    const Vertex p = from.pivots, b = from.border;
    copy_block(team, p + b, p, from.lower, from.lower_ld, to.lower, to.lower_ld);
    copy_block(team, p, b, from.upper, from.upper_ld, to.upper, to.upper_ld);
    copy_block(team, b, b, from.contribution, from.contribution_ld, to.contribution, to.contribution_ld);
  }
  KOKKOS_INLINE_FUNCTION static void copy_block(const TeamOf<Exec>& team, Vertex rows, Vertex columns,
                                                const S* from, Offset from_ld, S* to, Offset to_ld) {
    for_each_entry(team, rows, columns,
                   [&](Vertex i, Vertex j) { to[i + j * to_ld] = from[i + j * from_ld]; });
  }

  KOKKOS_INLINE_FUNCTION void update(const TeamOf<Exec>& team, const Blocks<S>& at) const {
    if (at.border == 0) return;
    dense.gemm_minus(team, Transpose::no, at.border, at.border, at.pivots, at.lower + at.pivots, at.lower_ld,
                     at.upper, at.upper_ld, at.contribution, at.contribution_ld);
  }
  KOKKOS_INLINE_FUNCTION PanelPlace<S> panel_place(Vertex first, const Blocks<S>& at) const {
    return {at.lower + at.pivots,
            at.lower_ld,
            {at.pivots, at.border, false},
            store.rule(),
            store.rule(),
            store.fronts.shift + first,
            store.fronts.work + first};
  }

  // `held` has kSmallThreads entries of scratch memory for each pivot.
  KOKKOS_INLINE_FUNCTION void factor(const TeamOf<Exec>& team, Vertex f, const Blocks<S>& at, S* held) const {
    const Vertex p = at.pivots, first = store.fronts.pivot_begin[f];
    Vertex* const order = scratch<Vertex>(team, p);
    const TileInScratch<S> tile{at.lower, at.lower_ld, p, held, held + p, order};
    const PanelTally tally = factor_tile(team, tile, panel_place(first, at));
    order_rows(team, p, order, p, at.lower, at.lower_ld, held);
    order_rows(team, p, order, at.border, at.upper, at.upper_ld, held);
    for_each(team, p, [&](Vertex i) { store.fronts.local_row[first + i] = order[i]; });
    once(team, [&]() { store.note(tally); });
    team.team_barrier();
    solve_beside(team, at);
  }
  KOKKOS_INLINE_FUNCTION void solve_beside(const TeamOf<Exec>& team, const Blocks<S>& at) const {
    dense.solve_small(team, at.pivots, at.border, at.lower, at.lower_ld, at.lower + at.pivots, at.lower_ld,
                      at.upper, at.upper_ld);
    team.team_barrier();
  }

  KOKKOS_INLINE_FUNCTION void factor_by_library(const TeamOf<Exec>& team, Vertex f,
                                                const Blocks<S>& at) const {
    const Vertex p = at.pivots, first = store.fronts.pivot_begin[f];
    Vertex *const interchange = store.fronts.interchange + first, *const row_at =
                                                                      store.fronts.local_row + first;
    const PanelTally tally =
        dense.factor_panel(at.lower, at.lower_ld, p, p, panel_place(first, at), interchange);
    team.team_barrier();
    // Each column follows the exchanges, and so does the note of what came where.
    for_each(team, at.border + 1, [&](Vertex j) {
      if (j < at.border) {
        follow(p, interchange, at.upper + j * at.upper_ld);
      } else {
        for (Vertex i = 0; i < p; ++i) row_at[i] = i;
        follow(p, interchange, row_at);
        store.note(tally);
      }
    });
    team.team_barrier();
    solve_beside(team, at);
  }
  template <class T>
  KOKKOS_INLINE_FUNCTION static void follow(Vertex count, const Vertex* interchange, T* column) {
    for (Vertex k = 0; k < count; ++k) {
      const Vertex other = interchange[k];
      if (other == k) continue;
      const T held = column[k];
      column[k] = column[other];
      column[other] = held;
    }
  }
};

}  // namespace mfs::portable
