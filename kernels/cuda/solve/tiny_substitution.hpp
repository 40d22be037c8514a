// Stage "solve" of tiny fronts, a warp each: they have at most 32 pivots, so that a lane has one. Columns are
// taken some at a time, with each entry of the factor read once for all of them. Where there are more columns
// than a lane has registers for, and few pivots, groups of lanes take columns of their own.
#pragma once

#include "kernels/cuda/solve/substitution.hpp"

namespace mfs::cuda {

constexpr int kTinyFrontsPerBlock = 4;

/// Columns that a lane has in registers.
template <int K>
constexpr int kTinyColumns = K < 4 ? K : 4;

/// A lane's place among those that share columns: Rows of them, a row each.
template <int Rows>
struct LaneGroup {
  const int lane = threadIdx.x % Rows, begin = threadIdx.x % kWarp - lane;
};
/// Calls work with groups of 8, 16 or 32 lanes: as many as p pivots need.
template <int K, class Work>
__device__ void with_lane_groups(int p, const Work& work) {
  if constexpr (K > kTinyColumns<K>) {
    if (p <= 8) return work(LaneGroup<8>());
    if (p <= 16) return work(LaneGroup<16>());
  }
  work(LaneGroup<kWarp>());
}
/// Columns that the groups of a warp take at once.
template <int Rows, int K>
constexpr int kColumnsAtOnce = K > kTinyColumns<K> ? (kWarp / Rows) * kTinyColumns<K> : K;

/// A lane's numbers, where others read them: several in shared memory, from where a group takes those of one
/// lane in two loads instead of eight shuffles.
template <int C, class S>
struct alignas(16) LaneNumbers {
  S numbers[C];
};
/// Of a warp; a place more for each group, so that groups read from different banks.
template <int C, class S>
struct WarpNumbers {
  LaneNumbers<C, S> lanes[C > 1 ? kWarp + kWarp / 8 : 1];
};
template <int Rows, int C, class S>
class GroupNumbers {
 public:
  /// To be made by all lanes of the warp, and again for other numbers.
  __device__ GroupNumbers(LaneGroup<Rows> group, WarpNumbers<C, S>& warp, const S (&own)[C])
      : group_(group), lanes_(warp.lanes + group.begin + group.begin / Rows), own_(own[0]) {
    if constexpr (C > 1) {
      __syncwarp();
#pragma unroll
      for (int c = 0; c < C; ++c) lanes_[group.lane].numbers[c] = own[c];
      __syncwarp();
    }
  }
  __device__ LaneNumbers<C, S> of(int lane) const {
    if constexpr (C > 1) {
      return lanes_[lane];
    } else {
      return {shuffle(own_, group_.begin + lane)};
    }
  }

