// Stage "solve" on the device, one launch per depth and direction for its tiny fronts, a warp each, and one
// for the others, in tiles of 64 rows of a front (of 64 columns where the factor is used transposed).
//
//   forward     y_i = L_ii^-1 (v_i + what the children left - sum_{j<i} L_ij y_j);  border: z = what the
//   children
//               left - L y
//   backward    v_i = U_ii^-1 (y_i - U v(border) - sum_{j>i} U_ij v_j)
//
// A tile needs the results of others of its front, which run at the same time: it waits, entry by entry,
// until they are no longer kUnset, which nothing computed is. They belong to blocks with smaller numbers, so
// none waits for one that has not begun. Each sum is made by one block in one order.
//
// The transposed system takes U^T forward and L^T backward, and undoes the row exchanges at the end.
#pragma once

#include "kernels/cuda/device_store.hpp"
#include "kernels/cuda/tile_lu.hpp"

namespace mfs::cuda {

constexpr int kSolveThreads = 256;

/// Every byte of an entry whose tile has not been done: a NaN that no operation makes.
constexpr int kUnset = 0xff;

/// Vectors of one solve in elimination order; `border` holds one value per border row of every front. y is
/// unset before the forward pass, v before the backward pass.
template <class S>
struct DeviceVectors {
  int columns;  // at most the K of the kernel
  Offset n, borders;
  S* v;       // n x columns
  S* y;       // n x columns
  S* border;  // borders x columns
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

// Columns (or rows) [begin, begin + count) of the factor beside the tile, count <= 64, seen as a 64 x 64
// matrix B(row, k) that multiplies the vector's part at `begin`:
//   rows contiguous   B(row, k) = base[row + k * ld]
//   transposed        B(row, k) = base[k + row * ld]
template <class S>
struct Panel {
  const S* base;
  Offset ld;
};

template <class S, int K>
struct TileSums {
  // Plain: thread = row + 64 * group, group takes every fourth column. Transposed: each warp takes 8 rows,
  // lanes run along k.
  static constexpr int kGroups = kSolveThreads / kSolveTile;
  static constexpr int kLoads = kSolveTile / kGroups;
  static constexpr int kRowsPerWarp = kSolveTile / (kSolveThreads / kWarp);

  S loaded[kLoads];
  S sum[K];                    // plain
  S row_sum[kRowsPerWarp][K];  // transposed

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
          const S total = group_sum<kWarp>(row_sum[r][c]);
          if (lane == 0) result[(first + r) * K + c] -= total;
        }
      }
    }
    __syncthreads();
  }
};

// Waits for an entry that another block writes.
__device__ inline double wait_for(const double* place) {
  long long bits;
  do {
    asm volatile("ld.relaxed.gpu.s64 %0, [%1];" : "=l"(bits) : "l"(place) : "memory");
  } while (bits == -1);
  return __longlong_as_double(bits);
}
__device__ inline float wait_for(const float* place) {
  int bits;
  do {
    asm volatile("ld.relaxed.gpu.s32 %0, [%1];" : "=r"(bits) : "l"(place) : "memory");
  } while (bits == -1);
  return __int_as_float(bits);
}
template <class Real>
__device__ Kokkos::complex<Real> wait_for(const Kokkos::complex<Real>* place) {
  const Real* parts = reinterpret_cast<const Real*>(place);
  return {wait_for(parts), wait_for(parts + 1)};
}

// out(i) = base(i) + sign * sum over k in [from(i), to(i)) of entry(i, k) x(k), for rows [begin, end) of at
// most 32, eight lanes to a row; x and out are rows of K in shared memory.
template <int K, class S, class Entry, class Bounds>
__device__ void multiply_block(int begin, int end, const Entry& entry, const Bounds& bounds, const S* x,
                               const S* base, bool minus, S* out) {
  constexpr int kLanes = kSolveThreads / kInverted;
  const int row = begin + static_cast<int>(threadIdx.x) / kLanes, part = threadIdx.x % kLanes;
  S sum[K];
#pragma unroll
  for (int c = 0; c < K; ++c) sum[c] = S(0);
  if (row < end) {
    const int2 span = bounds(row);
    for (int k = span.x + part; k < span.y; k += kLanes) {
      const S value = entry(row, k);
#pragma unroll
      for (int c = 0; c < K; ++c) sum[c] += value * x[k * K + c];
    }
  }
#pragma unroll
  for (int c = 0; c < K; ++c) {
    const S total = group_sum<kLanes>(sum[c]);
    if (row < end && part == 0) {
      const S start = base ? base[row * K + c] : S(0);
      out[row * K + c] = minus ? start - total : start + total;
    }
  }
  __syncthreads();
}

