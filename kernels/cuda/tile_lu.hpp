// LU of one tile in shared memory by one thread block: the pivot block of a small front with its border, or
// the diagonal tile of a larger one. The pivot of each column is searched in all pivot rows of the tile;
// pivots that are too small are treated as on the host (kernels/panel_lu.hpp).
//
// Sixteen columns at a time lie in registers, one row per thread; what is right of them is then solved for
// and updated on the tensor cores.
#pragma once

#include "kernels/cuda/device_plan.hpp"
#include "kernels/cuda/warp_tile.hpp"
#include "kernels/panel_lu.hpp"

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

/// Work of tile_lu in shared memory.
template <class S>
struct TileWork {
  // What each warp offers for the column under way: its best row, and that row's part of the panel.
  struct Offer {
    unsigned key[kMostPivotWarps];
    int row[kMostPivotWarps];
    S reciprocal[kMostPivotWarps];
    S part[kMostPivotWarps][kPanelColumns];
    S top[kPanelColumns];  // the row that is to be exchanged with it
  };
  Offer offer[2];  // by turns: one column is read while the next is offered
  int exchange[kPanelColumns];
  double border[kMostWarps];
  int any_exchange;
};

/// What the pivots below the bound are compared with: the largest entry of their column in border rows that
/// are no rows of the tile. Asked for with the tile's columns up to this one written back.
struct NoFurtherBorder {
  template <class S>
  __device__ double operator()(const Tile<S>&, int) const {
    return 0;
  }
};

// Orders by magnitude to 20 bits: enough to choose a pivot.
__device__ inline unsigned pivot_key(double size) {
  return __double2hiint(size) + 1u;
}

// 1 / x, to an ulp or two, without a branch.
__device__ inline double reciprocal_of(double x) {
  double r;
  asm("rcp.approx.ftz.f64 %0, %1;" : "=d"(r) : "d"(x));
  r = fma(r, fma(-x, r, 1.0), r);
  return fma(r, fma(-x, r, 1.0), r);
}
template <class S>
__device__ S reciprocal_of(const S& x) {
  return S(1) / x;
}

__device__ inline double block_max(double value, double* work) {
  for (int step = 16; step > 0; step /= 2) value = fmax(value, __shfl_xor_sync(0xffffffffu, value, step));
  __syncthreads();
  if (threadIdx.x % kWarp == 0) work[threadIdx.x / kWarp] = value;
  __syncthreads();
  for (unsigned w = 0; w < blockDim.x / kWarp; ++w) value = fmax(value, work[w]);
  __syncthreads();
  return value;
}

// Largest entry of column j of the tile in the border rows, once the columns left of it are eliminated there:
// the border rows of the block column are not solved for yet.
template <class S>
struct BorderBelow {
  const S* border_rows;  // at the first column of the tile
  Offset ld;
  int count;
  S* column;  // shared memory
  double* work;

  __device__ double operator()(const Tile<S>& tile, int j) const {
    if (threadIdx.x == 0) {
      for (int i = 0; i < j; ++i) column[i] = tile.a[i + j * tile.ld];
      for (int i = j - 1; i >= 0; --i) {
        column[i] /= tile.a[i + i * tile.ld];
        for (int k = 0; k < i; ++k) column[k] -= tile.a[k + i * tile.ld] * column[i];
      }
    }
    __syncthreads();
    double most = 0;
    for (int r = threadIdx.x; r < count; r += blockDim.x) {
      S sum = border_rows[r + j * ld];
      for (int k = 0; k < j; ++k) sum -= border_rows[r + k * ld] * column[k];
      most = fmax(most, magnitude(sum));
    }
    return block_max(most, work);
  }
};

template <class S>
__device__ S perturbed_pivot(S pivot, double wanted) {
  using Real = RealOf<S>;
  const double size = magnitude(pivot);
  return size > 0 ? pivot * static_cast<Real>(wanted / size) : S(static_cast<Real>(wanted));
}

/// What becomes of a pivot below the bound (kernels/panel_lu.hpp has the rule).
template <class S>
__device__ S replacement(S pivot, double border, const PivotRule& rule) {
  const double size = magnitude(pivot);
  if (size > rule.tiny && size >= kBorderThreshold * border) return pivot;
  const bool dependent = size <= rule.tiny && border <= kEmptyBorder * rule.tiny;
  return perturbed_pivot(pivot, dependent ? rule.largest : rule.bound);
}

// Keeps the compiler from loading everything that follows at once, for which there are no registers.
__device__ inline void hold_loads() {
  asm volatile("" ::: "memory");
}

// Exchanges [begin, end) of a panel whose first row is x[0], row `origin` of the tile.
template <class T>
__device__ void exchange_rows(T* x, const int* exchange, int begin, int end, int origin) {
  for (int k = begin; k < end; ++k) {
    const int from = exchange[k] - origin;
    const T held = x[k];
    x[k] = x[from];
    x[from] = held;
  }
}

