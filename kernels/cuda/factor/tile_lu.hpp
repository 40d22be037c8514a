// LU of one tile in shared memory by one thread block: the pivot block of a small front with its border, or
// the diagonal tile of a larger one. The pivot of each column is sought in all pivot rows of the tile;
// pivots that are too small are treated as on the host (kernels/dense/panel_lu.hpp).
//
// Sixteen columns at a time, a panel, lie in registers, one row per thread. Where its pivots may be taken
// from the diagonal, they are (diagonal_panel.hpp). Else they are searched, and rows stay where they are;
// then all of the panel's row exchanges are made at once. What is right of a panel is solved for, by the
// inverse of its unit lower triangle, and updated on the tensor cores.
#pragma once

#include "kernels/cuda/factor/diagonal_panel.hpp"
#include "kernels/dense/panel_lu.hpp"
#include "plan/device_plan.hpp"

namespace mfs::cuda {

/// Most panels of fronts with few pivots have no more columns.
constexpr int kHalfPanel = kPanelColumns / 2;

/// Where pivot row i of the tile lies while the panel from `first` on is under way.
struct PivotPlaces {
  int first;
  const int* chosen;
  __device__ int operator()(int i) const { return i < first ? i : chosen[i - first]; }
};

/// What the pivots below the bound are compared with: the largest entry of their column in border rows that
/// are no rows of the tile. Asked for with the tile's columns up to this one written back.
struct NoFurtherBorder {
  template <class S>
  __device__ double operator()(const Tile<S>&, int, const PivotPlaces&) const {
    return 0;
  }
};

/// Pivots in the order in which they are preferred: by size, then by row (at most 256). The entry on the
/// diagonal has `diagonal_bits` more.
template <class S>
__device__ unsigned pivot_key(const S& pivot, int row) {
  return size_bits(pivot) + 0x100u + (0xffu - row);
}
/// What size_bits of a number grow by where it is multiplied by a power of two.
template <class S>
__device__ unsigned bits_of_factor(double factor) {
  const unsigned exponent = static_cast<unsigned>(__double2hiint(factor) - __double2hiint(1.0));
  return std::is_same_v<S, float> ? exponent << 3 : exponent;
}
__device__ inline int row_of_key(unsigned key) {
  static_assert(kMostPivotWarps * kWarp <= 256 && kMostPivotWarps <= 8);
  return 0xff - (key & 0xff);
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

  __device__ double operator()(const Tile<S>& tile, int j, const PivotPlaces& place) const {
    if (threadIdx.x < kWarp) solve_above(tile, j, j, place, column);
    __syncthreads();
    double most = 0;
    for (int r = threadIdx.x; r < count; r += blockDim.x) {
      S sum = border_rows[r + j * ld];
      for (int k = 0; k < j; ++k) sum -= border_rows[r + k * ld] * column[k];
      most = fmax(most, magnitude(sum));
    }
    return block_max(most, work);
  }

  // above = U^-1 times the first `count` entries of column j, by one warp: a lane has every 32nd row.
  static __device__ void solve_above(const Tile<S>& tile, int count, int j, const PivotPlaces& place,
                                     S* above) {
    constexpr int kEach = kTile<S> / kWarp;
    const int lane = threadIdx.x % kWarp;
    S x[kEach];
#pragma unroll
    for (int q = 0; q < kEach; ++q) {
      const int k = lane + q * kWarp;
      x[q] = k < count ? tile.a[place(k) + j * tile.ld] : S(0);
    }
#pragma unroll
    for (int own = kEach - 1; own >= 0; --own) {
      for (int i = min(count, (own + 1) * kWarp) - 1; i >= own * kWarp; --i) {
        const S solved = shuffle(x[own], i % kWarp) / tile.a[place(i) + i * tile.ld];
#pragma unroll
        for (int q = 0; q <= own; ++q) {
          const int k = lane + q * kWarp;
          if (k < i) x[q] -= tile.a[place(k) + i * tile.ld] * solved;
          if (k == i) x[q] = solved;
        }
      }
    }
#pragma unroll
    for (int q = 0; q < kEach; ++q) {
      if (lane + q * kWarp < count) above[lane + q * kWarp] = x[q];
    }
  }
};

// The inverse of the unit lower triangle of a panel in its place, by one warp: a lane makes a column. Row i
// of the triangle lies at row place(i). What a panel of less than Columns lacks is computed too, and not
// used, from entries of the panel: those right of it are being moved by other warps.
template <int Columns, class S, class Place>
__device__ void invert_unit_lower(S* panel, int ld, int width, const Place& place) {
  const int lane = threadIdx.x % kWarp;
  S x[Columns];
#pragma unroll
  for (int i = 0; i < Columns; ++i) x[i] = S(i == lane ? 1 : 0);
#pragma unroll
  for (int i = 1; i < Columns; ++i) {
    const S* const row = panel + place(min(i, width - 1));
#pragma unroll
    for (int k = 0; k < i; ++k) x[i] -= row[min(k, width - 1) * ld] * x[k];
  }
  __syncwarp();
#pragma unroll
  for (int i = 1; i < Columns; ++i) {
    if (i < width && lane < i) panel[place(i) + lane * ld] = x[i];
  }
  __syncwarp();
}
template <class S, class Place>
__device__ void invert_unit_lower(S* panel, int ld, int width, const Place& place) {
  if (width <= kHalfPanel)
    invert_unit_lower<kHalfPanel>(panel, ld, width, place);
  else
    invert_unit_lower<kPanelColumns>(panel, ld, width, place);
}

// What becomes of an offered pivot that is suspect, or no number.
template <class S, class Border>
__device__ void settle_pivot(const Tile<S>& tile, int j, double border_entry, const PivotRule& rule,
                             const Border& further_border, const PivotPlaces& places, OfferedRow<S>& offered,
                             S* shift, FactorStatus* status, TileWork<S>& work) {
  const S pivot = offered.pivot;
  const double size = magnitude(pivot);
  const bool suspect = !(size >= rule.bound) && size == size;
  S accepted = pivot;
  if (suspect) {
    const double border = fmax(block_max(border_entry, work.border), further_border(tile, j, places));
    accepted = replacement(pivot, border, rule);
  }
  __syncthreads();
  if (threadIdx.x == 0) {
    if (!(size <= 1.7976931348623157e308)) atomicAdd(&status->nonfinite, 1ull);
    if (suspect) {
      const S added = accepted - pivot;
      if (magnitude(added) != 0) {
        atomicAdd(&status->perturbed, 1ull);
        shift[j] = added;
      }
      offered.pivot = accepted;
      offered.reciprocal = S(1) / accepted;
    }
  }
  __syncthreads();
}

// Columns [begin, end) of the panel [first, next), of which at most Live are left. Rows stay where they are;
// `waiting` says whether this thread's has not been pivot row.
template <int Live, class S, class Border>
__device__ void eliminate_columns(const Tile<S>& tile, int first, int begin, int end, int next,
                                  const PivotRule& rule, const Border& further_border,
                                  S (&row)[kPanelColumns], bool& waiting, S* shift, FactorStatus* status,
                                  TileWork<S>& work) {
  const int t = threadIdx.x, lane = t % kWarp, warp = t / kWarp;
  const int rows = tile.rows, pivots = tile.pivots, ld = tile.ld, pivot_warps = (pivots + kWarp - 1) / kWarp;
  const bool last_warp = warp == static_cast<int>(blockDim.x) / kWarp - 1;
  // A pivot on the diagonal may count for more than it is: settle_pivot looks at it.
  const unsigned lowest = bound_bits<S>(rule.bound * rule.preference) + 0x200u,
                 beyond = bound_bits<S>(HUGE_VAL) + 0x100u,
                 diagonal_bits = bits_of_factor<S>(rule.preference);
  S* const a = tile.a;
#pragma unroll 1
  for (int j = begin; j < end; ++j) {
    if (warp < pivot_warps) {
      const bool candidate = waiting && t < pivots;
      const unsigned key = candidate ? pivot_key(row[0], t) + (t == j ? diagonal_bits : 0u) : 0u;
      const unsigned most = __reduce_max_sync(0xffffffffu, key);
      const S reciprocal = reciprocal_of(row[0]);
      if (key != 0 && key == most) {
        OfferedRow<S>& offered = work.offered[j % 2][warp];
#pragma unroll
        for (int k = 3; k < Live; k += 2) {
          offered.right[k - 2] = row[k - 1];
          offered.right[k - 1] = row[k];
        }
        offered.pivot = row[0];
        offered.reciprocal = reciprocal;
        offered.right[0] = row[1];
      }
      if (lane == 0) work.key[j % 2][warp] = most;
    }
    __syncthreads();
    const unsigned* const key = work.key[j % 2];
    unsigned most = max(max(key[0], key[1]), max(key[2], key[3]));
    if (pivots > 4 * kWarp) most = max(most, key[4]);
    const int from = row_of_key(most);
    OfferedRow<S>& offered = work.offered[j % 2][from / kWarp];
    if (most < lowest || most >= beyond) {  // rare; the same for all threads
      const double border_entry = t >= pivots && t < rows ? magnitude(row[0]) : 0;
      settle_pivot(tile, j, border_entry, rule, further_border, PivotPlaces{first, work.chosen}, offered,
                   shift, status, work);
    }
    if (t == from) waiting = false;
    if (warp * kWarp < rows) {
      const S multiplier = row[0] * offered.reciprocal;
#pragma unroll
      for (int k = 1; k < Live; ++k) row[k - 1] = row[k] - multiplier * offered.right[k - 1];
      if (waiting) a[t + j * ld] = multiplier;
    }
    if (last_warp) {
      if (lane < next - j) a[from + (j + lane) * ld] = lane == 0 ? offered.pivot : offered.right[lane - 1];
      if (lane == 0) work.chosen[j - first] = from;
    }
  }
}

// Columns [first, first + width) of the tile, a thread for each row.
template <class S, class Border>
__device__ void factor_tile_panel(const Tile<S>& tile, int first, int width, const PivotRule& rule,
                                  const Border& further_border, S* shift, FactorStatus* status,
                                  TileWork<S>& work) {
  const int t = threadIdx.x, next = first + width;
  const int middle = width > kHalfPanel ? first + kHalfPanel : first;
  bool waiting = t >= first && t < tile.rows;
  S row[kPanelColumns];  // what is left of this thread's row: row[0] is of the column that is under way
#pragma unroll
  for (int c = 0; c < kPanelColumns; ++c) {
    row[c] = waiting && c < width ? tile.a[t + (first + c) * tile.ld] : S(0);
  }
  eliminate_columns<kPanelColumns>(tile, first, first, middle, next, rule, further_border, row, waiting,
                                   shift, status, work);
  eliminate_columns<kHalfPanel>(tile, first, middle, next, next, rule, further_border, row, waiting, shift,
                                status, work);
}

// What brings the pivot rows of a panel to its first rows: row `to` becomes row `from`, one in each lane,
// where moves; for each warp that asks.
struct RowMoves {
  int to, from;
  bool moves, any;

