// Stage "solve" on the device, for K columns at once, which lie side by side: entry (i, c) of a vector at
// i * K + c. One launch per direction, in tiles of 64 rows of a front (of 64 columns where the factor is used
// transposed); but depths with many tiny fronts have a launch of their own, and beside it one in which a warp
// does each of those (tiny_substitution.hpp).
//
//   forward     y_i = L_ii^-1 (v_i + what the children left - sum_{j<i} L_ij y_j);  border: z = what the
//               children left - L y
//   backward    v_i = U_ii^-1 (y_i - U v(border) - sum_{j>i} U_ij v_j)
//
// Backward, tiles with a long border are cut in parts (SolvePart), a block each, so that the few large fronts
// of a depth fill the device. A tile or part needs the results of others, of its front and forward of its
// children, backward of its ancestors, which run at the same time: it waits, entry by entry, until they are
// no longer kUnset, which nothing computed is. They belong to blocks with smaller numbers; the parts of a
// tile may come later, but never while so many tiles wait for theirs that these could fill the device
// (DeviceLimits::waiting_tiles). So none waits for one that cannot begin. Each sum is made in one order: the
// parts' are added one by one. Forward, where a depth has more tiles of borders than the device can hold,
// those with one step are up to 256 rows high: what a block needs before it can begin takes it longer than
// what it then does.
//
// What multiplies the vector comes in steps of 64 columns, and at the end the diagonal tile, which is
// inverted, or U as it is where tiny pivots are divided by: for one column column_sweep.hpp does them, for 4
// and 16 tile_sweep.hpp. From the last entries that a tile waits for to the first that others wait for takes
// about 1.5 us, for each tile of a large front: nothing is loaded on that path, and it has few barriers.
//
// The transposed system takes U^T forward and L^T backward, and undoes the row exchanges at the end.
#pragma once

#include "kernels/cuda/solve/column_sweep.hpp"
#include "kernels/cuda/solve/tile_sweep.hpp"

