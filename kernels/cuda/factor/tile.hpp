// A tile in shared memory that one thread block factors, and what its kernels share.
#pragma once

#include "kernels/cuda/factor/warp_tile.hpp"

namespace mfs::cuda {

constexpr int kPanelColumns = 16;
constexpr int kMostWarps = 16, kMostPivotWarps = 5;

/// A tile in shared memory, column-major: `rows` rows and columns of which the first `pivots` are eliminated
/// among each other.
template <class S>
struct Tile {
  S* a;
  int ld;
  int rows, pivots;
};

/// A row that may become pivot row, its part of the panel.
template <class S>
struct alignas(16) OfferedRow {
  S reciprocal;                // of the pivot
  S right[kPanelColumns - 1];  // what is right of it
  S pivot;
};

/// Work of tile_lu in shared memory.
template <class S>
struct TileWork {
  // What each warp offers for the column under way, by turns: one column is read while the next is offered.
  alignas(16) unsigned key[2][8];
  OfferedRow<S> offered[2][kMostPivotWarps];
  int chosen[kPanelColumns];    // rows that became pivot rows of the panel, and lie where they were
  int exchange[kPanelColumns];  // of a panel of a strict front
  double border[kMostWarps];
};

// Column of a tile of 16 x 8 that stands at place c of the product: so lanes find their sums, and what is
// multiplied, in different banks.
__device__ inline int spread_column(int c) {
  return (c & ~3) + (c >> 1 & 1) + 2 * ((c ^ c >> 2) & 1);
}

// What the sizes of pivots are compared by: 12 bits beside the exponent are enough to choose one.
__device__ inline unsigned size_bits(double x) {
  return __double2hiint(x) & 0x7fffff00u;
}
__device__ inline unsigned size_bits(float x) {
  return __float_as_uint(x) & 0x7fffff00u;
}
template <class Real>
__device__ unsigned size_bits(const Kokkos::complex<Real>& x) {
  return size_bits(magnitude(x));
}

/// What size_bits of a pivot is compared with.
template <class S>
__device__ unsigned bound_bits(double bound) {
  if constexpr (std::is_same_v<S, float>)
    return size_bits(static_cast<float>(bound));
  else
    return size_bits(bound);
}

// 1 / x, to an ulp or two, without a branch.
__device__ inline double reciprocal_of(double x) {
  double r;
  asm("rcp.approx.ftz.f64 %0, %1;" : "=d"(r) : "d"(x));
  const double e = fma(-x, r, 1.0);
  return fma(r, fma(e, e, e), r);
}
template <class S>
__device__ S reciprocal_of(const S& x) {
  return S(1) / x;
}

/// L^-1 times what is right of a panel; L^-1, unit lower triangular, at `lower`.
template <class S>
__device__ void solve_right(const Tile<S>& tile, int first, int width, const S* lower, int lower_ld) {
  const int warp = threadIdx.x / kWarp, warps = blockDim.x / kWarp, rows = tile.rows, ld = tile.ld,
            next = first + width;
  S* const top = tile.a + first;
  for (int n = next / 16 * 16 + 16 * warp; n < rows; n += 16 * warps) {
    WarpTile<S, 1, 2> u;
    u.clear();
    u.multiply_entries(
        [&](int m, int k) { return k < m && m < width ? lower[m + k * lower_ld] : S(k == m ? 1 : 0); },
        [&](int k, int c) {
          const int column = n + spread_column(c);  // others may write those of the panel
          return k < width && column >= next ? top[k + column * ld] : S(0);
        },
        kPanelColumns);
    __syncwarp();
    u.for_each([&](int r, int c, S& value) {
      const int column = n + spread_column(c);
      if (r < width && column >= next && column < rows) top[r + column * ld] = value;
    });
  }
}

}  // namespace mfs::cuda
