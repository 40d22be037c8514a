// Stage "solve" on the device, one launch per depth and direction, in tiles of 64 rows of a front (of 64 columns
// where the factor is used transposed). The block of a tile of pivots waits, in device memory, for those tiles of
// its front that it depends on; they belong to blocks with smaller numbers, so none waits for one that has not
// begun. Each sum is made by one block in one order.
//
//   forward     y_i = L_ii^-1 (v_i + what the children left - sum_{j<i} L_ij y_j);  border: z = what the children
//               left - L y
//   backward    x_i = U_ii^-1 (y_i - U x(border) - sum_{j>i} U_ij x_j)
//
// The transposed system takes U^T forward and L^T backward, and undoes the row exchanges at the end.
#pragma once

#include "kernels/cuda/device_store.hpp"
#include "kernels/cuda/tile_lu.hpp"

namespace mfs::cuda {

constexpr int kSolveThreads = 256;

/// Vectors of one solve in elimination order; `border` holds one value per border row of every front.
template <class S>
struct DeviceVectors {
  int columns;  // at most the K of the kernel
  Offset n, borders;
  S* v;       // n x columns
  S* y;       // n x columns
  S* border;  // borders x columns
  int* done;  // by tile of pivots: whether this pass has left its result
};

/// One tile of a front in the pass that is under way.
template <class S>
struct SolveTile {
  Front<S> front;
  Offset ld;
  int begin, width;  // its rows (or columns) of the front
  bool pivots;       // whether it holds pivots
};

template <class S, class Value>
__device__ SolveTile<S> solve_tile(const FrontStore<S, Value>& fronts, const FrontPart& part) {
  SolveTile<S> tile;
  tile.front = fronts.front(part.front);
  tile.ld = tile.front.rows();
  tile.begin = part.begin;
  tile.pivots = part.begin < tile.front.pivots;
  tile.width = min(kSolveTile, (tile.pivots ? tile.front.pivots : tile.front.rows()) - part.begin);
  return tile;
}

// Columns (or rows) [begin, begin + count) of the factor beside the tile, count <= 64, seen as a 64 x 64 matrix
// B(row, k) that multiplies the vector's part at `begin`:
//   rows contiguous   B(row, k) = base[row + k * ld]
//   transposed        B(row, k) = base[k + row * ld]
template <class S>
struct Panel {
  const S* base;
  Offset ld;
};

template <class S, int K>
struct TileSums {
  // Plain: thread = row + 64 * group, group takes every fourth column. Transposed: each warp takes 8 rows, lanes
  // run along k.
  static constexpr int kGroups = kSolveThreads / kSolveTile;
  static constexpr int kLoads = kSolveTile / kGroups;
  static constexpr int kRowsPerWarp = kSolveTile / (kSolveThreads / kWarp);

  S loaded[kLoads];
  S sum[K];                      // plain
  S row_sum[kRowsPerWarp][K];    // transposed

  __device__ void clear() {
#pragma unroll
    for (int c = 0; c < K; ++c) {
      sum[c] = S(0);
#pragma unroll
      for (int r = 0; r < kRowsPerWarp; ++r) row_sum[r][c] = S(0);
    }
  }

  template <bool Transposed>
  __device__ void load(const Panel<S>& panel, int width, int count) {
    const int t = threadIdx.x;
    if constexpr (!Transposed) {
      const int row = t % kSolveTile, group = t / kSolveTile;
#pragma unroll
      for (int i = 0; i < kLoads; ++i) {
        const int k = group + i * kGroups;
        loaded[i] = row < width && k < count ? panel.base[row + k * panel.ld] : S(0);
      }
    } else {
      const int lane = t % kWarp, first = t / kWarp * kRowsPerWarp;
#pragma unroll
      for (int r = 0; r < kRowsPerWarp; ++r) {
#pragma unroll
        for (int h = 0; h < 2; ++h) {
          const int k = lane + h * kWarp;
          loaded[2 * r + h] = first + r < width && k < count ? panel.base[k + (first + r) * panel.ld] : S(0);
        }
      }
    }
  }