namespace mfs::cuda {

/// Blocks on a multiprocessor that registers must not stand in the way of. Transposed, a thread has 16 sums.
template <bool Transposed, int K>
constexpr int kSolveBlocks = K == 1 && !Transposed ? 3 : 2;

template <bool Transposed, int K, class S, class PanelOf, class PlaceOf>
using Sweep = std::conditional_t<K == 1, ColumnSweep<Transposed, S, PanelOf, PlaceOf>,
                                 TileSweep<Transposed, K, S, PanelOf, PlaceOf>>;
template <bool Transposed, int K, class S, class PanelOf, class PlaceOf>
__device__ auto sweep_tile(void* memory, const SolvePart& part, const SolveTile<S>& tile,
                           const PanelOf& panel, const PlaceOf& place) {
  return Sweep<Transposed, K, S, PanelOf, PlaceOf>(memory, part, tile.width, panel, place);
}
/// Shared memory of both passes.
template <class S, int K>
constexpr std::size_t substitution_bytes() {
  return Sweep<false, K, S, int, int>::bytes;
}

/// Row and column of the tile for a thread's i-th entry; the row is -1 where the tile has none there.
template <int K>
__device__ int own_row(int i, int width) {
  const int row = static_cast<int>(threadIdx.x + i * kSolveThreads) / K;
  return row < width ? row : -1;
}
template <int K>
__device__ int own_column() {
  static_assert(kSolveThreads % K == 0);
  return threadIdx.x % K;
}

/// `Substituted`: U is, which the transposed system has forward and the other one backward.
template <bool Transposed, bool Substituted, int K, class S, class Value>
__device__ void solve_forward(const DeviceStore<S, Value>& store, const DeviceVectors<S>& vectors,
                              const SolvePart& part, void* memory) {
  const SolveTile<S> tile = solve_tile(store.fronts, part);
  const SolveFront& front = part.where;
  const Offset pivots_at = front.pivots_at;
  const int before = tile.has_pivots ? tile.begin : front.pivots;
  const S* left = Transposed ? tile.lower + tile.begin * tile.ld : tile.lower + tile.begin;
  Offset ld = tile.ld;
  if (Transposed && !tile.has_pivots) {
    ld = front.pivots;
    left = tile.upper + (tile.begin - front.pivots) * ld;
  }
  const auto panel = [&](int step) {
    if (step == (before + kStep - 1) / kStep) return diagonal_panel(tile);
    const int k = step * kStep;
    return Panel<S>{left + (Transposed ? k : k * ld), ld, min(kStep, before - k)};
  };
  const auto place = [&](int step, int row) {
    const int k = step * kStep + row;
    return k < before ? pivots_at + k : Offset(-1);
  };
  __shared__ Offset goes_to[kSolveTile];
  if (static_cast<int>(threadIdx.x) < tile.width) {
    const Offset row = tile.begin + threadIdx.x;
    goes_to[threadIdx.x] =
        tile.has_pivots ? pivots_at + row : store.destination[front.border_at + row - front.pivots];
  }
  auto sweep = sweep_tile<Transposed, K>(memory, part, tile, panel, place);
  // v, and what the children leave, which may be in the same launch.
  S own[kOwnEntries<K>];
  int children[kOwnEntries<K>];
  Offset from[kOwnEntries<K>];
#pragma unroll
  for (int i = 0; i < kOwnEntries<K>; ++i) {
    own[i] = S(0);
    children[i] = 0;
    int row = own_row<K>(i, tile.width);
    if (row < 0) continue;
    row += tile.begin;
    if (tile.has_pivots) {
      if (!Transposed) row = store.fronts.local_row[pivots_at + row];
      own[i] = vectors.v[(pivots_at + row) * K + own_column<K>()];
    }
    from[i] = store.source_begin[front.rows_at + row];
    children[i] = static_cast<int>(store.source_begin[front.rows_at + row + 1] - from[i]);
  }
  add_when_set(
      children, 1 + part.last_step,
      [&](int i, int child) { return vectors.border + (from[i] + child) * K + own_column<K>(); }, own);
  sweep.begin_with(own);
  sweep.subtract_sums(vectors.y, vectors.partial);
  S* const to = tile.has_pivots ? vectors.y : vectors.border;
  const auto write = [&](int row, int column, const S& value) {
    if (row < tile.width) to[goes_to[row] * K + column] = value;
  };
  if (tile.has_pivots) {
    if constexpr (Substituted) {
      static_assert(Transposed);
      sweep.template substitute_diagonal<false>(write);
    } else {
      sweep.template solve_diagonal<false, !Transposed>(write);
    }
  } else {
    sweep.write_rest(write);
  }
}

// A tall tile of a border: a thread for each row, all of its pivots in one step.
template <class S, class Value>
__device__ void subtract_tall_tile(const DeviceStore<S, Value>& store, const DeviceVectors<S>& vectors,
                                   const SolvePart& part, S* y) {
  static_assert(kTallTile == kSolveThreads);
  constexpr int kAhead = 16, kSums = 4;
  const SolveFront& front = part.where;
  const int row = part.begin + threadIdx.x, p = front.pivots;
  const bool has_row = static_cast<int>(threadIdx.x) < part.rows;
  const S* const from = store.fronts.storage + front.lower + row;
  S entry[kAhead];
  const auto load = [&](int k) {
#pragma unroll
    for (int j = 0; j < kAhead; ++j) entry[j] = has_row && k + j < p ? once(from + (k + j) * front.ld) : S(0);
  };
  load(0);
  constexpr int kLine = 128 / static_cast<int>(sizeof(S));
  if (has_row && threadIdx.x % kLine == 0) {
    for (int k = kAhead; k < p; ++k) prefetch_line(from + k * front.ld);
  }
  S sum[1] = {S(0)};
  Offset to = 0;
  if (has_row) {
    to = store.destination[front.border_at + row - p];
    const Offset source = store.source_begin[front.rows_at + row];
    const int children[1] = {static_cast<int>(store.source_begin[front.rows_at + row + 1] - source)};
    add_when_set(
        children, 1, [&](int, int child) { return vectors.border + source + child; }, sum);
  }
  if (threadIdx.x < kSolveTile) {
    const S* const place = vectors.y + front.pivots_at + threadIdx.x;
    y[threadIdx.x] = static_cast<int>(threadIdx.x) < p ? wait_for(place, peek(place), 1) : S(0);
  }
  __syncthreads();
  S product[kSums];
#pragma unroll
  for (int j = 0; j < kSums; ++j) product[j] = S(0);
  for (int k = 0; k < p; k += kAhead) {
#pragma unroll
    for (int j = 0; j < kAhead; ++j) product[j % kSums] += entry[j] * y[k + j];
    load(k + kAhead);
  }
  if (has_row) vectors.border[to] = sum[0] - ((product[0] + product[1]) + (product[2] + product[3]));
}

template <bool Transposed, bool Substituted, int K, class S, class Value>
__global__ void __launch_bounds__(kSolveThreads, kSolveBlocks<Transposed, K>)
    substitute_forward(DeviceStore<S, Value> store, DeviceVectors<S> vectors, Offset first) {
  extern __shared__ __align__(16) unsigned char memory[];
  SolvePart part = store.solve[first + blockIdx.x];
  if constexpr (K == 1 && !Transposed) {
    if (part.rows > kSolveTile) {
      subtract_tall_tile(store, vectors, part, reinterpret_cast<S*>(memory));
    } else {
      solve_forward<Transposed, Substituted, K>(store, vectors, part, memory);
    }
  } else {
    for (const int end = part.begin + part.rows; part.begin < end; part.begin += kSolveTile) {
      part.rows = min(kSolveTile, end - part.begin);
      solve_forward<Transposed, Substituted, K>(store, vectors, part, memory);
      __syncthreads();
    }
  }
}

template <bool Transposed, bool Substituted, int K, class S, class Value>
__global__ void __launch_bounds__(kSolveThreads, kSolveBlocks<Transposed, K>)
    substitute_backward(DeviceStore<S, Value> store, DeviceVectors<S> vectors, Offset first) {
  extern __shared__ __align__(16) unsigned char memory[];
  const SolvePart part = store.solve[first + blockIdx.x];
  const SolveTile<S> tile = solve_tile(store.fronts, part);
  const SolveFront& front = part.where;
  const Offset pivots_at = front.pivots_at;
  const Vertex* const border_rows = store.fronts.border + front.border_at;
  const auto row_of = [&](int pivot) {
    return pivots_at + Offset(Transposed ? store.fronts.local_row[pivots_at + pivot] : pivot);
  };
  // What is right of the tile, last columns first, as they are done first: the border, then the pivot block.
  const int of_border = (front.border + kStep - 1) / kStep, after = tile.begin + tile.width;
  const int steps = of_border + (front.pivots - after + kStep - 1) / kStep;
  const auto column_of = [&](int step) {
    return step < of_border ? (of_border - 1 - step) * kStep : after + (steps - 1 - step) * kStep;
  };
  const auto panel = [&](int step) {
    if (step >= steps) return diagonal_panel(tile);
    const bool border = step < of_border;
    const int k = column_of(step), count = min(kStep, (border ? front.border : front.pivots) - k);
    if (Transposed)
      return Panel<S>{tile.lower + (border ? front.pivots : 0) + k + tile.begin * tile.ld, tile.ld, count};
    const Offset ld = border ? Offset(front.pivots) : tile.ld;
    return Panel<S>{(border ? tile.upper : tile.lower) + tile.begin + k * ld, ld, count};
  };
  const auto place = [&](int step, int row) {
    const int k = column_of(step) + row;
    if (step < of_border) return k < front.border ? Offset(border_rows[k]) : Offset(-1);
    return k < front.pivots ? row_of(k) : Offset(-1);
  };
  auto sweep = sweep_tile<Transposed, K>(memory, part, tile, panel, place);
  if (!part.finishes) {
    sweep.leave_sums(vectors.v, vectors.partial);
    return;
  }
  S own[kOwnEntries<K>];
#pragma unroll
  for (int i = 0; i < kOwnEntries<K>; ++i) {
    const int row = own_row<K>(i, tile.width);
    own[i] = row < 0 ? S(0) : vectors.y[(pivots_at + tile.begin + row) * K + own_column<K>()];
  }
  sweep.begin_with(own);
  sweep.subtract_sums(vectors.v, vectors.partial);
  const auto write = [&](int row, int column, const S& value) {
    if (row < tile.width) vectors.v[row_of(tile.begin + row) * K + column] = value;
  };
  if constexpr (Substituted) {
    static_assert(!Transposed);
    sweep.template substitute_diagonal<true>(write);
  } else {
    sweep.template solve_diagonal<true, Transposed>(write);
  }
}

}  // namespace mfs::cuda
