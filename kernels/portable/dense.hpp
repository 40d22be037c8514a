// Dense operations of one team, in two forms with the same names: OwnDense, which any space can run, and
// LibraryDense, BLAS and the LU of a panel of the host, for spaces whose teams are threads of it. All threads
// of the team call them; operands are there when they do, and results after the next barrier, which is the
// caller's unless told otherwise.
//
// OwnDense works in place in whatever memory; the solves that many rows or columns need at once (strips) copy
// those to scratch memory, where each thread solves for one of them.
#pragma once

#include "kernels/dense/host_dense.hpp"
#include "kernels/portable/store.hpp"

namespace mfs::portable {

using blas::Transpose;

/// What small pivots of a panel are compared with: border rows, which are not solved for yet; or nothing,
/// where other pivot rows were left out.
struct BorderRows {
  Vertex begin;  // counted from the panel's first row
  Vertex count;
  bool undecided;
};

template <class S>
KOKKOS_INLINE_FUNCTION S divided_by(const S& value, const S& pivot, const S& inverse) {
  return magnitude(inverse) <= 1e300 ? value * inverse : value / pivot;
}

/// Scratch memory of a search: the best candidate of each of kLanes parts.
constexpr Vertex kLanes = 32;
struct Candidates {
  double size[kLanes];
  Vertex row[kLanes];
};

/// The largest of count entries, the first of equals; NaN counts as largest. The same for all threads.
template <class Team, class S>
KOKKOS_INLINE_FUNCTION Vertex largest_row(const Team& team, Vertex count, const S* x, Candidates* found) {
  for_each(team, kLanes, [&](Vertex lane) {
    double most = -1;
    Vertex row = count;
    for (Vertex i = lane; i < count; i += kLanes) {
      const double size = magnitude(x[i]);
      if (size > most || (size != size && most == most)) {
        most = size;
        row = i;
      }
    }
    found->size[lane] = most;
    found->row[lane] = row;
  });
  team.team_barrier();
  double most = found->size[0];
  Vertex best = found->row[0];
  for (Vertex lane = 1; lane < kLanes; ++lane) {
    const double size = found->size[lane];
    const bool is_nan = size != size, had_nan = most != most;
    const bool larger = is_nan != had_nan ? is_nan : size > most;
    const bool same = is_nan == had_nan && (is_nan || size == most);
    if (larger || (same && found->row[lane] < best)) {
      most = size;
      best = found->row[lane];
    }
  }
  team.team_barrier();
  return best < count ? best : 0;
}

template <class S>
struct OwnDense {
  static constexpr bool kSearchesAll = false;  // panels of tiles first, all rows only where a front is strict

  /// C (m x n) -= op(A) B, for small n.
  template <class Team>
  KOKKOS_INLINE_FUNCTION void gemm_minus(const Team& team, Transpose transpose, Vertex m, Vertex n, Vertex k,
                                         const S* a, Offset lda, const S* b, Offset ldb, S* c,
                                         Offset ldc) const {
    const Offset row_step = transpose == Transpose::no ? 1 : lda, step = transpose == Transpose::no ? lda : 1;
    for_each_entry(team, m, n, [&](Vertex i, Vertex j) {
      const S *x = a + i * row_step, *y = b + j * ldb;
      S sum(0);
      for (Vertex l = 0; l < k; ++l) sum += x[l * step] * y[l];
      c[i + j * ldc] -= sum;
    });
  }