  // x: 64 x K in shared memory, zero beyond count.
  template <bool Transposed>
  __device__ void multiply(const S* x) {
    const int t = threadIdx.x;
    if constexpr (!Transposed) {
      const int group = t / kSolveTile;
#pragma unroll
      for (int i = 0; i < kLoads; ++i) {
#pragma unroll
        for (int c = 0; c < K; ++c) sum[c] += loaded[i] * x[(group + i * kGroups) * K + c];
      }
    } else {
      const int lane = t % kWarp;
#pragma unroll
      for (int r = 0; r < kRowsPerWarp; ++r) {
#pragma unroll
        for (int h = 0; h < 2; ++h) {
#pragma unroll
          for (int c = 0; c < K; ++c) row_sum[r][c] += loaded[2 * r + h] * x[(lane + h * kWarp) * K + c];
        }
      }
    }
  }

  // result (64 x K, shared memory) -= the sums; `parts` is 256 x K of work. Ends with a barrier.
  template <bool Transposed>
  __device__ void subtract_from(S* result, S* parts) {
    const int t = threadIdx.x;
    if constexpr (!Transposed) {
#pragma unroll
      for (int c = 0; c < K; ++c) parts[t * K + c] = sum[c];
      __syncthreads();
      for (int i = t; i < kSolveTile * K; i += kSolveThreads) {
        S total = parts[i];
#pragma unroll
        for (int g = 1; g < kGroups; ++g) total += parts[i + g * kSolveTile * K];
        result[i] -= total;
      }
    } else {
      const int lane = t % kWarp, first = t / kWarp * kRowsPerWarp;
#pragma unroll
      for (int r = 0; r < kRowsPerWarp; ++r) {
#pragma unroll
        for (int c = 0; c < K; ++c) {
          const S total = warp_sum(row_sum[r][c]);
          if (lane == 0) result[(first + r) * K + c] -= total;
        }
      }
    }
    __syncthreads();
  }
};

__device__ inline void wait_for(const int* done) {
  if (threadIdx.x == 0) {
    int is_done;
    do {
      asm volatile("ld.acquire.gpu.s32 %0, [%1];" : "=r"(is_done) : "l"(done) : "memory");
    } while (!is_done);
  }
  __syncthreads();
}
__device__ inline void mark(int* done) {
  __threadfence();
  __syncthreads();
  if (threadIdx.x == 0) atomicExch(done, 1);
}

// result := T^-1 result for the diagonal tile T whose 32 x 32 blocks are inverted. Upper: U (or L^T), from the
// last block on; lower: L (or U^T). T(i, j) = at[i + j * ld], or at[j + i * ld] where transposed.
template <bool Upper, bool Transposed, bool Unit, int K, class S>
__device__ void solve_diagonal(const S* t, S* result, S* work, int width) {
  constexpr int ld = kSolveTile + 1;
  const auto entry = [&](int i, int j) { return Transposed ? t[j + i * ld] : t[i + j * ld]; };
  const int blocks = (width + kInverted - 1) / kInverted;
  for (int step = 0; step < blocks; ++step) {
    const int block = Upper ? blocks - 1 - step : step, begin = block * kInverted;
    const int end = min(begin + kInverted, width);
    if (step > 0) {  // the other block is done
      const int from = Upper ? kInverted : 0, to = Upper ? width : kInverted;
      for (int i = threadIdx.x; i < (end - begin) * K; i += kSolveThreads) {
        const int r = begin + i / K, c = i % K;
        S sum = result[r * K + c];
        for (int k = from; k < to; ++k) sum -= entry(r, k) * result[k * K + c];
        work[i] = sum;
      }
      __syncthreads();
      for (int i = threadIdx.x; i < (end - begin) * K; i += kSolveThreads) result[begin * K + i] = work[i];
      __syncthreads();
    }
    for (int i = threadIdx.x; i < (end - begin) * K; i += kSolveThreads) {
      const int r = begin + i / K, c = i % K;
      const int from = Upper ? (Unit ? r + 1 : r) : begin, to = Upper ? end : (Unit ? r : r + 1);
      S sum = Unit ? result[r * K + c] : S(0);
      for (int k = from; k < to; ++k) sum += entry(r, k) * result[k * K + c];
      work[i] = sum;
    }
    __syncthreads();
    for (int i = threadIdx.x; i < (end - begin) * K; i += kSolveThreads) result[begin * K + i] = work[i];
    __syncthreads();
  }
}

template <class S, int K>
constexpr std::size_t substitution_bytes() {
  return sizeof(S) * ((kSolveTile + 1) * kSolveTile + 2 * kSolveTile * K + kSolveThreads * K);
}

// Shared memory of both passes.
template <class S, int K>
struct SolveShared {
  S *diagonal, *result, *x, *parts;
  __device__ explicit SolveShared(void* memory) {
    diagonal = static_cast<S*>(memory);
    result = diagonal + (kSolveTile + 1) * kSolveTile;
    x = result + kSolveTile * K;
    parts = x + kSolveTile * K;
  }
  __device__ void load_diagonal(const SolveTile<S>& tile) {
    const S* from = tile.front.lower + tile.begin + tile.begin * tile.ld;
    for (int i = threadIdx.x; i < tile.width * tile.width; i += kSolveThreads) {
      const int r = i % tile.width, c = i / tile.width;
      diagonal[r + c * (kSolveTile + 1)] = from[r + c * tile.ld];
    }
  }
  // x := `count` rows of `from`, column stride `stride`; zero beyond.
  __device__ void load_x(const S* from, Offset stride, int columns, int count) {
    for (int i = threadIdx.x; i < kSolveTile * K; i += kSolveThreads) {
      const int r = i % kSolveTile, c = i / kSolveTile;
      x[r * K + c] = r < count && c < columns ? load_shared(from + r + c * stride) : S(0);
    }
    __syncthreads();
  }
};

template <bool Transposed, int K, class S, class Value>
__global__ void __launch_bounds__(kSolveThreads)
    substitute_forward(DeviceStore<S, Value> store, DeviceVectors<S> vectors, Offset first) {
  extern __shared__ __align__(16) unsigned char memory[];
  SolveShared<S, K> shared(memory);
  const FrontPart part = store.solve[first + blockIdx.x];
  const SolveTile<S> tile = solve_tile(store.fronts, part);
  const Front<S>& front = tile.front;
  const Offset pivots_at = store.fronts.pivot_begin[part.front], border_at = store.fronts.border_begin[part.front];
  int* const done = vectors.done + pivots_at;  // tile i of the front at place 64 i
  if (tile.pivots) shared.load_diagonal(tile);
  for (int i = threadIdx.x; i < kSolveTile * K; i += kSolveThreads) {
    const int r = i % kSolveTile, c = i / kSolveTile;
    S value = S(0);
    if (r < tile.width && c < vectors.columns) {
      int row = tile.begin + r;
      if (tile.pivots) {
        if (!Transposed) row = store.fronts.local_row[pivots_at + row];
        value = vectors.v[pivots_at + row + c * vectors.n];
      }
      const Offset place = store.row_begin[part.front] + row;
      for (Offset s = store.source_begin[place]; s < store.source_begin[place + 1]; ++s)
        value += vectors.border[store.source[s] + c * vectors.borders];
    }
    shared.result[r * K + c] = value;
  }
  TileSums<S, K> sums;
  sums.clear();
  const int before = tile.pivots ? tile.begin : front.pivots;
  for (int k = 0; k < before; k += kSolveTile) {
    const int count = min(kSolveTile, before - k);
    Panel<S> panel;
    if (!Transposed) {
      panel = {front.lower + tile.begin + k * tile.ld, tile.ld};
    } else if (tile.pivots) {
      panel = {front.lower + k + tile.begin * tile.ld, tile.ld};
    } else {
      panel = {front.upper + k + static_cast<Offset>(tile.begin - front.pivots) * front.pivots, front.pivots};
    }
    sums.template load<Transposed>(panel, tile.width, count);
    wait_for(done + k);
    shared.load_x(vectors.y + pivots_at + k, vectors.n, vectors.columns, count);
    sums.template multiply<Transposed>(shared.x);
    __syncthreads();
  }
  __syncthreads();
  if (before > 0) sums.template subtract_from<Transposed>(shared.result, shared.parts);
  if (tile.pivots) {
    solve_diagonal<false, Transposed, !Transposed, K>(shared.diagonal, shared.result, shared.parts, tile.width);
  }
  S* const to = tile.pivots ? vectors.y + pivots_at + tile.begin : vectors.border + border_at + tile.begin - front.pivots;
  const Offset stride = tile.pivots ? vectors.n : vectors.borders;
  for (int i = threadIdx.x; i < tile.width * vectors.columns; i += kSolveThreads) {
    const int r = i % tile.width, c = i / tile.width;
    to[r + c * stride] = shared.result[r * K + c];
  }
  if (tile.pivots) mark(done + tile.begin);
}

template <bool Transposed, int K, class S, class Value>
__global__ void __launch_bounds__(kSolveThreads)
    substitute_backward(DeviceStore<S, Value> store, DeviceVectors<S> vectors, Offset first) {
  extern __shared__ __align__(16) unsigned char memory[];
  SolveShared<S, K> shared(memory);
  const FrontPart part = store.solve[first + blockIdx.x];
  const SolveTile<S> tile = solve_tile(store.fronts, part);
  const Front<S>& front = tile.front;
  const Offset pivots_at = store.fronts.pivot_begin[part.front], border_at = store.fronts.border_begin[part.front];
  int* const done = vectors.done + pivots_at;
  shared.load_diagonal(tile);
  for (int i = threadIdx.x; i < kSolveTile * K; i += kSolveThreads) {
    const int r = i % kSolveTile, c = i / kSolveTile;
    const bool inside = r < tile.width && c < vectors.columns;
    shared.result[r * K + c] = inside ? vectors.y[pivots_at + tile.begin + r + c * vectors.n] : S(0);
  }
  __syncthreads();
  TileSums<S, K> sums;
  sums.clear();
  for (int k = 0; k < front.border; k += kSolveTile) {
    const int count = min(kSolveTile, front.border - k);
    const Panel<S> panel =
        Transposed ? Panel<S>{front.lower + front.pivots + k + tile.begin * tile.ld, tile.ld}
                   : Panel<S>{front.upper + tile.begin + static_cast<Offset>(k) * front.pivots, front.pivots};
    sums.template load<Transposed>(panel, tile.width, count);
    for (int i = threadIdx.x; i < kSolveTile * K; i += kSolveThreads) {
      const int r = i % kSolveTile, c = i / kSolveTile;
      shared.x[r * K + c] = r < count && c < vectors.columns
                                ? vectors.border[border_at + k + r + c * vectors.borders]
                                : S(0);
    }
    __syncthreads();
    sums.template multiply<Transposed>(shared.x);
    __syncthreads();
  }
  for (int k = (front.pivots - 1) / kSolveTile * kSolveTile; k > tile.begin; k -= kSolveTile) {
    const int count = min(kSolveTile, front.pivots - k);
    const Panel<S> panel = Transposed ? Panel<S>{front.lower + k + tile.begin * tile.ld, tile.ld}
                                      : Panel<S>{front.lower + tile.begin + k * tile.ld, tile.ld};
    sums.template load<Transposed>(panel, tile.width, count);
    wait_for(done + k);
    shared.load_x(vectors.y + pivots_at + k, vectors.n, vectors.columns, count);
    sums.template multiply<Transposed>(shared.x);
    __syncthreads();
  }
  sums.template subtract_from<Transposed>(shared.result, shared.parts);
  solve_diagonal<true, Transposed, Transposed, K>(shared.diagonal, shared.result, shared.parts, tile.width);
  for (int i = threadIdx.x; i < tile.width * vectors.columns; i += kSolveThreads) {
    const int r = i % tile.width, c = i / tile.width;
    const S value = shared.result[r * K + c];
    const int row = Transposed ? store.fronts.local_row[pivots_at + tile.begin + r] : tile.begin + r;
    vectors.y[pivots_at + tile.begin + r + c * vectors.n] = value;
    vectors.v[pivots_at + row + c * vectors.n] = value;
  }
  mark(done + tile.begin);
}

// border := v at the border rows of the fronts of a depth, before their backward pass.
template <class S, class Value>
__global__ void gather_border(DeviceStore<S, Value> store, DeviceVectors<S> vectors, Offset begin, Offset count) {
  const Offset i = static_cast<Offset>(blockIdx.x) * blockDim.x + threadIdx.x;
  if (i >= count) return;
  const Vertex from = store.fronts.border[begin + i];
  for (int c = 0; c < vectors.columns; ++c)
    vectors.border[begin + i + c * vectors.borders] = vectors.v[from + c * vectors.n];
}

}  // namespace mfs::cuda
