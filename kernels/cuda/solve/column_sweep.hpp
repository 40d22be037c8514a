// A tile of the solve for one column. Each entry of the factor is needed once, so it goes from memory to the
// registers of the thread that multiplies it: each warp takes 32 rows and 16 of the 64 columns of every step,
// with the part of the vector that meets them, and no barrier stands between the steps. What of the factor
// comes next is on its way while a warp waits for the vector, and what comes after that goes to the L2.
//
// From the last entries that a tile waits for to the first that others wait for: 16 multiplications, a
// barrier, 16 with the inverse of the diagonal tile, a barrier.
#pragma once

#include "kernels/cuda/solve/solve_tile.hpp"

namespace mfs::cuda {

/// As TileSweep, for K = 1.
template <bool Transposed, class S, class PanelOf, class PlaceOf>
class ColumnSweep {
  using Place = PanelPlace<Transposed, 1>;
  static constexpr int kRows = kWarp, kDepth = 16;  // what a warp multiplies of a panel
  static constexpr int kGroups = kStep / kDepth;    // of warps that share a row
  static constexpr int kApart = kWarp / kDepth;     // rows between a lane's entries, transposed
  static constexpr int kParts = 4;  // of a sum, as additions take longer than multiplications begin
  static constexpr int kSums = Transposed ? kDepth : kParts;
  static constexpr int kWarps = kSolveThreads / kWarp;
  static constexpr int kLine = 128 / static_cast<int>(sizeof(S));  // entries

 public:
  static constexpr std::size_t bytes =
      sizeof(S) * (kWarps * kDepth + Place::entries + (1 + 2 * kGroups) * kSolveTile);

  __device__ ColumnSweep(void* memory, const SolvePart& part, int width, const PanelOf& panel,
                         const PlaceOf& place)
      : vector_(static_cast<S*>(memory)),
        diagonal_(vector_ + kWarps * kDepth),
        result_(diagonal_ + Place::entries),
        sums_(result_ + kSolveTile),
        solved_(sums_ + kGroups * kSolveTile),
        part_(part),
        width_(width),
        panel_(panel),
        place_(place) {
    load(part.first_step);
    prefetch(part.first_step + 1);
    if (part.finishes) fetch_panel<Transposed, 1>(panel(part.last_step), width, diagonal_);
    commit_copies();
  }

  __device__ void begin_with(const S (&own)[1]) {
    if (has_row()) result_[threadIdx.x] = own[0];
  }

  __device__ void leave_sums(const S* vector, S* partial) {
    add_steps(vector, [] {});
    share_sums();
    if (has_row()) partial[part_.place * kSolveTile + threadIdx.x] = total_of(sums_, threadIdx.x);
  }

  __device__ void subtract_sums(const S* vector, const S* partial) {
    const auto subtract_parts = [&] {
      if (has_row() && part_.parts > 0) result_[threadIdx.x] -= sum_of_parts<1>(part_, partial, threadIdx.x);
    };
    add_steps(vector, subtract_parts);
    if (part_.first_step == part_.last_step) subtract_parts();
    wait_copies<0>();
    share_sums();
  }
  template <class Write>
  __device__ void write_rest(const Write& write) {
    if (has_row()) write(static_cast<int>(threadIdx.x), 0, rest(threadIdx.x));
  }
  template <bool Upper, bool Unit, class Write>
  __device__ void solve_diagonal(const Write& write) {
    const int row = first_row() + lane();
    const WarpVector x = share(rest(first_column() + lane() % kDepth));
    S sum[kParts];
#pragma unroll
    for (int j = 0; j < kParts; ++j) sum[j] = S(0);
#pragma unroll
    for (int j = 0; j < kDepth; ++j) {
      const int k = first_column() + j;
      sum[j % kParts] +=
          triangle_entry<Upper, Unit>(diagonal_[row * Place::row + k * Place::k], row, k) * x.row[j];
    }
    solved_[group() * kSolveTile + row] = (sum[0] + sum[1]) + (sum[2] + sum[3]);
    __syncthreads();
    if (has_row()) write(static_cast<int>(threadIdx.x), 0, total_of(solved_, threadIdx.x));
  }
  /// The same where the diagonal tile is U, or its transposed, as it is: by one warp.
  template <bool Upper, class Write>
  __device__ void substitute_diagonal(const Write& write) {
    if (threadIdx.x >= kWarp) return;
    S x[2][1];
#pragma unroll
    for (int i = 0; i < 2; ++i) x[i][0] = rest(lane() + i * kWarp);
    substitute_tile<Upper>(
        width_, [&](int row, int k) { return diagonal_[row * Place::row + k * Place::k]; }, x);
#pragma unroll
    for (int i = 0; i < 2; ++i) write(lane() + i * kWarp, 0, x[i][0]);
  }

 private:
  __device__ static int lane() {
    return threadIdx.x % kWarp;
  }
  __device__ static int group() {
    return threadIdx.x / kWarp % kGroups;
  }
  __device__ static int first_row() {
    return threadIdx.x / kWarp / kGroups * kRows;
  }
  __device__ static int first_column() {
    return group() * kDepth;
  }
  __device__ static bool has_row() {
    return threadIdx.x < kSolveTile;
  }

