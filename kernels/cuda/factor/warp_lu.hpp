// LU of a front of at most 32 rows by one warp, in shared memory. Its loops are short: what a warp with so
// little to do waits for most are its own instructions.
#pragma once

#include "kernels/cuda/factor/tile_lu.hpp"

namespace mfs::cuda {

/// What is divided by instead of a pivot that is suspect, or no number. `border`: the largest entry of the
/// column in border rows, in each lane.
template <class S>
__device__ S settled_pivot(const S& pivot, double border, const PivotRule& rule, S* shift,
                           FactorStatus* status) {
  const double size = magnitude(pivot);
  if (threadIdx.x == 0 && !(size <= 1.7976931348623157e308)) atomicAdd(&status->nonfinite, 1ull);
  if (size >= rule.bound || size != size) return pivot;
  const S accepted = replacement(pivot, border, rule), added = accepted - pivot;
  if (threadIdx.x == 0 && magnitude(added) != 0) {
    atomicAdd(&status->perturbed, 1ull);
    *shift = added;
  }
  return accepted;
}

/// As tile_lu, but for the inverses. A lane has a row, or every other entry of one where there are few.
template <class S>
__device__ void warp_lu(const Tile<S>& tile, const PivotRule& rule, int* row_at, S* shift,
                        FactorStatus* status) {
  const int rows = tile.rows, pivots = tile.pivots, ld = tile.ld;
  const int shares = rows <= kWarp / 2 ? 2 : 1, r = threadIdx.x % (kWarp / shares),
            share = threadIdx.x / (kWarp / shares);
  const unsigned lowest = bound_bits<S>(rule.bound * rule.preference) + 0x200u,
                 beyond = bound_bits<S>(HUGE_VAL) + 0x100u,
                 diagonal_bits = bits_of_factor<S>(rule.preference);
  S* const a = tile.a;
#pragma unroll 1
  for (int j = 0; j < pivots; ++j) {
    S own = r < rows ? a[r + j * ld] : S(0);
    const bool candidate = r >= j && r < pivots;
    const unsigned most =
        __reduce_max_sync(0xffffffffu, candidate ? pivot_key(own, r) + (r == j ? diagonal_bits : 0u) : 0u);
    const int from = row_of_key(most);
    S pivot = shuffle(own, from);
    if (most < lowest || most >= beyond) {
      double border = r >= pivots && r < rows ? magnitude(own) : 0;
      for (int step = 16; step > 0; step /= 2)
        border = fmax(border, __shfl_xor_sync(0xffffffffu, border, step));
      pivot = settled_pivot(pivot, border, rule, shift + j, status);
    }
    __syncwarp();  // the column has been read
    if (from != j) {
      const S first = shuffle(own, j);
      if (r == from) own = first;
      const int c = threadIdx.x;
      if (c < rows) {
        const S kept = a[j + c * ld];
        a[j + c * ld] = a[from + c * ld];
        a[from + c * ld] = kept;
      }
      if (c == 0) {
        const int kept = row_at[j];
        row_at[j] = row_at[from];
        row_at[from] = kept;
      }
      __syncwarp();
    }
    const S multiplier = own * reciprocal_of(pivot);
    if (share == 0 && r < rows && r >= j) a[r + j * ld] = r == j ? pivot : multiplier;
    if (r > j && r < rows) {
#pragma unroll 4
      for (int c = j + 1 + share; c < rows; c += shares) a[r + c * ld] -= multiplier * a[j + c * ld];
    }
    __syncwarp();
  }
}

/// The inverses of both triangles of its pivot block in their place; of the upper one unless it stays.
template <class S>
__device__ void invert_triangles(const Tile<S>& tile, bool keeps_upper) {
  const int lane = threadIdx.x, pivots = tile.pivots, ld = tile.ld;
  S* const a = tile.a;
#pragma unroll 1
  for (int i = 1; i < pivots; ++i) {
    S sum = lane < i ? a[i + lane * ld] : S(0);
#pragma unroll 4
    for (int k = lane + 1; k < i; ++k) sum += a[i + k * ld] * a[k + lane * ld];
    __syncwarp();
    if (lane < i) a[i + lane * ld] = -sum;
    __syncwarp();
  }
  if (keeps_upper) return;
#pragma unroll 1
  for (int j = 0; j < pivots; ++j) {
    const S inverse = reciprocal_of(a[j + j * ld]);
    S sum = S(0);
#pragma unroll 4
    for (int k = lane; k < j; ++k) sum += a[lane + k * ld] * a[k + j * ld];
    __syncwarp();
    if (lane <= j) a[lane + j * ld] = lane == j ? inverse : -sum * inverse;
    __syncwarp();
  }
}

}  // namespace mfs::cuda
