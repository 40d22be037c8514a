// What the kernels of every execution space work on: the fronts and the lists of their plan, as pointers into
// the memory of the space, and how teams are launched. Kernels are classes with operator()(team), not
// lambdas, as compilers for devices have rules for those; a kernel holds no more bytes than are handed over
// with a launch without a stop.
#pragma once

#include "kernels/dense/panel_lu.hpp"
#include "kernels/space/space.hpp"
#include "kernels/stages/front_store.hpp"
#include "kernels/stages/strict_fronts.hpp"
#include "plan/device_plan.hpp"

namespace mfs::portable {

/// What a factorization says when it is done.
struct Status {
  FactorStatus pivots;
  double largest;    // scaled entry of the matrix
  int found_strict;  // fronts that became strict
};

/// Rows of a front that a step exchanges: row to[i] takes what row from[i] had, counted from the step's
/// pivot. Those of the step at pivot k of a front begin at twice its position.
struct RowMoves {
  Vertex count;
  const Vertex *to, *from;
};

/// What a team found in the pivots of a panel.
struct PanelTally {
  Vertex perturbed = 0;
  Vertex nonfinite = 0;
  bool undecided = false;   // a pivot was small, and rows that might have better ones were left out
  bool needed_all = false;  // rows beyond the tile, for a pivot
};

template <class S, class V>
struct Store {
  FrontStore<S, V> fronts;

  int* strict;       // by front: its state
  PivotRule pivots;  // relative to the largest scaled entry
  Status* status;

  const Vertex* entry_place;
  Vertex* displacement;  // n, zero between two steps: how far from its place a row of a front comes from
  Vertex *move_to, *move_from;  // 2 n
  Vertex* move_count;           // n, at the first position of each step

  KOKKOS_INLINE_FUNCTION PivotRule rule() const { return pivots.times(status->largest); }
  KOKKOS_INLINE_FUNCTION PivotRule tile_rule(bool divides) const { return rule_of_tiles(rule(), divides); }
  KOKKOS_INLINE_FUNCTION bool is_strict(Vertex f) const { return strict[f] & kStrict; }
  KOKKOS_INLINE_FUNCTION void make_strict(Vertex f) const {
    if (!(Kokkos::atomic_fetch_or(strict + f, kBecomesStrict) & kBecomesStrict))
      Kokkos::atomic_add(&status->found_strict, 1);
  }
  KOKKOS_INLINE_FUNCTION void need_strict(Vertex f) const {
    Kokkos::atomic_fetch_or(strict + f, kNeedsStrict);
  }
  KOKKOS_INLINE_FUNCTION void note(const PanelTally& tally) const {
    if (tally.perturbed)
      Kokkos::atomic_add(&status->pivots.perturbed, static_cast<unsigned long long>(tally.perturbed));
    if (tally.nonfinite)
      Kokkos::atomic_add(&status->pivots.nonfinite, static_cast<unsigned long long>(tally.nonfinite));
  }
  KOKKOS_INLINE_FUNCTION RowMoves moves(Vertex f, Vertex k) const {
    const Offset at = fronts.pivot_begin[f] + static_cast<Offset>(k);
    return {move_count[at], move_to + 2 * at, move_from + 2 * at};
  }
};

/// Threads of a team on a device, at most, its lanes counted.
constexpr int kMostThreads = 256;
/// Lanes that share the work of a thread where kernels ask for it: neighbours on a device, one on the host.
template <class Exec>
constexpr int kLanes = kOnHost<Exec> ? 1 : 32;

template <class Exec>
using TeamsOf = Kokkos::TeamPolicy<Exec, Kokkos::IndexType<int>, Kokkos::Schedule<Kokkos::Dynamic>,
                                   Kokkos::LaunchBounds<kMostThreads>>;
template <class Exec>
using TeamOf = typename TeamsOf<Exec>::member_type;

/// Bytes of scratch memory that a team has, and an address in it, aligned for any number.
template <class Exec>
Offset scratch_bytes() {
  return TeamsOf<Exec>::scratch_size_max(0) - 64;
}
template <class T, class Team>
KOKKOS_INLINE_FUNCTION T* scratch(const Team& team, Offset count) {
  return static_cast<T*>(team.team_scratch(0).get_shmem_aligned(static_cast<int>(count * sizeof(T)), 16));
}

/// Threads of each team of a launch, and the lanes of each.
struct TeamShape {
  int threads, lanes = 1;
};

/// Calls kernel(team) for `league` teams of that shape with so many bytes of scratch memory each. Labels have
/// at most 15 characters: a longer one would cost an allocation.
template <class Exec, class Kernel>
void launch(const Exec& exec, const char* label, Offset league, TeamShape shape, Offset bytes,
            const Kernel& kernel) {
  static_assert(kOnHost<Exec> || sizeof(Kernel) <= 384,
                "with a few of its own, Kokkos hands over 512 bytes on CUDA, and waits for launches of more");
  if (league == 0) return;
  TeamsOf<Exec> teams(exec, static_cast<int>(league), shape.threads, shape.lanes);
  teams.set_scratch_size(0, Kokkos::PerTeam(static_cast<int>(bytes)));
  if constexpr (kOnHost<Exec>) teams.set_chunk_size(1);
  Kokkos::parallel_for(label, teams, kernel);
}

/// body(i) for i < count by the threads of a team and their lanes, neighbours by neighbours.
template <class Team, class Body>
KOKKOS_INLINE_FUNCTION void for_each(const Team& team, Vertex count, const Body& body) {
  Kokkos::parallel_for(Kokkos::TeamVectorRange(team, count), body);
}
/// The same by the lanes of the calling thread. All of them have done it when it returns.
template <class Team, class Body>
KOKKOS_INLINE_FUNCTION void for_each_lane(const Team& team, Vertex count, const Body& body) {
  Kokkos::parallel_for(Kokkos::ThreadVectorRange(team, count), body);
}

/// body(i, j) for i < rows, j < columns; columns are walked by neighbours.
template <class Team, class Body>
KOKKOS_INLINE_FUNCTION void for_each_entry(const Team& team, Vertex rows, Vertex columns, const Body& body) {
  if (rows <= 0 || columns <= 0) return;
  if (kOnHost<typename Team::execution_space> && team.team_size() == 1) {
    for (Vertex j = 0; j < columns; ++j) {
      for (Vertex i = 0; i < rows; ++i) body(i, j);
    }
    return;
  }
  const Vertex fit = kMostThreads / rows, groups = fit < 1 ? 1 : fit < columns ? fit : columns;
  for_each(team, rows * groups, [&](Vertex lane) {
    const Vertex i = lane % rows;
    for (Vertex j = lane / rows; j < columns; j += groups) body(i, j);
  });
}

/// A number that is known when code for a device is compiled (std::integral_constant is for the host).
template <Vertex kValue>
struct Constant {
  KOKKOS_INLINE_FUNCTION constexpr operator Vertex() const { return kValue; }
};
/// body(i) for i = 0 ... kCount-1 as constants, so that an array of the thread that they index is registers.
template <Vertex kCount, Vertex kFirst = 0, class Body>
KOKKOS_FORCEINLINE_FUNCTION void unrolled(const Body& body) {
  if constexpr (kFirst < kCount) {
    body(Constant<kFirst>());
    unrolled<kCount, kFirst + 1>(body);
  }
}

/// One thread of the team does it.
template <class Team, class Body>
KOKKOS_INLINE_FUNCTION void once(const Team& team, const Body& body) {
  Kokkos::single(Kokkos::PerTeam(team), body);
}

}  // namespace mfs::portable
