// Stage "assemble" of larger fronts on the device: each block makes some columns of a front, each of its warps a
// column at a time. Every entry is the sum of what the children have for it, in their order, and is written once;
// the original entries are added last. The shared source of the stage (kernels/assemble.hpp), which clears and
// then adds child by child, moves four times as many bytes.
#pragma once

#include "kernels/assemble.hpp"
#include "kernels/cuda/device_store.hpp"
#include "kernels/cuda/warp_tile.hpp"

namespace mfs::cuda {

constexpr int kAssembleThreads = 256;

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
      const Offset b = at.border_begin[child + 1] - at.border_begin[child];
      const S* const from = at.contribution + at.contribution_begin[child] + column * b;
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
__global__ void __launch_bounds__(kAssembleThreads) assemble_fronts(DeviceStore<S, Value> store, Offset first) {
  const FrontPart part = store.assemble[first + blockIdx.x];
  const FrontStore<S, Value>& at = store.fronts;
  const Vertex f = part.front;
  const Front<S> front = at.front(f);
  const int p = front.pivots, rows = front.rows();
  for (int j = part.begin + threadIdx.x / kWarp; j < part.other; j += kAssembleThreads / kWarp) {
    if (j < p) {
      sum_children(store, f, j, 0, rows, front.lower + j * static_cast<Offset>(rows));
    } else {
      sum_children(store, f, j, 0, p, front.upper + (j - p) * static_cast<Offset>(p));
      sum_children(store, f, j, p, rows, front.contribution + (j - p) * static_cast<Offset>(front.border));
    }
  }
  __syncthreads();
  const Offset end = part.other == rows ? at.entry_begin[f + 1] : first_entry(at, f, part.other);
  for (Offset e = first_entry(at, f, part.begin) + threadIdx.x; e < end; e += kAssembleThreads) {
    const double scale = at.row_scale[at.entry_row[e]] * at.column_scale[at.entry_column[e]];
    at.factor[at.entry_target[e]] +=
        static_cast<S>(at.matrix_values[at.entry_slot[e]] * static_cast<RealOf<Value>>(scale));
  }
}

}  // namespace mfs::cuda