  // This warp's part of a panel. One entry after the other lies in the lanes of a load.
  __device__ void load(int step) {
    if (step >= part_.last_step) return;
    const Panel<S> panel = panel_(step);
    if constexpr (Transposed) {
      const int k = first_column() + lane() % kDepth, row = first_row() + lane() / kDepth;
      const S* const from = panel.base + k + row * panel.ld;
#pragma unroll
      for (int j = 0; j < kDepth; ++j)
        entry_[j] = k < panel.count && row + j * kApart < width_ ? once(from + j * kApart * panel.ld) : S(0);
    } else {
      const int k = first_column(), row = first_row() + lane();
      const S* const from = panel.base + row + k * panel.ld;
#pragma unroll
      for (int j = 0; j < kDepth; ++j)
        entry_[j] = row < width_ && k + j < panel.count ? once(from + j * panel.ld) : S(0);
    }
  }
  __device__ void prefetch(int step) const {
    if (step >= part_.last_step) return;
    const Panel<S> panel = panel_(step);
    const int along = Transposed ? panel.count : width_, apart = Transposed ? width_ : panel.count;
    constexpr int kLines = kSolveTile / kLine;
    for (int i = threadIdx.x; i < kSolveTile * kLines; i += kSolveThreads) {
      const int entry = i % kLines * kLine, column = i / kLines;
      if (entry < along && column < apart) prefetch_line(panel.base + entry + column * panel.ld);
    }
  }

  // The 16 rows of the vector that lanes 0...15 have, for all lanes.
  struct alignas(2 * sizeof(S)) WarpVector {
    S row[kDepth];
  };
  __device__ const WarpVector& share(const S& x) const {
    S* const to = vector_ + threadIdx.x / kWarp * kDepth;
    __syncwarp();
    if (lane() < kDepth) to[lane()] = x;
    __syncwarp();
    return *reinterpret_cast<const WarpVector*>(to);
  }

  __device__ void multiply(const S& x) {
    if constexpr (Transposed) {
#pragma unroll
      for (int j = 0; j < kDepth; ++j) sum_[j] += entry_[j] * x;
    } else {
      const WarpVector shared = share(x);
#pragma unroll
      for (int j = 0; j < kDepth; ++j) sum_[j % kParts] += entry_[j] * shared.row[j];
    }
  }

  // As TileSweep::add_steps. Lane l has row l % 16 of this warp's part of the vector: where it lies is looked
  // up two steps ahead, its value asked for one step ahead.
  template <class BeforeLast>
  __device__ void add_steps(const S* vector, const BeforeLast& before_last) {
    const int first = part_.first_step, last = part_.last_step, row = first_column() + lane() % kDepth;
    const auto look_up = [&](int step) { return step < last ? place_(step, row) : Offset(-1); };
    const auto ask = [&](Offset place) { return place < 0 ? S(0) : peek(vector + place); };
#pragma unroll
    for (int j = 0; j < kSums; ++j) sum_[j] = S(0);
    Offset at = look_up(first), next = look_up(first + 1);
    S value = ask(at);
    for (int step = first; step < last; ++step) {
      if (step + 1 == last) before_last();
      const S x = at < 0 ? S(0) : wait_for(vector + at, value, tiles_after(part_, step));
      __syncwarp();  // else the lanes whose entry came first go on alone, and all others after them
      at = next;
      value = ask(at);
      next = look_up(step + 2);
      multiply(x);
      load(step + 1);
      prefetch(step + 2);
    }
  }

  // sums[group][row] = what the warps of the group have; ends with a barrier.
  __device__ void share_sums() {
    int row = lane();
    if constexpr (Transposed) {
      // Lane l ends with row l / 16 + 2 (l % 16): half of what is left goes to the other half of the lanes.
      give_half<kDepth / 2>();
      row = lane() / kDepth + lane() % kDepth * kApart;
    } else {
      sum_[0] = (sum_[0] + sum_[1]) + (sum_[2] + sum_[3]);
    }
    sums_[group() * kSolveTile + first_row() + row] = sum_[0];
    __syncthreads();
  }
  // A template, as a loop over halves would not be unrolled, and sums in memory take four times as long.
  template <int Half>
  __device__ void give_half() {
    const bool upper = (lane() & Half) != 0;
#pragma unroll
    for (int j = 0; j < Half; ++j) {
      const S kept = upper ? sum_[j + Half] : sum_[j], given = upper ? sum_[j] : sum_[j + Half];
      sum_[j] = kept + shuffle(given, lane() ^ Half);
    }
    if constexpr (Half > 1) give_half<Half / 2>();
  }
  __device__ static S total_of(const S* sums, int row) {
    S total = sums[row];
#pragma unroll
    for (int g = 1; g < kGroups; ++g) total += sums[g * kSolveTile + row];
    return total;
  }
  __device__ S rest(int row) const {
    return result_[row] - total_of(sums_, row);
  }

  S *vector_, *diagonal_, *result_, *sums_, *solved_;
  const SolvePart& part_;
  int width_;
  const PanelOf& panel_;
  const PlaceOf& place_;
  S entry_[kDepth], sum_[kSums];
};

}  // namespace mfs::cuda
