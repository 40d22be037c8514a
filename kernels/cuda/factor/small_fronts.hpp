// Small fronts on the device, one block each: the stages "assemble", "variable factor" and "variable update"
// in shared memory, the front written once.
#pragma once

#include "kernels/cuda/factor/device_store.hpp"
#include "kernels/cuda/factor/tile_lu.hpp"
#include "kernels/cuda/factor/warp_lu.hpp"
#include "kernels/cuda/runtime/early_launch.hpp"

namespace mfs::cuda {

/// What is asked for of a child before its contribution block is.
struct ListedChild {
  Offset block, map;  // from FrontStore::storage and ::border_in_parent on
  int border;
};
/// Children that are listed at a time, where the work of the pivots will be.
constexpr int kListedChildren = 32;
/// Fronts of more rows than a warp has lanes have more than one warp.
template <class S>
__host__ __device__ constexpr std::size_t small_work_bytes(int rows) {
  return rows > kWarp ? sizeof(TileWork<S>) + sizeof(PivotWork<S>) : kListedChildren * sizeof(ListedChild);
}
template <class S>
constexpr std::size_t small_front_bytes(int rows) {
  return small_work_bytes<S>(rows) +
         sizeof(S) * static_cast<std::size_t>(tile_ld(rows)) * ((rows + 15) / 16 * 16) +
         sizeof(int) * static_cast<std::size_t>(rows);
}

/// Entries of a child, and of A, that a thread asks for before it waits for the first of them.
template <class S>
constexpr int kAskedFor = sizeof(S) <= 8 ? 8 : 4;
constexpr int kAskedEntries = 4;

template <class S, class Value>
__device__ void list_children(const DeviceStore<S, Value>& store, Vertex first, int count,
                              ListedChild* listed) {
  const int c = threadIdx.x;
  if (c >= count) return;
  const Vertex child = store.fronts.children[first + c];
  const Offset begin = store.fronts.border_begin[child];
  listed[c] = {store.block_read[child], begin,
               static_cast<int>(store.fronts.border_begin[child + 1] - begin)};
}

template <class S, class Value>
__device__ void place_entries(const DeviceStore<S, Value>& store, Vertex f, const Front<S>& front,
                              const Tile<S>& tile) {
  const int p = front.pivots, rows = front.rows(), threads = blockDim.x;
  const Offset end = store.fronts.entry_begin[f + 1];
  for (Offset e = store.fronts.entry_begin[f] + threadIdx.x; e < end; e += kAskedEntries * threads) {
    S value[kAskedEntries];
    int target[kAskedEntries];
#pragma unroll
    for (int k = 0; k < kAskedEntries; ++k) {
      const Offset at = min(e + k * threads, end - 1);
      const int place = store.entry_place[at], beyond = place - p * rows;
      const int i = beyond < 0 ? place % rows : beyond % p, j = beyond < 0 ? place / rows : p + beyond / p;
      target[k] = i + j * tile.ld;
      value[k] = store.fronts.scaled_entry(at, f, i, p);
    }
#pragma unroll
    for (int k = 0; k < kAskedEntries; ++k) {
      if (e + k * threads < end) tile.a[target[k]] = value[k];
    }
  }
}

// The threads go through the block column after column. `map`: room for its rows in shared memory.
template <class S, class Value>
__device__ void add_child(const FrontStore<S, Value>& store, const ListedChild& child, const Tile<S>& tile,
                          int* map) {
  constexpr int kTogether = kAskedFor<S>;
  const int t = threadIdx.x, threads = blockDim.x, b = child.border, size = b * b;
  if (b == 0) return;
  const S* const block = store.storage + child.block;
  const int down = threads % b, right = threads / b;
  int i = t % b, j = t / b;
  for (int k = t; k < b; k += threads) map[k] = store.border_in_parent[child.map + k];
  for (int first = t; first - t < size; first += kTogether * threads) {
    S value[kTogether];
#pragma unroll
    for (int k = 0; k < kTogether; ++k) {
      const int at = first + k * threads;
      value[k] = at < size ? block[at] : S(0);
    }
    if (first == t) __syncthreads();  // the map is there
#pragma unroll
    for (int k = 0; k < kTogether; ++k) {
      if (first + k * threads < size) tile.a[map[i] + map[j] * tile.ld] += value[k];
      i += down;
      j += right;
      if (i >= b) {
        i -= b;
        ++j;
      }
    }
  }
}

// Until the children are needed, nothing is read that the kernel ahead writes, and nothing is written.
template <class S, class Value>
__device__ void assemble_in_tile(const DeviceStore<S, Value>& store, Vertex f, const Front<S>& front,
                                 const Tile<S>& tile, ListedChild* listed, int* map) {
  const FrontStore<S, Value>& at = store.fronts;
  const int rows = front.rows();
  const Vertex begin = at.child_begin[f], end = at.child_begin[f + 1];
  list_children(store, begin, min(end - begin, kListedChildren), listed);
  for (int i = threadIdx.x; i < tile.ld * rows; i += blockDim.x) tile.a[i] = S(0);
  __syncthreads();
  place_entries(store, f, front, tile);
  wait_for_kernel_ahead();
  for (Vertex first = begin; first < end; first += kListedChildren) {
    const int count = min(end - first, kListedChildren);
    if (first > begin) {
      __syncthreads();
      list_children(store, first, count, listed);
    }
    for (int c = 0; c < count; ++c) {
      __syncthreads();
      add_child(at, listed[c], tile, map);
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
#elif defined(__CUDA_ARCH__) && \
    (__CUDA_ARCH__ == 890 || __CUDA_ARCH__ / 100 == 11 || __CUDA_ARCH__ / 100 == 12)
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
  constexpr std::size_t kWork = small_work_bytes<S>(Threads);
  S* a = reinterpret_cast<S*>(memory + kWork);
  const Tile<S> tile{a, tile_ld(rows), rows, front.pivots};
  int* row_at = reinterpret_cast<int*>(a + tile.ld * ((rows + 15) / 16 * 16));
  let_kernel_behind_begin();
  assemble_in_tile(store, f, front, tile, reinterpret_cast<ListedChild*>(memory), row_at);
  if (static_cast<int>(threadIdx.x) < rows) row_at[threadIdx.x] = threadIdx.x;
  const Vertex begin = store.fronts.pivot_begin[f];
  S* const shift = store.fronts.shift + begin;
  if constexpr (Threads == kWarp) {
    __syncwarp();
    warp_lu(tile, store.rule(), row_at, shift, store.fronts.status);
    invert_triangles(tile, store.substitutes);
  } else {
    TileWork<S>& work = *reinterpret_cast<TileWork<S>*>(memory);
    static_assert(sizeof work >= kListedChildren * sizeof(ListedChild));
    tile_lu<Threads>(tile, store.rule(), store.substitutes, NoFurtherBorder(), row_at, shift,
                     store.fronts.status, work, *reinterpret_cast<PivotWork<S>*>(memory + sizeof work));
    invert_diagonal_blocks(tile, store.substitutes);
  }
  __syncthreads();
  write_tile(front, tile);
  for (int i = threadIdx.x; i < front.pivots; i += blockDim.x) store.fronts.local_row[begin + i] = row_at[i];
}

/// Launches these; `early`: the launch ahead is one of small fronts, or of what comes before all fronts.
template <class S, class Value>
void launch_small(const DeviceStore<S, Value>& store, const SmallLaunch& what, const Stream& stream,
                  bool early) {
  const auto fronts = static_cast<unsigned>(what.fronts.count());
  const std::size_t bytes = small_front_bytes<S>(what.rows);
  const auto launch = [&](unsigned threads, auto kernel) {
    launch_early(early, stream, fronts, threads, bytes, kernel, store, what.fronts.begin);
  };
  if (what.rows <= 32) {
    launch(32, &factor_small_fronts<32, 28, S, Value>);
  } else if (what.rows <= 64) {
    launch(128, &factor_small_fronts<128, 4, S, Value>);
  } else {
    launch(256, &factor_small_fronts<256, 2, S, Value>);
  }
}

}  // namespace mfs::cuda
