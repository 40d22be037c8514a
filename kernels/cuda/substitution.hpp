// Stage "solve" on the device, for K columns at once, which lie side by side: entry (i, c) of a vector at
// i * K + c. One launch per depth and direction for tiny fronts, a warp each (tiny_substitution.hpp), and one
// for the others, in tiles of 64 rows of a front (of 64 columns where the factor is used transposed).
//
//   forward     y_i = L_ii^-1 (v_i + what the children left - sum_{j<i} L_ij y_j);  border: z = what the
//               children left - L y
//   backward    v_i = U_ii^-1 (y_i - U v(border) - sum_{j>i} U_ij v_j)
//
// Backward, tiles with a long border are cut in parts (SolvePart), a block each, so that the few large fronts
// of a depth fill the device. A part needs the results of other tiles of its front, which run at the same
// time: it waits, entry by entry, until they are no longer kUnset, which nothing computed is. They belong to
// blocks with smaller numbers, so none waits for one that has not begun. Each sum is made in one order: the
// parts' are added one by one.
//
// What multiplies the vector comes in steps of 64 columns through two places in shared memory, one step
// ahead, and the diagonal tile last. From the last entries that a tile waits for to the first that others
// wait for takes about 2 us, for each tile of a large front: nothing is loaded on that path, and it has few
// barriers.
//
// The transposed system takes U^T forward and L^T backward, and undoes the row exchanges at the end.
#pragma once

#include "kernels/cuda/async_copy.hpp"
#include "kernels/cuda/device_store.hpp"
#include "kernels/cuda/tile_lu.hpp"

namespace mfs::cuda {

constexpr int kSolveThreads = 256;
/// Blocks on a multiprocessor that registers must not stand in the way of.
template <int K>
constexpr int kSolveBlocks = K == 1 ? 3 : 2;
/// Columns of the factor that a step takes: as many as the diagonal tile has.
constexpr int kStep = kSolveTile;
constexpr int kStages = 2;

/// Every byte of an entry whose tile has not been done: a NaN that no operation makes.
constexpr int kUnset = 0xff;

/// Vectors of one solve in elimination order, K columns side by side; `border` holds a row per border row of
/// every front, `partial` 64 rows per place of a part. y is unset before the forward pass, v and partial
/// before the backward pass.
template <class S>
struct DeviceVectors {
  S* v;        // n x K
  S* y;        // n x K
  S* border;   // borders x K
  S* partial;  // 64 places x K
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
__device__ SolveTile<S> solve_tile(const FrontStore<S, Value>& fronts, const SolvePart& part) {
  SolveTile<S> tile;
  tile.front = fronts.front(part.front);
  tile.ld = tile.front.lower_ld;
  tile.begin = part.begin;
  tile.pivots = part.begin < tile.front.pivots;
  tile.width = min(kSolveTile, (tile.pivots ? tile.front.pivots : tile.front.rows()) - part.begin);
  return tile;
}

/// What a step multiplies: B(row, k), k < count <= 64, at base[row + k * ld], or base[k + row * ld] where the
/// factor is used transposed.
template <class S>
struct Panel {
  const S* base;
  Offset ld;
  int count;
};

/// How a panel lies in shared memory; reads of doubles are free of bank conflicts both ways.
template <bool Transposed>
struct PanelPlace {
  static constexpr int ld = kSolveTile + 4;
  static constexpr int row = Transposed ? ld : 1, k = Transposed ? 1 : ld;
};
constexpr int kPanelEntries = kSolveTile * (kSolveTile + 4);

// Rows from `width` and columns from the panel's count on become zero.
template <bool Transposed, class S>
__device__ void fetch_panel(const Panel<S>& panel, int width, S* to) {
  constexpr int kAlong = kSolveTile;  // entries that lie one after the other
  constexpr int kApart = kSolveThreads / kAlong, kTimes = kSolveTile / kApart;
  const int along = threadIdx.x % kAlong, first = threadIdx.x / kAlong;
  const bool within = along < (Transposed ? panel.count : width);
  const int end = Transposed ? width : panel.count;
  const S* from = panel.base + along + first * panel.ld;
  const unsigned address = shared_address(to + along + first * PanelPlace<Transposed>::ld);
#pragma unroll
  for (int i = 0; i < kTimes; ++i) {
    const bool inside = within && first + i * kApart < end;
    copy_async<sizeof(S)>(address + i * kApart * PanelPlace<Transposed>::ld * static_cast<int>(sizeof(S)),
                          inside ? from + i * kApart * panel.ld : panel.base, inside);
  }
}

/// Leading dimension of K columns in shared memory.
template <int K>
constexpr int kColumnsLd = K == 1 ? 1 : K + 4;

/// Sums of Rows (32 or 64) x K, spread over the threads of a block: for one column four neighbouring lanes
/// have parts of a row, for 16 columns each warp has a tile of 16 x 8.
template <class S, int K, int Rows>
struct TileSums {
  static constexpr int kThreads = K == 1 ? 4 * Rows : 2 * Rows / 16 * kWarp;
  std::conditional_t<K == 1, S, WarpTile<S, 1, 1>> sum;

