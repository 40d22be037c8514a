// A tile of the solve for K = 4 or 16 columns at once: products of 64 x 64 panels with 64 x K of the vector,
// on the tensor cores. Panels come through two places in shared memory, one step ahead.
#pragma once

#include "kernels/cuda/solve/solve_tile.hpp"

namespace mfs::cuda {

/// Sums of 64 x K by tiles of 16 x 8, one for each warp of the block; the others wait. A tile may be wider
/// than K: what stands right of the vector in shared memory makes columns that nobody asks for.
template <class S, int K>
struct TileSums {
  static constexpr int kWide = K < 8 ? 8 : K;
  static_assert(kSolveTile / 16 * (kWide / 8) * kWarp <= kSolveThreads);
  WarpTile<S, 1, 1> sum;

  __device__ static int warp_row() { return threadIdx.x / kWarp % (kSolveTile / 16) * 16; }
  __device__ static int warp_column() { return threadIdx.x / kWarp / (kSolveTile / 16) * 8; }
  __device__ static bool has_tile() { return warp_column() < kWide; }

  /// += B x for 64 columns of B = entry(row, k) and as many rows of x, of leading dimension ld.
  template <class Entry>
  __device__ void multiply(const Entry& entry, const S* x, int ld) {
    if (!has_tile()) return;
    const int first = warp_row();
    sum.multiply_entries([&](int row, int k) { return entry(first + row, k); }, x + warp_column(), ld, 1,
                         kStep);
  }
  /// Calls body(row, column, sum), once for each.
  template <class Body>
  __device__ void for_each(const Body& body) {
    if (!has_tile()) return;
    sum.for_each([&](int row, int column, S& value) {
      column += warp_column();
      if (column < K) body(warp_row() + row, column, value);
    });
  }
};

/// The 64 rows of the vector that a step multiplies: asked for ahead, waited for when they are needed.
template <class S, int K>
class VectorAhead {
 public:
  __device__ explicit VectorAhead(const S* vector) : vector_(vector) {}

  /// place(i) for rows i = 0...63: the row of the vector, -1 for none.
  template <class Place>
  __device__ void look_up(const Place& place) {
#pragma unroll
    for (int j = 0; j < kTimes; ++j) next_[j] = place(row(j));
  }
  __device__ void ask() {
#pragma unroll
    for (int j = 0; j < kTimes; ++j) {
      at_[j] = next_[j];
      value_[j] = at_[j] < 0 ? S(0) : peek(vector_ + at_[j] * K + column());
    }
  }
  __device__ void settle(S* x, int ld, int tiles) {
#pragma unroll
    for (int j = 0; j < kTimes; ++j)
      x[row(j) * ld + column()] =
          at_[j] < 0 ? S(0) : wait_for(vector_ + at_[j] * K + column(), value_[j], tiles);
  }

 private:
  static constexpr int kTimes = kSolveTile * K / kSolveThreads;
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

/// The sum over the steps of a part of panel(step) times the rows place(step, 0...63) of the vector. Where
/// the part finishes its tile, panel(last_step) is the diagonal tile.
template <bool Transposed, int K, class S, class PanelOf, class PlaceOf>
class TileSweep {
  using Place = PanelPlace<Transposed, K>;
  static constexpr int kLd = K + 4, kBlock = kSolveTile * kLd, kStages = 2;
  static_assert(kLd >= TileSums<S, K>::kWide);

 public:
  static constexpr std::size_t bytes = sizeof(S) * (kStages * Place::entries + 2 * kBlock);

  /// Asks for the first panel.
  __device__ TileSweep(void* memory, const SolvePart& part, int width, const PanelOf& panel,
                       const PlaceOf& place)
      : stage_(static_cast<S*>(memory)),
        x_(stage_ + kStages * Place::entries),
        result_(x_ + kBlock),
        part_(part),
        width_(width),
        panel_(panel),
        place_(place) {
    fetch(part.first_step);
  }

  /// What the sums are subtracted from.
  __device__ void begin_with(const S (&own)[kOwnEntries<K>]) {
#pragma unroll
    for (int j = 0; j < kOwnEntries<K>; ++j) {
      const int i = threadIdx.x + j * kSolveThreads;
      result_[i / K * kLd + i % K] = own[j];
    }
  }

