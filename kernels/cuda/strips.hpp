// The triangular solves beside a diagonal tile T: strips of 128 rows of the block column, X := X U^-1, and of
// 128 columns of the block row, X := L^-1 X, which is solved transposed, X^T := X^T L^-T. The 32 x 32 blocks
// on T's diagonal are inverted already, so all is products, on the tensor cores.
#pragma once

#include "kernels/cuda/block_lu.hpp"

namespace mfs::cuda {

constexpr int kStripThreads = kStrip / 16 * kWarp;

/// The upper triangle of a tile in 32 x 32 blocks, column by column: block (i, j), i <= j, at j (j + 1) / 2 +
/// i.
constexpr int kBlockLd = tile_ld(kInverted);
constexpr int kBlockEntries = kBlockLd * kInverted;
__device__ inline int block_place(int i, int j) {
  return (j * (j + 1) / 2 + i) * kBlockEntries;
}

template <class S>
constexpr std::size_t strip_bytes() {
  constexpr int blocks = kTile<S> / kInverted, staging = tile_ld(16) * kInverted * (kStripThreads / kWarp);
  return sizeof(S) * (blocks * (blocks + 1) / 2 * kBlockEntries + staging) + sizeof(int) * kTile<S>;
}

// The triangle that the strips are solved with: U, or L^T with ones on its diagonal; zero beyond s.
template <class S>
__device__ void load_triangle(S* t, const S* diagonal, Offset ld, int s, bool upper) {
  const int lane = threadIdx.x % kWarp, blocks = (s + kInverted - 1) / kInverted;
  for (int j = 0; j < blocks; ++j) {
    for (int i = 0; i <= j; ++i) {
      S* const block = t + block_place(i, j);
      for (int c = threadIdx.x / kWarp; c < kInverted; c += kStripThreads / kWarp) {
        // Lanes run along the columns of the factor: rows of U, columns of L.
        const int row = i * kInverted + (upper ? lane : c), column = j * kInverted + (upper ? c : lane);
        const bool inside = row < s && column < s && (upper ? row <= column : row < column);
        S* const to = block + (row - i * kInverted) + (column - j * kInverted) * kBlockLd;
        const S* const from = upper ? diagonal + row + column * ld : diagonal + column + row * ld;
        if (!upper && row == column) {
          *to = S(1);
        } else {
          copy_async<sizeof(S)>(shared_address(to), inside ? from : diagonal, inside);
        }
      }
    }
  }
  commit_copies();
}

/// 16 rows of X, all its columns, in the registers of one warp: 32 columns are one WarpTile.
template <class S>
struct StripRows {
  static constexpr int kBlocks = kTile<S> / kInverted;
  WarpTile<S, 1, 4> x[kBlocks];

  template <class Load>
  __device__ void load(const Load& load) {
#pragma unroll
    for (int j = 0; j < kBlocks; ++j)
      x[j].for_each([&](int r, int c, S& value) { value = load(r, j * kInverted + c); });
  }

  // X := X t^-1. Sums move through `staging` (16 x 32, shared memory of this warp) to become operands.
  __device__ void solve(const S* t, S* staging, int blocks) {
    constexpr int ld = tile_ld(16);
#pragma unroll
    for (int j = 0; j < kBlocks; ++j) {
      if (j >= blocks) break;
      stage(x[j], staging);
      x[j].clear();
      x[j].multiply(staging, 1, ld, t + block_place(j, j), 1, kBlockLd, kInverted);
      stage(x[j], staging, true);
#pragma unroll
      for (int k = j + 1; k < kBlocks; ++k) {
        if (k < blocks) x[k].multiply(staging, 1, ld, t + block_place(j, k), 1, kBlockLd, kInverted);
      }
    }
  }

 private:
  static __device__ void stage(WarpTile<S, 1, 4>& sums, S* staging, bool negated = false) {
    __syncwarp();
    sums.for_each([&](int r, int c, S& value) { staging[r + c * tile_ld(16)] = negated ? -value : value; });
    __syncwarp();
  }
};

template <class S, class Value>
__global__ void __launch_bounds__(kStripThreads, 1)
    solve_strips(DeviceStore<S, Value> store, Offset first, int count) {
  extern __shared__ __align__(16) unsigned char memory[];
  constexpr int tile = kTile<S>, kTriangle = tile / kInverted * (tile / kInverted + 1) / 2 * kBlockEntries;
  S* const t = reinterpret_cast<S*>(memory);
  S* const staging = t + kTriangle + threadIdx.x / kWarp * tile_ld(16) * kInverted;
  int* const row_at = reinterpret_cast<int*>(t + kTriangle + kStripThreads / kWarp * tile_ld(16) * kInverted);
  const StepTask task =
      store.steps[first + find_task(store.steps + first, count, &StepTask::first_strip, blockIdx.x)];
  const Vertex f = task.front;
  const Front<S> front = store.fronts.front(f);
  const Offset ld = front.lower_ld;
  const int k = task.k, s = min(tile, front.pivots - k), next = k + s;
  const int rest = front.pivots - next, length = rest + front.border;
  const int strips = task.left ? (length + kStrip - 1) / kStrip : 0;
  const int strip = static_cast<int>(blockIdx.x) - task.first_strip;
  const bool left = strip < strips;  // of the block column
  const bool strict = store.is_strict(f);
  const int warp_begin = static_cast<int>(threadIdx.x / kWarp) * 16;
  const int begin = (left ? strip * kStrip : task.begin + (strip - strips) * kStrip) + warp_begin;
  const int width = min(16, (left ? length : task.end) - begin);
  if (left && strict && begin - warp_begin + kStrip <= rest) return;  // multipliers already

  load_triangle(t, front.lower + k + k * ld, ld, s, left);
  // The block row comes with its rows exchanged.
  for (int i = threadIdx.x; i < s; i += kStripThreads) {
    row_at[i] = strict ? i : store.fronts.local_row[store.fronts.pivot_begin[f] + next - s + i] - k;
  }
  __syncthreads();
  // Row r of X is row begin + r below the tile, or column begin + r right of it.
  S* const column = front.lower + next + begin + k * ld;
  const auto block_row = [&](int r) {
    const int c = begin + r;
    return c < rest ? front.lower + k + (next + c) * ld
                    : front.upper + k + static_cast<Offset>(c - rest) * front.pivots;
  };
  StripRows<S> x;
  if (left) {
    x.load([&](int r, int c) { return r < width && c < s ? column[r + c * ld] : S(0); });
  } else {
    x.load([&](int r, int c) { return r < width && c < s ? block_row(r)[row_at[c]] : S(0); });
  }
  wait_copies<0>();
  __syncthreads();
  if (width <= 0) return;
  x.solve(t, staging, (s + kInverted - 1) / kInverted);
  double most = 0;
#pragma unroll
  for (int j = 0; j < StripRows<S>::kBlocks; ++j) {
    x.x[j].for_each([&](int r, int c, S& value) {
      c += j * kInverted;
      if (r >= width || c >= s) return;
      if (!left) {
        block_row(r)[c] = value;
      } else if (!strict || begin + r >= rest) {
        if (begin + r < rest) most = fmax(most, magnitude(value));
        column[r + c * ld] = value;
      }
    });
  }
  if (most > kMostGrowth) store.make_strict(f);
}

}  // namespace mfs::cuda