// out := T^-1 x for the diagonal tile T, 64 x 64, whose two 32 x 32 blocks are inverted. Upper: U (or L^T),
// from the last block on; lower: L (or U^T). T(i, j) = t[i + j * ld], or t[j + i * ld] where transposed. x is
// lost.
template <bool Upper, bool Transposed, bool Unit, int K, class S>
__device__ void solve_diagonal(const S* t, S* x, S* out, int width) {
  constexpr int ld = kSolveTile + 1;
  const auto entry = [&](int i, int j) {
    return Unit && i == j ? S(1) : Transposed ? t[j + i * ld] : t[i + j * ld];
  };
  const int middle = min(kInverted, width);
  const int2 first = Upper && width > kInverted ? int2{middle, width} : int2{0, middle};
  const int2 second = Upper ? int2{0, middle} : int2{middle, width};
  const auto inverse = [&](int2 block) {
    multiply_block<K>(
        block.x, block.y, entry,
        [&](int i) {
          return Upper ? int2{i, block.y} : int2{block.x, i + 1};
        },
        x, static_cast<const S*>(nullptr), false, out);
  };
  inverse(first);
  if (width <= kInverted) return;
  multiply_block<K>(
      second.x, second.y, entry, [&](int) { return first; }, out, x, true, x);
  inverse(second);
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
  // x(r) := at(r, column), for r < count; zero beyond.
  template <class At>
  __device__ void load_x(int columns, int count, const At& at) {
    for (int i = threadIdx.x; i < kSolveTile * K; i += kSolveThreads) {
      const int r = i % kSolveTile, c = i / kSolveTile;
      x[r * K + c] = r < count && c < columns ? at(r, c) : S(0);
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
  const Offset pivots_at = store.fronts.pivot_begin[part.front],
               border_at = store.fronts.border_begin[part.front];
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
    shared.load_x(vectors.columns, count,
                  [&](int r, int c) { return wait_for(vectors.y + pivots_at + k + r + c * vectors.n); });
    sums.template multiply<Transposed>(shared.x);
    __syncthreads();
  }
  __syncthreads();
  if (before > 0) sums.template subtract_from<Transposed>(shared.result, shared.parts);
  const S* result = shared.result;
  if (tile.pivots) {
    solve_diagonal<false, Transposed, !Transposed, K>(shared.diagonal, shared.result, shared.x, tile.width);
    result = shared.x;
  }
  S* const to = tile.pivots ? vectors.y + pivots_at + tile.begin
                            : vectors.border + border_at + tile.begin - front.pivots;
  const Offset stride = tile.pivots ? vectors.n : vectors.borders;
  for (int i = threadIdx.x; i < tile.width * vectors.columns; i += kSolveThreads) {
    const int r = i % tile.width, c = i / tile.width;
    to[r + c * stride] = result[r * K + c];
  }
}

template <bool Transposed, int K, class S, class Value>
__global__ void __launch_bounds__(kSolveThreads)
    substitute_backward(DeviceStore<S, Value> store, DeviceVectors<S> vectors, Offset first) {
  extern __shared__ __align__(16) unsigned char memory[];
  SolveShared<S, K> shared(memory);
  const FrontPart part = store.solve[first + blockIdx.x];
  const SolveTile<S> tile = solve_tile(store.fronts, part);
  const Front<S>& front = tile.front;
  const Offset pivots_at = store.fronts.pivot_begin[part.front],
               border_at = store.fronts.border_begin[part.front];
  const auto row_of = [&](int pivot) {
    return pivots_at + (Transposed ? store.fronts.local_row[pivots_at + pivot] : pivot);
  };
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
    const Vertex* const rows = store.fronts.border + border_at + k;
    shared.load_x(vectors.columns, count, [&](int r, int c) { return vectors.v[rows[r] + c * vectors.n]; });
    sums.template multiply<Transposed>(shared.x);
    __syncthreads();
  }
  for (int k = (front.pivots - 1) / kSolveTile * kSolveTile; k > tile.begin; k -= kSolveTile) {
    const int count = min(kSolveTile, front.pivots - k);
    const Panel<S> panel = Transposed ? Panel<S>{front.lower + k + tile.begin * tile.ld, tile.ld}
                                      : Panel<S>{front.lower + tile.begin + k * tile.ld, tile.ld};
    sums.template load<Transposed>(panel, tile.width, count);
    shared.load_x(vectors.columns, count,
                  [&](int r, int c) { return wait_for(vectors.v + row_of(k + r) + c * vectors.n); });
    sums.template multiply<Transposed>(shared.x);
    __syncthreads();
  }
  sums.template subtract_from<Transposed>(shared.result, shared.parts);
  solve_diagonal<true, Transposed, Transposed, K>(shared.diagonal, shared.result, shared.x, tile.width);
  for (int i = threadIdx.x; i < tile.width * vectors.columns; i += kSolveThreads) {
    const int r = i % tile.width, c = i / tile.width;
    vectors.v[row_of(tile.begin + r) + c * vectors.n] = shared.x[r * K + c];
  }
}

