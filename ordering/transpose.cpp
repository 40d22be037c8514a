#include "ordering/transpose.hpp"

#include <utility>

#include "ordering/row_shares.hpp"

namespace mfs {

// Each share of the rows counts its entries by column; sums over shares and columns tell each share where its
// entries of a column begin.
TransposedPattern transpose(const Pattern& pattern, int threads) {
  const RowShares shares(pattern.n, threads);
  const std::size_t n = static_cast<std::size_t>(pattern.n);
  std::vector<std::vector<Offset>> next(shares.count(), std::vector<Offset>(n, 0));  // by share, by column
#pragma omp parallel for num_threads(shares.count()) schedule(static, 1)
  for (int share = 0; share < shares.count(); ++share) {
    const Offset begin = pattern.offsets[shares.first_row(share)],
                 end = pattern.offsets[shares.first_row(share + 1)];
    for (Offset slot = begin; slot < end; ++slot) ++next[share][pattern.columns[slot]];
  }

  TransposedPattern result;
  result.offsets.assign(n + 1, 0);
  Offset place = 0;
  for (std::size_t column = 0; column < n; ++column) {
    for (std::vector<Offset>& of_share : next) place += std::exchange(of_share[column], place);
    result.offsets[column + 1] = place;
  }

  result.columns.resize(pattern.columns.size());
  result.slots.resize(pattern.columns.size());
#pragma omp parallel for num_threads(shares.count()) schedule(static, 1)
  for (int share = 0; share < shares.count(); ++share) {
    for (Vertex row = shares.first_row(share); row < shares.first_row(share + 1); ++row) {
      for (Offset slot = pattern.offsets[row]; slot < pattern.offsets[row + 1]; ++slot) {
        const Offset k = next[share][pattern.columns[slot]]++;
        result.columns[k] = row;
        result.slots[k] = slot;
      }
    }
  }
  return result;
}

}  // namespace mfs
