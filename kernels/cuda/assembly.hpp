// Stage "assemble" of larger fronts on the device: each block makes some columns of a front, each of its
// warps a piece of a column at a time. Every entry is the sum of what the children have for it, in their
// order, and is written once; the original entries are added last. The shared source of the stage
// (kernels/assemble.hpp), which clears and then adds child by child, moves four times as many bytes.
#pragma once

#include "kernels/cuda/device_store.hpp"
#include "kernels/cuda/warp_tile.hpp"

namespace mfs::cuda {

constexpr int kAssembleThreads = 256, kAssembleRows = 512;

// Rows [begin, end) of column j of a front go to to[row - begin].
template <class S, class Value>
__device__ void sum_children(const DeviceStore<S, Value>& store, Vertex f, int j, int begin, int end, S* to) {
  constexpr int kBatch = 4;  // rows per lane that are under way together
  const FrontStore<S, Value>& at = store.fronts;
  const int lane = threadIdx.x % kWarp;
  for (int first = begin + lane; first < end; first += kWarp * kBatch) {
    S sum[kBatch];
#pragma unroll
    for (int k = 0; k < kBatch; ++k) sum[k] = S(0);
    for (Vertex c = at.child_begin[f]; c < at.child_begin[f + 1]; ++c) {
      const Vertex* const rows = store.child_row + store.child_row_begin[c];
      const int column = rows[j];
      if (column < 0) continue;
      const Vertex child = at.children[c];
      const Vertex b = static_cast<Vertex>(at.border_begin[child + 1] - at.border_begin[child]);
      const S* const from =
          at.storage + at.contribution_begin[child] + column * static_cast<Offset>(leading_dimension(b));
      int row[kBatch];
#pragma unroll
      for (int k = 0; k < kBatch; ++k) row[k] = first + k * kWarp < end ? rows[first + k * kWarp] : -1;
#pragma unroll
      for (int k = 0; k < kBatch; ++k) {
        if (row[k] >= 0) sum[k] += from[row[k]];
      }
    }
#pragma unroll
    for (int k = 0; k < kBatch; ++k) {
      if (first + k * kWarp < end) to[first + k * kWarp - begin] = sum[k];
    }
  }
}

template <class S, class Value>
__global__ void __launch_bounds__(kAssembleThreads)
    assemble_fronts(DeviceStore<S, Value> store, Offset first) {
  const AssemblyPart part = store.assemble[first + blockIdx.x];
  const FrontStore<S, Value>& at = store.fronts;
  const Vertex f = part.front;
  const Front<S> front = at.front(f);
  const int p = front.pivots, columns = part.end - part.begin;
  S* block = front.lower;
  Offset ld = front.lower_ld;
  if (part.begin >= p) {
    const bool pivots = part.first_row < p;
    ld = pivots ? p : front.contribution_ld;
    block = (pivots ? front.upper : front.contribution) - p * ld - part.first_row;
  }
  const int pieces = (part.last_row - part.first_row + kAssembleRows - 1) / kAssembleRows;
  for (int task = threadIdx.x / kWarp; task < columns * pieces; task += kAssembleThreads / kWarp) {
    const int j = part.begin + task % columns, begin = part.first_row + task / columns * kAssembleRows;
    sum_children(store, f, j, begin, min(begin + kAssembleRows, part.last_row), block + j * ld + begin);
  }
  __syncthreads();
  S* const first_column = block + part.begin * ld;
  for (Offset e = part.first_entry + threadIdx.x; e < part.last_entry; e += kAssembleThreads) {
    const int place = store.entry_place[e];
    first_column[place] += store.scaled_entry(e, f, place % static_cast<int>(ld), p);
  }
}

}  // namespace mfs::cuda