  /// B := op(T)^-1 B for few columns.
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_unit_lower(const Team& team, Transpose transpose, Vertex n,
                                               Vertex columns, const S* t, Offset ldt, S* b,
                                               Offset ldb) const {
    if (transpose == Transpose::no) {
      for (Vertex k = 0; k < n; ++k) {
        for_each_entry(team, n - k - 1, columns, [&](Vertex i, Vertex j) {
          b[k + 1 + i + j * ldb] -= t[k + 1 + i + k * ldt] * b[k + j * ldb];
        });
        team.team_barrier();
      }
    } else {
      for (Vertex k = n - 1; k >= 0; --k) {
        for_each_entry(team, k, columns,
                       [&](Vertex i, Vertex j) { b[i + j * ldb] -= t[k + i * ldt] * b[k + j * ldb]; });
        team.team_barrier();
      }
    }
  }
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_upper(const Team& team, Transpose transpose, Vertex n, Vertex columns,
                                          const S* t, Offset ldt, S* b, Offset ldb) const {
    const bool back = transpose == Transpose::no;
    for (Vertex turn = 0; turn < n; ++turn) {
      const Vertex k = back ? n - 1 - turn : turn;
      for_each(team, columns, [&](Vertex j) { b[k + j * ldb] = b[k + j * ldb] / t[k + k * ldt]; });
      team.team_barrier();
      if (back) {
        for_each_entry(team, k, columns,
                       [&](Vertex i, Vertex j) { b[i + j * ldb] -= t[i + k * ldt] * b[k + j * ldb]; });
      } else {
        for_each_entry(team, n - k - 1, columns, [&](Vertex i, Vertex j) {
          b[k + 1 + i + j * ldb] -= t[k + (k + 1 + i) * ldt] * b[k + j * ldb];
        });
      }
      team.team_barrier();
    }
  }

  /// B (rows x n) := B U^-1, in as many turns as the `room` entries of scratch memory `x` ask for.
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_upper_right(const Team& team, Vertex rows, Vertex n, const S* u,
                                                Offset ldu, S* b, Offset ldb, S* x, Offset room) const {
    solve_strips(
        team, rows, n, x, room, [&](Vertex k, Vertex c) { return u[k + c * ldu]; },
        [&](Vertex c) { return u[c + c * ldu]; }, b, 1, ldb);
  }
  /// B (n x columns) := L^-1 B for the unit lower triangle of `l`.
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_unit_lower_strip(const Team& team, Vertex n, Vertex columns, const S* l,
                                                     Offset ldl, S* b, Offset ldb, S* x, Offset room) const {
    solve_strips(
        team, columns, n, x, room, [&](Vertex k, Vertex c) { return l[c + k * ldl]; },
        [&](Vertex) { return S(1); }, b, ldb, 1);
  }

  /// C (m x n) -= A (m x k) B (k x n) for at most kTileRows rows and columns, which kProductThreads threads
  /// share; A and B come through scratch memory, `kDepth` columns and rows at a time.
  static constexpr Vertex kTileRows = 64, kProductThreads = 256, kDepth = 128 / sizeof(S);
  static constexpr Offset kProductEntries = kDepth * (2 * kTileRows + 1);
  template <class Team>
  KOKKOS_INLINE_FUNCTION void subtract_product(const Team& team, Vertex m, Vertex n, Vertex k, const S* a,
                                               Offset lda, const S* b, Offset ldb, S* c, Offset ldc) const {
    S *const left = scratch<S>(team, kProductEntries), *const right = left + kDepth * kTileRows;
    const bool one_each = team.team_size() == kProductThreads;  // else a thread has some, one after the other
    S sum[kMicro][kMicro];
    set_zero(sum);
    for (Vertex begin = 0; begin < k; begin += kDepth) {
      const Vertex depth = kDepth < k - begin ? kDepth : k - begin;
      const S *const own_a = a + begin * lda, *const own_b = b + begin;
      for_each(team, kTileRows * kDepth, [&](Vertex t) {
        const Vertex i = t % kTileRows, l = t / kTileRows;
        left[t] = i < m && l < depth ? own_a[i + l * lda] : S(0);
      });
      for_each(team, kTileRows * kDepth, [&](Vertex t) {
        const Vertex l = t % kDepth, j = t / kDepth;
        right[j + l * (kTileRows + 1)] = j < n && l < depth ? own_b[l + j * ldb] : S(0);
      });
      team.team_barrier();
      if (one_each) {
        add_product(team.team_rank(), left, right, sum);
      } else {
        for_each(team, kProductThreads, [&](Vertex lane) {
          set_zero(sum);
          add_product(lane, left, right, sum);
          subtract(lane, m, n, sum, c, ldc);
        });
      }
      team.team_barrier();
    }
    if (one_each) subtract(team.team_rank(), m, n, sum, c, ldc);
  }

