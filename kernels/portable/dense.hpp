// Dense operations of one team, in two forms with the same names: OwnDense, which any space can run, and
// LibraryDense, BLAS and the LU of a panel of the host, for spaces whose teams are threads of it. All threads
// of the team call them; operands are there when they do, and results after the next barrier, which is the
// caller's unless told otherwise.
//
// OwnDense works in place in whatever memory. Its diagonal tiles have the triangles of their diagonal blocks
// inverted (own_panel.hpp), those of U unless it is substituted with; those of LibraryDense are as BLAS wants
// them.
#pragma once

#include "kernels/dense/host_dense.hpp"
#include "kernels/portable/own_panel.hpp"
#include "kernels/portable/own_strips.hpp"
#include "kernels/portable/store.hpp"

namespace mfs::portable {

using blas::Transpose;

template <class S>
struct OwnDense {
  // Panels of tiles first, all rows only where a front is strict; diagonal blocks are left inverted.
  static constexpr bool kSearchesAll = false;
  /// U is substituted with: where tiny pivots are divided by, inverses of its blocks lose what they have
  /// left.
  bool substitutes = false;

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

  /// The same for few columns and a large k, which several threads share for an entry of C; `room` has
  /// few_entries(n) of scratch memory.
  KOKKOS_INLINE_FUNCTION static constexpr Offset few_entries(Vertex columns) {
    return kMostThreads * static_cast<Offset>(columns > 1 ? kFewColumns : 1);
  }
  template <class Team>
  KOKKOS_INLINE_FUNCTION void multiply_few(const Team& team, Transpose transpose, Vertex m, Vertex n,
                                           Vertex k, const S* a, Offset lda, const S* b, Offset ldb, S* c,
                                           Offset ldc, S* room) const {
    const Offset row_step = transpose == Transpose::no ? 1 : lda, step = transpose == Transpose::no ? lda : 1;
    if (n == 1) {
      share_products<1>(team, m, n, k, a, row_step, step, b, ldb, c, ldc, room);
    } else {
      share_products<kFewColumns>(team, m, n, k, a, row_step, step, b, ldb, c, ldc, room);
    }
  }

  /// B := op(T)^-1 B for few columns; the triangles of diagonal blocks of T are inverted, those of U unless
  /// it is substituted with. `room` has kInvertedBlock x columns entries of scratch memory. Both end with a
  /// barrier.
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_unit_lower(const Team& team, Transpose transpose, Vertex n,
                                               Vertex columns, const S* t, Offset ldt, S* b, Offset ldb,
                                               S* room) const {
    const bool plain = transpose == Transpose::no;
    solve_by_blocks(
        team, n, columns, plain, false,
        [&](Vertex i, Vertex l) {
          const Vertex row = plain ? i : l, column = plain ? l : i;
          return row > column ? t[row + column * ldt] : S(row == column ? 1 : 0);
        },
        b, ldb, room);
  }
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_upper(const Team& team, Transpose transpose, Vertex n, Vertex columns,
                                          const S* t, Offset ldt, S* b, Offset ldb, S* room) const {
    const bool plain = transpose == Transpose::no;
    solve_by_blocks(
        team, n, columns, !plain, substitutes,
        [&](Vertex i, Vertex l) {
          const Vertex row = plain ? i : l, column = plain ? l : i;
          return row <= column ? t[row + column * ldt] : S(0);
        },
        b, ldb, room);
  }

