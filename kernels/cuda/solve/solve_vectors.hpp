// What a solve does with its vectors beside the substitutions, each in one pass over all K columns: into
// elimination order and back, with scaling, and the residual with its backward error (Oettli and Prager 1964,
// as in kernels/stages/residual.hpp).
//
// Vectors of the solve itself have their K columns side by side, (i, c) at i * K + c; those of the caller are
// columns one after the other and may have fewer.
#pragma once

#include "kernels/cuda/factor/reductions.hpp"
#include "kernels/cuda/runtime/device_scalar.hpp"
#include "kernels/stages/residual.hpp"

namespace mfs::cuda {

/// A caller's vectors.
template <class V>
struct Columns {
  V* data;
  Offset ld;
  int count;
};
/// How one side of the system is permuted and scaled: position -> row (or column) of A, and its scale.
struct Side {
  const Vertex* index;
  const double* scale;
};

/// Rows [first, first + kRows) of K columns, on their way between columns one after the other and side by
/// side: either is read and written in whole lines of memory.
template <int K, class V>
class TurnedRows {
 public:
  static constexpr int kRows = K == 1 ? kVectorThreads : 64;
  static constexpr int kApart = K + 1;  // so that neighbours of a column lie in different banks
  static unsigned blocks(Offset n) { return static_cast<unsigned>((n + kRows - 1) / kRows); }
  __device__ TurnedRows(V* memory, Offset n) : memory_(memory), first_(blockIdx.x * Offset{kRows}), n_(n) {}

  /// Calls work(row, column, number) with those of a column after the other.
  template <class Work>
  __device__ void by_columns(const Work& work) const {
    for (int e = threadIdx.x; e < kRows * K; e += kVectorThreads) {
      const int row = e % kRows, column = e / kRows;
      if (first_ + row < n_) work(first_ + row, column, memory_[row * kApart + column]);
    }
  }
  /// Calls work(place, number) with those of a row after the other, whose places have no gaps.
  template <class Work>
  __device__ void by_rows(const Work& work) const {
    for (int e = threadIdx.x; e < kRows * K; e += kVectorThreads) {
      const Offset place = first_ * K + e;
      if (place < n_ * K) work(place, memory_[e / K * kApart + e % K]);
    }
  }

