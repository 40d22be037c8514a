// The diagonal tile of each larger front at one step of its factorization, one block per front.
#pragma once

#include "kernels/cuda/factor/device_store.hpp"
#include "kernels/cuda/factor/strict_panel.hpp"
#include "kernels/cuda/factor/tile_lu.hpp"
#include "kernels/cuda/runtime/async_copy.hpp"

namespace mfs::cuda {

constexpr int kTileThreads = 256;

/// A tile of up to so many pivots has half the threads, so that a multiprocessor holds more of them.
template <class S>
constexpr int kNarrowTile = kTile<S> / 2;
constexpr int kNarrowThreads = kTileThreads / 2;

/// Entries of a tile of so many pivots in shared memory.
__host__ __device__ constexpr int tile_entries(int pivots) {
  return tile_ld(pivots) * ((pivots + 15) / 16 * 16);
}
/// Of a tile, and of the panels of a strict front in its place.
template <class S>
__host__ __device__ constexpr int block_lu_entries(int pivots) {
  const int tile = tile_entries(pivots), panels = kPanelColumns * (kTile<S> + pivots);
  return tile > panels ? tile : panels;
}
template <class S>
constexpr std::size_t block_lu_bytes(int pivots) {
  constexpr int tile = kTile<S>;
  return sizeof(TileWork<S>) + sizeof(PivotWork<S>) + sizeof(S) * (block_lu_entries<S>(pivots) + tile) +
         sizeof(int) * tile;
}

// A tile that leaves out pivot rows below it does not decide about a small pivot: its front becomes strict,
// and is factored again.
template <class S, class Value>
struct UndecidedBelow {
  const DeviceStore<S, Value>* store;
  Vertex front;
  template <class T>
  __device__ double operator()(const T&, int, const PivotPlaces&) const {
    if (threadIdx.x == 0) store->make_strict(front);
    return 0;
  }
};

template <class S>
__device__ void load_tile(const Tile<S>& tile, const S* from, Offset ld) {
  const int lane = threadIdx.x % kWarp, warp = threadIdx.x / kWarp, warps = blockDim.x / kWarp;
  constexpr int kTogether = 16 / sizeof(S);  // entries of 16 bytes
  if (tile.rows % kTogether == 0 && ld % kTogether == 0 && reinterpret_cast<std::size_t>(from) % 16 == 0) {
    for (int c = warp; c < tile.rows; c += warps) {
      for (int r = kTogether * lane; r < tile.rows; r += kTogether * kWarp)
        copy_async<16>(shared_address(tile.a + r + c * tile.ld), from + r + c * ld);
    }
  } else {
    for (int c = warp; c < tile.rows; c += warps) {
      for (int r = lane; r < tile.rows; r += kWarp)
        copy_async<sizeof(S)>(shared_address(tile.a + r + c * tile.ld), from + r + c * ld);
    }
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

/// Of the factorization before and what it found.
__global__ inline void settle_strict_fronts(int* strict, int fronts, const int* found_strict) {
  const int f = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  if (f < fronts && strict[f] != 0) strict[f] = settled_state(strict[f], *found_strict > 0);
}
/// Counts those that will be strict in the next factorization, if this one need not be repeated, and the tall
/// ones of them.
template <class S, class Value>
__global__ void count_strict_fronts(DeviceStore<S, Value> store, int fronts, int* count, int* tall) {
  const int f = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  if (f >= fronts || !(settled_state(store.strict[f], false) & kStrict)) return;
  atomicAdd(count, 1);
  if (store.fronts.front(f).pivots > store.tall) atomicAdd(tall, 1);
}

/// Tiles of at most Pivots pivots.
template <int Pivots, int Threads, class S, class Value>
__global__ void __launch_bounds__(Threads) factor_diagonal_tiles(DeviceStore<S, Value> store, Offset first) {
  extern __shared__ __align__(16) unsigned char memory[];
  const StepTask task = store.steps[first + blockIdx.x];
  const Vertex f = task.front;
  const Front<S> front = store.fronts.front(f);
  const int k = task.k, s = min(store.tile, front.pivots - k);
  const Offset ld = front.lower_ld;
  S* const diagonal = front.lower + k + k * ld;
  TileWork<S>& work = *reinterpret_cast<TileWork<S>*>(memory);
  PivotWork<S>& pivot_work = *reinterpret_cast<PivotWork<S>*>(memory + sizeof(TileWork<S>));
  S* a = reinterpret_cast<S*>(&pivot_work + 1);
  const Tile<S> tile{a, tile_ld(Pivots), s, s};
  constexpr int entries = block_lu_entries<S>(Pivots);
  S* column_work = a + entries;
  int* row_at = reinterpret_cast<int*>(column_work + kTile<S>);
  const Vertex begin = store.fronts.pivot_begin[f] + k;
  if (store.is_strict(f)) {
    if (!store.goes_by_panels(f, front.pivots))
      factor_strict_column(store, f, front, k, s, a, entries, column_work, work);
    load_tile(tile, diagonal, ld);
    invert_panels(tile);
  } else {
    if (static_cast<int>(threadIdx.x) < s) row_at[threadIdx.x] = threadIdx.x;
    load_tile(tile, diagonal, ld);
    if (k + s < front.pivots) {
      tile_lu<Threads>(tile, store.tile_rule(), store.substitutes, UndecidedBelow<S, Value>{&store, f},
                       row_at, store.fronts.shift + begin, store.fronts.status, work, pivot_work);
    } else {
      const BorderBelow<S> below{front.lower + front.pivots + k * ld, ld, front.border, column_work,
                                 work.border};
      tile_lu<Threads>(tile, store.tile_rule(), store.substitutes, below, row_at, store.fronts.shift + begin,
                       store.fronts.status, work, pivot_work);
    }
    for (int i = threadIdx.x; i < s; i += blockDim.x) store.fronts.local_row[begin + i] = k + row_at[i];
  }
  invert_diagonal_blocks(tile, store.substitutes);
  store_tile(tile, diagonal, ld);
}

// Block row `begin` of each pivot block left of it: the row exchanges that came after.
template <class S, class Value>
__global__ void exchange_block_rows(DeviceStore<S, Value> store, Offset first) {
  extern __shared__ __align__(16) unsigned char memory[];
  const FrontPart part = store.exchange[first + blockIdx.x];
  if (store.is_strict(part.front)) return;  // has exchanged whole rows
  const Front<S> front = store.fronts.front(part.front);
  const int s = min(store.tile, front.pivots - part.begin);
  const Vertex* local_row = store.fronts.local_row + store.fronts.pivot_begin[part.front] + part.begin;
  int moved = 0;
  for (int i = threadIdx.x; i < s; i += blockDim.x) moved |= local_row[i] != part.begin + i;
  if (!__syncthreads_or(moved)) return;
  S* const held = reinterpret_cast<S*>(memory);
  S* const a = front.lower + part.begin + static_cast<Offset>(part.column) * front.lower_ld;
  constexpr int kColumns = 32;
  for (int c = 0; c < store.tile; c += kColumns) {
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