  /// LU of a (m x n, m >= n) with the pivot of each column searched in all m rows: as factor_panel, whose
  /// `interchange` and `shift` it gives. `found` is scratch memory, `work` has n entries in any. Ends with a
  /// barrier.
  template <class Team>
  KOKKOS_INLINE_FUNCTION PanelTally factor_panel(const Team& team, S* a, Offset lda, Vertex m, Vertex n,
                                                 const S* border, Offset border_ld, const BorderRows& below,
                                                 const PivotRule& rule, Vertex* interchange, S* shift,
                                                 S* work, Candidates* found) const {
    PanelTally tally;
    for (Vertex j = 0; j < n; ++j) {
      S* const column = a + j * lda;
      const Vertex chosen = j + largest_row(team, m - j, column + j, found);
      const S pivot = column[chosen];
      const double size = magnitude(pivot);
      S accepted = pivot;
      if (!(size <= kLargestFinite)) {
        ++tally.nonfinite;
      } else if (size < rule.bound) {
        if (below.undecided) {
          tally.undecided = true;
        } else {
          const double most = largest_in_border(team, a, lda, j, border, border_ld, below.count, work, found);
          accepted = replacement(pivot, most, rule);
        }
      }
      const S added = accepted - pivot;
      const bool replaced = accepted != pivot && size <= kLargestFinite;
      tally.perturbed += replaced;
      team.team_barrier();  // all have read the pivot
      for_each(team, n, [&](Vertex c) {
        S* const entries = a + c * lda;
        const S taken = c == j ? accepted : entries[chosen];
        entries[chosen] = entries[j];
        entries[j] = taken;
      });
      once(team, [&]() {
        interchange[j] = chosen;
        shift[j] = replaced ? added : S(0);
      });
      team.team_barrier();
      const S inverse = S(1) / accepted;
      for_each(team, m - j - 1,
               [&](Vertex i) { column[j + 1 + i] = divided_by(column[j + 1 + i], accepted, inverse); });
      team.team_barrier();
      for_each_entry(team, m - j - 1, n - j - 1, [&](Vertex i, Vertex c) {
        S* const to = column + (c + 1) * lda;
        to[j + 1 + i] -= column[j + 1 + i] * to[j];
      });
      team.team_barrier();
    }
    return tally;
  }

 private:
  static constexpr double kLargestFinite = 1.7976931348623157e308;

  // A thread's part of a tile: every kStep-th row and column from its own on.
  static constexpr Vertex kMicro = 4, kStep = kTileRows / kMicro;
  KOKKOS_INLINE_FUNCTION static void set_zero(S (&sum)[kMicro][kMicro]) {
    for (Vertex q = 0; q < kMicro; ++q) {
      for (Vertex r = 0; r < kMicro; ++r) sum[q][r] = S(0);
    }
  }
  KOKKOS_INLINE_FUNCTION static void add_product(Vertex lane, const S* left, const S* right,
                                                 S (&sum)[kMicro][kMicro]) {
    const S *x = left + lane % kStep, *y = right + lane / kStep;
    for (Vertex l = 0; l < kDepth; ++l, x += kTileRows, y += kTileRows + 1) {
      S of_row[kMicro];
      for (Vertex q = 0; q < kMicro; ++q) of_row[q] = x[q * kStep];
      for (Vertex r = 0; r < kMicro; ++r) {
        const S of_column = y[r * kStep];
        for (Vertex q = 0; q < kMicro; ++q) sum[q][r] += of_row[q] * of_column;
      }
    }
  }
  KOKKOS_INLINE_FUNCTION static void subtract(Vertex lane, Vertex m, Vertex n, const S (&sum)[kMicro][kMicro],
                                              S* c, Offset ldc) {
    for (Vertex r = 0; r < kMicro; ++r) {
      const Vertex j = lane / kStep + r * kStep;
      for (Vertex q = 0; q < kMicro; ++q) {
        const Vertex i = lane % kStep + q * kStep;
        if (i < m && j < n) c[i + j * ldc] -= sum[q][r];
      }
    }
  }

