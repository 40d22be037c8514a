// The diagonal tile of each larger front at one step of its factorization, one block per front; and the rare
// fronts whose pivots must be searched further than that.
#pragma once

#include "kernels/cuda/async_copy.hpp"
#include "kernels/cuda/device_store.hpp"
#include "kernels/cuda/tile_lu.hpp"

namespace mfs::cuda {

/// A multiplier beyond this, of a row that the pivot search left out, makes its front strict: the growth that
/// kBorderThreshold allows.
constexpr double kMostGrowth = 1 / kBorderThreshold;

constexpr int kTileThreads = 256;

template <class S>
constexpr std::size_t block_lu_bytes() {
  constexpr int tile = kTile<S>;
  return sizeof(TileWork<S>) + sizeof(S) * tile_ld(tile) * tile + sizeof(int) * tile + sizeof(S) * tile;
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

// A tile that leaves out pivot rows below it does not decide about a small pivot: its front becomes strict,
// and is factored again.
template <class S, class Value>
struct UndecidedBelow {
  const DeviceStore<S, Value>* store;
  Vertex front;
  template <class T>
  __device__ double operator()(const T&, int) const {
    if (threadIdx.x == 0) store->make_strict(front);
    return 0;
  }
};

template <class S>
__device__ void load_tile(const Tile<S>& tile, const S* from, Offset ld) {
  const int lane = threadIdx.x % kWarp, warp = threadIdx.x / kWarp, warps = blockDim.x / kWarp;
  for (int c = warp; c < tile.rows; c += warps) {
    for (int r = lane; r < tile.rows; r += kWarp)
      copy_async<sizeof(S)>(shared_address(tile.a + r + c * tile.ld), from + r + c * ld);
  }
  commit_copies();
  wait_copies<0>();
  __syncthreads();
}
template <class S>
__device__ void store_tile(const Tile<S>& tile, S* to, Offset ld) {
  const int lane = threadIdx.x % kWarp, warp = threadIdx.x / kWarp, warps = blockDim.x / kWarp;
  __syncthreads();
  for (int c = warp; c < tile.rows; c += warps) {
    for (int r = lane; r < tile.rows; r += kWarp) to[r + c * ld] = tile.a[r + c * tile.ld];
  }
}

// Exchanges two rows of a whole front, all columns.
template <class S>
__device__ void exchange_front_rows(const Front<S>& front, int a, int b) {
  const Offset ld = front.lower_ld;
  for (int c = threadIdx.x; c < front.rows(); c += blockDim.x) {
    S* column = c < front.pivots ? front.lower + c * ld
                                 : front.upper + static_cast<Offset>(c - front.pivots) * front.pivots;
    const S held = column[a];
    column[a] = column[b];
    column[b] = held;
  }
}

// Columns [k, k + s) of a strict front, rows [k, p), in global memory: each pivot is searched in all of them.
template <class S, class Value>
__device__ __noinline__ void factor_strict(const DeviceStore<S, Value>& store, Vertex f,
                                           const Front<S>& front, int k, int s, S* column_work,
                                           TileWork<S>& work) {
  const PivotRule rule = store.rule();
  const Offset ld = front.lower_ld;
  const int m = front.pivots - k, begin = store.fronts.pivot_begin[f];
  S* const a = front.lower + k + k * ld;
  Vertex* local_row = store.fronts.local_row + begin;
  if (k == 0) {
    for (int i = threadIdx.x; i < front.pivots; i += blockDim.x) local_row[i] = i;
  }
  __shared__ int chosen;
  for (int j = 0; j < s; ++j) {
    __syncthreads();
    // The column up to date: left-looking, one row per thread.
    for (int i = threadIdx.x; i < j; i += blockDim.x) column_work[i] = a[i + j * ld];
    __syncthreads();
    if (threadIdx.x < kWarp) {  // its part above the diagonal, by one warp
      for (int i = 0; i < j; ++i) {
        const S solved = column_work[i];
        __syncwarp();
        for (int r = i + 1 + threadIdx.x; r < j; r += kWarp) column_work[r] -= a[r + i * ld] * solved;
        __syncwarp();
      }
    }
    __syncthreads();
    for (int i = threadIdx.x; i < j; i += blockDim.x) a[i + j * ld] = column_work[i];
    double most = -1;
    int from = m;
    for (int r = j + threadIdx.x; r < m; r += blockDim.x) {
      S sum = a[r + j * ld];
      for (int i = 0; i < j; ++i) sum -= a[r + i * ld] * column_work[i];
      a[r + j * ld] = sum;
      const double size = magnitude(sum);
      if (!(size <= most)) {
        most = size;
        from = r;
      }
    }
    const double largest = block_max(most, work.border);
    if (threadIdx.x == 0) chosen = m;
    __syncthreads();
    if (most == largest) atomicMin(&chosen, from);
    __syncthreads();
    const int row = chosen < m ? chosen : j;
    if (row != j) {
      exchange_front_rows(front, k + j, k + row);
      if (threadIdx.x == 0) {
        const Vertex held = local_row[k + j];
        local_row[k + j] = local_row[k + row];
        local_row[k + row] = held;
      }
    }
    __syncthreads();
    S pivot = a[j + j * ld];
    const double size = magnitude(pivot);
    S added = S(0);
    if (size == size && !(size >= rule.bound)) {
      // The border rows of columns left of this one are not solved for: do so for this column alone.
      const Tile<S> tile{a, static_cast<int>(ld), s, s};
      const BorderBelow<S> below{front.lower + front.pivots + k * ld, ld, front.border, column_work,
                                 work.border};
      const S accepted = replacement(pivot, below(tile, j), rule);
      added = accepted - pivot;
      pivot = accepted;
      if (threadIdx.x == 0 && magnitude(added) != 0) atomicAdd(&store.fronts.status->perturbed, 1ull);
    }
    __syncthreads();
    if (threadIdx.x == 0) {
      if (!(size <= 1.7976931348623157e308)) atomicAdd(&store.fronts.status->nonfinite, 1ull);
      a[j + j * ld] = pivot;
      if (magnitude(added) != 0) store.fronts.shift[begin + k + j] = added;
    }
    for (int r = j + 1 + threadIdx.x; r < m; r += blockDim.x) a[r + j * ld] = a[r + j * ld] / pivot;
  }
  __syncthreads();
}

template <class S, class Value>
__global__ void __launch_bounds__(kTileThreads)
    factor_diagonal_tiles(DeviceStore<S, Value> store, Offset first) {
  extern __shared__ __align__(16) unsigned char memory[];
  const StepTask task = store.steps[first + blockIdx.x];
  const Vertex f = task.front;
  const Front<S> front = store.fronts.front(f);
  const int k = task.k, s = min(kTile<S>, front.pivots - k);
  const Offset ld = front.lower_ld;
  S* const diagonal = front.lower + k + k * ld;
  TileWork<S>& work = *reinterpret_cast<TileWork<S>*>(memory);
  S* a = reinterpret_cast<S*>(memory + sizeof(TileWork<S>));
  const Tile<S> tile{a, tile_ld(kTile<S>), s, s};
  S* column_work = a + tile.ld * kTile<S>;
  int* row_at = reinterpret_cast<int*>(column_work + kTile<S>);
  const Vertex begin = store.fronts.pivot_begin[f] + k;
  if (store.strict[f]) {
    factor_strict(store, f, front, k, s, column_work, work);
    load_tile(tile, diagonal, ld);
  } else {
    if (static_cast<int>(threadIdx.x) < s) row_at[threadIdx.x] = threadIdx.x;
    load_tile(tile, diagonal, ld);
    if (k + s < front.pivots) {
      tile_lu(tile, store.rule(), UndecidedBelow<S, Value>{&store, f}, row_at, store.fronts.shift + begin,
              store.fronts.status, work);
    } else {
      const BorderBelow<S> below{front.lower + front.pivots + k * ld, ld, front.border, column_work,
                                 work.border};
      tile_lu(tile, store.rule(), below, row_at, store.fronts.shift + begin, store.fronts.status, work);
    }
    for (int i = threadIdx.x; i < s; i += blockDim.x) store.fronts.local_row[begin + i] = k + row_at[i];
  }
  invert_diagonal_blocks(tile);
  store_tile(tile, diagonal, ld);
}

// Block row `begin` of each pivot block left of it: the row exchanges that came after.
template <class S, class Value>
__global__ void exchange_block_rows(DeviceStore<S, Value> store, Offset first) {
  extern __shared__ __align__(16) unsigned char memory[];
  const FrontPart part = store.exchange[first + blockIdx.x];
  if (store.strict[part.front]) return;  // has exchanged whole rows
  const Front<S> front = store.fronts.front(part.front);
  const int s = min(kTile<S>, front.pivots - part.begin);
  const Vertex* local_row = store.fronts.local_row + store.fronts.pivot_begin[part.front] + part.begin;
  int moved = 0;
  for (int i = threadIdx.x; i < s; i += blockDim.x) moved |= local_row[i] != part.begin + i;
  if (!__syncthreads_or(moved)) return;
  S* const held = reinterpret_cast<S*>(memory);
  S* const a = front.lower + part.begin + static_cast<Offset>(part.column) * front.lower_ld;
  constexpr int kColumns = 32;
  for (int c = 0; c < kTile<S>; c += kColumns) {
    for (int i = threadIdx.x; i < s * kColumns; i += blockDim.x)
      held[i] = a[i % s + static_cast<Offset>(c + i / s) * front.lower_ld];
    __syncthreads();
    for (int i = threadIdx.x; i < s * kColumns; i += blockDim.x)
      a[i % s + static_cast<Offset>(c + i / s) * front.lower_ld] =
          held[local_row[i % s] - part.begin + i / s * s];
    __syncthreads();
  }
}

}  // namespace mfs::cuda