// x := L^-1 x for the unit lower triangle L of a panel; the panel's columns of x lie together.
template <class S>
__device__ void solve_panel_column(const S* lower, int ld, int width, S* x) {
  S solved[kPanelColumns];
#pragma unroll
  for (int k = 0; k < kPanelColumns; ++k) solved[k] = k < width ? x[k] : S(0);
#pragma unroll
  for (int k = 0; k < kPanelColumns - 1; ++k) {
    if (k >= width) break;
    hold_loads();
#pragma unroll
    for (int i = k + 1; i < kPanelColumns; ++i) {
      if (i < width) solved[i] -= lower[i + k * ld] * solved[k];
    }
  }
#pragma unroll
  for (int k = 0; k < kPanelColumns; ++k) {
    if (k < width) x[k] = solved[k];
  }
}

// Columns [first, first + width) of the tile, a thread for each row.
template <class S, class Border>
__device__ void factor_tile_panel(const Tile<S>& tile, int first, int width, const PivotRule& rule,
                                  const Border& further_border, S* shift, FactorStatus* status,
                                  TileWork<S>& work) {
  const int t = threadIdx.x, lane = t % kWarp, warp = t / kWarp, next = first + width;
  const int rows = tile.rows, pivots = tile.pivots, ld = tile.ld, pivot_warps = (pivots + kWarp - 1) / kWarp;
  S* const a = tile.a;
  S row[kPanelColumns];  // what is left of this thread's row: row[0] is of the column that is under way
#pragma unroll
  for (int c = 0; c < kPanelColumns; ++c) {
    row[c] = t >= first && t < rows && c < width ? a[t + (first + c) * ld] : S(0);
  }
#pragma unroll 1
  for (int j = first; j < next; ++j) {
    typename TileWork<S>::Offer& offer = work.offer[j % 2];
    if (warp < pivot_warps) {
      const S reciprocal = reciprocal_of(row[0]);
      const unsigned key = t >= j && t < pivots ? pivot_key(magnitude(row[0])) : 0u;
      const unsigned most = __reduce_max_sync(0xffffffffu, key);
      const unsigned who = __ballot_sync(0xffffffffu, key == most);
      if (lane == __ffs(who) - 1) {
        offer.key[warp] = most;
        offer.row[warp] = t;
        offer.reciprocal[warp] = reciprocal;
#pragma unroll
        for (int k = 0; k < kPanelColumns; ++k) offer.part[warp][k] = row[k];
      }
      if (t == j) {
#pragma unroll
        for (int k = 0; k < kPanelColumns; ++k) offer.top[k] = row[k];
      }
    }
    __syncthreads();
    int best = 0;
    unsigned most = offer.key[0];
#pragma unroll
    for (int w = 1; w < kMostPivotWarps; ++w) {
      const unsigned key = w < pivot_warps ? offer.key[w] : 0u;
      if (key > most) {
        most = key;
        best = w;
      }
    }
    const int from = offer.row[best];
    const S* const pivot_row = offer.part[best];
    S pivot = pivot_row[0], inverse = offer.reciprocal[best];
    if (t == from && from != j) {
#pragma unroll
      for (int k = 0; k < kPanelColumns; ++k) row[k] = offer.top[k];
    }
    const double size = magnitude(pivot);
    S added = S(0);
    if (!(size >= rule.bound) && size == size) {  // rare; the same for all threads
      const double own = t >= pivots && t < rows ? magnitude(row[0]) : 0;
      const double border = fmax(block_max(own, work.border), further_border(tile, j));
      const S accepted = replacement(pivot, border, rule);
      added = accepted - pivot;
      pivot = accepted;
      inverse = S(1) / pivot;
      if (t == 0 && magnitude(added) != 0) atomicAdd(&status->perturbed, 1ull);
    }
    if (t == 0) {
      if (!(size <= 1.7976931348623157e308)) atomicAdd(&status->nonfinite, 1ull);
      if (magnitude(added) != 0) shift[j] = added;
      work.exchange[j - first] = from;
      if (from != j) work.any_exchange = 1;
    }
    if (t < next - j) a[j + (j + t) * ld] = t == 0 ? pivot : pivot_row[t];
    if (t > j && t < rows) {
      const S multiplier = row[0] * inverse;
      a[t + j * ld] = multiplier;
#pragma unroll
      for (int k = 1; k < kPanelColumns; ++k) row[k - 1] = row[k] - multiplier * pivot_row[k];
    }
  }
}

