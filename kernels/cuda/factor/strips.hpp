// The triangular solves beside a diagonal tile T: strips of rows of the block column, X := X U^-1, and of
// columns of the block row, X := L^-1 X, which is solved transposed, X^T := X^T L^-T. The 32 x 32 blocks
// on T's diagonal are inverted already, so all is products, on the tensor cores, but where tiny pivots are
// divided by: then blocks of U are as they are, and are substituted with. A strip lies in shared memory and
// is read and written in rows of memory: what a strip costs is its instructions, most of all where few run.
#pragma once

#include "kernels/cuda/factor/block_lu.hpp"

namespace mfs::cuda {

/// Strips have kStrip rows, or kShortStrip where a block may have less shared memory.
constexpr int kStrip = 128, kShortStrip = 64;

/// A warp for 16 rows.
__host__ __device__ constexpr int strip_threads(int rows) {
  return rows / 16 * kWarp;
}

/// A triangle in 32 x 32 blocks, as it lies in the tile: block (i, j), i <= j, of the upper one and block (j,
/// i) of the lower one at j (j + 1) / 2 + i.
constexpr int kBlockLd = tile_ld(kInverted);
constexpr int kBlockEntries = kBlockLd * kInverted;
__device__ inline int block_place(int i, int j) {
  return (j * (j + 1) / 2 + i) * kBlockEntries;
}

/// Calls work with the rows of a strip and the blocks of 32 columns that tiles of up to `pivots` pivots may
/// have: beside narrow tiles, strips need less shared memory, so that a multiprocessor holds more of them.
template <class S, class Work>
void with_strip_shape(Vertex rows, Vertex pivots, const Work& work) {
  const auto with_blocks = [&](auto strip) {
    if (pivots <= kInverted) return work(strip, std::integral_constant<int, 1>());
    if (pivots <= 2 * kInverted) return work(strip, std::integral_constant<int, 2>());
    constexpr int tile = kTile<S>;
    if constexpr (tile > 2 * kInverted) work(strip, std::integral_constant<int, tile / kInverted>());
  };
  if (rows == kStrip) return with_blocks(std::integral_constant<int, kStrip>());
  with_blocks(std::integral_constant<int, kShortStrip>());
}
__host__ __device__ constexpr int triangle_entries(int blocks) {
  return blocks * (blocks + 1) / 2 * kBlockEntries;
}
/// X by columns in one kind of strip, X^T by columns in the other.
__host__ __device__ constexpr int transposed_ld(int blocks) {
  return tile_ld(blocks * kInverted);
}
template <class S>
constexpr std::size_t strip_bytes(int blocks, int rows) {
  const int x = tile_ld(rows) * blocks * kInverted, transposed = transposed_ld(blocks) * rows;
  return sizeof(S) * (triangle_entries(blocks) + (x > transposed ? x : transposed));
}

// The triangle that the strips are solved with: U, or L with ones on its diagonal; zero beyond s.
template <int Rows, bool Upper, class S>
__device__ void load_triangle(S* t, const S* diagonal, Offset ld, int s, int blocks) {
  const int lane = threadIdx.x % kWarp;
  for (int column = threadIdx.x / kWarp; column < blocks * kInverted; column += strip_threads(Rows) / kWarp) {
    const int j = column / kInverted, c = column % kInverted, row = j * kInverted + lane;
    const S* const from = diagonal + lane + column * ld;
    S* const to = t + lane + c * kBlockLd;
    for (int i = Upper ? 0 : j + 1; i < (Upper ? j : blocks); ++i) {
      const bool inside = column < s && (Upper || i * kInverted + lane < s);
      copy_async<sizeof(S)>(shared_address(to + (Upper ? block_place(i, j) : block_place(j, i))),
                            inside ? from + i * kInverted : diagonal, inside);
    }
    if (!Upper && lane == c) {
      to[block_place(j, j)] = S(1);
    } else {
      const bool inside = Upper ? lane <= c && column < s : lane > c && row < s;
      copy_async<sizeof(S)>(shared_address(to + block_place(j, j)), inside ? from + j * kInverted : diagonal,
                            inside);
    }
  }
}

/// 16 rows of X, in shared memory, by one warp: X(r, c) at x[r * row_step + c * column_step].
template <int Rows, int Blocks, bool Upper, class S>
struct StripRows {
  static constexpr int row_step = Upper ? 1 : transposed_ld(Blocks), column_step = Upper ? tile_ld(Rows) : 1;
  S* x;

