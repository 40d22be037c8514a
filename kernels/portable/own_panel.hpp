// LU of a tile by one team, without a library, for any space: pivots are searched in the tile while it lies
// in scratch memory, or, where a front is strict, in all rows of its pivot block, in their place.
//
// In scratch memory no row moves while pivots are searched. A thread and its lanes find the pivot of a column
// by themselves, all threads the same one, and take it from the columns that are theirs. So a column costs
// one barrier. The rows that gave the pivots, in their order, are the exchanges.
//
// Triangles of diagonal blocks of kInvertedBlock pivots are left inverted in their place, so that strips and
// solves are products but for the few steps from block to block. Where tiny pivots are divided by, U stays as
// it is, and is substituted with.
#pragma once

#include <cstring>

#include "kernels/portable/store.hpp"

namespace mfs::portable {

/// Pivots of a diagonal block whose triangles are left inverted; tiles begin at multiples of it.
constexpr Vertex kInvertedBlock = 16;
/// Rows of a panel in scratch memory, at most.
constexpr Vertex kMostPanelRows = 128;

/// What small pivots of a panel are compared with: border rows, which are not solved for yet; or nothing,
/// where other pivot rows were left out.
struct BorderRows {
  Vertex begin;  // counted from the panel's first row
  Vertex count;
  bool undecided;
};

/// What a panel needs to know and leaves, beside its entries.
template <class S>
struct PanelPlace {
  const S* border;  // entry (i, j) of the border rows at border[i + j * border_ld]
  Offset border_ld;
  BorderRows below;
  PivotRule rule, tile_rule;  // the second tells whether all rows are needed
  S *shift, *work;            // of the panel's pivots; work is anyone's between two panels
};

template <class S>
KOKKOS_INLINE_FUNCTION S divided_by(const S& value, const S& pivot, const S& inverse) {
  return magnitude(inverse) <= 1e300 ? value * inverse : value / pivot;
}

constexpr double kLargestFinite = 1.7976931348623157e308;

/// A row that may give a pivot.
struct Candidate {
  double size;  // infinite where the entry is no number
  Vertex row, unused;
};
/// The largest of candidates, the first of equals: the same for any number of lanes and threads.
class LargestCandidate {
 public:
  using reducer = LargestCandidate;
  using value_type = Candidate;
  using result_view_type = Kokkos::View<Candidate, Kokkos::HostSpace, Kokkos::MemoryUnmanaged>;

  KOKKOS_INLINE_FUNCTION explicit LargestCandidate(Candidate& best) : best_(&best) {}
  KOKKOS_INLINE_FUNCTION static void take(Candidate& best, double size, Vertex row) {
    if (size > best.size || (size == best.size && row < best.row)) best = {size, row, 0};
  }
  /// It counts `times` its size.
  template <class S>
  KOKKOS_INLINE_FUNCTION static void take_entry(Candidate& best, const S& entry, Vertex row, double times) {
    const double size = magnitude(entry) * times;
    take(best, size <= kLargestFinite ? size : HUGE_VAL, row);
  }
  KOKKOS_INLINE_FUNCTION void join(Candidate& to, const Candidate& from) const {
    take(to, from.size, from.row);
  }
  KOKKOS_INLINE_FUNCTION void init(Candidate& value) const { value = {-1, 0, 0}; }
  KOKKOS_INLINE_FUNCTION Candidate& reference() const { return *best_; }
  KOKKOS_INLINE_FUNCTION bool references_scalar() const { return true; }

 private:
  Candidate* best_;
};

/// Up to kMostPanelRows rows.
class RowSet {
 public:
  KOKKOS_INLINE_FUNCTION bool has(Vertex row) const { return ((row < 64 ? low_ : high_) >> (row % 64)) & 1; }
  KOKKOS_INLINE_FUNCTION void add(Vertex row) {
    (row < 64 ? low_ : high_) |= static_cast<unsigned long long>(1) << (row % 64);
  }

 private:
  unsigned long long low_ = 0, high_ = 0;
};

/// Of a tile while its pivots are searched, in scratch memory: entry (i, j) of the factors, in the order of
/// pivots, is a[order[i] + j * lda] at the end.
template <class S>
struct TileInScratch {
  S* a;
  Offset lda;
  Vertex n;
  S *pivot, *inverse;  // n each
  Vertex* order;

