// What follows the library's LU without pivoting of roots' pivot blocks: whether pivots were needed, and what
// the solve needs of their diagonal tiles.
#pragma once

#include "kernels/cuda/factor/block_lu.hpp"

namespace mfs::cuda {

/// The largest multiplier that an LU without pivoting may have: that of threshold pivoting (Duff, Erisman and
/// Reid, Direct Methods for Sparse Matrices, 2017, section 5.2).
constexpr double kMostUnpivoted = 1 / kBorderThreshold;

constexpr int kCheckThreads = 256;

template <class S>
constexpr std::size_t tile_bytes(int pivots) {
  return sizeof(S) * tile_entries(pivots);
}

template <class S, class Value>
__device__ void tell_pivots_needed(const DeviceStore<S, Value>& store, bool needed) {
  if (__syncthreads_or(needed) && threadIdx.x == 0) *store.pivots_needed = 1;
}

/// Looks at the multipliers of tiles below the diagonal.
template <class S, class Value>
__global__ void __launch_bounds__(kCheckThreads)
    check_unpivoted_tiles(DeviceStore<S, Value> store, Offset first) {
  const FrontPart part = store.unpivoted[first + blockIdx.x];
  const Front<S> front = store.fronts.front(part.front);
  const int rows = min(store.tile, front.pivots - part.begin);
  const S* const a = front.lower + part.begin + static_cast<Offset>(part.column) * front.lower_ld;
  unsigned most = 0;
  for (int i = threadIdx.x; i < store.tile * store.tile; i += kCheckThreads) {
    const int r = i % store.tile, c = i / store.tile;
    if (r < rows) most = max(most, size_bits(a[r + static_cast<Offset>(c) * front.lower_ld]));
  }
  tell_pivots_needed(store, most > bound_bits<S>(kMostUnpivoted));
}

/// Looks at pivots and multipliers of tiles on the diagonal and leaves them as factor_diagonal_tiles does, no
/// row exchanged.
template <class S, class Value>
__global__ void __launch_bounds__(kTileThreads)
    take_unpivoted_tiles(DeviceStore<S, Value> store, Offset first) {
  extern __shared__ __align__(16) unsigned char memory[];
  const FrontPart part = store.unpivoted[first + blockIdx.x];
  const Front<S> front = store.fronts.front(part.front);
  const int k = part.begin, s = min(store.tile, front.pivots - k);
  S* const diagonal = front.lower + k + static_cast<Offset>(k) * front.lower_ld;
  const Tile<S> tile{reinterpret_cast<S*>(memory), tile_ld(store.tile), s, s};
  load_tile(tile, diagonal, front.lower_ld);
  const unsigned least = bound_bits<S>(store.rule().bound), most = bound_bits<S>(kMostUnpivoted);
  bool needed = false;
  for (int i = threadIdx.x; i < s * s; i += blockDim.x) {
    const int r = i % s, c = i / s;
    const unsigned size = size_bits(tile.a[r + c * tile.ld]);
    needed |= r == c ? !(size > least && size < bound_bits<S>(HUGE_VAL)) : r > c && size > most;
  }
  tell_pivots_needed(store, needed);
  const Vertex begin = store.fronts.pivot_begin[part.front] + k;
  for (int i = threadIdx.x; i < s; i += blockDim.x) store.fronts.local_row[begin + i] = k + i;
  invert_panels(tile);
  invert_diagonal_blocks(tile, store.substitutes);
  store_tile(tile, diagonal, front.lower_ld);
}

}  // namespace mfs::cuda
