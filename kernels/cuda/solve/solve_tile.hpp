// What both ways of doing a tile of the solve share: where it lies, how its parts of the factor and of the
// vector are had, and how a block waits for the results of others.
#pragma once

#include "kernels/cuda/factor/device_store.hpp"
#include "kernels/cuda/factor/tile_lu.hpp"
#include "kernels/cuda/runtime/async_copy.hpp"

namespace mfs::cuda {

constexpr int kSolveThreads = 256;
/// Columns of the factor that a step takes: as many as the diagonal tile has.
constexpr int kStep = kSolveTile;
/// Entries of a tile of K columns that a thread begins with: its i-th is entry threadIdx.x + i kSolveThreads
/// of the tile, columns side by side.
template <int K>
constexpr int kOwnEntries = K == 1 ? 1 : kSolveTile* K / kSolveThreads;

/// Every byte of an entry whose tile has not been done: a NaN that no operation makes.
constexpr int kUnset = 0xff;

/// Vectors of one solve in elimination order, K columns side by side; `border` holds what the borders of the
/// fronts of two launches leave, by DevicePlan::destination, `partial` 64 rows per place of a part. y is
/// unset before the forward pass, v and partial before the backward pass, and of the border what a launch
/// that waits for it leaves.
template <class S>
struct DeviceVectors {
  S* v;        // n x K
  S* y;        // n x K
  S* border;   // places x K
  S* partial;  // 64 places x K
};

/// One tile of a front in the pass that is under way.
template <class S>
struct SolveTile {
  const S *lower, *upper;
  Offset ld;         // of lower
  int begin, width;  // the tile's rows (or columns) of the front
  bool has_pivots;
};

template <class S, class Value>
__device__ SolveTile<S> solve_tile(const FrontStore<S, Value>& fronts, const SolvePart& part) {
  const SolveFront& at = part.where;
  return {fronts.storage + at.lower, fronts.storage + at.upper, at.ld, part.begin, part.rows,
          part.begin < at.pivots};
}

/// What a step multiplies: B(row, k), k < count <= 64, at base[row + k * ld], or base[k + row * ld] where the
/// factor is used transposed.
template <class S>
struct Panel {
  const S* base;
  Offset ld;
  int count;
};

template <class S>
__device__ Panel<S> diagonal_panel(const SolveTile<S>& tile) {
  return {tile.lower + (tile.has_pivots ? tile.begin + tile.begin * tile.ld : 0), tile.ld,
          tile.has_pivots ? tile.width : 0};
}

/// How a panel lies in shared memory: reads of doubles are free of bank conflicts whether lanes run along
/// rows (one column) or over tiles for the tensor cores.
template <bool Transposed, int K>
struct PanelPlace {
  static constexpr int ld = kSolveTile + (K == 1 ? 1 : 4);
  static constexpr int row = Transposed ? ld : 1, k = Transposed ? 1 : ld;
  static constexpr int entries = kSolveTile * ld;
};

// Begins to copy; rows from `width` and columns from the panel's count on become zero.
template <bool Transposed, int K, class S>
__device__ void fetch_panel(const Panel<S>& panel, int width, S* to) {
  using Place = PanelPlace<Transposed, K>;
  constexpr int kAlong = kSolveTile;  // entries that lie one after the other
  constexpr int kApart = kSolveThreads / kAlong, kTimes = kSolveTile / kApart;
  const int along = threadIdx.x % kAlong, first = threadIdx.x / kAlong;
  const bool within = along < (Transposed ? panel.count : width);
  const int end = Transposed ? width : panel.count;
  const S* from = panel.base + along + first * panel.ld;
  const unsigned address = shared_address(to + along + first * Place::ld);
#pragma unroll
  for (int i = 0; i < kTimes; ++i) {
    const bool inside = within && first + i * kApart < end;
    copy_async<sizeof(S)>(address + i * kApart * Place::ld * static_cast<int>(sizeof(S)),
                          inside ? from + i * kApart * panel.ld : panel.base, inside);
  }
}

/// Entry (i, j) of the inverse of a triangle, `value` being what lies there: the other triangle of the tile
/// has its own.
template <bool Upper, bool Unit, class S>
__device__ S triangle_entry(const S& value, int i, int j) {
  return i == j && Unit ? S(1) : (Upper ? j < i : j > i) ? S(0) : value;
}

/// Solves with U, or with its transposed, a lower triangle, for C columns by one warp: lane l has rows l and
/// l + 32 of them. entry(i, k) is the triangle, of `width` rows.
template <bool Upper, int C, class S, class Entry>
__device__ void substitute_tile(int width, const Entry& entry, S (&x)[2][C]) {
  static_assert(kSolveTile == 2 * kWarp);
  const int lane = threadIdx.x % kWarp;
  S reciprocal[2];
#pragma unroll
  for (int i = 0; i < 2; ++i) {
    const int row = lane + i * kWarp;
    reciprocal[i] = row < width ? reciprocal_of(entry(row, row)) : S(0);
  }
#pragma unroll
  for (int half = 0; half < 2; ++half) {
    const int own = Upper ? 1 - half : half;  // of the rows that are solved for
#pragma unroll 8
    for (int turn = 0; turn < kWarp; ++turn) {
      const int at = Upper ? kWarp - 1 - turn : turn, k = at + own * kWarp;
      S solved[C];
#pragma unroll
      for (int c = 0; c < C; ++c) solved[c] = shuffle(x[own][c] * reciprocal[own], at);
#pragma unroll
      for (int i = 0; i < 2; ++i) {
        if (Upper ? i > own : i < own) continue;  // solved for
        const int row = lane + i * kWarp;
        const bool waits = Upper ? row < k : row > k;
        const S factor = waits ? entry(row, k) : S(0);
#pragma unroll
        for (int c = 0; c < C; ++c) x[i][c] = row == k ? solved[c] : x[i][c] - factor * solved[c];
      }
    }
  }
}

// An entry that no one needs again: what has been asked for ahead should stay in the L2 instead.
__device__ inline double once(const double* place) {
  return __ldcs(place);
}
__device__ inline float once(const float* place) {
  return __ldcs(place);
}
template <class Real>
__device__ Kokkos::complex<Real> once(const Kokkos::complex<Real>* place) {
  const Real* parts = reinterpret_cast<const Real*>(place);
  return {once(parts), once(parts + 1)};
}

// Asks for a line of memory, which comes to the L2.
__device__ inline void prefetch_line(const void* place) {
  asm volatile("prefetch.global.L2 [%0];" ::"l"(place));
}

// An entry that another block may be about to write.
__device__ inline double peek(const double* place) {
  double value;
  asm volatile("ld.relaxed.gpu.f64 %0, [%1];" : "=d"(value) : "l"(place) : "memory");
  return value;
}
__device__ inline float peek(const float* place) {
  float value;
  asm volatile("ld.relaxed.gpu.f32 %0, [%1];" : "=f"(value) : "l"(place) : "memory");
  return value;
}
template <class Real>
__device__ Kokkos::complex<Real> peek(const Kokkos::complex<Real>* place) {
  const Real* parts = reinterpret_cast<const Real*>(place);
  return {peek(parts), peek(parts + 1)};
}
__device__ inline bool is_unset(double value) {
  return __double_as_longlong(value) == -1;
}
__device__ inline bool is_unset(float value) {
  return __float_as_int(value) == -1;
}
template <class Real>
__device__ bool is_unset(const Kokkos::complex<Real>& value) {
  return is_unset(value.real()) || is_unset(value.imag());
}

/// Before a block looks again for what is not set. `tiles`: how many others must be done after that before
/// this block can end. Those that are far from their end look rarely: all wait for the same entries, and the
/// one whose turn is next would wait behind them.
__device__ inline void pause_for(int tiles) {
  constexpr int kPause = 64, kMostTiles = 16;  // ns per tile
  if (tiles > 0) __nanosleep(kPause * min(tiles, kMostTiles));
}

/// The entry at `place` once it is set; `value` is what it was.
template <class S>
__device__ S wait_for(const S* place, S value, int tiles) {
  while (is_unset(value)) {
    pause_for(tiles);
    value = peek(place);
  }
  return value;
}

/// About how many tiles must be done after those that `step` of a part needs before the part's own can end.
/// One at least while that waits for the part.
__device__ inline int tiles_after(const SolvePart& part, int step) {
  return part.last_step - 1 - step + (part.finishes ? 0 : 1);
}

/// sum[m] += the entries at place(m, 0...count[m] - 1) once they are set, in this order. Some are asked for
/// at once, again and again until all of them are there. `tiles` as for pause_for.
template <int Rows, class S, class Place>
__device__ void add_when_set(const int (&count)[Rows], int tiles, const Place& place, S (&sum)[Rows]) {
  constexpr int kAtOnce = Rows < 4 ? 4 / Rows : 1;
  int most = 0;
#pragma unroll
  for (int m = 0; m < Rows; ++m) most = max(most, count[m]);
  for (int first = 0; first < most; first += kAtOnce) {
    S value[Rows][kAtOnce];
    for (bool ask = true; ask;) {
#pragma unroll
      for (int m = 0; m < Rows; ++m) {
#pragma unroll
        for (int j = 0; j < kAtOnce; ++j)
          value[m][j] = first + j < count[m] ? peek(place(m, first + j)) : S(0);
      }
      ask = false;
#pragma unroll
      for (int m = 0; m < Rows; ++m) {
#pragma unroll
        for (int j = 0; j < kAtOnce; ++j) ask = ask || is_unset(value[m][j]);
      }
      if (ask) pause_for(tiles);
    }
#pragma unroll
    for (int m = 0; m < Rows; ++m) {
#pragma unroll
      for (int j = 0; j < kAtOnce; ++j) sum[m] += value[m][j];
    }
  }
}

/// What the parts of a tile before this one have left, entry `i` of 64 x K.
template <int K, class S>
__device__ S sum_of_parts(const SolvePart& part, const S* partial, int i) {
  const S* const left = partial + part.place * (kSolveTile * K) + i;
  const int count[] = {part.parts};
  S sum[] = {S(0)};
  add_when_set(
      count, 0, [&](int, int p) { return left + p * (kSolveTile * K); }, sum);
  return sum[0];
}

}  // namespace mfs::cuda