  __device__ static bool active() { return static_cast<int>(threadIdx.x) < kThreads; }
  __device__ static int warp_row() { return threadIdx.x / kWarp % (Rows / 16) * 16; }
  __device__ static int warp_column() { return threadIdx.x / kWarp / (Rows / 16) * 8; }

  __device__ void clear() {
    if constexpr (K == 1) {
      sum = S(0);
    } else {
      sum.clear();
    }
  }
  /// += B x for Depth columns of B = entry(row, k) and as many rows of x.
  template <int Depth, class Entry>
  __device__ void multiply(const Entry& entry, const S* x) {
    if (!active()) return;
    if constexpr (K == 1) {
      const int row = threadIdx.x / 4, part = threadIdx.x % 4;
#pragma unroll
      for (int k = 0; k < Depth; k += 4) sum += entry(row, k + part) * x[k + part];
    } else {
      const int first = warp_row();
      sum.multiply_entries([&](int row, int k) { return entry(first + row, k); }, x + warp_column(),
                           kColumnsLd<K>, 1, Depth);
    }
  }
  /// Calls body(row, column, sum), once for each.
  template <class Body>
  __device__ void for_each(const Body& body) {
    if (!active()) return;
    if constexpr (K == 1) {
      const S total = group_sum<4>(sum);
      if (threadIdx.x % 4 == 0) body(static_cast<int>(threadIdx.x) / 4, 0, total);
    } else {
      sum.for_each(
          [&](int row, int column, S& value) { body(warp_row() + row, warp_column() + column, value); });
    }
  }
};

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

/// The 64 rows of the vector that a step multiplies: asked for ahead, waited for when they are needed.
template <class S, int K>
class VectorAhead {
 public:
  __device__ explicit VectorAhead(const S* vector) : vector_(vector) {}

  /// place(i) for rows i = 0...63: the row of the vector, -1 for none.
  template <class Place>
  __device__ void look_up(const Place& place) {
    if (!active()) return;
#pragma unroll
    for (int j = 0; j < kTimes; ++j) next_[j] = place(row(j));
  }
  __device__ void ask() {
    if (!active()) return;
#pragma unroll
    for (int j = 0; j < kTimes; ++j) {
      at_[j] = next_[j];
      value_[j] = at_[j] < 0 ? S(0) : peek(vector_ + at_[j] * K + column());
    }
  }
  __device__ void settle(S* x) {
    if (!active()) return;
#pragma unroll
    for (int j = 0; j < kTimes; ++j) {
      while (at_[j] >= 0 && is_unset(value_[j])) value_[j] = peek(vector_ + at_[j] * K + column());
      x[row(j) * kColumnsLd<K> + column()] = value_[j];
    }
  }

 private:
  static constexpr int kTimes = K == 1 ? 1 : kSolveTile * K / kSolveThreads;
  __device__ static bool active() {
    return static_cast<int>(threadIdx.x) < kSolveTile * K;
  }
  __device__ static int row(int j) {
    return (threadIdx.x + j * kSolveThreads) / K;
  }
  __device__ static int column() {
    return threadIdx.x % K;
  }

