// The pattern by columns, beside a plain loop over rows and columns.
#include "ordering/transpose.hpp"

#include <gmock/gmock.h>

#include <random>

#include "test/unit/test_matrices.hpp"

namespace mfs::test {
namespace {

using ::testing::ElementsAreArray;

void expect_transposed(const Pattern& pattern, int threads) {
  SCOPED_TRACE("n = " + std::to_string(pattern.n) + ", threads " + std::to_string(threads));
  std::vector<Offset> offsets{0}, slots;
  std::vector<Vertex> rows;
  for (Vertex column = 0; column < pattern.n; ++column) {
    for (Vertex row = 0; row < pattern.n; ++row) {
      for (Offset slot = pattern.offsets[row]; slot < pattern.offsets[row + 1]; ++slot) {
        if (pattern.columns[slot] != column) continue;
        rows.push_back(row);
        slots.push_back(slot);
      }
    }
    offsets.push_back(static_cast<Offset>(rows.size()));
  }
  const TransposedPattern transposed = transpose(pattern, threads);
  EXPECT_THAT(transposed.offsets, ElementsAreArray(offsets));
  EXPECT_THAT(transposed.columns, ElementsAreArray(rows));
  EXPECT_THAT(transposed.slots, ElementsAreArray(slots));
}

TEST(Transpose, EmptyColumnsAndFullOnesWithAnyNumberOfThreads) {
  for (const Vertex n : {1, 2, 7, 33, 65, 257}) {
    std::mt19937 random(static_cast<unsigned>(n));
    Entries entries;
    for (Vertex row = 0; row < n; ++row) {
      entries[{row, n / 2}] = 1;  // a full column
      for (int k = 0; k < 3; ++k) {
        const auto column = static_cast<Vertex>(random() % static_cast<unsigned>(n));
        if (column % 4 != 1 && column != n / 2) entries[{row, column}] = 1;  // some stay empty
      }
    }
    for (const int threads : {1, 2, 3, 8, 16}) expect_transposed(pattern_of(n, entries), threads);
  }
}

}  // namespace
}  // namespace mfs::test
