// Scaling for one solution: rows by what their residual is measured by.
#include "ordering/size_scaling.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "test/unit/test_matrices.hpp"

namespace mfs::test {
namespace {

struct GradedSystem {
  Matrix<double> a, at;
  std::vector<double> b, x;  // A x = b
};

/// Entries and unknowns of many decades.
GradedSystem graded_system(unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> grade(-70, 70);
  const Vertex n = 30;
  Entries entries = random_entries(generator, n, 3.0, 1.0, false), mirrored;
  GradedSystem system;
  system.b.assign(n, 0.0);
  for (Vertex i = 0; i < n; ++i) system.x.push_back(std::pow(10.0, grade(generator)));
  for (auto& [place, value] : entries) {
    value *= std::pow(10.0, grade(generator));
    mirrored[{place.second, place.first}] = value;
    system.b[place.first] += value * system.x[place.second];
  }
  system.a = matrix_of(n, entries);
  system.at = matrix_of(n, mirrored);
  return system;
}

TEST(SizeScaling, SizesOfRowsAndLargestEntriesOfColumnsBecomeOne) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const GradedSystem system = graded_system(seed);
    const Pattern p = check_pattern(system.a.view());
    const double* values = system.a.values.data();
    const PowerScaling scaling = scaling_by_size(p, values, system.b.data(), system.x.data(), false, 1);
    for (Vertex i = 0; i < p.n; ++i) {
      double size = std::abs(system.b[i]);
      for (Offset k = p.offsets[i]; k < p.offsets[i + 1]; ++k)
        size += std::abs(values[k]) * system.x[p.columns[k]];
      EXPECT_GE(std::ldexp(size, scaling.row[i]), 1) << "row " << i;
      EXPECT_LT(std::ldexp(size, scaling.row[i]), 2) << "row " << i;
    }
    const LargestEntries largest = largest_entries(p, exponents_of(values, p.nnz(), 1), scaling, 1);
    for (Vertex i = 0; i < p.n; ++i) {
      EXPECT_EQ(largest.column[i], 0) << "column " << i;
      EXPECT_LE(largest.row[i], 0) << "row " << i;
      EXPECT_GE(largest.row[i], -8) << "row " << i;  // 1/2 of 1/(2 n), as b = A x
    }
  }
}

TEST(SizeScaling, OfTheTransposedMatrix) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const GradedSystem system = graded_system(seed);
    const double *b = system.b.data(), *x = system.x.data();
    const PowerScaling plain =
        scaling_by_size(check_pattern(system.a.view()), system.a.values.data(), b, x, false, 1);
    const PowerScaling transposed =
        scaling_by_size(check_pattern(system.at.view()), system.at.values.data(), b, x, true, 1);
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
  const double b[] = {32, 0}, x[] = {4, 0};
  const PowerScaling scaling = scaling_by_size(check_pattern(a.view()), a.values.data(), b, x, false, 1);
  EXPECT_EQ(scaling.row, (std::vector<std::int32_t>{-6, -11}));
  EXPECT_EQ(scaling.column, (std::vector<std::int32_t>{3, 5}));
}

}  // namespace
}  // namespace mfs::test