/// Tiny fronts, a warp each: at most 32 pivots, so that a lane has one.
constexpr int kTinyFrontsPerBlock = 4;

template <bool Transposed, class S, class Value>
__global__ void __launch_bounds__(kTinyFrontsPerBlock* kWarp)
    substitute_tiny_forward(DeviceStore<S, Value> store, DeviceVectors<S> vectors, Offset first, int count) {
  const int place = static_cast<int>(blockIdx.x) * kTinyFrontsPerBlock + threadIdx.x / kWarp;
  if (place >= count) return;
  const Vertex f = store.tiny_fronts[first + place];
  const Front<S> front = store.fronts.front(f);
  const int p = front.pivots, b = front.border, rows = p + b, lane = threadIdx.x % kWarp;
  const Offset pivots_at = store.fronts.pivot_begin[f], border_at = store.fronts.border_begin[f];
  const auto from_children = [&](int row, int c) {
    S sum = S(0);
    const Offset at = store.row_begin[f] + row;
    for (Offset s = store.source_begin[at]; s < store.source_begin[at + 1]; ++s)
      sum += vectors.border[store.source[s] + c * vectors.borders];
    return sum;
  };
  const int own = lane < p ? (Transposed ? lane : store.fronts.local_row[pivots_at + lane]) : 0;
  for (int c = 0; c < vectors.columns; ++c) {
    const S v = lane < p ? vectors.v[pivots_at + own + c * vectors.n] + from_children(own, c) : S(0);
    S y = Transposed ? S(0) : v;
#pragma unroll 8
    for (int k = 0; k < p; ++k) {
      const S other = shuffle(v, k);
      if (lane < p && (Transposed ? k <= lane : k < lane))
        y += (Transposed ? front.lower[k + lane * rows] : front.lower[lane + k * rows]) * other;
    }
    if (lane < p) vectors.y[pivots_at + lane + c * vectors.n] = y;
    for (int begin = 0; begin < b; begin += kWarp) {
      const int row = begin + lane;
      S z = row < b ? from_children(p + row, c) : S(0);
#pragma unroll 8
      for (int k = 0; k < p; ++k) {
        const S other = shuffle(y, k);
        if (row < b) z -= (Transposed ? front.upper[k + row * p] : front.lower[p + row + k * rows]) * other;
      }
      if (row < b) vectors.border[border_at + row + c * vectors.borders] = z;
    }
  }
}

template <bool Transposed, class S, class Value>
__global__ void __launch_bounds__(kTinyFrontsPerBlock* kWarp)
    substitute_tiny_backward(DeviceStore<S, Value> store, DeviceVectors<S> vectors, Offset first, int count) {
  const int place = static_cast<int>(blockIdx.x) * kTinyFrontsPerBlock + threadIdx.x / kWarp;
  if (place >= count) return;
  const Vertex f = store.tiny_fronts[first + place];
  const Front<S> front = store.fronts.front(f);
  const int p = front.pivots, b = front.border, rows = p + b, lane = threadIdx.x % kWarp;
  const Offset pivots_at = store.fronts.pivot_begin[f], border_at = store.fronts.border_begin[f];
  for (int c = 0; c < vectors.columns; ++c) {
    S sum = lane < p ? vectors.y[pivots_at + lane + c * vectors.n] : S(0);
    for (int begin = 0; begin < b; begin += kWarp) {
      const int count_here = min(kWarp, b - begin);
      const S x =
          lane < count_here ? vectors.v[store.fronts.border[border_at + begin + lane] + c * vectors.n] : S(0);
#pragma unroll 8
      for (int k = 0; k < count_here; ++k) {
        const S other = shuffle(x, k);
        const int j = begin + k;
        if (lane < p)
          sum -= (Transposed ? front.lower[p + j + lane * rows] : front.upper[lane + j * p]) * other;
      }
    }
    S x = Transposed ? sum : S(0);
#pragma unroll 8
    for (int k = 0; k < p; ++k) {
      const S other = shuffle(sum, k);
      if (lane < p && (Transposed ? k > lane : k >= lane))
        x += (Transposed ? front.lower[k + lane * rows] : front.lower[lane + k * rows]) * other;
    }
    if (lane < p) {
      const int row = Transposed ? store.fronts.local_row[pivots_at + lane] : lane;
      vectors.v[pivots_at + row + c * vectors.n] = x;
    }
  }
}

}  // namespace mfs::cuda
