// Stage "solve" of tiny fronts, a warp each: they have at most 32 pivots, so that a lane has one. Columns are
// taken some at a time, with each entry of the factor read once for all of them.
#pragma once

#include "kernels/cuda/solve/substitution.hpp"

namespace mfs::cuda {

constexpr int kTinyFrontsPerBlock = 4;

/// Columns that a lane has in registers.
template <int K>
constexpr int kTinyColumns = K < 4 ? K : 4;

// sum(c) += or -= the sum over k < count <= 32 of entry(k) times other(c) of lane k, which is zero from
// `count` on. Entries are asked for 16 at a time: a warp has nothing else to do until they come.
template <int C, class S, class Entry>
__device__ void add_products(int count, bool minus, const Entry& entry, const S (&other)[C], S (&sum)[C]) {
  constexpr int kAtOnce = 16;
  for (int begin = 0; begin < count; begin += kAtOnce) {
    S value[kAtOnce];
#pragma unroll
    for (int k = 0; k < kAtOnce; ++k) value[k] = begin + k < count ? entry(begin + k) : S(0);
#pragma unroll
    for (int k = 0; k < kAtOnce; ++k) {
#pragma unroll
      for (int c = 0; c < C; ++c) {
        const S product = value[k] * shuffle(other[c], begin + k);
        sum[c] = minus ? sum[c] - product : sum[c] + product;
      }
    }
  }
}

// x := U^-1 x, or U^-T x, for p <= 32 pivots; entry(k) is that of the lane's row of the triangle.
template <bool Upper, int C, class S, class Entry>
__device__ void substitute_pivots(int p, const Entry& entry, S (&x)[C]) {
  constexpr int kAtOnce = 16;
  const int lane = threadIdx.x % kWarp;
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
        const S solved = shuffle(x[c] * reciprocal, k);
        x[c] = lane == k ? solved : x[c] - value[j] * solved;
      }
    }
  }
}

// What the children, of a launch before, have left for a row of the front, column c.
template <int K, class S, class Value>
__device__ S from_children(const DeviceStore<S, Value>& store, const S* border, Offset row, int c) {
  S sum = S(0);
  for (Offset s = store.source_begin[row]; s < store.source_begin[row + 1]; ++s) sum += border[s * K + c];
  return sum;
}

template <bool Transposed, bool Substituted, int K, class S, class Value>
__global__ void __launch_bounds__(kTinyFrontsPerBlock* kWarp)
    substitute_tiny_forward(DeviceStore<S, Value> store, DeviceVectors<S> vectors, Offset first, int count) {
  constexpr int C = kTinyColumns<K>;
  const int place = static_cast<int>(blockIdx.x) * kTinyFrontsPerBlock + threadIdx.x / kWarp;
  if (place >= count) return;
  const Vertex f = store.tiny_fronts[first + place];
  const Front<S> front = store.fronts.front(f);
  const int p = front.pivots, b = front.border, ld = front.lower_ld, lane = threadIdx.x % kWarp;
  const Offset pivots_at = store.fronts.pivot_begin[f], border_at = store.fronts.border_begin[f];
  const Offset rows_at = store.row_begin[f];
  const bool has_pivot = lane < p;
  const int own = has_pivot && !Transposed ? store.fronts.local_row[pivots_at + lane] : lane;
  for (int column = 0; column < K; column += C) {
    S v[C], y[C];
#pragma unroll
    for (int c = 0; c < C; ++c) {
      v[c] = has_pivot ? vectors.v[(pivots_at + own) * K + column + c] +
                             from_children<K>(store, vectors.border, rows_at + own, column + c)
                       : S(0);
      y[c] = Transposed ? S(0) : v[c];
    }
    if constexpr (Substituted) {
      static_assert(Transposed);
#pragma unroll
      for (int c = 0; c < C; ++c) y[c] = v[c];
      substitute_pivots<false>(
          p, [&](int k) { return front.lower[k + lane * ld]; }, y);
    } else {
      add_products(
          p, false,
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
    for (int begin = 0; begin < b; begin += kWarp) {
      const int row = begin + lane;
      const Offset to = row < b ? store.destination[border_at + row] : 0;
      S z[C];
#pragma unroll
      for (int c = 0; c < C; ++c)
        z[c] = row < b ? from_children<K>(store, vectors.border, rows_at + p + row, column + c) : S(0);
      add_products(
          p, true,
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
    substitute_tiny_backward(DeviceStore<S, Value> store, DeviceVectors<S> vectors, Offset first, int count) {
  constexpr int C = kTinyColumns<K>;
  const int place = static_cast<int>(blockIdx.x) * kTinyFrontsPerBlock + threadIdx.x / kWarp;
  if (place >= count) return;
  const Vertex f = store.tiny_fronts[first + place];
  const Front<S> front = store.fronts.front(f);
  const int p = front.pivots, b = front.border, ld = front.lower_ld, lane = threadIdx.x % kWarp;
  const Offset pivots_at = store.fronts.pivot_begin[f], border_at = store.fronts.border_begin[f];
  const bool has_pivot = lane < p;
  for (int column = 0; column < K; column += C) {
    S sum[C], x[C];
#pragma unroll
    for (int c = 0; c < C; ++c) sum[c] = has_pivot ? vectors.y[(pivots_at + lane) * K + column + c] : S(0);
    const auto border_row = [&](int begin) {
      return begin + lane < b ? Offset(store.fronts.border[border_at + begin + lane]) : Offset(-1);
    };
    Offset next = border_row(0);
    for (int begin = 0; begin < b; begin += kWarp) {
      const int here = min(kWarp, b - begin);
      const Offset at = next;
      next = border_row(begin + kWarp);
#pragma unroll
      for (int c = 0; c < C; ++c) x[c] = at < 0 ? S(0) : vectors.v[at * K + column + c];
      add_products(
          here, true,
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
          p, [&](int k) { return front.lower[lane + k * ld]; }, x);
    } else {
      add_products(
          p, false,
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

}  // namespace mfs::cuda