  const S* vector_;
  Offset next_[kTimes], at_[kTimes];
  S value_[kTimes];
};

/// Shared memory of both passes.
template <class S, int K>
struct SolveShared {
  static constexpr int kBlock = kSolveTile * kColumnsLd<K>;
  S *stage, *x, *result;
  __device__ explicit SolveShared(void* memory) {
    stage = static_cast<S*>(memory);
    x = stage + kStages * kPanelEntries;
    result = x + kBlock;
  }
  __device__ S* panel(int step) const { return stage + step % kStages * kPanelEntries; }
};
template <class S, int K>
constexpr std::size_t substitution_bytes() {
  return sizeof(S) * (kStages * kPanelEntries + 2 * SolveShared<S, K>::kBlock);
}

/// The sum over the steps of a part of panel(step) times the rows place(step, 0...63) of the vector. Where
/// the part finishes its tile, panel(last_step) is the diagonal tile.
template <bool Transposed, int K, class S, class PanelOf, class PlaceOf>
class TileSweep {
  using Place = PanelPlace<Transposed>;

 public:
  /// Asks for the first panel.
  __device__ TileSweep(const SolveShared<S, K>& shared, const SolvePart& part, int width,
                       const PanelOf& panel, const PlaceOf& place)
      : shared_(shared), part_(part), width_(width), panel_(panel), place_(place) {
    fetch(part.first_step);
  }

  /// partial = the sums, for the part that finishes the tile.
  __device__ void leave_sums(const S* vector, S* partial) {
    S* const to = place_of(partial, 0);
    add_steps(vector, [] {});
    sums_.for_each([&](int row, int column, const S& sum) { to[row * K + column] = sum; });
  }

  /// result -= the sums of all parts. Begins and ends with a barrier.
  __device__ void subtract_sums(const S* vector, const S* partial) {
    add_steps(vector, [&] { subtract_parts(partial); });
    if (part_.first_step == part_.last_step) {
      subtract_parts(partial);
      __syncthreads();
    }
    sums_.for_each(
        [&](int row, int column, const S& sum) { shared_.result[row * kColumnsLd<K> + column] -= sum; });
    __syncthreads();
  }

  /// Calls write(row, column, value) for T^-1 result, T being the diagonal tile, whose two 32 x 32 blocks are
  /// inverted. Upper: U (or L^T), from the last block on; lower: L (or U^T).
  template <bool Upper, bool Unit, class Write>
  __device__ void solve_diagonal(const Write& write) {
    constexpr int kBegin = Upper ? 1 : 0, kEnd = 1 - kBegin;
    S* const solved = shared_.x;
    const auto half = [](S* block, int which) { return block + which * kInverted * kColumnsLd<K>; };
    const auto inverse = [&](int which) {
      const auto entry = entries(part_.last_step, which * kInverted, which * kInverted);
      multiply(
          [&](int row, int k) {
            const S value = entry(row, k);
            return k == row && Unit ? S(1) : (Upper ? k < row : k > row) ? S(0) : value;
          },
          half(shared_.result, which),
          [&](int row, int column, const S& sum) {
            half(solved, which)[row * kColumnsLd<K> + column] = sum;
            write(which * kInverted + row, column, sum);
          });
    };
    const bool both = width_ > kInverted;
    if (both || !Upper) inverse(kBegin);
    if (both) {
      __syncthreads();
      multiply(entries(part_.last_step, kEnd * kInverted, kBegin * kInverted), half(solved, kBegin),
               [&](int row, int column, const S& sum) {
                 half(shared_.result, kEnd)[row * kColumnsLd<K> + column] -= sum;
               });
      __syncthreads();
    }
    if (both || Upper) inverse(kEnd);
  }

 private:
  // Calls before_last() where the last step may have to wait for the results of another tile.
  template <class BeforeLast>
  __device__ void add_steps(const S* vector, const BeforeLast& before_last) {
    const int first = part_.first_step, last = part_.last_step;
    VectorAhead<S, K> ahead(vector);
    const auto look_up = [&](int step) {
      if (step < last) ahead.look_up([&](int row) { return place_(step, row); });
    };
    look_up(first);
    if (first < last) ahead.ask();
    look_up(first + 1);
    sums_.clear();
    for (int step = first; step < last; ++step) {
      __syncthreads();  // nobody needs the panel and the rows before any more
      fetch(step + 1);
      if (step + 1 == last) before_last();
      ahead.settle(shared_.x);
      wait_copies<1>();
      __syncthreads();
      if (step + 1 < last) ahead.ask();
      look_up(step + 2);
      sums_.template multiply<kStep>(entries(step, 0, 0), shared_.x);
    }
    wait_copies<0>();
  }

