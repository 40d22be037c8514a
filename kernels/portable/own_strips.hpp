// The strips beside a diagonal tile, without a library, for any space: X T = B for the upper triangle T of a
// tile whose diagonal blocks are inverted, so that all is products from block to block. A team of as many
// threads as a strip has parts keeps X in their registers, where each has kMicro rows of every block; another
// one takes a row by a thread. Blocks that are not inverted are substituted with, by a thread for each row.
#pragma once

#include "kernels/portable/own_panel.hpp"
#include "kernels/portable/store.hpp"

namespace mfs::portable {

/// Rows of a strip, pivots of a tile at most, and threads that share a strip.
constexpr Vertex kStripRows = 64, kMostTile = 64, kStripThreads = 256;
/// Entries of scratch memory: one block of X and the rows of T beside it.
constexpr Offset kStripLd = 65, kStripEntries = 2 * kInvertedBlock * kStripLd;

template <class Team, class S, class Triangle>
class StripSolve {
 public:
  /// Entry (i, c) of B, for i < count and c < n, at b[i * row + c * step]; triangle(l, c) is T, its diagonal
  /// blocks inverted unless it `substitutes`.
  KOKKOS_FORCEINLINE_FUNCTION StripSolve(const Team& team, Vertex count, Vertex n, bool substitutes,
                                         const Triangle& triangle, S* b, Offset row, Offset step, S* room)
      : team_(team),
        count_(count),
        n_(n),
        substitutes_(substitutes),
        triangle_(triangle),
        b_(b),
        row_(row),
        step_(step),
        block_(room),
        beside_(room + kBlock * kStripLd) {
    // Neighbours have what lies side by side.
    const Vertex lane = team.team_rank(), low = lane % kBlock, high = lane / kBlock;
    own_row_ = row == 1 ? low : high;
    own_column_ = row == 1 ? high : low;
  }

  KOKKOS_FORCEINLINE_FUNCTION void run() {
    unrolled<kBlocks>([&](auto at) {
      unrolled<kMicro>([&](auto q) {
        const Vertex i = own_row_ + q * kBlock, c = own_column_ + at * kBlock;
        x_[at][q] = i < count_ && c < n_ ? b_[i * row_ + c * step_] : S(0);
      });
    });
    eliminate<0>();
    unrolled<kBlocks>([&](auto at) {
      unrolled<kMicro>([&](auto q) {
        const Vertex i = own_row_ + q * kBlock, c = own_column_ + at * kBlock;
        if (i < count_ && c < n_) b_[i * row_ + c * step_] = x_[at][q];
      });
    });
  }

 private:
  static constexpr Vertex kBlock = kInvertedBlock, kMicro = kStripRows / kBlock, kBlocks = kMostTile / kBlock;
  static_assert(kMicro * kBlock == kStripRows && kBlock * kBlock == kStripThreads);