  __device__ RowMoves(const int* chosen, int first, int width) {
    const int lane = threadIdx.x % kWarp, k = lane % kPanelColumns, next = first + width;
    const int row = k < width ? chosen[k] : first;
    const bool leaves = k < width && row >= next;  // its place below the panel's first rows
    const unsigned left = __ballot_sync(0xffffffffu, leaves && lane < kPanelColumns);
    // The i-th of the first rows that are not chosen goes where the i-th that leaves was.
    unsigned others = ~__reduce_or_sync(0xffffffffu, k < width && row < next ? 1u << (row - first) : 0u);
    for (unsigned before = left & ((1u << k) - 1); before != 0; before &= before - 1) others &= others - 1;
    if (lane < kPanelColumns) {
      to = first + k;
      from = row;
      moves = k < width && to != from;
    } else {
      to = row;
      from = first + __ffs(others) - 1;
      moves = leaves;
    }
    any = __any_sync(0xffffffffu, moves);
  }
  /// Of columns begin, begin + step, ... before `end`, by one warp.
  template <class T>
  __device__ void apply(T* a, int ld, int begin, int end, int step) const {
    if (!any) return;
    constexpr int kTogether = 4;
    for (int first = begin; first < end; first += kTogether * step) {
      T moved[kTogether];
#pragma unroll
      for (int i = 0; i < kTogether; ++i) {
        const int c = first + i * step;
        if (moves && c < end) moved[i] = a[from + c * ld];
      }
      __syncwarp();
#pragma unroll
      for (int i = 0; i < kTogether; ++i) {
        const int c = first + i * step;
        if (moves && c < end) a[to + c * ld] = moved[i];
      }
    }
    __syncwarp();
  }
};

// What is right of and below a panel.
template <int RowTiles, class S>
__device__ void update_tile(const Tile<S>& tile, int first, int width) {
  const int warp = threadIdx.x / kWarp, warps = blockDim.x / kWarp, rows = tile.rows, ld = tile.ld;
  const int next = first + width, begin = next / 16 * 16, rest = rows - begin;
  constexpr int kRows = 16 * RowTiles;
  const int groups = (rest + kRows - 1) / kRows;
  S* const a = tile.a;
  for (int i = warp; i < groups * ((rest + 15) / 16); i += warps) {
    const int m = begin + i % groups * kRows, n = begin + i / groups * 16, there = (rows + 15) / 16 * 16 - m;
    S* const c = a + m + n * ld;
    WarpTile<S, RowTiles, 2> product;
    // Columns beyond the tile are read, from memory of the tile, and not used.
    product.for_each([&](int r, int k, S& sum) { sum = r < there ? -c[r + spread_column(k) * ld] : S(0); });
    product.multiply_entries(
        [&](int r, int k) { return k < width && r < there ? a[m + r + (first + k) * ld] : S(0); },
        [&](int k, int c) { return k < width ? a[first + k + (n + spread_column(c)) * ld] : S(0); },
        kPanelColumns);
    product.for_each([&](int r, int k, S& sum) {
      const int row = m + r, column = n + spread_column(k);
      if (row >= next && row < rows && column >= next && column < rows) c[r + spread_column(k) * ld] = -sum;
    });
  }
}

/// Factors the tile. row_at (in shared memory, set to the identity by the caller) follows the row exchanges;
/// shift[j] (global memory, zero before) becomes what was added to pivot j. In place of the unit lower
/// triangle of each panel comes its inverse. All threads of the block call it, at least `rows` of them and
/// two warps. With `searches` all panels are searched, as where tiny pivots are divided by: what a sweep of
/// pairs divides by and what it leaves as U differ by rounding of the entries that cancel in them.
template <int Threads, class S, class Border>
__device__ void tile_lu(const Tile<S>& tile, const PivotRule& rule, bool searches,
                        const Border& further_border, int* row_at, S* shift, FactorStatus* status,
                        TileWork<S>& work, PivotWork<S>& pivot_work) {
  constexpr int warps = Threads / kWarp;
  static_assert(warps > 1);  // one of them has the pivots' rows, while the others exchange
  const int t = threadIdx.x, warp = t / kWarp;
  const int rows = tile.rows, pivots = tile.pivots, ld = tile.ld;
  S* const a = tile.a;
  if (t < 16) work.key[t / 8][t % 8] = 0;
  for (int first = 0; first < pivots; first += kPanelColumns) {
    const int width = min(kPanelColumns, pivots - first), next = first + width;
    __syncthreads();
    if (searches || !DiagonalPanel<Threads, S>(tile, first, rule.bound, pivot_work).factor()) {
      factor_tile_panel(tile, first, width, rule, further_border, shift, status, work);
      __syncthreads();
      const RowMoves moves(work.chosen, first, width);
      if (warp == warps - 1) {
        invert_unit_lower(a + first * ld, ld, width, [&](int i) { return work.chosen[i]; });
        moves.apply(a, ld, first, next, 1);
        moves.apply(row_at, 0, 0, 1, 1);
      } else {
        moves.apply(a, ld, warp, first, warps - 1);
        moves.apply(a, ld, next + warp, rows, warps - 1);
      }
      __syncthreads();
      solve_right(tile, first, width, a + first + first * ld, ld);
    }
    if (next == rows) break;
    __syncthreads();
    update_tile<(warps > 4 ? 2 : 1)>(tile, first, width);
  }
  __syncthreads();
}

// Inverses of the upper triangles of two 16 x 16 blocks on the diagonal, of which each has at most Columns,
// in place, by one warp: a lane makes a row of X U = I.
template <int Columns, class S>
__device__ void invert_upper_blocks(S* m, int ld, int size) {
  const int lane = threadIdx.x % kWarp, r = lane % kPanelColumns, begin = lane - r;
  const int count = min(kPanelColumns, size - begin);
  S* const block = m + begin + begin * ld;
  const S own = r < count ? reciprocal_of(block[r + r * ld]) : S(0);
  S x[Columns];
#pragma unroll
  for (int c = 0; c < Columns; ++c) {
    S sum = S(r == c ? -1 : 0);
#pragma unroll
    for (int k = 0; k < c; ++k) {
      if (c < count) sum += x[k] * block[k + c * ld];
    }
    x[c] = -sum * shuffle(own, begin + c);
  }
  __syncwarp();
#pragma unroll
  for (int c = 0; c < Columns; ++c) {
    if (r <= c && c < count) block[r + c * ld] = x[c];
  }
  __syncwarp();
}

// The inverse of a 32 x 32 triangle from those of its 16 x 16 blocks, in place, by one warp.
//
//   [A   ]^-1   [A^-1              ]          [A  B]^-1   [A^-1  -A^-1 B C^-1]
//   [B  C]    = [-C^-1 B A^-1  C^-1]          [   C]    = [              C^-1]
template <bool Upper, class S>
__device__ void join_inverses(S* m, int ld, int size) {
  constexpr int h = kPanelColumns;
  const int second = size - h;
  if (second <= 0) return;
  const auto triangle = [&](int begin, int r, int c) {
    const bool inside = Upper ? r <= c && c < size - begin : r > c && r < size - begin;
    return inside ? m[begin + r + (begin + c) * ld] : S(!Upper && r == c ? 1 : 0);
  };
  S* const corner = Upper ? m + h * ld : m + h;
  const int rows = Upper ? h : second, columns = Upper ? second : h;
  const auto between = [&](int r, int c) { return r < rows && c < columns ? corner[r + c * ld] : S(0); };
  WarpTile<S, 1, 2> product;
  const auto keep = [&](int sign) {
    __syncwarp();
    product.for_each([&](int r, int c, S& sum) {
      if (r < rows && c < columns) corner[r + c * ld] = sign < 0 ? -sum : sum;
    });
    __syncwarp();
  };
  product.clear();
  product.multiply_entries(
      between, [&](int k, int c) { return triangle(Upper ? h : 0, k, c); }, h);
  keep(1);
  product.clear();
  product.multiply_entries([&](int r, int k) { return triangle(Upper ? 0 : h, r, k); }, between, h);
  keep(-1);
}

/// Puts the inverses of the unit lower and of the upper triangle of each 32 x 32 diagonal block in its place:
/// what follows only multiplies. Those of the unit lower triangles of panels are there. Upper triangles that
/// are substituted with stay as they are.
template <class S>
__device__ void invert_diagonal_blocks(const Tile<S>& tile, bool keeps_upper) {
  const int warp = threadIdx.x / kWarp, warps = blockDim.x / kWarp;
  const int blocks = (tile.pivots + kInverted - 1) / kInverted;
  for (int task = warp; task < 2 * blocks; task += warps) {
    const int begin = task / 2 * kInverted, size = min(kInverted, tile.pivots - begin);
    S* const m = tile.a + begin + begin * tile.ld;
    if (task % 2 == 0) {
      join_inverses<false>(m, tile.ld, size);
    } else if (!keeps_upper) {
      if (size <= kHalfPanel)
        invert_upper_blocks<kHalfPanel>(m, tile.ld, size);
      else
        invert_upper_blocks<kPanelColumns>(m, tile.ld, size);
      join_inverses<true>(m, tile.ld, size);
    }
  }
}

/// The inverses of the unit lower triangles of panels, where the tile was not factored by tile_lu.
template <class S>
__device__ void invert_panels(const Tile<S>& tile) {
  const int warp = threadIdx.x / kWarp, warps = blockDim.x / kWarp;
  for (int first = warp * kPanelColumns; first < tile.pivots; first += warps * kPanelColumns) {
    invert_unit_lower(tile.a + first * tile.ld, tile.ld, min(kPanelColumns, tile.pivots - first),
                      [&](int i) { return first + i; });
  }
  __syncthreads();
}

}  // namespace mfs::cuda