  /// B (rows x n) := B U^-1 and B (n x columns) := L^-1 B beside a diagonal tile whose blocks are inverted;
  /// `room` has strip_entries() of scratch memory. Both end with a barrier.
  static constexpr Offset strip_entries() { return kStripEntries; }
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_upper_right(const Team& team, Vertex rows, Vertex n, const S* u,
                                                Offset ldu, S* b, Offset ldb, S* room) const {
    solve_strip(
        team, rows, n, substitutes, [&](Vertex l, Vertex c) { return l <= c ? u[l + c * ldu] : S(0); }, b, 1,
        ldb, room);
  }
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_unit_lower_strip(const Team& team, Vertex n, Vertex columns, const S* t,
                                                     Offset ldt, S* b, Offset ldb, S* room) const {
    solve_strip(
        team, columns, n, false,
        [&](Vertex l, Vertex c) { return l < c ? t[c + l * ldt] : S(l == c ? 1 : 0); }, b, ldb, 1, room);
  }
  /// The same in small fronts, with triangles as they are, a thread for each row or column.
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_small(const Team& team, Vertex p, Vertex border, const S* t, Offset ldt,
                                          S* rows, Offset rows_ld, S* columns, Offset columns_ld) const {
    for_each(team, 2 * border, [&](Vertex i) {
      if (i < border) {
        solve_one(
            p, [&](Vertex k, Vertex c) { return t[k + c * ldt]; }, [&](Vertex c) { return t[c + c * ldt]; },
            rows + i, rows_ld);
      } else {
        solve_one(
            p, [&](Vertex k, Vertex c) { return t[c + k * ldt]; }, [](Vertex) { return S(1); },
            columns + (i - border) * columns_ld, 1);
      }
    });
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

 private:
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

  // A thread has kColumns columns of a row of C and a part of k, kTogether numbers of A at a time; the parts
  // are added in their order.
  static constexpr Vertex kFewColumns = 4;
  template <Vertex kColumns, class Team>
  KOKKOS_INLINE_FUNCTION static void share_products(const Team& team, Vertex m, Vertex n, Vertex k,
                                                    const S* a, Offset row_step, Offset step, const S* b,
                                                    Offset ldb, S* c, Offset ldc, S* room) {
    constexpr Vertex kTogether = 8, kMostParts = 8;
    if (m <= 0 || n <= 0) return;
    const Vertex groups = (n + kColumns - 1) / kColumns, items = m * groups;
    const Vertex wanted = kMostThreads / items, useful = k / kTogether;
    const Vertex most = wanted < useful ? wanted : useful;
    const Vertex parts = most < 1 ? 1 : most < kMostParts ? most : kMostParts;
    for_each(team, items * parts, [&](Vertex t) {
      const Vertex i = t % m, group = t / m % groups, part = t / items;
      const Vertex first = group * kColumns, width = kColumns < n - first ? kColumns : n - first;
      const Vertex end = static_cast<Vertex>(static_cast<Offset>(k) * (part + 1) / parts);
      const S *const x = a + i * row_step, *const y = b + first * ldb;
      S sum[kColumns];
      unrolled<kColumns>([&](auto q) { sum[q] = S(0); });
      Vertex l = static_cast<Vertex>(static_cast<Offset>(k) * part / parts);
      for (; l + kTogether <= end; l += kTogether) {
        S entry[kTogether];
        unrolled<kTogether>([&](auto u) { entry[u] = x[(l + u) * step]; });
        unrolled<kColumns>([&](auto q) {
          if (q >= width) return;
          unrolled<kTogether>([&](auto u) { sum[q] += entry[u] * y[l + u + q * ldb]; });
        });
      }
      for (; l < end; ++l) {
        const S entry = x[l * step];
        unrolled<kColumns>([&](auto q) {
          if (q < width) sum[q] += entry * y[l + q * ldb];
        });
      }
      unrolled<kColumns>([&](auto q) {
        if (q >= width) return;
        if (parts == 1) {
          c[i + (first + q) * ldc] -= sum[q];
        } else {
          room[i + (first + q + part * static_cast<Offset>(n)) * m] = sum[q];
        }
      });
    });
    if (parts == 1) return;
    team.team_barrier();
    for_each_entry(team, m, n, [&](Vertex i, Vertex j) {
      S sum(0);
      for (Vertex part = 0; part < parts; ++part) sum += room[i + (j + part * static_cast<Offset>(n)) * m];
      c[i + j * ldc] -= sum;
    });
  }

  // Block after block: what is known of one goes to the others as a product. Blocks on the diagonal are
  // inverted, or substituted with by a thread for each column.
  template <class Team, class Entry>
  KOKKOS_INLINE_FUNCTION static void solve_by_blocks(const Team& team, Vertex n, Vertex columns,
                                                     bool ascending, bool substitutes, const Entry& entry,
                                                     S* b, Offset ldb, S* x) {
    constexpr Vertex kBlock = kInvertedBlock;
    const Vertex blocks = (n + kBlock - 1) / kBlock;
    for (Vertex turn = 0; turn < blocks; ++turn) {
      const Vertex k = kBlock * (ascending ? turn : blocks - 1 - turn);
      const Vertex width = kBlock < n - k ? kBlock : n - k;
      if (substitutes) {
        for_each(team, columns, [&](Vertex j) {
          substitute(
              width, ascending, [&](Vertex i, Vertex l) { return entry(k + i, k + l); }, b + k + j * ldb,
              x + j * kBlock);
        });
      } else {
        for_each_entry(team, width, columns, [&](Vertex i, Vertex j) {
          S sum(0);
          for (Vertex l = 0; l < width; ++l) sum += entry(k + i, k + l) * b[k + l + j * ldb];
          x[i + j * kBlock] = sum;
        });
      }
      team.team_barrier();
      const Vertex first = ascending ? k : 0, last = ascending ? n : k + width;
      for_each_entry(team, last - first, columns, [&](Vertex at, Vertex j) {
        const Vertex i = first + at;
        const S* const known = x + j * kBlock;
        if (i >= k && i < k + width) {
          b[i + j * ldb] = known[i - k];
          return;
        }
        S sum(0);
        for (Vertex l = 0; l < width; ++l) sum += entry(i, k + l) * known[l];
        b[i + j * ldb] -= sum;
      });
      team.team_barrier();
    }
  }

  // x = T^-1 b for a block on the diagonal. Nothing that is loaded waits for what is solved for.
  template <class Entry>
  KOKKOS_INLINE_FUNCTION static void substitute(Vertex width, bool ascending, const Entry& entry, const S* b,
                                                S* x) {
    S solved[kInvertedBlock];
    unrolled<kInvertedBlock>([&](auto turn) {
      solved[turn] = S(0);
      if (turn >= width) return;
      const Vertex i = ascending ? turn : width - 1 - turn;
      S sum = b[i];
      unrolled<turn>([&](auto known) {
        sum -= entry(i, ascending ? Vertex(known) : width - 1 - known) * solved[known];
      });
      solved[turn] = sum / entry(i, i);
      x[i] = solved[turn];
    });
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
  static constexpr Offset strip_entries() { return 0; }
  KOKKOS_INLINE_FUNCTION static constexpr Offset few_entries(Vertex) { return 0; }
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
  KOKKOS_INLINE_FUNCTION void multiply_few(const Team&, Transpose transpose, Vertex m, Vertex n, Vertex k,
                                           const S* a, Offset lda, const S* b, Offset ldb, S* c, Offset ldc,
                                           S*) const {
    host.gemm_minus(transpose, m, n, k, a, lda, b, ldb, c, ldc);
  }
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_unit_lower(const Team&, Transpose transpose, Vertex n, Vertex columns,
                                               const S* t, Offset ldt, S* b, Offset ldb, S*) const {
    host.solve_unit_lower(transpose, n, columns, t, ldt, b, ldb);
  }
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_upper(const Team&, Transpose transpose, Vertex n, Vertex columns,
                                          const S* t, Offset ldt, S* b, Offset ldb, S*) const {
    host.solve_upper(transpose, n, columns, t, ldt, b, ldb);
  }
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_upper_right(const Team&, Vertex rows, Vertex n, const S* u, Offset ldu,
                                                S* b, Offset ldb, S*) const {
    host.solve_upper_right(rows, n, u, ldu, b, ldb);
  }
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_unit_lower_strip(const Team&, Vertex n, Vertex columns, const S* l,
                                                     Offset ldl, S* b, Offset ldb, S*) const {
    host.solve_unit_lower(Transpose::no, n, columns, l, ldl, b, ldb);
  }
  template <class Team>
  KOKKOS_INLINE_FUNCTION void solve_small(const Team&, Vertex p, Vertex border, const S* t, Offset ldt,
                                          S* rows, Offset rows_ld, S* columns, Offset columns_ld) const {
    host.solve_upper_right(border, p, t, ldt, rows, rows_ld);
    host.solve_unit_lower(Transpose::no, p, border, t, ldt, columns, columns_ld);
  }
  /// LU of a (m x n) with pivots searched in all m rows, and its exchanges.
  KOKKOS_INLINE_FUNCTION PanelTally factor_panel(S* a, Offset lda, Vertex m, Vertex n,
                                                 const PanelPlace<S>& place, Vertex* interchange) const {
    const PivotTally found =
        host.factor_panel(BlockColumns<S>{a, lda, place.below.begin, place.below.count, place.work}, m, n,
                          place.rule, interchange, place.shift);
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
