// Block columns of the rare fronts whose pivots must be searched in all rows of the pivot block (strict
// fronts), one block of threads each: a right-looking LU by panels of a few columns, which lie in shared
// memory if they fit there.
#pragma once

#include "kernels/cuda/factor/device_store.hpp"
#include "kernels/cuda/factor/tile_lu.hpp"

namespace mfs::cuda {

/// Row exchanges of a panel as one permutation of the rows that take part: row to[i] becomes row from[i].
struct PanelExchange {
  int count;
  int to[kWarp], from[kWarp];

  /// By one warp, of exchange[j] with j for each j < width in this order.
  __device__ void combine(const int* exchange, int width) {
    static_assert(2 * kPanelColumns <= kWarp);
    const int lane = threadIdx.x % kWarp;
    int row = lane < width ? lane : -1, source = row, rows = width;
    for (int j = 0; j < width; ++j) {
      const unsigned known = __ballot_sync(0xffffffffu, row == exchange[j]);
      const int at = known ? __ffs(known) - 1 : rows++;
      if (!known && lane == at) row = source = exchange[j];
      const int upper = __shfl_sync(0xffffffffu, source, j), lower = __shfl_sync(0xffffffffu, source, at);
      if (lane == j) source = lower;
      if (lane == at) source = upper;
    }
    to[lane] = row;
    from[lane] = source;
    if (lane == 0) count = rows;
  }
  /// One warp exchanges the entries of a column.
  template <class T>
  __device__ void apply(T* column) const {
    const int lane = threadIdx.x % kWarp;
    T moved{};
    if (lane < count) moved = column[from[lane]];
    __syncwarp();
    if (lane < count) column[to[lane]] = moved;
    __syncwarp();
  }
};

// Keeps the compiler from loading everything that follows at once, for which there are no registers.
__device__ inline void hold_loads() {
  asm volatile("" ::: "memory");
}

// x := L^-1 x for the unit lower triangle L of a panel; the panel's columns of x lie together.
template <class S>
__device__ void solve_panel_column(const S* lower, int ld, int width, S* x) {
  S solved[kPanelColumns];
#pragma unroll
  for (int k = 0; k < kPanelColumns; ++k) solved[k] = k < width ? x[k] : S(0);
#pragma unroll
  for (int k = 0; k < kPanelColumns - 1; ++k) {
    if (k >= width) break;
    hold_loads();
#pragma unroll
    for (int i = k + 1; i < kPanelColumns; ++i) {
      if (i < width) solved[i] -= lower[i + k * ld] * solved[k];
    }
  }
#pragma unroll
  for (int k = 0; k < kPanelColumns; ++k) {
    if (k < width) x[k] = solved[k];
  }
}

/// Columns [k, k + s) of a front, s at most kTile, rows [k, p), by all threads of a block.
template <class S, class Value>
class StrictPanels {
 public:
  /// `memory` (`entries` of them) and `column` (kTile entries) are shared memory.
  __device__ StrictPanels(const DeviceStore<S, Value>& store, Vertex f, const Front<S>& front, int k, int s,
                          S* memory, int entries, S* column, TileWork<S>& work)
      : store_(store),
        front_(front),
        rule_(store.rule()),
        k_(k),
        s_(s),
        ld_(front.lower_ld),
        a_(front.lower + k + k * ld_),
        right_(memory),
        copy_(memory + kPanelColumns * kTile<S>),
        copy_entries_(entries - kPanelColumns * kTile<S>),
        column_(column),
        work_(work),
        front_index_(f),
        begin_(store.fronts.pivot_begin[f]),
        columns_(store.is_divided(f) ? front.pivots : front.rows()) {}