  // Largest entry that column c has in the border rows once the columns left of it are eliminated there.
  template <class Team>
  KOKKOS_INLINE_FUNCTION double largest_in_border(const Team& team, const S* a, Offset lda, Vertex c,
                                                  const S* border, Offset border_ld, Vertex count, S* work,
                                                  Candidates* found) const {
    for_each(team, c, [&](Vertex i) { work[i] = a[i + c * lda]; });
    team.team_barrier();
    solve_upper(team, Transpose::no, c, 1, a, lda, work, c);
    for_each(team, kLanes, [&](Vertex lane) {
      double most = 0;
      for (Vertex r = lane; r < count; r += kLanes) {
        S sum = border[r + c * border_ld];
        for (Vertex k = 0; k < c; ++k) sum -= border[r + k * border_ld] * work[k];
        const double size = magnitude(sum);
        if (size > most) most = size;
      }
      found->size[lane] = most;
    });
    team.team_barrier();
    double most = 0;
    for (Vertex lane = 0; lane < kLanes; ++lane) most = found->size[lane] > most ? found->size[lane] : most;
    team.team_barrier();
    return most;
  }

  // Each thread solves x T = b for one of `count` rows b of n entries, which lie at b[i * row + c * step];
  // T(k, c) is upper triangular.
  template <class Team, class Above, class Diagonal>
  KOKKOS_INLINE_FUNCTION void solve_strips(const Team& team, Vertex count, Vertex n, S* x, Offset room,
                                           const Above& above, const Diagonal& diagonal, S* b, Offset row,
                                           Offset step) const {
    if (count <= 0 || n <= 0) return;
    const Vertex most = static_cast<Vertex>(room / n);
    if (most < 1) {  // no room: in place
      for_each(team, count, [&](Vertex i) { solve_one(n, above, diagonal, b + i * row, step); });
      return;
    }
    for (Vertex begin = 0; begin < count; begin += most) {
      const Vertex rows = most < count - begin ? most : count - begin;
      S* const own = b + begin * row;
      if (row == 1) {
        for_each_entry(team, rows, n, [&](Vertex i, Vertex c) { x[i + c * rows] = own[i + c * step]; });
      } else {
        for_each_entry(team, n, rows, [&](Vertex c, Vertex i) { x[i + c * rows] = own[i * row + c]; });
      }
      team.team_barrier();
      for_each(team, rows, [&](Vertex i) { solve_one(n, above, diagonal, x + i, rows); });
      team.team_barrier();
      if (row == 1) {
        for_each_entry(team, rows, n, [&](Vertex i, Vertex c) { own[i + c * step] = x[i + c * rows]; });
      } else {
        for_each_entry(team, n, rows, [&](Vertex c, Vertex i) { own[i * row + c] = x[i + c * rows]; });
      }
      team.team_barrier();
    }
  }
  // Four unknowns at a time.
  template <class Above, class Diagonal>
  KOKKOS_INLINE_FUNCTION static void solve_one(Vertex n, const Above& above, const Diagonal& diagonal, S* x,
                                               Offset step) {
    constexpr Vertex kTogether = 4;
    for (Vertex begin = 0; begin < n; begin += kTogether) {
      const Vertex width = kTogether < n - begin ? kTogether : n - begin;
      S sum[kTogether];
      for (Vertex q = 0; q < kTogether; ++q) sum[q] = q < width ? x[(begin + q) * step] : S(0);
      if (width == kTogether) {
        for (Vertex k = 0; k < begin; ++k) {
          const S known = x[k * step];
          for (Vertex q = 0; q < kTogether; ++q) sum[q] -= known * above(k, begin + q);
        }
      } else {
        for (Vertex k = 0; k < begin; ++k) {
          const S known = x[k * step];
          for (Vertex q = 0; q < kTogether; ++q) {
            if (q < width) sum[q] -= known * above(k, begin + q);
          }
        }
      }
      for (Vertex q = 0; q < kTogether; ++q) {
        if (q >= width) break;
        for (Vertex k = 0; k < kTogether; ++k) {
          if (k < q) sum[q] -= sum[k] * above(begin + k, begin + q);
        }
        sum[q] = sum[q] / diagonal(begin + q);
        x[(begin + q) * step] = sum[q];
      }
    }
  }
};

template <class S>
struct LibraryDense {
  static constexpr bool kSearchesAll = true;
  static constexpr Offset kProductEntries = 0;
  HostDense<S> host = host_dense<S>();

