// Small fronts, one team each: the stages "assemble", "variable factor" and "variable update" in one go.
// Where a front fits the scratch memory of a team, it is made there and written once; else in its place.
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
/// Entries that the blocks of a front of so many rows need there, at most.
KOKKOS_INLINE_FUNCTION constexpr Offset small_front_entries(Offset rows) {
  return rows * (rows + 1);
}
template <class S>
constexpr Offset small_front_bytes(Offset rows) {
  return static_cast<Offset>(sizeof(Candidates)) +
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
    Candidates* const found = scratch<Candidates>(team, 1);
    Blocks<S> at = own;
    if (small_front_entries(front.rows()) <= room) {
      at = scratch_blocks(front, scratch<S>(team, room));
      if (!stages.assemble) {
        copy(team, own, at);
        team.team_barrier();
      }
    }
    if (stages.assemble) assemble_front(team, store, f, at);
    if (stages.factor) factor(team, f, at, found);
    if (stages.update && at.border > 0) {
      dense.gemm_minus(team, Transpose::no, at.border, at.border, at.pivots, at.lower + at.pivots,
                       at.lower_ld, at.upper, at.upper_ld, at.contribution, at.contribution_ld);
    }
    if (at.lower != own.lower) {
      team.team_barrier();
      copy(team, at, own);
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

  KOKKOS_INLINE_FUNCTION void factor(const TeamOf<Exec>& team, Vertex f, const Blocks<S>& at,
                                     Candidates* found) const {
    const Vertex p = at.pivots, b = at.border;
    const FrontStore<S, V>& fronts = store.fronts;
    const Vertex first = fronts.pivot_begin[f];
    Vertex *const interchange = fronts.interchange + first, *const row_at = fronts.local_row + first;
    const PanelTally tally =
        dense.factor_panel(team, at.lower, at.lower_ld, p, p, at.lower + p, at.lower_ld, {p, b, false},
                           store.rule(), interchange, fronts.shift + first, fronts.work + first, found);
    team.team_barrier();
    // Each column follows the exchanges, and so does the note of what came where.
    for_each(team, b + 1, [&](Vertex j) {
      if (j < b) {
        follow(p, interchange, at.upper + j * at.upper_ld);
      } else {
        for (Vertex i = 0; i < p; ++i) row_at[i] = i;
        follow(p, interchange, row_at);
        store.note(tally);
      }
    });
    team.team_barrier();
    dense.solve_upper_right(team, b, p, at.lower, at.lower_ld, at.lower + p, at.lower_ld, nullptr, 0);
    dense.solve_unit_lower_strip(team, p, b, at.lower, at.lower_ld, at.upper, at.upper_ld, nullptr, 0);
    team.team_barrier();
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