  __device__ void factor() {
    const int m = front_.pivots - k_;
    // Wide panels in the memory of the device are better than very narrow ones in shared memory.
    const int columns = min(kPanelColumns, copy_entries_ / m);
    copied_ = columns >= 4;
    if (k_ == 0) {
      for (int i = threadIdx.x; i < m; i += blockDim.x) store_.fronts.local_row[begin_ + i] = i;
    }
    for (int first = 0, width; first < s_; first += width) {
      width = min(copied_ ? columns : kPanelColumns, s_ - first);
      take_panel(first, width);
      for (int j = 0; j < width; ++j) eliminate(first, width, j);
      return_panel(first, width);
      exchange_rows(first, width);
      update(first, width);
    }
  }

 private:
  __device__ void take_panel(int first, int width) {
    rows_ = front_.pivots - k_ - first;
    S* const from = a_ + first + first * ld_;
    panel_ = copied_ ? copy_ : from;
    panel_ld_ = copied_ ? rows_ : static_cast<int>(ld_);
    if (copied_) {
      for (int c = 0; c < width; ++c) {
        for (int r = threadIdx.x; r < rows_; r += blockDim.x) panel_[r + c * panel_ld_] = from[r + c * ld_];
      }
    }
    __syncthreads();
  }

  __device__ void return_panel(int first, int width) const {
    __syncthreads();
    if (!copied_) return;
    S* const to = a_ + first + first * ld_;
    for (int c = 0; c < width; ++c) {
      for (int r = threadIdx.x; r < rows_; r += blockDim.x) to[r + c * ld_] = panel_[r + c * panel_ld_];
    }
    __syncthreads();
  }

  // Row of the pivot of column j of the panel: of the largest entry from row j on, which counts more itself.
  __device__ int search(int j) const {
    __shared__ int chosen;
    double most = -1;
    int from = rows_;
    for (int r = j + threadIdx.x; r < rows_; r += blockDim.x) {
      const double size = magnitude(panel_[r + j * panel_ld_]) * (r == j ? rule_.preference : 1);
      if (!(size <= most)) {
        most = size;
        from = r;
      }
    }
    if (threadIdx.x == 0) chosen = rows_;
    const double largest = block_max(most, work_.border);
    if (most == largest) atomicMin(&chosen, from);
    __syncthreads();
    return chosen < rows_ ? chosen : j;
  }

  // Whether the tile's own rows would have done for the pivot in row `row` of the panel, by the first warp.
  __device__ void learn(int first, int j, int row) {
    const int of_tile = s_ - first, lane = threadIdx.x % kWarp;
    if (threadIdx.x >= kWarp || needed_ || rows_ <= of_tile) return;
    const S* const column = panel_ + j * static_cast<Offset>(panel_ld_);
    const PivotRule rule = store_.tile_rule();
    if (row < of_tile && magnitude(column[row]) >= rule.bound) return;
    double most = 0;
    for (int r = j + lane; r < of_tile; r += kWarp) most = fmax(most, magnitude(column[r]));
    for (int step = 16; step > 0; step /= 2) most = fmax(most, __shfl_xor_sync(0xffffffffu, most, step));
    needed_ = needs_strict(magnitude(column[row]), most, rule);
    if (needed_ && lane == 0) store_.need_strict(front_index_);
    __syncwarp();
  }

