#include "ordering/transpose.hpp"

#include <algorithm>
#include <utility>

namespace mfs {
namespace {

/// More threads than this would cost more memory for their counters than they save time.
constexpr int kMostShares = 8;

}  // namespace

// Each share of the rows counts its entries by column; sums over shares and columns tell each share where its
// entries of a column begin.
TransposedPattern transpose(const Pattern& pattern, int threads) {
  const int shares = std::min(threads, kMostShares);
  const std::size_t n = static_cast<std::size_t>(pattern.n);
  const auto first_row = [&](int share) { return static_cast<Vertex>(Offset{pattern.n} * share / shares); };
  std::vector<std::vector<Offset>> next(shares, std::vector<Offset>(n, 0));  // by share, by column
#pragma omp parallel for num_threads(shares) schedule(static, 1)
  for (int share = 0; share < shares; ++share) {
    const Offset begin = pattern.offsets[first_row(share)], end = pattern.offsets[first_row(share + 1)];
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
#pragma omp parallel for num_threads(shares) schedule(static, 1)
  for (int share = 0; share < shares; ++share) {
    for (Vertex row = first_row(share); row < first_row(share + 1); ++row) {
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