  KOKKOS_INLINE_FUNCTION S& at(Vertex i, Vertex j) const { return a[order[i] + j * lda]; }
};

/// The largest entry that column c has in the border rows once the columns left of it are eliminated there.
/// work[0 ... c-1] holds the column above its pivot; upper(i, k) is U.
template <class Team, class S, class Upper>
KOKKOS_INLINE_FUNCTION double largest_in_border(const Team& team, Vertex c, const PanelPlace<S>& place,
                                                const Upper& upper) {
  S* const work = place.work;
  for (Vertex k = c - 1; k >= 0; --k) {
    once(team, [&]() { work[k] = work[k] / upper(k, k); });
    team.team_barrier();
    for_each(team, k, [&](Vertex i) { work[i] -= upper(i, k) * work[k]; });
    team.team_barrier();
  }
  double most = 0;
  Kokkos::parallel_reduce(
      Kokkos::TeamVectorRange(team, place.below.count),
      [&](Vertex r, double& largest) {
        S sum = place.border[r + c * place.border_ld];
        for (Vertex k = 0; k < c; ++k) sum -= place.border[r + k * place.border_ld] * work[k];
        const double size = magnitude(sum);
        if (size > largest) largest = size;
      },
      Kokkos::Max<double>(most));
  team.team_barrier();
  return most;
}

/// What becomes of a pivot, counted in `tally`; `border()` is the largest entry below a small one.
template <class S, class Border>
KOKKOS_INLINE_FUNCTION S accept_pivot(S pivot, const PanelPlace<S>& place, PanelTally& tally,
                                      const Border& border) {
  const double size = magnitude(pivot);
  if (!(size <= kLargestFinite)) {
    ++tally.nonfinite;
    return pivot;
  }
  if (!(size < place.rule.bound)) return pivot;
  if (place.below.undecided) {
    tally.undecided = true;
    return pivot;
  }
  const S accepted = replacement(pivot, border(), place.rule);
  tally.perturbed += accepted != pivot;
  return accepted;
}
template <class S>
KOKKOS_INLINE_FUNCTION S shift_of(const S& pivot, const S& accepted) {
  return magnitude(pivot) <= kLargestFinite ? accepted - pivot : S(0);
}

/// A candidate of a tile as one number, which lanes exchange faster than two: the larger, the better. The
/// size without its last seven bits, then the row, the first of equals in front.
KOKKOS_INLINE_FUNCTION unsigned long long candidate_key(double size, Vertex row) {
  const double known = size <= kLargestFinite ? size : HUGE_VAL;
  unsigned long long bits = 0;
  memcpy(&bits, &known, sizeof bits);
  return (bits & ~static_cast<unsigned long long>(kMostPanelRows - 1)) |
         static_cast<unsigned long long>(kMostPanelRows - 1 - row);
}
KOKKOS_INLINE_FUNCTION Vertex row_of_key(unsigned long long key) {
  return kMostPanelRows - 1 - static_cast<Vertex>(key & (kMostPanelRows - 1));
}

/// Takes the pivot row from row i, in column `first` and each `threads`-th after it. Four are under way at a
/// time.
template <class S>
KOKKOS_INLINE_FUNCTION void subtract_pivot_row(const TileInScratch<S>& tile, Vertex first, Vertex threads,
                                               Vertex pivot_row, Vertex i, const S& multiplier) {
  constexpr Vertex kTogether = 4;
  const Vertex lda = static_cast<Vertex>(tile.lda), step = threads * lda, end = tile.n * lda;
  const S* const from = tile.a + pivot_row;
  S* const to = tile.a + i;
  for (Vertex at = first * lda; at < end; at += kTogether * step) {
    S of_pivot[kTogether], own[kTogether];
    unrolled<kTogether>([&](auto q) {
      const bool inside = at + q * step < end;
      of_pivot[q] = inside ? from[at + q * step] : S(0);
      own[q] = inside ? to[at + q * step] : S(0);
    });
    unrolled<kTogether>([&](auto q) {
      if (at + q * step < end) to[at + q * step] = own[q] - multiplier * of_pivot[q];
    });
  }
}

/// LU of a tile in scratch memory, its pivots searched in it. Ends with a barrier.
template <class Team, class S>
KOKKOS_INLINE_FUNCTION PanelTally factor_tile(const Team& team, const TileInScratch<S>& tile,
                                              const PanelPlace<S>& place) {
  PanelTally tally;
  RowSet used;
  const Vertex n = tile.n, threads = team.team_size();
  Vertex first = team.team_rank();  // of this thread's columns that are not eliminated
  for (Vertex j = 0; j < n; ++j) {
    const S* const column = tile.a + j * tile.lda;
    unsigned long long best = 0;
    Kokkos::parallel_reduce(
        Kokkos::ThreadVectorRange(team, n),
        [&](Vertex i, unsigned long long& most) {
          const double size = magnitude(column[i]) * (i == j ? place.rule.preference : 1);
          const unsigned long long key = used.has(i) ? 0 : candidate_key(size, i);
          if (key > most) most = key;
        },
        Kokkos::Max<unsigned long long>(best));
    const Vertex row = row_of_key(best);
    const S pivot = column[row];
    const S accepted = accept_pivot(pivot, place, tally, [&]() {
      for_each(team, j, [&](Vertex i) { place.work[i] = tile.at(i, j); });
      team.team_barrier();
      return largest_in_border(team, j, place,
                               [&](Vertex i, Vertex k) { return i == k ? tile.pivot[k] : tile.at(i, k); });
    });
    const S inverse = S(1) / accepted;
    used.add(row);
    once(team, [&]() {
      tile.order[j] = row;
      tile.pivot[j] = accepted;
      tile.inverse[j] = inverse;
      place.shift[j] = shift_of(pivot, accepted);
    });
    if (first == j) first += threads;
    for_each_lane(team, n, [&](Vertex i) {
      if (!used.has(i))
        subtract_pivot_row(tile, first, threads, row, i, divided_by(column[i], accepted, inverse));
    });
    team.team_barrier();
  }
  // Multipliers and replaced pivots.
  for_each_entry(team, n, n, [&](Vertex i, Vertex j) {
    if (i > j) tile.at(i, j) = divided_by(tile.at(i, j), tile.pivot[j], tile.inverse[j]);
    if (i == j) tile.at(j, j) = tile.pivot[j];
  });
  team.team_barrier();
  return tally;
}

/// Columns of a panel of all rows that are eliminated together before those right of them.
constexpr Vertex kPanelColumns = 8;

/// The columns [begin, end) of a panel of m rows: pivots in all of them. Row exchanges reach all n columns.
template <class Team, class S>
KOKKOS_INLINE_FUNCTION void factor_columns(const Team& team, S* a, Offset lda, Vertex m, Vertex n,
                                           Vertex begin, Vertex end, const PanelPlace<S>& place,
                                           Vertex* interchange, PanelTally& tally) {
  for (Vertex j = begin; j < end; ++j) {
    S* const column = a + j * lda;
    Candidate best;
    Kokkos::parallel_reduce(
        Kokkos::TeamVectorRange(team, m - j),
        [&](Vertex i, Candidate& largest) {
          LargestCandidate::take_entry(largest, column[j + i], j + i, i == 0 ? place.rule.preference : 1);
        },
        LargestCandidate(best));
    const Vertex chosen = best.row;
    const S pivot = column[chosen];
    if (n < m && !tally.needed_all && (chosen >= n || magnitude(pivot) < place.tile_rule.bound)) {
      double most = 0;
      Kokkos::parallel_reduce(
          Kokkos::TeamVectorRange(team, n - j),
          [&](Vertex i, double& largest) {
            const double size = magnitude(column[j + i]);
            if (size > largest) largest = size;
          },
          Kokkos::Max<double>(most));
      tally.needed_all = needs_strict(magnitude(pivot), most, place.tile_rule);
    }
    const S accepted = accept_pivot(pivot, place, tally, [&]() {
      for_each(team, j, [&](Vertex i) { place.work[i] = column[i]; });
      team.team_barrier();
      return largest_in_border(team, j, place, [&](Vertex i, Vertex k) { return a[i + k * lda]; });
    });
    team.team_barrier();  // all have read the pivot
    for_each(team, n, [&](Vertex c) {
      S* const entries = a + c * lda;
      const S taken = c == j ? accepted : entries[chosen];
      entries[chosen] = entries[j];
      entries[j] = taken;
    });
    once(team, [&]() {
      interchange[j] = chosen;
      place.shift[j] = shift_of(pivot, accepted);
    });
    team.team_barrier();
    const S inverse = S(1) / accepted;
    for_each(team, m - j - 1, [&](Vertex i) {
      S* const row = a + j + 1 + i;
      const S multiplier = divided_by(row[j * lda], accepted, inverse);
      row[j * lda] = multiplier;
      for (Vertex c = j + 1; c < end; ++c) row[c * lda] -= multiplier * a[j + c * lda];
    });
    team.team_barrier();
  }
}

/// LU of a (m x n, m >= n) in its place, with the pivot of each column searched in all m rows: as
/// factor_panel, whose `interchange` it gives. Ends with a barrier.
template <class Team, class S>
KOKKOS_INLINE_FUNCTION PanelTally factor_rows(const Team& team, S* a, Offset lda, Vertex m, Vertex n,
                                              const PanelPlace<S>& place, Vertex* interchange) {
  PanelTally tally;
  for (Vertex begin = 0; begin < n; begin += kPanelColumns) {
    const Vertex end = begin + kPanelColumns < n ? begin + kPanelColumns : n;
    factor_columns(team, a, lda, m, n, begin, end, place, interchange, tally);
    for_each(team, n - end, [&](Vertex c) {
      S* const column = a + (end + c) * lda;
      for (Vertex k = begin; k < end; ++k) {
        for (Vertex i = k + 1; i < end; ++i) column[i] -= a[i + k * lda] * column[k];
      }
    });
    team.team_barrier();
    if (end == n) break;
    for_each(team, m - end, [&](Vertex i) {
      S* const row = a + end + i;
      S multiplier[kPanelColumns];
      for (Vertex k = 0; k < kPanelColumns; ++k) multiplier[k] = row[(begin + k) * lda];
      for (Vertex c = end; c < n; ++c) {
        const S* const above = a + begin + c * lda;
        S sum = row[c * lda];
        for (Vertex k = 0; k < kPanelColumns; ++k) sum -= multiplier[k] * above[k];
        row[c * lda] = sum;
      }
    });
    team.team_barrier();
  }
  return tally;
}

/// Writes the inverted triangles of the diagonal blocks of an n x n tile to `to`, all other entries as they
/// are, and with `keeps_upper` those of U: entry(i, j) gives those of L (whose diagonal is one) and U, and
/// lies in other memory than `to`.
template <class Team, class S, class Entry>
KOKKOS_INLINE_FUNCTION void write_inverted(const Team& team, Vertex n, bool keeps_upper, const Entry& entry,
                                           S* to, Offset ld) {
  constexpr Vertex kBlock = kInvertedBlock;
  for_each_entry(team, n, n, [&](Vertex i, Vertex j) {
    if (i / kBlock != j / kBlock || (keeps_upper && i <= j)) to[i + j * ld] = entry(i, j);
  });
  // Columns of the inverses, each by substitution: those of U are those of a lower triangle, seen from its
  // last row and column.
  const Vertex blocks = (n + kBlock - 1) / kBlock;
  for_each(team, (keeps_upper ? 1 : 2) * blocks * kBlock, [&](Vertex t) {
    const bool upper = t >= blocks * kBlock;
    const Vertex begin = t / kBlock % blocks * kBlock, c = t % kBlock;
    const Vertex width = kBlock < n - begin ? kBlock : n - begin;
    if (c >= width) return;
    const auto place = [&](Vertex i) { return begin + (upper ? width - 1 - i : i); };
    S x[kBlock];
    unrolled<kBlock>([&](auto i) {
      S sum(i == c ? 1 : 0);
      if (i < width) {
        unrolled<i>([&](auto k) { sum -= entry(place(i), place(k)) * x[k]; });
        if (upper) sum = sum / entry(place(i), place(i));
        if (upper ? i >= c : i > c) to[place(i) + place(c) * ld] = sum;
      }
      x[i] = sum;
    });
  });
}

/// Rows [0, n) of some columns in scratch memory, in the order of pivots; `held` has n entries for each
/// thread of the team.
template <class Team, class S>
KOKKOS_INLINE_FUNCTION void order_rows(const Team& team, Vertex n, const Vertex* order, Vertex columns, S* a,
                                       Offset lda, S* held) {
  S* const own = held + static_cast<Offset>(team.team_rank()) * n;
  for (Vertex c = team.team_rank(); c < columns; c += team.team_size()) {
    S* const column = a + c * lda;
    for_each_lane(team, n, [&](Vertex i) { own[i] = column[order[i]]; });
    for_each_lane(team, n, [&](Vertex i) { column[i] = own[i]; });
  }
}

}  // namespace mfs::portable