  // result -= what the parts before have left, by the thread that has set that entry of the result.
  __device__ void subtract_parts(const S* partial) {
    for (int i = threadIdx.x; i < kSolveTile * K && part_.parts > 0; i += kSolveThreads) {
      S total = S(0);
      for (int part = 0; part < part_.parts; ++part) {
        const S* const from = place_of(partial, part) + i;
        S value = peek(from);
        while (is_unset(value)) value = peek(from);
        total += value;
      }
      shared_.result[i / K * kColumnsLd<K> + i % K] -= total;
    }
  }
  template <class Entry>
  __device__ Entry* place_of(Entry* partial, int part) const {
    return partial + (part_.place + part) * (kSolveTile * K);
  }

  __device__ void fetch(int step) {
    if (step < part_.last_step || part_.finishes)
      fetch_panel<Transposed>(panel_(step), width_, shared_.panel(step));
    commit_copies();
  }
  /// Of the panel of this step, from (row, k) on.
  __device__ auto entries(int step, int row, int k) const {
    const S* const at = shared_.panel(step) + row * Place::row + k * Place::k;
    return [at](int i, int j) { return at[i * Place::row + j * Place::k]; };
  }
  template <class Entry, class Take>
  __device__ static void multiply(const Entry& entry, const S* x, const Take& take) {
    TileSums<S, K, kInverted> sums;
    sums.clear();
    sums.template multiply<kInverted>(entry, x);
    sums.for_each(take);
  }