  // X := X t^-1 in place, t upper triangular, of s columns, or the transposed of what was loaded.
  __device__ void solve(const S* t, int blocks, bool substitutes, int s) const {
    constexpr int k_step = Upper ? 1 : kBlockLd, n_step = Upper ? kBlockLd : 1;
#pragma unroll 1
    for (int j = 0; j < blocks; ++j) {
      WarpTile<S, 1, 4> sums;
      S* const own = x + j * kInverted * column_step;
      sums.for_each([&](int r, int c, S& value) { value = own[r * row_step + c * column_step]; });
#pragma unroll 1
      for (int i = 0; i < j; ++i) {
        const S* const left = x + i * kInverted * column_step;
        sums.multiply_entries([=](int r, int k) { return -left[r * row_step + k * column_step]; },
                              t + block_place(i, j), k_step, n_step, kInverted);
      }
      keep(sums, own);
      if constexpr (Upper) {
        if (substitutes) {
          substitute(own, t + block_place(j, j), min(kInverted, s - j * kInverted));
          continue;
        }
      }
      sums.clear();
      sums.multiply(own, row_step, column_step, t + block_place(j, j), k_step, n_step, kInverted);
      keep(sums, own);
    }
  }

 private:
  // The same for one block of columns. Two lanes share a row: each has every second column. Not inlined: the
  // products would pay with registers.
  static __device__ __noinline__ void substitute(S* own, const S* t, int width) {
    static_assert(Upper && kInverted == kWarp);
    const int lane = threadIdx.x % kWarp, row = lane % 16, half = lane / 16;
    S* const x = own + row * row_step + half * column_step;
    const S reciprocal = lane < width ? reciprocal_of(t[lane + lane * kBlockLd]) : S(0);
    S rest[kInverted / 2];
#pragma unroll
    for (int i = 0; i < kInverted / 2; ++i) rest[i] = x[2 * i * column_step];
#pragma unroll
    for (int c = 0; c < kInverted; ++c) {
      if (c >= width) break;
      const S solved = shuffle(rest[c / 2], row + 16 * (c % 2)) * shuffle(reciprocal, c);
      if (half == c % 2) rest[c / 2] = solved;
#pragma unroll
      for (int i = c / 2; i < kInverted / 2; ++i) {
        const int column = 2 * i + half;
        if (column > c) rest[i] -= solved * t[c + column * kBlockLd];
      }
    }
#pragma unroll
    for (int i = 0; i < kInverted / 2; ++i) x[2 * i * column_step] = rest[i];
    __syncwarp();
  }
  static __device__ void keep(WarpTile<S, 1, 4>& sums, S* own) {
    __syncwarp();
    sums.for_each([&](int r, int c, S& value) { own[r * row_step + c * column_step] = value; });
    __syncwarp();
  }
};

// Rows below a tile.
template <int Rows, int Blocks, class S, class Value>
__device__ void solve_column_strip(const DeviceStore<S, Value>& store, const StepTask& task,
                                   const Front<S>& front, int strip, S* memory) {
  const Vertex f = task.front;
  const Offset ld = front.lower_ld;
  const int k = task.k, s = min(store.tile, front.pivots - k), next = k + s;
  const int rest = front.pivots - next, length = rest + front.border;
  const bool strict = store.is_strict(f);
  if (strict && (strip + 1) * Rows <= rest) return;  // multipliers already
  const int lane = threadIdx.x % kWarp, warp_begin = static_cast<int>(threadIdx.x / kWarp) * 16;
  const int begin = strip * Rows + warp_begin;
  // Lanes take a row each, of two columns at a time.
  const int row = lane % 16, first = lane / 16;
  const bool there = begin + row < length;
  constexpr int kLd = tile_ld(Rows);
  S* const t = memory;
  const StripRows<Rows, Blocks, true, S> rows{memory + triangle_entries(Blocks) + warp_begin};
  S* const own = rows.x + row;
  S* const column = front.lower + next + begin + row + k * ld;
  const int blocks = (s + kInverted - 1) / kInverted;
  if (there) {
    const S* from = column + first * ld;
#pragma unroll 8
    for (int c = first; c < s; c += 2, from += 2 * ld)
      copy_async<sizeof(S)>(shared_address(own + c * kLd), from);
    for (int c = s + (s + first) % 2; c < blocks * kInverted; c += 2) own[c * kLd] = S(0);
  }
  load_triangle<Rows, true>(t, front.lower + k + k * ld, ld, s, blocks);
  commit_copies();
  wait_copies<0>();
  __syncthreads();
  if (begin >= length) return;
  rows.solve(t, blocks, store.substitutes, s);
  if (!there || (strict && begin + row < rest)) return;
  S* to = column + first * ld;
#pragma unroll 8
  for (int c = first; c < s; c += 2, to += 2 * ld) *to = own[c * kLd];
  const bool border = begin + row >= rest;
  if (border && (strict || !store.substitutes)) return;
  double most = 0;
#pragma unroll 4
  for (int c = first; c < s; c += 2) most = fmax(most, magnitude(own[c * kLd]));
  if (most > most_left_out(store.pivots, store.substitutes)) store.make_strict(f);
}

// Columns right of a tile, which come with their rows exchanged.
template <int Rows, int Blocks, class S, class Value>
__device__ void solve_row_strip(const DeviceStore<S, Value>& store, const StepTask& task,
                                const Front<S>& front, int strip, S* memory) {
  const Vertex f = task.front;
  const Offset ld = front.lower_ld;
  const int k = task.k, s = min(store.tile, front.pivots - k), next = k + s, rest = front.pivots - next;
  const bool strict = store.is_strict(f);
  const int lane = threadIdx.x % kWarp, warp_begin = static_cast<int>(threadIdx.x / kWarp) * 16;
  const int begin = task.begin + strip * Rows + warp_begin, width = min(16, task.end - begin);
  constexpr int kLd = transposed_ld(Blocks);
  S* const t = memory;
  const StripRows<Rows, Blocks, false, S> rows{memory + triangle_entries(Blocks) + warp_begin * kLd};
  const int blocks = (s + kInverted - 1) / kInverted;
  const auto block_row = [&](int r) {
    const int c = begin + r;
    return c < rest ? front.lower + k + (next + c) * ld
                    : store.fronts.storage + task.upper + k + static_cast<Offset>(c - rest) * front.pivots;
  };
  int row_at[Blocks];
  const Vertex* const local_row = store.fronts.local_row + store.fronts.pivot_begin[f] + k;
#pragma unroll
  for (int i = 0; i < Blocks; ++i) {
    const int c = lane + i * kInverted;
    row_at[i] = c >= s ? 0 : strict ? c : local_row[c] - k;
  }
#pragma unroll 4
  for (int r = 0; r < width; ++r) {
    const S* const from = block_row(r);
#pragma unroll
    for (int i = 0; i < Blocks; ++i) {
      const bool inside = lane + i * kInverted < s;
      copy_async<sizeof(S)>(shared_address(rows.x + lane + i * kInverted + r * kLd), from + row_at[i],
                            inside);
    }
  }
  load_triangle<Rows, false>(t, front.lower + k + k * ld, ld, s, blocks);
  commit_copies();
  wait_copies<0>();
  __syncthreads();
  if (width <= 0) return;
  rows.solve(t, blocks, false, s);
#pragma unroll 4
  for (int r = 0; r < width; ++r) {
    S* const to = block_row(r);
#pragma unroll
    for (int i = 0; i < Blocks; ++i) {
      const int c = lane + i * kInverted;
      if (c < s) to[c] = rows.x[c + r * kLd];
    }
  }
}

template <int Rows, int Blocks, class S, class Value>
__global__ void __launch_bounds__(strip_threads(Rows), Blocks == 4 ? 1 : 2)
    solve_strips(DeviceStore<S, Value> store, Offset first, int count) {
  extern __shared__ __align__(16) unsigned char memory[];
  S* const shared = reinterpret_cast<S*>(memory);
  const StepTask task =
      store.steps[first + find_task(store.steps + first, count, &StepTask::first_strip, blockIdx.x)];
  const Front<S> front = store.fronts.front(task.front);
  const int below = front.rows() - min(task.k + store.tile, front.pivots);
  const int strips = task.left ? (below + Rows - 1) / Rows : 0;
  const int strip = static_cast<int>(blockIdx.x) - task.first_strip;
  if (strip < strips) {
    solve_column_strip<Rows, Blocks>(store, task, front, strip, shared);
  } else {
    solve_row_strip<Rows, Blocks>(store, task, front, strip - strips, shared);
  }
}

}  // namespace mfs::cuda