/// Factors the tile. row_at (in shared memory, set to the identity by the caller) follows the row exchanges;
/// shift[j] (global memory, zero before) becomes what was added to pivot j. All threads of the block call it,
/// at least `rows` of them, a multiple of 32.
template <class S, class Border>
__device__ void tile_lu(const Tile<S>& tile, const PivotRule& rule, const Border& further_border, int* row_at,
                        S* shift, FactorStatus* status, TileWork<S>& work) {
  const int t = threadIdx.x, warp = t / kWarp, warps = blockDim.x / kWarp;
  const int rows = tile.rows, pivots = tile.pivots, ld = tile.ld;
  S* const a = tile.a;
  for (int first = 0; first < pivots; first += kPanelColumns) {
    const int width = min(kPanelColumns, pivots - first), next = first + width;
    if (t == 0) work.any_exchange = 0;
    factor_tile_panel(tile, first, width, rule, further_border, shift, status, work);
    __syncthreads();
    // This panel's columns see the exchanges that came after them; then the others see all, and what is on
    // the right is solved for.
    if (work.any_exchange) {
      if (t < width) exchange_rows(a + (first + t) * ld + first, work.exchange, t + 1, width, first);
      if (t == blockDim.x - 1) exchange_rows(row_at + first, work.exchange, 0, width, first);
      __syncthreads();
    }
    for (int c = t; c < rows; c += blockDim.x) {
      if (c >= first && c < next) continue;
      S* const column = a + c * ld + first;
      if (work.any_exchange) exchange_rows(column, work.exchange, 0, width, first);
      if (c >= next) solve_panel_column(a + first + first * ld, ld, width, column);
    }
    __syncthreads();
    // What is left of the tile.
    const int rest = rows - next, row_tiles = (rest + 15) / 16, tiles = row_tiles * ((rest + 15) / 16);
    if (width == kPanelColumns) {
      for (int i = warp; i < tiles; i += warps) {
        const int m = next + i % row_tiles * 16, n = next + i / row_tiles * 16;
        S* const c = a + m + n * ld;
        WarpTile<S, 1, 2> product;
        // Rows and columns beyond the tile are read, from memory of the tile, and not used.
        product.for_each([&](int r, int k, S& sum) { sum = -c[r + k * ld]; });
        product.multiply(a + m + first * ld, 1, ld, a + first + n * ld, 1, ld, kPanelColumns);
        product.for_each([&](int r, int k, S& sum) {
          if (m + r < rows && n + k < rows) c[r + k * ld] = -sum;
        });
      }
    } else {
      for (int i = t; i < rest * rest; i += blockDim.x) {
        const int r = next + i % rest, c = next + i / rest;
        S sum = S(0);
        for (int k = first; k < next; ++k) sum += a[r + k * ld] * a[k + c * ld];
        a[r + c * ld] -= sum;
      }
    }
    __syncthreads();
  }
}

// X L = I and X U = I, column by column in place, by one warp: lane r makes row r of X. Rolled loops:
// unrolled ones are so long that every warp waits for its instructions.
template <class S>
__device__ void invert_unit_lower(S* m, int ld, int size) {
  const int r = threadIdx.x % kWarp;
  for (int c = size - 2; c >= 0; --c) {
    S sum = S(0);
#pragma unroll 4
    for (int k = c + 1; k < size; ++k) {
      const S x = k < r ? m[r + k * ld] : S(k == r ? 1 : 0);
      sum += x * m[k + c * ld];
    }
    __syncwarp();
    if (r > c && r < size) m[r + c * ld] = -sum;
    __syncwarp();
  }
}
template <class S>
__device__ void invert_upper(S* m, int ld, int size) {
  const int r = threadIdx.x % kWarp;
  for (int c = 0; c < size; ++c) {
    const S inverse = S(1) / m[c + c * ld];
    S sum = S(0);
#pragma unroll 4
    for (int k = 0; k < c; ++k) {
      const S x = k >= r ? m[r + k * ld] : S(0);
      sum += x * m[k + c * ld];
    }
    __syncwarp();
    if (r <= c) m[r + c * ld] = r == c ? inverse : -sum * inverse;
    __syncwarp();
  }
}

/// Puts the inverses of the unit lower and of the upper triangle of each 32 x 32 diagonal block in its place:
/// what follows only multiplies.
template <class S>
__device__ void invert_diagonal_blocks(const Tile<S>& tile) {
  const int warp = threadIdx.x / kWarp, warps = blockDim.x / kWarp;
  const int blocks = (tile.pivots + kInverted - 1) / kInverted;
  for (int task = warp; task < 2 * blocks; task += warps) {
    const int begin = task / 2 * kInverted, size = min(kInverted, tile.pivots - begin);
    S* const m = tile.a + begin + begin * tile.ld;
    if (task % 2 == 0) {
      invert_unit_lower(m, tile.ld, size);
    } else {
      invert_upper(m, tile.ld, size);
    }
  }
}

}  // namespace mfs::cuda