  const SolveShared<S, K>& shared_;
  const SolvePart& part_;
  int width_;
  const PanelOf& panel_;
  const PlaceOf& place_;
  TileSums<S, K, kSolveTile> sums_;
};
template <bool Transposed, int K, class S, class PanelOf, class PlaceOf>
__device__ auto tile_sweep(const SolveShared<S, K>& shared, const SolvePart& part, int width,
                           const PanelOf& panel, const PlaceOf& place) {
  return TileSweep<Transposed, K, S, PanelOf, PlaceOf>(shared, part, width, panel, place);
}

template <class S>
__device__ Panel<S> diagonal_panel(const SolveTile<S>& tile) {
  return {tile.front.lower + (tile.pivots ? tile.begin + tile.begin * tile.ld : 0), tile.ld,
          tile.pivots ? tile.width : 0};
}

// What the children have left for a row of the front, column c.
template <int K, class S, class Value>
__device__ S from_children(const DeviceStore<S, Value>& store, const S* border, Offset row, int c) {
  S sum = S(0);
  for (Offset s = store.source_begin[row]; s < store.source_begin[row + 1]; ++s)
    sum += border[store.source[s] * K + c];
  return sum;
}

template <bool Transposed, int K, class S, class Value>
__global__ void __launch_bounds__(kSolveThreads, kSolveBlocks<K>)
    substitute_forward(DeviceStore<S, Value> store, DeviceVectors<S> vectors, Offset first) {
  extern __shared__ __align__(16) unsigned char memory[];
  const SolveShared<S, K> shared(memory);
  const SolvePart part = store.solve[first + blockIdx.x];
  const SolveTile<S> tile = solve_tile(store.fronts, part);
  const Front<S>& front = tile.front;
  const Offset pivots_at = store.fronts.pivot_begin[part.front];
  const int before = tile.pivots ? tile.begin : front.pivots;
  const S* left = Transposed ? front.lower + tile.begin * tile.ld : front.lower + tile.begin;
  Offset ld = tile.ld;
  if (Transposed && !tile.pivots) {
    ld = front.pivots;
    left = front.upper + (tile.begin - front.pivots) * ld;
  }
  const auto panel = [&](int step) {
    if (step == (before + kStep - 1) / kStep) return diagonal_panel(tile);
    const int k = step * kStep;
    return Panel<S>{left + (Transposed ? k : k * ld), ld, min(kStep, before - k)};
  };
  const auto place = [&](int step, int row) {
    const int k = step * kStep + row;
    return k < before ? pivots_at + k : Offset(-1);
  };
  auto sweep = tile_sweep<Transposed>(shared, part, tile.width, panel, place);
  for (int i = threadIdx.x; i < kSolveTile * K; i += kSolveThreads) {
    const int r = i / K, c = i % K;
    S value = S(0);
    if (r < tile.width) {
      int row = tile.begin + r;
      if (tile.pivots) {
        if (!Transposed) row = store.fronts.local_row[pivots_at + row];
        value = vectors.v[(pivots_at + row) * K + c];
      }
      value += from_children<K>(store, vectors.border, store.row_begin[part.front] + row, c);
    }
    shared.result[r * kColumnsLd<K> + c] = value;
  }
  sweep.subtract_sums(vectors.y, vectors.partial);
  if (tile.pivots) {
    S* const to = vectors.y + (pivots_at + tile.begin) * K;
    sweep.template solve_diagonal<false, !Transposed>([&](int row, int column, const S& value) {
      if (row < tile.width) to[row * K + column] = value;
    });
  } else {
    S* const to = vectors.border + (store.fronts.border_begin[part.front] + tile.begin - front.pivots) * K;
    for (int i = threadIdx.x; i < tile.width * K; i += kSolveThreads)
      to[i] = shared.result[i / K * kColumnsLd<K> + i % K];
  }
}

template <bool Transposed, int K, class S, class Value>
__global__ void __launch_bounds__(kSolveThreads, kSolveBlocks<K>)
    substitute_backward(DeviceStore<S, Value> store, DeviceVectors<S> vectors, Offset first) {
  extern __shared__ __align__(16) unsigned char memory[];
  const SolveShared<S, K> shared(memory);
  const SolvePart part = store.solve[first + blockIdx.x];
  const SolveTile<S> tile = solve_tile(store.fronts, part);
  const Front<S>& front = tile.front;
  const Offset pivots_at = store.fronts.pivot_begin[part.front];
  const Vertex* const border_rows = store.fronts.border + store.fronts.border_begin[part.front];
  const auto row_of = [&](int pivot) {
    return pivots_at + Offset(Transposed ? store.fronts.local_row[pivots_at + pivot] : pivot);
  };
  // The border, whose rows are done, then what is right of the tile in the pivot block, last columns first.
  const int of_border = (front.border + kStep - 1) / kStep, after = tile.begin + tile.width;
  const int steps = of_border + (front.pivots - after + kStep - 1) / kStep;
  const auto column_of = [&](int step) {
    return step < of_border ? step * kStep : after + (steps - 1 - step) * kStep;
  };
  const auto panel = [&](int step) {
    if (step >= steps) return diagonal_panel(tile);
    const bool border = step < of_border;
    const int k = column_of(step), count = min(kStep, (border ? front.border : front.pivots) - k);
    if (Transposed)
      return Panel<S>{front.lower + (border ? front.pivots : 0) + k + tile.begin * tile.ld, tile.ld, count};
    const Offset ld = border ? Offset(front.pivots) : tile.ld;
    return Panel<S>{(border ? front.upper : front.lower) + tile.begin + k * ld, ld, count};
  };
  const auto place = [&](int step, int row) {
    const int k = column_of(step) + row;
    if (step < of_border) return k < front.border ? Offset(border_rows[k]) : Offset(-1);
    return k < front.pivots ? row_of(k) : Offset(-1);
  };
  auto sweep = tile_sweep<Transposed>(shared, part, tile.width, panel, place);
  if (!part.finishes) {
    sweep.leave_sums(vectors.v, vectors.partial);
    return;
  }
  for (int i = threadIdx.x; i < kSolveTile * K; i += kSolveThreads) {
    const int r = i / K;
    shared.result[r * kColumnsLd<K> + i % K] =
        r < tile.width ? vectors.y[(pivots_at + tile.begin) * K + i] : S(0);
  }
  sweep.subtract_sums(vectors.v, vectors.partial);
  sweep.template solve_diagonal<true, Transposed>([&](int row, int column, const S& value) {
    if (row < tile.width) vectors.v[row_of(tile.begin + row) * K + column] = value;
  });
}

}  // namespace mfs::cuda
