// A panel of a tile with its pivots on the diagonal, as they come, which needs no search: the 16 x 16 block
// of its pivots is factored and both triangles are inverted in one sweep, a thread for each entry or two, and
// all else is products. It is kept if no pivot is suspect, no multiplier of a pivot row of the tile is beyond
// 1 / kDiagonalThreshold (threshold pivoting, which prefers the diagonal: Duff, Erisman and Reid, Direct
// Methods for Sparse Matrices, 2017, section 5.2) and U's inverse is harmless.
#pragma once

#include <limits>

#include "kernels/cuda/factor/tile.hpp"

namespace mfs::cuda {

/// A pivot on the diagonal is accepted if it is at least this fraction of the largest entry below it in the
/// rows in which it would be searched.
constexpr double kDiagonalThreshold = 0.1;

/// The largest entry that the inverse of U may have in the panel, its rows scaled to a diagonal of ones:
/// times so much, at most, are rounding errors of multipliers larger than those of a solve with U (its error
/// is bounded by |A| |U^-1| |U|: Higham, Accuracy and Stability of Numerical Algorithms, 2002, section 8.3).
constexpr double kMostInverse = 100;

constexpr int kPivotLd = tile_ld(kPanelColumns);

/// Work in shared memory: the block of the pivots before and after a step, by turns.
template <class S>
struct alignas(16) PivotWork {
  S block[2][kPivotLd * kPanelColumns];
};

// Between these a determinant can be, in which neither underflow nor overflow has taken part.
template <class Real>
constexpr double kLeastPlain =
    static_cast<double>(std::numeric_limits<Real>::min()) / std::numeric_limits<Real>::epsilon();
template <class Real>
constexpr double kMostPlain =
    static_cast<double>(std::numeric_limits<Real>::max()) * std::numeric_limits<Real>::epsilon();

// The sizes of what a thread saw, as size_bits has them; multipliers of pivot rows and of border rows; of the
// inverse of U with its rows scaled.
struct SeenSizes {
  unsigned least_pivot = ~0u, least_determinant = ~0u, most_determinant = 0;
  unsigned most_multiplier = 0, most_border = 0, most_inverse = 0;
};

/// The panel from column `first` on, a multiple of kPanelColumns, of a tile; by a block of Threads threads,
/// at least as many as the tile has rows, all of which call everything.
template <int Threads, class S>
class DiagonalPanel {
 public:
  __device__ DiagonalPanel(const Tile<S>& tile, int first, double bound, PivotWork<S>& work)
      : tile_(tile),
        first_(first),
        width_(min(kPanelColumns, tile.pivots - first)),
        bound_(bound),
        work_(work),
        pivots_(tile.a + first + first * tile.ld) {}

  /// Leaves the multipliers, L^-1 times what is right of the pivot rows, U and, in place of the unit lower
  /// triangle, its inverse; or returns false, to all threads, and the tile as it was.
  __device__ bool factor() {
    SeenSizes seen;
    factor_pivots(seen);
    if (!__syncthreads_and(may_stay(seen))) return false;
    WarpTile<S, 1, 2> multipliers[kTurns];
    make_multipliers(multipliers, seen);
    if (!__syncthreads_and(may_stay(seen))) return false;
    keep_multipliers(multipliers);
    solve_right(tile_, first_, width_, inverses_, kPivotLd);
    if (own_row() < width_) {
#pragma unroll
      for (int e = 0; e < kEach; ++e) {
        const int c = own_column(e);
        if (c < width_) pivots_[own_row() + c * tile_.ld] = own_row() <= c ? upper_[e] : value_[e];
      }
    }
    return true;
  }

 private:
  static constexpr int kEntries = kPanelColumns * kPanelColumns, kEach = kEntries / Threads;
  static_assert(kEach * Threads == kEntries);

  __device__ static int own_row() {
    return threadIdx.x % kPanelColumns;
  }
  __device__ static int own_column(int e) {
    return threadIdx.x / kPanelColumns + e * (Threads / kPanelColumns);
  }

