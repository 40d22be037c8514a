#include "ordering/transpose.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "ordering/row_shares.hpp"

namespace mfs {

// Each share of the rows counts its entries by column; sums over the shares before it tell where in each
// column they begin, and sums over columns where that does.
TransposedPattern transpose(const Pattern& pattern, int threads) {
  const RowShares shares(pattern.n, threads);
  const int count = shares.count();
  const auto n = static_cast<std::size_t>(pattern.n);
  RawVector<Vertex> next(static_cast<std::size_t>(count) * n);  // by share, by column
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int share = 0; share < count; ++share) {
    Vertex* const of_share = next.data() + static_cast<std::size_t>(share) * n;
    std::fill_n(of_share, n, 0);
    const Offset end = pattern.offsets[shares.first_row(share + 1)];
    for (Offset slot = pattern.offsets[shares.first_row(share)]; slot < end; ++slot)
      ++of_share[pattern.columns[slot]];
  }

  TransposedPattern result;
  result.offsets.resize(n + 1);
  std::vector<Offset> begin(static_cast<std::size_t>(count) + 1, 0);  // by share of the columns
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int share = 0; share < count; ++share) {
    Offset place = 0;
    for (Vertex column = shares.first_row(share); column < shares.first_row(share + 1); ++column) {
      Vertex entries = 0;
      for (int rows = 0; rows < count; ++rows)
        entries += std::exchange(next[static_cast<std::size_t>(rows) * n + column], entries);
      result.offsets[column + 1] = place += entries;
    }
    begin[share + 1] = place;
  }
  for (int share = 0; share < count; ++share) begin[share + 1] += begin[share];
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int share = 0; share < count; ++share) {
    for (Vertex column = shares.first_row(share); column < shares.first_row(share + 1); ++column)
      result.offsets[column + 1] += begin[share];
  }

  result.columns.resize(pattern.columns.size());
  result.slots.resize(pattern.columns.size());
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int share = 0; share < count; ++share) {
    Vertex* const of_share = next.data() + static_cast<std::size_t>(share) * n;
    for (Vertex row = shares.first_row(share); row < shares.first_row(share + 1); ++row) {
      for (Offset slot = pattern.offsets[row]; slot < pattern.offsets[row + 1]; ++slot) {
        const Vertex column = pattern.columns[slot];
        const Offset k = result.offsets[column] + of_share[column]++;
        result.columns[k] = row;
        result.slots[k] = slot;
      }
    }
  }
  return result;
}

}  // namespace mfs