 private:
  LaneGroup<Rows> group_;
  LaneNumbers<C, S>* lanes_;
  S own_;
};

// sum(c) += or -= the sum over k < count <= Rows of entry(k) times other(c) of lane k of the group. Up to 16
// entries are asked for at a time: a warp has nothing else to do until they come.
template <int Rows, int C, class S, class Entry>
__device__ void add_products(LaneGroup<Rows> group, WarpNumbers<C, S>& warp, int count, bool minus,
                             const Entry& entry, const S (&other)[C], S (&sum)[C]) {
  constexpr int kAtOnce = Rows < 16 ? Rows : 16;
  const GroupNumbers<Rows, C, S> others(group, warp, other);
  for (int begin = 0; begin < count; begin += kAtOnce) {
    S value[kAtOnce];
#pragma unroll
    for (int k = 0; k < kAtOnce; ++k) value[k] = begin + k < count ? entry(begin + k) : S(0);
#pragma unroll
    for (int k = 0; k < kAtOnce; ++k) {
      if (C > 1 && begin + k >= count) break;  // one product takes less than the question
      const LaneNumbers<C, S> factor = others.of(begin + k);
#pragma unroll
      for (int c = 0; c < C; ++c) {
        const S product = value[k] * factor.numbers[c];
        sum[c] = minus ? sum[c] - product : sum[c] + product;
      }
    }
  }
}

// x := U^-1 x, or U^-T x, for p <= Rows pivots; entry(k) is that of the lane's row of the triangle.
template <bool Upper, int Rows, int C, class S, class Entry>
__device__ void substitute_pivots(LaneGroup<Rows> group, int p, const Entry& entry, S (&x)[C]) {
  constexpr int kAtOnce = Rows < 16 ? Rows : 16;
  const int lane = group.lane;
  const S reciprocal = lane < p ? reciprocal_of(entry(lane)) : S(0);
  for (int begin = 0; begin < p; begin += kAtOnce) {
    const auto column = [&](int j) { return Upper ? p - 1 - begin - j : begin + j; };
    S value[kAtOnce];
#pragma unroll
    for (int j = 0; j < kAtOnce; ++j) {
      const int k = column(j);
      value[j] = begin + j < p && lane < p && (Upper ? lane < k : lane > k) ? entry(k) : S(0);
    }
#pragma unroll
    for (int j = 0; j < kAtOnce; ++j) {
      const int k = column(j);
      if (begin + j >= p) break;
#pragma unroll
      for (int c = 0; c < C; ++c) {
        const S solved = shuffle(x[c] * reciprocal, group.begin + k);
        x[c] = lane == k ? solved : x[c] - value[j] * solved;
      }
    }
  }
}

/// Calls work(f, front, group, warp's numbers) for the warp's front of `count` from `first` on, if there is
/// one.
template <int K, class S, class Value, class Work>
__device__ void with_tiny_front(const DeviceStore<S, Value>& store, Offset first, int count,
                                const Work& work) {
  const int place = static_cast<int>(blockIdx.x) * kTinyFrontsPerBlock + threadIdx.x / kWarp;
  if (place >= count) return;
  const Vertex f = store.tiny_fronts[first + place];
  const Front<S> front = store.fronts.front(f);
  __shared__ WarpNumbers<kTinyColumns<K>, S> numbers[kTinyFrontsPerBlock];
  with_lane_groups<K>(front.pivots, [&](auto group) { work(f, front, group, numbers[threadIdx.x / kWarp]); });
}

// sum(c) += what the children, of a launch before, have left for a row of the front, from `column` on.
template <int K, int C, class S, class Value>
__device__ void add_children(const DeviceStore<S, Value>& store, const S* border, Offset row, int column,
                             S (&sum)[C]) {
  S left[C];
#pragma unroll
  for (int c = 0; c < C; ++c) left[c] = S(0);
  for (Offset s = store.source_begin[row]; s < store.source_begin[row + 1]; ++s) {
#pragma unroll
    for (int c = 0; c < C; ++c) left[c] += border[s * K + column + c];
  }
#pragma unroll
  for (int c = 0; c < C; ++c) sum[c] += left[c];
}

template <bool Transposed, bool Substituted, int K, int Rows, class S, class Value>
__device__ void substitute_front_forward(const DeviceStore<S, Value>& store, const DeviceVectors<S>& vectors,
                                         Vertex f, const Front<S>& front, LaneGroup<Rows> group,
                                         WarpNumbers<kTinyColumns<K>, S>& warp) {
  constexpr int C = kTinyColumns<K>;
  const int p = front.pivots, b = front.border, ld = front.lower_ld, lane = group.lane;
  const Offset pivots_at = store.fronts.pivot_begin[f], border_at = store.fronts.border_begin[f];
  const Offset rows_at = store.row_begin[f];
  const bool has_pivot = lane < p;
  const int own = has_pivot && !Transposed ? store.fronts.local_row[pivots_at + lane] : lane;
  for (int column = group.begin / Rows * C; column < K; column += kColumnsAtOnce<Rows, K>) {
    S v[C], y[C];
#pragma unroll
    for (int c = 0; c < C; ++c) v[c] = has_pivot ? vectors.v[(pivots_at + own) * K + column + c] : S(0);
    if (has_pivot) add_children<K>(store, vectors.border, rows_at + own, column, v);
#pragma unroll
    for (int c = 0; c < C; ++c) y[c] = Transposed ? S(0) : v[c];
    if constexpr (Substituted) {
      static_assert(Transposed);
#pragma unroll
      for (int c = 0; c < C; ++c) y[c] = v[c];
      substitute_pivots<false>(
          group, p, [&](int k) { return front.lower[k + lane * ld]; }, y);
    } else {
      add_products(
          group, warp, p, false,
          [&](int k) {
            if (!has_pivot || (Transposed ? k > lane : k >= lane)) return S(0);
            return Transposed ? front.lower[k + lane * ld] : front.lower[lane + k * ld];
          },
          v, y);
    }
#pragma unroll
    for (int c = 0; c < C; ++c) {
      if (has_pivot) vectors.y[(pivots_at + lane) * K + column + c] = y[c];
    }
    for (int begin = 0; begin < b; begin += Rows) {
      const int row = begin + lane;
      const Offset to = row < b ? store.destination[border_at + row] : 0;
      S z[C];
#pragma unroll
      for (int c = 0; c < C; ++c) z[c] = S(0);
      if (row < b) add_children<K>(store, vectors.border, rows_at + p + row, column, z);
      add_products(
          group, warp, p, true,
          [&](int k) {
            if (row >= b) return S(0);
            return Transposed ? front.upper[k + row * p] : front.lower[p + row + k * ld];
          },
          y, z);
#pragma unroll
      for (int c = 0; c < C; ++c) {
        if (row < b) vectors.border[to * K + column + c] = z[c];
      }
    }
  }
}

template <bool Transposed, bool Substituted, int K, class S, class Value>
__global__ void __launch_bounds__(kTinyFrontsPerBlock* kWarp)
    substitute_tiny_forward(DeviceStore<S, Value> store, DeviceVectors<S> vectors, Offset first, int count) {
  with_tiny_front<K>(store, first, count, [&](Vertex f, const Front<S>& front, auto group, auto& warp) {
    substitute_front_forward<Transposed, Substituted, K>(store, vectors, f, front, group, warp);
  });
}

template <bool Transposed, bool Substituted, int K, int Rows, class S, class Value>
__device__ void substitute_front_backward(const DeviceStore<S, Value>& store, const DeviceVectors<S>& vectors,
                                          Vertex f, const Front<S>& front, LaneGroup<Rows> group,
                                          WarpNumbers<kTinyColumns<K>, S>& warp) {
  constexpr int C = kTinyColumns<K>;
  const int p = front.pivots, b = front.border, ld = front.lower_ld, lane = group.lane;
  const Offset pivots_at = store.fronts.pivot_begin[f], border_at = store.fronts.border_begin[f];
  const bool has_pivot = lane < p;
  for (int column = group.begin / Rows * C; column < K; column += kColumnsAtOnce<Rows, K>) {
    S sum[C], x[C];
#pragma unroll
    for (int c = 0; c < C; ++c) sum[c] = has_pivot ? vectors.y[(pivots_at + lane) * K + column + c] : S(0);
    const auto border_row = [&](int begin) {
      return begin + lane < b ? Offset(store.fronts.border[border_at + begin + lane]) : Offset(-1);
    };
    Offset next = border_row(0);
    for (int begin = 0; begin < b; begin += Rows) {
      const int here = min(Rows, b - begin);
      const Offset at = next;
      next = border_row(begin + Rows);
#pragma unroll
      for (int c = 0; c < C; ++c) x[c] = at < 0 ? S(0) : vectors.v[at * K + column + c];
      add_products(
          group, warp, here, true,
          [&](int k) {
            if (!has_pivot) return S(0);
            return Transposed ? front.lower[p + begin + k + lane * ld] : front.upper[lane + (begin + k) * p];
          },
          x, sum);
    }
#pragma unroll
    for (int c = 0; c < C; ++c) x[c] = Transposed || Substituted ? sum[c] : S(0);
    if constexpr (Substituted) {
      static_assert(!Transposed);
      substitute_pivots<true>(
          group, p, [&](int k) { return front.lower[lane + k * ld]; }, x);
    } else {
      add_products(
          group, warp, p, false,
          [&](int k) {
            if (!has_pivot || (Transposed ? k <= lane : k < lane)) return S(0);
            return Transposed ? front.lower[k + lane * ld] : front.lower[lane + k * ld];
          },
          sum, x);
    }
    const int row = has_pivot && Transposed ? store.fronts.local_row[pivots_at + lane] : lane;
#pragma unroll
    for (int c = 0; c < C; ++c) {
      if (has_pivot) vectors.v[(pivots_at + row) * K + column + c] = x[c];
    }
  }
}

template <bool Transposed, bool Substituted, int K, class S, class Value>
__global__ void __launch_bounds__(kTinyFrontsPerBlock* kWarp)
    substitute_tiny_backward(DeviceStore<S, Value> store, DeviceVectors<S> vectors, Offset first, int count) {
  with_tiny_front<K>(store, first, count, [&](Vertex f, const Front<S>& front, auto group, auto& warp) {
    substitute_front_backward<Transposed, Substituted, K>(store, vectors, f, front, group, warp);
  });
}

}  // namespace mfs::cuda
