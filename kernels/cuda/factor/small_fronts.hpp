// Small fronts on the device, one block each: the stages "assemble", "variable factor" and "variable update"
// in shared memory, the front written once.
#pragma once

#include "kernels/cuda/factor/device_store.hpp"
#include "kernels/cuda/factor/tile_lu.hpp"

namespace mfs::cuda {

/// Fronts of more rows than a warp has lanes have more than one warp.
template <class S>
constexpr std::size_t small_front_bytes(int rows) {
  return sizeof(TileWork<S>) + (rows > kWarp ? sizeof(PivotWork<S>) : 0) +
         sizeof(S) * static_cast<std::size_t>(tile_ld(rows)) * ((rows + 15) / 16 * 16) +
         sizeof(int) * static_cast<std::size_t>(rows);
}

template <class S, class Value>
__device__ void assemble_in_tile(const DeviceStore<S, Value>& store, Vertex f, const Front<S>& front,
                                 const Tile<S>& tile) {
  const FrontStore<S, Value>& at = store.fronts;
  const int p = front.pivots, rows = front.rows();
  for (int i = threadIdx.x; i < tile.ld * rows; i += blockDim.x) tile.a[i] = S(0);
  __syncthreads();
  for (Offset e = at.entry_begin[f] + threadIdx.x; e < at.entry_begin[f + 1]; e += blockDim.x) {
    const int place = store.entry_place[e], beyond = place - p * rows;
    const int i = beyond < 0 ? place % rows : beyond % p, j = beyond < 0 ? place / rows : p + beyond / p;
    tile.a[i + j * tile.ld] = store.fronts.scaled_entry(e, f, i, p);
  }
  const int lane = threadIdx.x % kWarp, warp = threadIdx.x / kWarp, warps = blockDim.x / kWarp;
  for (Vertex c = at.child_begin[f]; c < at.child_begin[f + 1]; ++c) {
    __syncthreads();
    const Vertex child = at.children[c];
    const Vertex* map = at.border_in_parent + at.border_begin[child];
    const int b = static_cast<int>(at.border_begin[child + 1] - at.border_begin[child]);
    const S* block = at.storage + store.block_read[child];
    for (int j = warp; j < b; j += warps) {
      S* column = tile.a + map[j] * tile.ld;
      for (int i = lane; i < b; i += kWarp) column[map[i]] += block[i + static_cast<Offset>(j) * b];
    }
  }
  __syncthreads();
}

template <class S>
__device__ void write_tile(const Front<S>& front, const Tile<S>& tile) {
  const int p = front.pivots, b = front.border, rows = p + b;
  const int lane = threadIdx.x % kWarp, warp = threadIdx.x / kWarp, warps = blockDim.x / kWarp;
  for (int j = warp; j < rows; j += warps) {
    const S* column = tile.a + j * tile.ld;
    if (j < p) {
      for (int i = lane; i < rows; i += kWarp) front.lower[i + j * rows] = column[i];
    } else {
      for (int i = lane; i < p; i += kWarp) front.upper[i + (j - p) * p] = column[i];
      for (int i = lane; i < b; i += kWarp) front.contribution[i + (j - p) * b] = column[p + i];
    }
  }
}

/// Blocks that a multiprocessor can hold: the compiler says so where it is asked for more.
#if defined(__CUDA_ARCH__) && (__CUDA_ARCH__ >= 860 && __CUDA_ARCH__ <= 880)
constexpr int kMostBlocks = 16;
#elif defined(__CUDA_ARCH__) && (__CUDA_ARCH__ == 890 || __CUDA_ARCH__ / 100 == 11 || __CUDA_ARCH__ / 100 == 12)
constexpr int kMostBlocks = 24;
#else
constexpr int kMostBlocks = 32;
#endif

/// Threads by the number of rows, and how many blocks a multiprocessor should hold.
template <int Threads, int Blocks, class S, class Value>
__global__ void __launch_bounds__(Threads, Blocks < kMostBlocks ? Blocks : kMostBlocks)
    factor_small_fronts(DeviceStore<S, Value> store, Offset first) {
  extern __shared__ __align__(16) unsigned char memory[];
  const Vertex f = store.small_fronts[first + blockIdx.x];
  const Front<S> front = store.fronts.front(f);
  const int rows = front.rows();
  TileWork<S>& work = *reinterpret_cast<TileWork<S>*>(memory);
  PivotWork<S>* pivot_work = reinterpret_cast<PivotWork<S>*>(memory + sizeof(TileWork<S>));
  S* a = reinterpret_cast<S*>(pivot_work + (Threads > kWarp ? 1 : 0));
  const Tile<S> tile{a, tile_ld(rows), rows, front.pivots};
  int* row_at = reinterpret_cast<int*>(a + tile.ld * ((rows + 15) / 16 * 16));
  if (static_cast<int>(threadIdx.x) < rows) row_at[threadIdx.x] = threadIdx.x;
  assemble_in_tile(store, f, front, tile);
  const Vertex begin = store.fronts.pivot_begin[f];
  tile_lu<Threads>(tile, store.rule(), store.substitutes, NoFurtherBorder(), row_at,
                   store.fronts.shift + begin, store.fronts.status, work, pivot_work);
  invert_diagonal_blocks(tile, store.substitutes);
  __syncthreads();
  write_tile(front, tile);
  for (int i = threadIdx.x; i < front.pivots; i += blockDim.x) store.fronts.local_row[begin + i] = row_at[i];
}

}  // namespace mfs::cuda
