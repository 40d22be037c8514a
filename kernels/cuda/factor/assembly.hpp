// Stage "assemble" of larger fronts on the device: each block makes some columns of a front, each of its
// warps a piece of a column at a time. Every entry is the sum of what the children have for it, in their
// order, and is written once; the original entries are added last. The shared source of the stage
// (kernels/stages/assemble.hpp), which clears and then adds child by child, moves four times as many bytes.
#pragma once

#include "kernels/cuda/factor/device_store.hpp"
#include "kernels/cuda/factor/warp_tile.hpp"

namespace mfs::cuda {

constexpr int kAssembleThreads = 256;
/// What a warp makes at a time: one look at a child's row map serves all of its columns.
constexpr int kPieceRows = 64, kPieceColumns = 4;

template <int N>
__device__ bool any_of(const int (&places)[N]) {
  bool any = false;
#pragma unroll
  for (int i = 0; i < N; ++i) any |= places[i] >= 0;
  return any;
}

// Rows [begin, end) of columns [first, last) of a front, a piece at most; the entry in row i of column j goes
// to to[i + j * ld], and is that of row row_at(i) of what the children have.
template <class S, class Value, class RowAt>
__device__ void sum_children(const DeviceStore<S, Value>& store, Vertex f, int first, int last, int begin,
                             int end, S* to, Offset ld, const RowAt& row_at) {
  constexpr int kRows = kPieceRows / kWarp;
  const FrontStore<S, Value>& at = store.fronts;
  const int lane = threadIdx.x % kWarp;
  S sum[kPieceColumns][kRows];
#pragma unroll
  for (int k = 0; k < kPieceColumns; ++k) {
#pragma unroll
    for (int r = 0; r < kRows; ++r) sum[k][r] = S(0);
  }
  const Vertex children_end = at.child_begin[f + 1];
  for (Vertex c = at.child_begin[f]; c < children_end; c += kWarp) {
    // Each lane looks for one child, so that the warp waits once.
    const int count = min(kWarp, static_cast<int>(children_end - c));
    Offset block = 0, map = 0;
    int block_ld = 0;
    if (lane < count) {
      const Vertex child = at.children[c + lane];
      block = store.block_read[child];
      block_ld = leading_dimension(static_cast<Vertex>(at.border_begin[child + 1] - at.border_begin[child]));
      map = store.child_row_begin[c + lane];
    }
    for (int i = 0; i < count; ++i) {
      const S* const from = at.storage + __shfl_sync(0xffffffffu, block, i);
      const Vertex* const rows = store.child_row + __shfl_sync(0xffffffffu, map, i);
      const Offset from_ld = __shfl_sync(0xffffffffu, block_ld, i);
      int column[kPieceColumns], row[kRows];
#pragma unroll
      for (int k = 0; k < kPieceColumns; ++k) column[k] = first + k < last ? rows[first + k] : -1;
#pragma unroll
      for (int r = 0; r < kRows; ++r) {
        const int place = begin + lane + r * kWarp;
        row[r] = place < end ? rows[row_at(place)] : -1;
      }
      if (!any_of(column) || !__any_sync(0xffffffffu, any_of(row))) continue;
      S value[kPieceColumns][kRows];  // all are asked for before the first is added
#pragma unroll
      for (int k = 0; k < kPieceColumns; ++k) {
#pragma unroll
        for (int r = 0; r < kRows; ++r)
          value[k][r] = column[k] >= 0 && row[r] >= 0 ? from[row[r] + column[k] * from_ld] : S(0);
      }
#pragma unroll
      for (int k = 0; k < kPieceColumns; ++k) {
#pragma unroll
        for (int r = 0; r < kRows; ++r) sum[k][r] += value[k][r];
      }
    }
  }
#pragma unroll
  for (int k = 0; k < kPieceColumns; ++k) {
#pragma unroll
    for (int r = 0; r < kRows; ++r) {
      const int place = begin + lane + r * kWarp;
      if (first + k < last && place < end) to[place + (first + k) * ld] = sum[k][r];
    }
  }
}

template <bool Divided, class S, class Value>
__device__ void assemble_part(const DeviceStore<S, Value>& store, const AssemblyPart& part) {
  const FrontStore<S, Value>& at = store.fronts;
  const Vertex f = part.front;
  const Front<S> front = at.front(f);
  const int p = front.pivots, columns = part.end - part.begin;
  const bool of_upper = part.begin >= p && part.first_row < p;
  const Offset ld = part.begin < p ? front.lower_ld : of_upper ? p : front.contribution_ld;
  S* const block = at.storage + part.place;
  const bool exchanged = Divided && of_upper && store.is_divided(f) && store.is_strict(f);
  const Vertex begin = at.pivot_begin[f];
  const auto row_at = [&](int i) -> int { return exchanged ? at.local_row[begin + i] : i; };
  const int down = (part.last_row - part.first_row + kPieceRows - 1) / kPieceRows;
  const int pieces = down * ((columns + kPieceColumns - 1) / kPieceColumns);
  for (int piece = threadIdx.x / kWarp; piece < pieces; piece += kAssembleThreads / kWarp) {
    const int j = part.begin + piece / down * kPieceColumns, i = part.first_row + piece % down * kPieceRows;
    sum_children(store, f, j, min(j + kPieceColumns, part.end), i, min(i + kPieceRows, part.last_row), block,
                 ld, row_at);
  }
  __syncthreads();
  S* const first_column = block + part.begin * ld;
  for (Offset e = part.first_entry + threadIdx.x; e < part.last_entry; e += kAssembleThreads) {
    const int place = store.entry_place[e], row = place % static_cast<int>(ld);
    const int to = exchanged ? place - row + store.row_place[begin + row] : place;
    first_column[to] += store.fronts.scaled_entry(e, f, row, p);
  }
}

/// `Divided`: there are fronts whose U is assembled when their pivots are known. In strict ones its rows come
/// exchanged, as those of [P; L] are. As many blocks as parts, or fewer, which take one after the other.
template <bool Divided, class S, class Value>
__global__ void __launch_bounds__(kAssembleThreads)
    assemble_fronts(DeviceStore<S, Value> store, Offset first, Offset end) {
  for (Offset part = first + blockIdx.x; part < end; part += gridDim.x)
    assemble_part<Divided>(store, store.assemble[part]);
}

/// Notes for a divided front where its rows are once all pivots are known.
template <class S, class Value>
__global__ void follow_exchanges(DeviceStore<S, Value> store, Vertex f) {
  const FrontStore<S, Value>& at = store.fronts;
  const Vertex begin = at.pivot_begin[f], pivots = at.pivot_begin[f + 1] - begin;
  const int i = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  if (i < pivots) store.row_place[begin + at.local_row[begin + i]] = i;
}

}  // namespace mfs::cuda
