// Scaling for one right-hand side: rows by what their residual is measured by.
#include "ordering/size_scaling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "test/unit/test_matrices.hpp"

namespace mfs::test {
namespace {

struct GradedSystem {
  Matrix<double> a, at;
  std::vector<double> b;
  std::vector<double> size;  // log2 of (|A| |x| + |b|)_i, but for the number of terms; A x = b
};

/// A lower triangular matrix with its rows exchanged. Entries, unknowns and sizes are of many hundred
/// decades, so that sums are their largest terms, and sizes come by substitution.
GradedSystem graded_system(unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> grade(-900, 900);
  const Vertex n = 30;
  std::vector<Vertex> row(n);
  std::iota(row.begin(), row.end(), 0);
  std::shuffle(row.begin(), row.end(), generator);
  Entries entries, mirrored;
  GradedSystem system;
  system.b.assign(n, 0.0);
  system.size.assign(n, 0.0);
  std::vector<double> unknown;
  for (Vertex i = 0; i < n; ++i) {
    double& size = system.size[row[i]] = grade(generator);
    system.b[row[i]] = std::exp2(size);
    double diagonal = 0;
    for (Vertex j = i - std::min<Vertex>(i, 4); j <= i; ++j) {
      const double logarithm = j == i ? diagonal = grade(generator) : grade(generator);
      entries[{row[i], j}] = mirrored[{j, row[i]}] = std::exp2(logarithm);
      if (j < i) size = std::max(size, logarithm + unknown[j]);
    }
    unknown.push_back(size - diagonal);
  }
  system.a = matrix_of(n, entries);
  system.at = matrix_of(n, mirrored);
  return system;
}

TEST(SizeScaling, SizesOfRowsAndLargestEntriesOfColumnsBecomeOne) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const GradedSystem system = graded_system(seed);
    const Pattern p = check_pattern(system.a.view(), 1);
    const double* values = system.a.values.data();
    const PowerScaling scaling = scaling_by_size(p, values, system.b.data(), false, 1);
    for (Vertex i = 0; i < p.n; ++i) {
      const double wanted = std::clamp(-system.size[i], -1020.0, 1020.0);  // as far as doubles reach
      EXPECT_NEAR(scaling.row[i], wanted, 1.001) << "row " << i;
    }
    const LargestEntries largest = largest_entries(p, exponents_of(values, p.nnz(), 1), scaling, 1);
    for (Vertex j = 0; j < p.n; ++j) {
      EXPECT_TRUE(largest.column[j] == 0 || std::abs(scaling.column[j]) == 1020) << "column " << j;
    }
  }
}

TEST(SizeScaling, OfTheTransposedMatrix) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const GradedSystem system = graded_system(seed);
    const double* b = system.b.data();
    const PowerScaling plain =
        scaling_by_size(check_pattern(system.a.view(), 1), system.a.values.data(), b, false, 1);
    const PowerScaling transposed =
        scaling_by_size(check_pattern(system.at.view(), 1), system.at.values.data(), b, true, 1);
    EXPECT_EQ(plain.row, transposed.column);
    EXPECT_EQ(plain.column, transposed.row);
  }
}

// Row 1 has no size: it must neither blow up nor decide about column 1.
//
//   [ 8  2 ]  x = [ 4 ]   b = [ 32 ]
//   [ 0 64 ]      [ 0 ]       [  0 ]
TEST(SizeScaling, RowsWithoutSizeAreScaledByTheirEntries) {
  const Matrix<double> a = matrix_of(2, {{{0, 0}, 8.0}, {{0, 1}, 2.0}, {{1, 1}, 64.0}});
  const double b[] = {32, 0};
  const PowerScaling scaling = scaling_by_size(check_pattern(a.view(), 1), a.values.data(), b, false, 1);
  EXPECT_EQ(scaling.row, (std::vector<std::int32_t>{-5, -10}));
  EXPECT_EQ(scaling.column, (std::vector<std::int32_t>{2, 4}));
}

}  // namespace
}  // namespace mfs::test