  // Two pivots at a time, so that of the chain of reciprocals, whose latency is what this takes, two are
  // found side by side:
  //
  //   [a  b]   [1   ] [a   b      ]      x0 x1 of another row:  m1 = x0 / a,  m2 = (a x1 - b x0) / det
  //   [c  d] = [l  1] [    det / a]      the row becomes        row - (m1 - m2 l) first - m2 second
  //
  // Below the two, m1 and m2 are multipliers. What is right of them there becomes what is left of the block;
  // the columns up to theirs, which are done with, take the rows of L^-1, made by the same steps from those
  // of the identity. Above them, what is right of them holds minus the product of the inverse of U so far
  // and U; then m1 and m2 are the next two columns of that inverse, and what is left of the product follows
  // by the same steps again. So one entry is enough for each place; U itself stays with its threads.
  __device__ void factor_pivots(SeenSizes& seen) {
    const int r = own_row();
#pragma unroll
    for (int e = 0; e < kEach; ++e) {
      const int c = own_column(e);
      value_[e] = r < width_ && c < width_ ? pivots_[r + c * tile_.ld] : S(r == c ? 1 : 0);
    }
    S *from = work_.block[0], *to = work_.block[1];
    put(from);
#pragma unroll 1
    for (int j = 0; j < width_; j += 2) {
      __syncthreads();
      const S* const column = from + j * kPivotLd;
      const S a = column[j], b = column[j + kPivotLd], c = column[j + 1], d = column[j + 1 + kPivotLd];
      const bool is_first = r == j, is_second = r == j + 1, of_pair = is_first || is_second,
                 below = r > j + 1;
      S x0 = column[r], x1 = column[r + kPivotLd], first[kEach], next[kEach];
#pragma unroll
      for (int e = 0; e < kEach; ++e) {
        first[e] = from[j + own_column(e) * kPivotLd];
        next[e] = from[j + 1 + own_column(e) * kPivotLd];
      }
      x0 = of_pair ? S(is_first ? 1 : 0) : x0;
      x1 = of_pair ? S(is_second ? 1 : 0) : x1;
      const S determinant = a * d - b * c, reciprocal = reciprocal_of(a);
      const S m1 = x0 * reciprocal, m2 = (x1 * a - x0 * b) * reciprocal_of(determinant);
      const S l = c * reciprocal, second = d - l * b, by_first = m1 - m2 * l;
#pragma unroll
      for (int e = 0; e < kEach; ++e) {
        const int own = own_column(e);
        S& value = value_[e];
        if (own == j || own == j + 1) {
          const bool odd = own != j;
          if (of_pair && r <= own) upper_[e] = is_second ? second : first[e];
          value = is_second && !odd ? -l : below ? (odd ? -m2 : -by_first) : odd ? m2 : m1;
        } else if (own > j) {
          if (of_pair) upper_[e] = is_first ? first[e] : next[e] - l * first[e];
          value = (of_pair ? S(0) : value) - by_first * first[e] - m2 * next[e];
        } else if (r > j) {
          value = is_second ? value - l * first[e] : value - by_first * first[e] - m2 * next[e];
        }
      }
      put(to);
      S* const held = from;
      from = to;
      to = held;
      const unsigned size = size_bits(determinant);
      seen.least_determinant = min(seen.least_determinant, size);
      seen.most_determinant = max(seen.most_determinant, size);
      seen.least_pivot = min(seen.least_pivot, size_bits(a));
      if (j + 1 < width_) seen.least_pivot = min(seen.least_pivot, size_bits(second));
      seen.most_multiplier = max(seen.most_multiplier, size_bits(l));
      // Above the two, m1 and m2 times their pivots are entries of the scaled inverse.
      const unsigned most = max(size_bits(below ? m1 : x0), size_bits(below ? m2 : m2 * second));
      if (below)
        seen.most_multiplier = max(seen.most_multiplier, most);
      else
        seen.most_inverse = max(seen.most_inverse, most);
    }
    inverses_ = from;
  }
  __device__ bool may_stay(const SeenSizes& seen) const {
    return (seen.least_pivot > bound_bits<S>(bound_)) &
           (seen.least_determinant > bound_bits<S>(kLeastPlain<RealOf<S>>)) &
           (seen.most_determinant < bound_bits<S>(kMostPlain<RealOf<S>>)) &
           (seen.most_multiplier <= bound_bits<S>(1 / kDiagonalThreshold)) &
           (seen.most_inverse <= bound_bits<S>(kMostInverse)) & (seen.most_border < bound_bits<S>(HUGE_VAL));
  }
  __device__ void put(S* to) const {
#pragma unroll
    for (int e = 0; e < kEach; ++e) to[own_row() + own_column(e) * kPivotLd] = value_[e];
  }

  // The rows below the pivots times U^-1, 16 by each warp in each turn. There are no more rows than threads,
  // so two turns are enough.
  static constexpr int kTurns = 2;
  __device__ int first_row(int turn) const {
    return (first_ + width_) / 16 * 16 + 16 * (threadIdx.x / kWarp + turn * (Threads / kWarp));
  }
  __device__ void make_multipliers(WarpTile<S, 1, 2> (&multipliers)[kTurns], SeenSizes& seen) const {
#pragma unroll
    for (int turn = 0; turn < kTurns; ++turn) {
      const int begin = first_row(turn), next = first_ + width_;
      if (begin >= tile_.rows) break;
      const S* const left = tile_.a + begin + first_ * tile_.ld;
      multipliers[turn].clear();
      multipliers[turn].multiply_entries(
          [&](int r, int k) { return k < width_ && begin + r >= next ? left[r + k * tile_.ld] : S(0); },
          [&](int k, int c) { return k <= c && c < width_ ? inverses_[k + c * kPivotLd] : S(0); },
          kPanelColumns);
      multipliers[turn].for_each([&](int r, int, const S& value) {
        const unsigned size = size_bits(value);
        if (begin + r < tile_.pivots) {
          seen.most_multiplier = max(seen.most_multiplier, size);
        } else if (begin + r < tile_.rows) {
          seen.most_border = max(seen.most_border, size);
        }
      });
    }
  }
  __device__ void keep_multipliers(WarpTile<S, 1, 2> (&multipliers)[kTurns]) const {
#pragma unroll
    for (int turn = 0; turn < kTurns; ++turn) {
      const int begin = first_row(turn);
      if (begin >= tile_.rows) break;
      multipliers[turn].for_each([&](int r, int c, const S& value) {
        const int row = begin + r;
        if (row >= first_ + width_ && row < tile_.rows && c < width_)
          pivots_[row - first_ + c * tile_.ld] = value;
      });
    }
  }

  const Tile<S>& tile_;
  const int first_, width_;
  const double bound_;
  PivotWork<S>& work_;
  S* const pivots_;
  const S* inverses_ = nullptr;    // of both triangles of the pivots' block
  S value_[kEach], upper_[kEach];  // entries of this thread: of the inverses, of U
};

}  // namespace mfs::cuda