  // Block kAt and those after it.
  template <Vertex kAt>
  KOKKOS_FORCEINLINE_FUNCTION void eliminate() {
    if constexpr (kAt < kBlocks) {
      if (kAt * kBlock >= n_) return;
      put_block<kAt>();
      fetch_triangle<kAt>();
      team_.team_barrier();
      if (substitutes_) {
        if (team_.team_rank() < kStripRows) substitute(team_.team_rank(), kAt * kBlock);
        team_.team_barrier();
        unrolled<kMicro>([&](auto q) { x_[kAt][q] = block_entry(q, own_column_); });
      } else {
        unrolled<kMicro>([&](auto q) { x_[kAt][q] = S(0); });
        for (Vertex l = 0; l < kBlock; ++l) {
          const S entry = beside_[l * kStripLd + kAt * kBlock + own_column_];
          unrolled<kMicro>([&](auto q) { x_[kAt][q] += block_entry(q, l) * entry; });
        }
        team_.team_barrier();
        put_block<kAt>();
        team_.team_barrier();
      }
      for (Vertex l = 0; l < kBlock; ++l) {
        S known[kMicro];
        unrolled<kMicro>([&](auto q) { known[q] = block_entry(q, l); });
        unrolled<kBlocks, kAt + 1>([&](auto at) {
          const S entry = beside_[l * kStripLd + at * kBlock + own_column_];
          unrolled<kMicro>([&](auto q) { x_[at][q] -= known[q] * entry; });
        });
      }
      team_.team_barrier();
      eliminate<kAt + 1>();
    }
  }
  // The block of X from column `begin` on, which lies in scratch memory: its row i.
  KOKKOS_FORCEINLINE_FUNCTION void substitute(Vertex i, Vertex begin) const {
    const Vertex width = kBlock < n_ - begin ? kBlock : n_ - begin;
    for (Vertex c = 0; c < width; ++c) {
      S sum = block_[i + c * kStripLd];
      for (Vertex l = 0; l < c; ++l) sum -= block_[i + l * kStripLd] * beside_[l * kStripLd + begin + c];
      block_[i + c * kStripLd] = sum / beside_[c * kStripLd + begin + c];
    }
  }
  KOKKOS_FORCEINLINE_FUNCTION S block_entry(Vertex q, Vertex l) const {
    return block_[own_row_ + q * kBlock + l * kStripLd];
  }
  template <Vertex kAt>
  KOKKOS_FORCEINLINE_FUNCTION void put_block() {
    unrolled<kMicro>([&](auto q) { block_[own_row_ + q * kBlock + own_column_ * kStripLd] = x_[kAt][q]; });
  }
  template <Vertex kAt>
  KOKKOS_FORCEINLINE_FUNCTION void fetch_triangle() {
    const Vertex l = kAt * kBlock + own_row_;
    unrolled<kBlocks, kAt>([&](auto at) {
      const Vertex c = at * kBlock + own_column_;
      beside_[own_row_ * kStripLd + c] = l < n_ && c < n_ ? triangle_(l, c) : S(0);
    });
  }

  const Team& team_;
  Vertex count_, n_;
  bool substitutes_;
  const Triangle& triangle_;
  S* b_;
  Offset row_, step_;
  S *block_, *beside_;
  Vertex own_row_, own_column_;
  S x_[kBlocks][kMicro];
};

/// X := B T^-1 in place, for at most kStripRows rows. Ends with a barrier.
template <class Team, class S, class Triangle>
KOKKOS_INLINE_FUNCTION void solve_strip(const Team& team, Vertex count, Vertex n, bool substitutes,
                                        const Triangle& triangle, S* b, Offset row, Offset step, S* room) {
  if (count <= 0 || n <= 0) return;
  if (team.team_size() == kStripThreads && n <= kMostTile && count <= kStripRows) {
    StripSolve<Team, S, Triangle>(team, count, n, substitutes, triangle, b, row, step, room).run();
    team.team_barrier();
    return;
  }
  constexpr Vertex kBlock = kInvertedBlock;
  for_each(team, count, [&](Vertex i) {
    S* const x = b + i * row;
    for (Vertex begin = 0; begin < n; begin += kBlock) {
      S sum[kBlock];
      for (Vertex q = 0; q < kBlock; ++q) {
        const Vertex c = begin + q;
        if (c >= n) break;
        sum[q] = x[c * step];
        for (Vertex l = 0; l < begin; ++l) sum[q] -= x[l * step] * triangle(l, c);
      }
      for (Vertex q = 0; q < kBlock; ++q) {
        const Vertex c = begin + q;
        if (c >= n) break;
        if (substitutes) {
          for (Vertex l = 0; l < q; ++l) sum[q] -= sum[l] * triangle(begin + l, c);
          sum[q] = sum[q] / triangle(c, c);
          x[c * step] = sum[q];
          continue;
        }
        S solved(0);
        for (Vertex l = 0; l <= q; ++l) solved += sum[l] * triangle(begin + l, c);
        x[c * step] = solved;
      }
    }
  });
  team.team_barrier();
}

}  // namespace mfs::portable