  __device__ void eliminate(int first, int width, int j) {
    const int row = search(j);
    learn(first, j, row);
    if (row != j && static_cast<int>(threadIdx.x) < width) {
      S* const x = panel_ + threadIdx.x * static_cast<Offset>(panel_ld_);
      const S held = x[j];
      x[j] = x[row];
      x[row] = held;
    }
    if (threadIdx.x == 0) work_.exchange[j] = row;
    __syncthreads();
    S pivot = panel_[j + j * static_cast<Offset>(panel_ld_)];
    const double size = magnitude(pivot);
    S added = S(0);
    if (size == size && !(size >= rule_.bound)) {
      // The border rows of columns left of this one are not solved for: do so for this column alone.
      return_panel(first, width);
      const Tile<S> tile{a_, static_cast<int>(ld_), s_, s_};
      const BorderBelow<S> below{front_.lower + front_.pivots + k_ * ld_, ld_, front_.border, column_,
                                 work_.border};
      const S accepted = replacement(pivot, below(tile, first + j, PivotPlaces{s_, nullptr}), rule_);
      added = accepted - pivot;
      pivot = accepted;
      if (threadIdx.x == 0 && magnitude(added) != 0) {
        atomicAdd(&store_.fronts.status->perturbed, 1ull);
        if (store_.substitutes) store_.need_strict(front_index_);  // its border decided
      }
    }
    __syncthreads();
    if (threadIdx.x == 0) {
      if (!(size <= 1.7976931348623157e308)) atomicAdd(&store_.fronts.status->nonfinite, 1ull);
      panel_[j + j * static_cast<Offset>(panel_ld_)] = pivot;
      if (magnitude(added) != 0) store_.fronts.shift[begin_ + k_ + first + j] = added;
    }
    for (int r = j + 1 + threadIdx.x; r < rows_; r += blockDim.x) {
      S* const x = panel_ + r;
      const S multiplier = x[j * static_cast<Offset>(panel_ld_)] / pivot;
      x[j * static_cast<Offset>(panel_ld_)] = multiplier;
      for (int c = j + 1; c < width; ++c) {
        const Offset at = c * static_cast<Offset>(panel_ld_);
        x[at] -= multiplier * panel_[j + at];
      }
    }
    __syncthreads();
  }

  // In all columns of the front but the panel's, as far as they are there.
  __device__ void exchange_rows(int first, int width) const {
    __shared__ PanelExchange moves;
    const int warp = threadIdx.x / kWarp, warps = blockDim.x / kWarp, top = k_ + first;
    if (warp == 0) moves.combine(work_.exchange, width);
    __syncthreads();
    for (int c = warp; c < columns_; c += warps) {
      if (c >= top && c < top + width) continue;
      moves.apply(top + (c < front_.pivots
                             ? front_.lower + c * ld_
                             : front_.upper + static_cast<Offset>(c - front_.pivots) * front_.pivots));
    }
    if (warp == 0) moves.apply(store_.fronts.local_row + begin_ + top);
    __syncthreads();
  }

  // Columns right of the panel: U by its unit lower triangle, then what is below.
  __device__ void update(int first, int width) const {
    const int columns = s_ - first - width;
    S* const to = a_ + first + (first + width) * ld_;
    for (int c = threadIdx.x; c < columns; c += blockDim.x) {
      S* const x = right_ + c * kPanelColumns;
      for (int i = 0; i < kPanelColumns; ++i) x[i] = i < width ? to[i + c * ld_] : S(0);
      solve_panel_column(panel_, panel_ld_, width, x);
      for (int i = 0; i < width; ++i) to[i + c * ld_] = x[i];
    }
    __syncthreads();
    for (int r = width + threadIdx.x; r < rows_; r += blockDim.x) {
      S multiplier[kPanelColumns];
#pragma unroll
      for (int i = 0; i < kPanelColumns; ++i)
        multiplier[i] = i < width ? panel_[r + i * static_cast<Offset>(panel_ld_)] : S(0);
#pragma unroll 4
      for (int c = 0; c < columns; ++c) {
        S sum = to[r + c * ld_];
#pragma unroll
        for (int i = 0; i < kPanelColumns; ++i) sum -= multiplier[i] * right_[i + c * kPanelColumns];
        to[r + c * ld_] = sum;
      }
    }
    __syncthreads();
  }

  const DeviceStore<S, Value>& store_;
  const Front<S>& front_;
  const PivotRule rule_;
  const int k_, s_;
  const Offset ld_;
  S* const a_;  // of the block column: its diagonal
  S *const right_, *const copy_;
  const int copy_entries_;
  S* const column_;
  TileWork<S>& work_;
  const Vertex front_index_, begin_, columns_;
  bool copied_ = false;
  bool needed_ = false;  // strictness, for a pivot before
  S* panel_ = nullptr;
  int panel_ld_ = 0, rows_ = 0;  // of the panel
};

}  // namespace mfs::cuda
