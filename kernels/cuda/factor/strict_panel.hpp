// Block columns of the rare fronts whose pivots must be searched in all rows of the pivot block (strict
// fronts): a right-looking LU by panels of a few columns, which lie in shared memory if they fit there. Of a
// front with few pivots one block of threads makes a block column as a whole. In tall ones it would be alone
// on the device for long, so one launch makes a panel, and the next, with many blocks, all that follows.
#pragma once

#include <climits>

#include "kernels/cuda/factor/device_store.hpp"
#include "kernels/cuda/factor/tile_lu.hpp"
#include "kernels/cuda/runtime/async_copy.hpp"

namespace mfs::cuda {

/// Row exchanges of a panel as one permutation of the rows that take part: row to[i] becomes row from[i].
struct PanelExchange {
  int count;
  int to[kWarp], from[kWarp];

  /// By one warp, of exchange[j] with j for each j < width in this order.
  __device__ void combine(const int* exchange, int width) {
    static_assert(2 * kPanelColumns <= kWarp);
    const int lane = threadIdx.x % kWarp, own = lane < width ? exchange[lane] : 0;
    int row = lane < width ? lane : -1, source = row, rows = width;
    for (int j = 0; j < width; ++j) {
      const int partner = __shfl_sync(0xffffffffu, own, j);
      const unsigned known = __ballot_sync(0xffffffffu, row == partner);
      const int at = known ? __ffs(known) - 1 : rows++;
      if (!known && lane == at) row = source = partner;
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

/// Columns [first, first + width) of the block column [k, k + s) of a front, s at most kTile, from their
/// diagonal down.
template <class S>
struct StrictPanel {
  const Front<S>& front;
  int k, s, first, width;

  __device__ int top() const { return k + first; }
  __device__ int rows() const { return front.pivots - top(); }
  __device__ Offset ld() const { return front.lower_ld; }
  __device__ S* entries() const { return front.lower + top() + top() * ld(); }
};

/// Eliminates panels of a strict front, by all threads of a block.
template <class S, class Value>
class StrictPanels {
 public:
  /// `memory` (`entries` of them) and `column` (kTile entries) are shared memory. `border`, if not null: of
  /// the panel, its border rows as eliminate_panel_borders leaves them.
  __device__ StrictPanels(const DeviceStore<S, Value>& store, Vertex f, const Front<S>& front, S* memory,
                          int entries, S* column, const S* border, TileWork<S>& work)
      : store_(store),
        front_(front),
        rule_(store.rule()),
        copy_(memory),
        entries_(entries),
        column_(column),
        border_(border),
        work_(work),
        front_index_(f),
        begin_(store.fronts.pivot_begin[f]) {}

  /// Before the first panel of a front: no row has moved.
  __device__ void number_rows() const {
    for (int i = threadIdx.x; i < front_.pivots; i += blockDim.x) store_.fronts.local_row[begin_ + i] = i;
  }

  /// Leaves the panel in its place, and in `memory` where it is copied, and the rows that its own were
  /// exchanged with in the TileWork.
  __device__ __forceinline__ void factor(const StrictPanel<S>& place) {
    rows_ = place.rows();
    if (is_copied(place)) {
      const Entries panel{copy_, rows_};
      take(place);
      factor(place, panel);
      give_back(place, panel, rows_);
    } else {
      factor(place, {place.entries(), static_cast<int>(place.ld())});
    }
  }
  __device__ bool is_copied(const StrictPanel<S>& place) const {
    return place.rows() * place.width <= entries_;
  }

 private:
  /// Of a panel, column-major: the compiler must see whether they are shared memory.
  struct Entries {
    S* at;
    int ld;
    __device__ S& operator()(int r, int c) const { return at[r + c * ld]; }
  };
  struct Candidate {
    double size;
    int row;
    // Rows come in their order. What is no number is never larger.
    __device__ void compare(double other, int other_row) {
      if (other > size) {
        size = other;
        row = other_row;
      }
    }
    // Numbers that are not negative have the same order as the integers that they are made of.
    __device__ void compare_in_warp() {
      const unsigned high = __double2hiint(size), most = __reduce_max_sync(0xffffffffu, high);
      const unsigned low = high == most ? __double2loint(size) : 0,
                     most_low = __reduce_max_sync(0xffffffffu, low);
      row = __reduce_min_sync(0xffffffffu, high == most && low == most_low ? row : INT_MAX);
      size = __hiloint2double(most, most_low);
    }
  };

  __device__ Candidate none() const { return {0, rows_}; }
  __device__ double size_of_pivot(const S& entry, int row, int j) const {
    return magnitude(entry) * (row == j ? rule_.preference : 1);
  }

  __device__ __forceinline__ void factor(const StrictPanel<S>& place, Entries panel) {
    Candidate best = none();
    for (int r = threadIdx.x; r < rows_; r += blockDim.x) best.compare(size_of_pivot(panel(r, 0), r, 0), r);
    for (int j = 0; j < place.width; ++j) {
      exchange(place, panel, j, choose(best, j));
      best = update(place, panel, j, settled_pivot(place, panel, j));
    }
    __syncthreads();
  }

  __device__ void take(const StrictPanel<S>& place) const {
    const S* const from = place.entries();
    for (int c = 0; c < place.width; ++c) {
      for (int r = threadIdx.x; r < rows_; r += blockDim.x)
        copy_async<sizeof(S)>(shared_address(copy_ + r + c * rows_), from + r + c * place.ld());
    }
    commit_copies();
    wait_copies<0>();
    __syncthreads();
  }

  // The first rows of the panel.
  __device__ __forceinline__ void give_back(const StrictPanel<S>& place, Entries panel, int rows) const {
    S* const to = place.entries();
    if (panel.at == to) return;
    for (int c = 0; c < place.width; ++c) {
      for (int r = threadIdx.x; r < rows; r += blockDim.x) to[r + c * place.ld()] = panel(r, c);
    }
    __syncthreads();
  }

  // The row of the pivot of column j of the panel: of the largest of all threads' candidates.
  __device__ int choose(Candidate best, int j) const {
    // By turns: one column is read while the next is offered.
    static_assert(sizeof(Candidate) * 2 * kMostWarps <= sizeof(work_.offered));
    Candidate(&of_warps)[2][kMostWarps] = *reinterpret_cast<Candidate(*)[2][kMostWarps]>(&work_.offered);
    const int lane = threadIdx.x % kWarp, warps = blockDim.x / kWarp;
    best.compare_in_warp();
    if (lane == 0) of_warps[j % 2][threadIdx.x / kWarp] = best;
    __syncthreads();
    best = lane < warps ? of_warps[j % 2][lane] : none();
    best.compare_in_warp();
    return best.row < rows_ ? best.row : j;
  }

  // Whether the tile's own rows would have done for the pivot in row `row` of the panel, by the first warp.
  __device__ __forceinline__ void learn(const StrictPanel<S>& place, Entries panel, int j, int row) {
    const int of_tile = place.s - place.first, lane = threadIdx.x % kWarp;
    if (threadIdx.x >= kWarp || needed_ || rows_ <= of_tile) return;
    const PivotRule rule = store_.tile_rule();
    if (row < of_tile && magnitude(panel(row, j)) >= rule.bound) return;
    double most = 0;
    for (int r = j + lane; r < of_tile; r += kWarp) most = fmax(most, magnitude(panel(r, j)));
    for (int step = 16; step > 0; step /= 2) most = fmax(most, __shfl_xor_sync(0xffffffffu, most, step));
    needed_ = needs_strict(magnitude(panel(row, j)), most, rule);
    if (needed_ && lane == 0) store_.need_strict(front_index_);
    __syncwarp();
  }

  // Row j of the panel and that of the pivot.
  __device__ __forceinline__ void exchange(const StrictPanel<S>& place, Entries panel, int j, int row) {
    learn(place, panel, j, row);
    const int c = threadIdx.x;
    if (row != j && c < place.width) {
      const S held = panel(j, c);
      panel(j, c) = panel(row, c);
      panel(row, c) = held;
    }
    if (threadIdx.x == 0) work_.exchange[j] = row;
    __syncthreads();
  }

  // The pivot of column j, or what becomes of it.
  __device__ __forceinline__ S settled_pivot(const StrictPanel<S>& place, Entries panel, int j) const {
    const S pivot = panel(j, j);
    const double size = magnitude(pivot);
    if (threadIdx.x == 0 && !(size <= 1.7976931348623157e308))
      atomicAdd(&store_.fronts.status->nonfinite, 1ull);
    if (size >= rule_.bound || size != size) return pivot;
    const S accepted = replacement(pivot, most_in_border(place, panel, j), rule_), added = accepted - pivot;
    __syncthreads();
    if (threadIdx.x == 0 && magnitude(added) != 0) {
      panel(j, j) = accepted;
      store_.fronts.shift[begin_ + place.top() + j] = added;
      atomicAdd(&store_.fronts.status->perturbed, 1ull);
      if (store_.substitutes) store_.need_strict(front_index_);  // its border decided
    }
    __syncthreads();
    return accepted;
  }

  // The border rows of columns left of this one are not solved for: that is done for this column alone.
  __device__ __forceinline__ double most_in_border(const StrictPanel<S>& place, Entries panel, int j) const {
    const int count = front_.border, k = place.k, s = place.s, width = place.width;
    if (count == 0) return 0;
    if (border_) {
      const BorderBelow<S> below{border_, count, count, column_, work_.border};
      return below(Tile<S>{panel.at, panel.ld, width, width}, j, PivotPlaces{width, nullptr});
    }
    give_back(place, panel, min(rows_, s - place.first));
    const BorderBelow<S> below{front_.lower + front_.pivots + k * place.ld(), place.ld(), count, column_,
                               work_.border};
    const Tile<S> tile{front_.lower + k + k * place.ld(), static_cast<int>(place.ld()), s, s};
    return below(tile, place.first + j, PivotPlaces{s, nullptr});
  }

  // Multipliers of column j, and what is right of them. Returns this thread's candidate for the next column.
  __device__ __forceinline__ Candidate update(const StrictPanel<S>& place, Entries panel, int j,
                                              const S& pivot) const {
    constexpr int kTogether = 4;  // rows
    Candidate best = none();
    const int stride = blockDim.x;
    for (int first = j + 1 + threadIdx.x; first < rows_; first += kTogether * stride) {
      S multiplier[kTogether];
#pragma unroll
      for (int q = 0; q < kTogether; ++q) {
        const int r = first + q * stride;
        if (r < rows_) panel(r, j) = multiplier[q] = panel(r, j) / pivot;
      }
      for (int c = j + 1; c < place.width; ++c) {
        const S right = panel(j, c);
#pragma unroll
        for (int q = 0; q < kTogether; ++q) {
          const int r = first + q * stride;
          if (r < rows_) {
            const S entry = panel(r, c) - multiplier[q] * right;
            panel(r, c) = entry;
            if (c == j + 1) best.compare(size_of_pivot(entry, r, c), r);
          }
        }
      }
    }
    return best;
  }

  const DeviceStore<S, Value>& store_;
  const Front<S>& front_;
  const PivotRule rule_;
  S* const copy_;
  const int entries_;
  S* const column_;
  const S* const border_;
  TileWork<S>& work_;
  const Vertex front_index_, begin_;
  bool needed_ = false;  // strictness, for a pivot before
  int rows_ = 0;         // of the panel
};

/// What follows a panel that StrictPanels has left, by all threads of a block or, of other columns, of
/// others.
template <class S, class Value>
class StrictUpdate {
 public:
  /// `panel`: its entries, there or in shared memory. `right` holds kPanelColumns entries for each column
  /// that is updated at once, in shared memory.
  __device__ StrictUpdate(const DeviceStore<S, Value>& store, Vertex f, const StrictPanel<S>& place,
                          const S* panel, int ld, S* right)
      : store_(store),
        place_(place),
        panel_(panel),
        panel_ld_(ld),
        right_(right),
        begin_(store.fronts.pivot_begin[f]),
        columns_(store.is_divided(f) ? place.front.pivots : place.front.rows()) {}

  /// Of the front, as far as they are there.
  __device__ int columns() const { return columns_; }

  /// In columns [begin, end) of the front; those of the panel moved with it.
  __device__ void exchange_rows(const PanelExchange& moves, int begin, int end) const {
    const int warp = threadIdx.x / kWarp, warps = blockDim.x / kWarp, top = place_.top();
    const Front<S>& front = place_.front;
    for (int c = begin + warp; c < min(end, columns_); c += warps) {
      if (c >= top && c < top + place_.width) continue;
      moves.apply(top + (c < front.pivots
                             ? front.lower + c * place_.ld()
                             : front.upper + static_cast<Offset>(c - front.pivots) * front.pivots));
    }
  }
  /// By one warp.
  __device__ void exchange_places(const PanelExchange& moves) const {
    moves.apply(store_.fronts.local_row + begin_ + place_.top());
  }

  /// Columns [begin, end) of the block column, right of the panel: U by the unit lower triangle at `lower`,
  /// then what is below.
  __device__ void update(int begin, int end, const S* lower, int lower_ld) const {
    const int columns = end - begin, width = place_.width, rows = place_.rows();
    const Offset ld = place_.ld();
    S* const to = place_.entries() + (begin - place_.first) * ld;
    for (int c = threadIdx.x; c < columns; c += blockDim.x) {
      S* const x = right_ + c * kPanelColumns;
      for (int i = 0; i < kPanelColumns; ++i) x[i] = i < width ? to[i + c * ld] : S(0);
      solve_panel_column(lower, lower_ld, width, x);
      for (int i = 0; i < width; ++i) to[i + c * ld] = x[i];
    }
    __syncthreads();
    for (int r = width + threadIdx.x; r < rows; r += blockDim.x) {
      S multiplier[kPanelColumns];
#pragma unroll
      for (int i = 0; i < kPanelColumns; ++i)
        multiplier[i] = i < width ? panel_[r + i * static_cast<Offset>(panel_ld_)] : S(0);
#pragma unroll 4
      for (int c = 0; c < columns; ++c) {
        S sum = to[r + c * ld];
#pragma unroll
        for (int i = 0; i < kPanelColumns; ++i) sum -= multiplier[i] * right_[i + c * kPanelColumns];
        to[r + c * ld] = sum;
      }
    }
    __syncthreads();
  }

 private:
  const DeviceStore<S, Value>& store_;
  const StrictPanel<S>& place_;
  const S* const panel_;
  const int panel_ld_;
  S* const right_;
  const Vertex begin_, columns_;
};

/// Columns of panels of so many rows where `entries` fit shared memory: wide ones in the memory of the device
/// are better than very narrow ones.
__host__ __device__ constexpr int panel_columns(int entries, int rows) {
  const int columns = entries / rows;
  return columns >= 4 && columns < kPanelColumns ? columns : kPanelColumns;
}

/// The block column [k, k + s) of a front as a whole, by all threads of a block. `memory` (`entries` of them)
/// and `column` (kTile entries) are shared memory. Not inlined: the tiles of all other fronts would pay with
/// registers.
template <class S, class Value>
__device__ __noinline__ void factor_strict_column(const DeviceStore<S, Value>& store, Vertex f,
                                                  const Front<S>& front, int k, int s, S* memory, int entries,
                                                  S* column, TileWork<S>& work) {
  __shared__ PanelExchange moves;
  S *const right = memory, *const copy = memory + kPanelColumns * kTile<S>;
  const int copied = entries - kPanelColumns * kTile<S>;
  StrictPanels<S, Value> panels(store, f, front, copy, copied, column, nullptr, work);
  if (k == 0) panels.number_rows();
  const int columns = panel_columns(copied, front.pivots - k);
  for (int first = 0; first < s; first += columns) {
    const StrictPanel<S> place{front, k, s, first, min(columns, s - first)};
    panels.factor(place);
    if (threadIdx.x < kWarp) moves.combine(work.exchange, place.width);
    __syncthreads();
    const S* const panel = panels.is_copied(place) ? copy : place.entries();
    const int ld = panel == copy ? place.rows() : static_cast<int>(place.ld());
    const StrictUpdate<S, Value> follow(store, f, place, panel, ld, right);
    follow.exchange_rows(moves, 0, follow.columns());
    if (threadIdx.x < kWarp) follow.exchange_places(moves);
    __syncthreads();
    follow.update(first + place.width, s, panel, ld);
  }
}

static_assert(kPanelColumns == kMostPanelColumns);
constexpr int kStrictThreads = 512, kFollowThreads = 512;
/// Columns of a block that updates them, and of one that only exchanges rows.
constexpr int kUpdatedColumns = 4, kExchangedColumns = 32;

/// Shared memory of factor_strict_panels.
template <class S>
constexpr std::size_t strict_panel_bytes(int entries) {
  return sizeof(TileWork<S>) + sizeof(S) * (kTile<S> + entries);
}
/// Entries of a panel in it, where a block may have so many bytes.
template <class S>
constexpr int strict_panel_entries(std::size_t memory) {
  return static_cast<int>((memory - strict_panel_bytes<S>(0)) / sizeof(S));
}

/// Shared memory of eliminate_panel_borders: the triangle left of the panel, and what is above it twice. That
/// is less than the tile.
template <class S>
constexpr std::size_t panel_border_bytes(int first, int width) {
  return sizeof(S) * static_cast<std::size_t>(first) * (first + 2 * width);
}

/// The border rows of the panels that factor_strict_panels makes next, with the columns of the tile left of
/// them eliminated, for pivots that are compared with them. Blocks (x, y) for task x, a row for each thread.
template <class S, class Value>
__global__ void __launch_bounds__(kFollowThreads)
    eliminate_panel_borders(DeviceStore<S, Value> store, Offset first_task, int first, int width) {
  extern __shared__ __align__(16) unsigned char memory[];
  const StepTask task = store.steps[first_task + blockIdx.x];
  const Front<S> front = store.fronts.front(task.front);
  const int s = min(store.tile, front.pivots - task.k), row = blockIdx.y * blockDim.x + threadIdx.x;
  if (first >= s || !store.goes_by_panels(task.front, front.pivots)) return;
  width = min(width, s - first);
  const Offset ld = front.lower_ld;
  S *const left = reinterpret_cast<S*>(memory), *const above = left + first * (first + width);
  const S* const tile = front.lower + task.k + task.k * ld;
  for (int i = threadIdx.x; i < first * (first + width); i += blockDim.x)
    copy_async<sizeof(S)>(shared_address(left + i), tile + i % first + i / first * ld);
  commit_copies();
  wait_copies<0>();
  __syncthreads();
  const int warps = blockDim.x / kWarp;
  for (int c = threadIdx.x / kWarp; c < width; c += warps) {
    BorderBelow<S>::solve_above(Tile<S>{left, first, first, first}, first, first + c,
                                PivotPlaces{first, nullptr}, above + c * first);
  }
  __syncthreads();
  if (row >= front.border) return;
  const S* const from = front.lower + front.pivots + row + task.k * ld;
  S sum[kPanelColumns];
#pragma unroll
  for (int c = 0; c < kPanelColumns; ++c) sum[c] = c < width ? from[(first + c) * ld] : S(0);
#pragma unroll 8
  for (int k = 0; k < first; ++k) {
    const S entry = from[k * ld];
#pragma unroll
    for (int c = 0; c < kPanelColumns; ++c) {
      if (c < width) sum[c] -= entry * above[k + c * first];
    }
  }
  S* const to = store.panel_border + task.border_at + row;
#pragma unroll
  for (int c = 0; c < kPanelColumns; ++c) {
    if (c < width) to[c * static_cast<Offset>(front.border)] = sum[c];
  }
}

/// The panel from column `first` on of `width` columns at most, of the block columns that are factored by
/// panels: a block for each task.
template <class S, class Value>
__global__ void __launch_bounds__(kStrictThreads)
    factor_strict_panels(DeviceStore<S, Value> store, Offset first_task, int first, int width, int entries) {
  extern __shared__ __align__(16) unsigned char memory[];
  const StepTask task = store.steps[first_task + blockIdx.x];
  const Front<S> front = store.fronts.front(task.front);
  const int s = min(store.tile, front.pivots - task.k);
  if (first >= s || !store.goes_by_panels(task.front, front.pivots)) return;
  TileWork<S>& work = *reinterpret_cast<TileWork<S>*>(memory);
  S* const column = reinterpret_cast<S*>(memory + sizeof(TileWork<S>));
  const S* const border = store.substitutes ? store.panel_border + task.border_at : nullptr;
  StrictPanels<S, Value> panels(store, task.front, front, column + kTile<S>, entries, column, border, work);
  if (task.k == 0 && first == 0) panels.number_rows();
  const StrictPanel<S> place{front, task.k, s, first, min(width, s - first)};
  panels.factor(place);
  if (static_cast<int>(threadIdx.x) < place.width)
    store.panel_rows[blockIdx.x * kPanelColumns + threadIdx.x] = work.exchange[threadIdx.x];
}

/// What follows those panels: blocks (x, y) for task x, of which the first update columns of the tile.
template <class S, class Value>
__global__ void __launch_bounds__(kFollowThreads)
    follow_strict_panels(DeviceStore<S, Value> store, Offset first_task, int first, int width) {
  __shared__ PanelExchange moves;
  __shared__ __align__(
      16) unsigned char memory[sizeof(S) * kPanelColumns * (kPanelColumns + kUpdatedColumns)];
  S *const lower = reinterpret_cast<S*>(memory), *const right = lower + kPanelColumns * kPanelColumns;
  const StepTask task = store.steps[first_task + blockIdx.x];
  const Front<S> front = store.fronts.front(task.front);
  const int s = min(store.tile, front.pivots - task.k);
  if (first >= s || !store.goes_by_panels(task.front, front.pivots)) return;
  const StrictPanel<S> place{front, task.k, s, first, min(width, s - first)};
  const StrictUpdate<S, Value> follow(store, task.front, place, place.entries(), static_cast<int>(place.ld()),
                                      right);
  const int updating = store.tile / kUpdatedColumns, block = blockIdx.y;
  const int begin = first + place.width + block * kUpdatedColumns,
            exchanged = (block - updating) * kExchangedColumns;
  if (block < updating ? begin >= s : exchanged >= follow.columns()) return;
  if (threadIdx.x < kWarp) moves.combine(store.panel_rows + blockIdx.x * kPanelColumns, place.width);
  __syncthreads();
  if (block < updating) {
    const int end = min(begin + kUpdatedColumns, s);
    for (int i = threadIdx.x; i < kPanelColumns * place.width; i += blockDim.x) {
      const int row = i % kPanelColumns, column = i / kPanelColumns;
      if (row < place.width) lower[i] = place.entries()[row + column * place.ld()];
    }
    follow.exchange_rows(moves, task.k + begin, task.k + end);
    __syncthreads();
    follow.update(begin, end, lower, kPanelColumns);
  } else {
    // Columns of the tile from the panel on are others'.
    const int end = exchanged + kExchangedColumns;
    follow.exchange_rows(moves, exchanged, min(end, place.top()));
    follow.exchange_rows(moves, max(exchanged, task.k + s), end);
    if (exchanged == 0 && threadIdx.x < kWarp) follow.exchange_places(moves);
  }
}

}  // namespace mfs::cuda