 private:
  V* const memory_;
  const Offset first_, n_;
};
template <int K, class V>
struct TurningMemory {
  __align__(16) unsigned char bytes[TurnedRows<K, V>::kRows * TurnedRows<K, V>::kApart * sizeof(V)];
};

/// The caller's columns side by side; those that it has not got become zero.
template <int K, class V>
__global__ void __launch_bounds__(kVectorThreads) gather_columns(Offset n, Columns<const V> from, V* to) {
  __shared__ TurningMemory<K, V> memory;
  const TurnedRows<K, V> rows(reinterpret_cast<V*>(memory.bytes), n);
  rows.by_columns(
      [&](Offset i, int c, V& number) { number = c < from.count ? from.data[i + c * from.ld] : V(0); });
  __syncthreads();
  rows.by_rows([&](Offset place, const V& number) { to[place] = number; });
}

/// to(position) = scale * from(index[position]). A NaN of the caller must not look like the substitutions'
/// kUnset.
template <int K, class S, class V>
__global__ void __launch_bounds__(kVectorThreads)
    enter_elimination_order(Offset n, Side side, const V* from, S* to) {
  const Offset at = blockIdx.x * static_cast<Offset>(kVectorThreads) + threadIdx.x;
  if (at >= n * K) return;
  const Offset i = side.index[at / K];
  const V value = from[i * K + at % K] * static_cast<RealOf<V>>(side.scale[i]);
  to[at] = without_payload(static_cast<S>(value));
}

/// x(index[position]) = scale * from(position), or += that.
template <int K, class S, class V>
__global__ void __launch_bounds__(kVectorThreads)
    leave_elimination_order(Offset n, Side side, const S* from, bool add, V* x) {
  const Offset at = blockIdx.x * static_cast<Offset>(kVectorThreads) + threadIdx.x;
  if (at >= n * K) return;
  const Offset i = side.index[at / K];
  V& to = x[i * K + at % K];
  const V value = V(from[at]) * static_cast<RealOf<V>>(side.scale[i]);
  to = add ? to + value : value;
}

/// The caller's columns of x, if *error is at most `bound`.
template <int K, class V>
__global__ void __launch_bounds__(kVectorThreads)
    write_columns(Offset n, const V* x, Columns<V> to, const double* error, double bound) {
  if (!(*error <= bound)) return;
  if constexpr (K == 1) {
    const Offset i = blockIdx.x * static_cast<Offset>(kVectorThreads) + threadIdx.x;
    if (i < n) to.data[i] = x[i];
  } else {
    __shared__ TurningMemory<K, V> memory;
    const TurnedRows<K, V> rows(reinterpret_cast<V*>(memory.bytes), n);
    rows.by_rows([&](Offset place, V& number) { number = x[place]; });
    __syncthreads();
    rows.by_columns([&](Offset i, int c, const V& number) {
      if (c < to.count) to.data[i + c * to.ld] = number;
    });
  }
}

/// largest[c] = the largest |x(i, c)| / scale[i]; zero before. Any number of blocks.
template <int K, class V>
__global__ void __launch_bounds__(kVectorThreads)
    largest_unscaled_unknowns(Offset n, const double* scale, const V* x, double* largest) {
  static_assert(kVectorThreads % K == 0);
  const Offset stride = static_cast<Offset>(gridDim.x) * kVectorThreads;
  double most = 0;
  for (Offset at = blockIdx.x * static_cast<Offset>(kVectorThreads) + threadIdx.x; at < n * K; at += stride)
    most = fmax(most, magnitude(x[at]) / scale[at / K]);
  if constexpr (K == 1) {
    raise_to(largest, most);
  } else if (most > 0) {
    atomicMax(reinterpret_cast<unsigned long long*>(largest + threadIdx.x % K), order_of(most));
  }
}

/// What the rows of column c count at least: part * largest[c] / scale of the row; nothing where part is 0.
struct RowFloors {
  double part;
  const double* largest;
};

/// *worst = the largest backward error of all columns, with nothing free, as the host measures again what is
/// too large; zero before. Where `r` is not null the rows are taken by position, and r(position) = scale *
/// (b - A x), ready for a step of refinement. Any number of blocks.
template <int K, int Lanes, class S, class V>
__global__ void __launch_bounds__(kVectorThreads)
    residual_in_elimination_order(Offset n, RowAccess<V> a, Side side, Columns<const V> b, const V* x, S* r,
                                  RowFloors floors, double* worst) {
  static_assert(K == 1 || K == Lanes);
  constexpr int kRows = kVectorThreads / Lanes;
  constexpr int kApart = K == 1 ? Lanes : 1;  // entries of a row that a lane takes
  // Of them, where rows are long: one of 81 entries has three for each lane.
  constexpr int kAtOnce = K == 1 && Lanes == kLongRowLanes ? 3 : 1, kUnrolled = kAtOnce > 1 ? 1 : 4;
  const int lane = threadIdx.x % Lanes, column = K == 1 ? 0 : lane;
  using Sum = decltype(widened(*x));
  double error = 0;
  for (Offset first = blockIdx.x * static_cast<Offset>(kRows); first < n;
       first += gridDim.x * static_cast<Offset>(kRows)) {
    const Offset place = first + threadIdx.x / Lanes;
    const bool inside = place < n;
    const Offset i = inside && r ? side.index[place] : place;
    const Offset end = inside ? a.offsets[i + 1] : 0;
    const bool has_right = inside && column < b.count;
    const Sum right = has_right ? widened(b.data[i + column * b.ld]) : Sum(0);
    Sum sum(0);
    double size = 0;
#pragma unroll kUnrolled
    for (Offset k = inside ? a.offsets[i] + (K == 1 ? lane : 0) : 0; k < end; k += kAtOnce * kApart) {
      V value[kAtOnce];
      Vertex unknown[kAtOnce];
#pragma unroll
      for (int j = 0; j < kAtOnce; ++j) {
        const Offset at = k + j * kApart;
        unknown[j] = at < end ? a.columns[at] : -1;
        value[j] = at < end ? a.values[a.slots ? a.slots[at] : at] : V(0);
      }
      Sum product[kAtOnce];
#pragma unroll
      for (int j = 0; j < kAtOnce; ++j) {
        product[j] = unknown[j] < 0
                         ? Sum(0)
                         : widened(value[j]) * widened(x[unknown[j] * static_cast<Offset>(K) + column]);
      }
#pragma unroll
      for (int j = 0; j < kAtOnce; ++j) {
        sum -= product[j];
        size += magnitude(product[j]);
      }
    }
    if constexpr (K == 1) {
      sum = group_sum<Lanes>(sum);
      size = group_sum<Lanes>(size);
    }
    if (has_right) {
      sum += right;
      size += magnitude(right);
      if (floors.part > 0) size += floors.part * floors.largest[column] / side.scale[i];
      error = fmax(error, row_error(magnitude(sum), size));
      V rounded;
      narrow(sum, rounded);
      if (r && (K > 1 || lane == 0))
        r[place * K + column] = static_cast<S>(rounded * static_cast<RealOf<V>>(side.scale[i]));
    } else if (inside && r && K > 1) {
      r[place * K + column] = S(0);
    }
  }
  raise_to(worst, error);
}

}  // namespace mfs::cuda