  /// partial = the sums, for the part that finishes the tile.
  __device__ void leave_sums(const S* vector, S* partial) {
    S* const to = partial + part_.place * (kSolveTile * K);
    add_steps(vector, [] {});
    sums_.for_each([&](int row, int column, const S& sum) { to[row * K + column] = sum; });
  }

  /// Subtracts the sums of all parts.
  __device__ void subtract_sums(const S* vector, const S* partial) {
    add_steps(vector, [&] { subtract_parts(partial); });
    if (part_.first_step == part_.last_step) {
      subtract_parts(partial);
      __syncthreads();
    }
    sums_.for_each([&](int row, int column, const S& sum) { result_[row * kLd + column] -= sum; });
    __syncthreads();
  }
  /// Calls write(row, column, value) for what is left.
  template <class Write>
  __device__ void write_rest(const Write& write) {
    for (int i = threadIdx.x; i < kSolveTile * K; i += kSolveThreads)
      write(i / K, i % K, result_[i / K * kLd + i % K]);
  }
  /// The same for T^-1 times that, T being the diagonal tile, which is inverted. Upper: U (or L^T); else L
  /// (or U^T).
  template <bool Upper, bool Unit, class Write>
  __device__ void solve_diagonal(const Write& write) {
    TileSums<S, K> solved;
    solved.sum.clear();
    const auto inverse = entries(part_.last_step);
    solved.multiply([&](int row, int k) { return triangle_entry<Upper, Unit>(inverse(row, k), row, k); },
                    result_, kLd);
    solved.for_each(write);
  }
  /// The same where T is U, or its transposed, as it is: by some warps, a few columns each.
  template <bool Upper, class Write>
  __device__ void substitute_diagonal(const Write& write) {
    constexpr int kWarps = kSolveThreads / kWarp, kEach = (K + kWarps - 1) / kWarps;
    const int lane = threadIdx.x % kWarp, first = static_cast<int>(threadIdx.x) / kWarp * kEach;
    if (first >= K) return;
    S x[2][kEach];
#pragma unroll
    for (int i = 0; i < 2; ++i) {
#pragma unroll
      for (int c = 0; c < kEach; ++c) x[i][c] = result_[(lane + i * kWarp) * kLd + first + c];
    }
    substitute_tile<Upper>(width_, entries(part_.last_step), x);
#pragma unroll
    for (int i = 0; i < 2; ++i) {
#pragma unroll
      for (int c = 0; c < kEach; ++c) write(lane + i * kWarp, first + c, x[i][c]);
    }
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
    sums_.sum.clear();
    for (int step = first; step < last; ++step) {
      __syncthreads();  // nobody needs the panel and the rows before any more
      fetch(step + 1);
      if (step + 1 == last) before_last();
      ahead.settle(x_, kLd, tiles_after(part_, step));
      wait_copies<1>();
      __syncthreads();
      if (step + 1 < last) ahead.ask();
      look_up(step + 2);
      sums_.multiply(entries(step), x_, kLd);
    }
    wait_copies<0>();
  }

  // By the thread that has set that entry of the result.
  __device__ void subtract_parts(const S* partial) {
    for (int i = threadIdx.x; i < kSolveTile * K && part_.parts > 0; i += kSolveThreads)
      result_[i / K * kLd + i % K] -= sum_of_parts<K>(part_, partial, i);
  }

  __device__ S* stage(int step) const {
    return stage_ + step % kStages * Place::entries;
  }
  __device__ void fetch(int step) {
    if (step < part_.last_step || part_.finishes)
      fetch_panel<Transposed, K>(panel_(step), width_, stage(step));
    commit_copies();
  }
  __device__ auto entries(int step) const {
    const S* const at = stage(step);
    return [at](int row, int k) { return at[row * Place::row + k * Place::k]; };
  }

  S *stage_, *x_, *result_;
  const SolvePart& part_;
  int width_;
  const PanelOf& panel_;
  const PlaceOf& place_;
  TileSums<S, K> sums_;
};

}  // namespace mfs::cuda