  template <class Team>
  KOKKOS_INLINE_FUNCTION void subtract_product(const Team&, Vertex m, Vertex n, Vertex k, const S* a,
                                               Offset lda, const S* b, Offset ldb, S* c, Offset ldc) const {
    host.gemm_minus(Transpose::no, m, n, k, a, lda, b, ldb, c, ldc);
  }

  template <class Team>
  KOKKOS_INLINE_FUNCTION void gemm_minus(const Team&, Transpose transpose, Vertex m, Vertex n, Vertex k,
                                         const S* a, Offset lda, const S* b, Offset ldb, S* c,
                                         Offset ldc) const {
    host.gemm_minus(transpose, m, n, k, a, lda, b, ldb, c, ldc);
  }
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_unit_lower(const Team&, Transpose transpose, Vertex n, Vertex columns,
                                               const S* t, Offset ldt, S* b, Offset ldb) const {
    host.solve_unit_lower(transpose, n, columns, t, ldt, b, ldb);
  }
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_upper(const Team&, Transpose transpose, Vertex n, Vertex columns,
                                          const S* t, Offset ldt, S* b, Offset ldb) const {
    host.solve_upper(transpose, n, columns, t, ldt, b, ldb);
  }
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_upper_right(const Team&, Vertex rows, Vertex n, const S* u, Offset ldu,
                                                S* b, Offset ldb, S*, Offset) const {
    host.solve_upper_right(rows, n, u, ldu, b, ldb);
  }
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_unit_lower_strip(const Team&, Vertex n, Vertex columns, const S* l,
                                                     Offset ldl, S* b, Offset ldb, S*, Offset) const {
    host.solve_unit_lower(Transpose::no, n, columns, l, ldl, b, ldb);
  }
  template <class Team>
  KOKKOS_INLINE_FUNCTION PanelTally factor_panel(const Team&, S* a, Offset lda, Vertex m, Vertex n, const S*,
                                                 Offset, const BorderRows& below, const PivotRule& rule,
                                                 Vertex* interchange, S* shift, S* work, Candidates*) const {
    const PivotTally found = host.factor_panel(BlockColumns<S>{a, lda, below.begin, below.count, work}, m, n,
                                               rule, interchange, shift);
    PanelTally tally;
    tally.perturbed = found.perturbed;
    tally.nonfinite = found.first_nonfinite >= 0;
    return tally;
  }
};

/// What a space takes, but in a test.
template <class Exec, class S>
using DenseOf = std::conditional_t<kOnHost<Exec>, LibraryDense<S>, OwnDense<S>>;

}  // namespace mfs::portable
