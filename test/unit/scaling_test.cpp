// Exponents and scaling by powers of two.
#include "ordering/scaling.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <complex>
#include <random>

#include "test/unit/test_matrices.hpp"

namespace mfs::test {
namespace {

using ::testing::ElementsAre;

TEST(Scaling, ExponentsOfAllKindsOfNumbers) {
  const std::vector<double> reals{1.0, -1.5, 2.0, 0.75, 0.0, -0.0, 1e308, 5e-324};
  EXPECT_THAT(exponents_of(reals.data(), 8, 1),
              ElementsAre(0, 0, 1, -1, kZeroEntry, kZeroEntry, 1023, -1020));
  const std::vector<std::complex<float>> numbers{{0.0f, -4.0f}, {3.0f, 1.0f}, {0.0f, 0.0f}};
  EXPECT_THAT(exponents_of(numbers.data(), 3, 1), ElementsAre(2, 1, kZeroEntry));
}

TEST(Scaling, EachRowAndColumnGetsALargestEntryNearOne) {
  // D1 B D2 with D1, D2 between 1e-140 and 1e140: scaling must find its way back to entries near 1.
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> grade(-140, 140);
    const Vertex n = 30;
    Entries entries = random_entries(generator, n, 3.0, 1.0, false);
    std::vector<double> left(n), right(n);
    for (Vertex i = 0; i < n; ++i) {
      left[i] = std::pow(10.0, grade(generator));
      right[i] = std::pow(10.0, grade(generator));
    }
    for (auto& [place, value] : entries) value *= left[place.first] * right[place.second];
    const Matrix<double> a = matrix_of(n, entries);
    const Pattern p = check_pattern(a.view(), 1);
    const auto exponents = exponents_of(a.values.data(), p.nnz(), 1);
    PowerScaling scaling(n);
    equilibrate(p, exponents, 1, scaling);
    const LargestEntries largest = largest_entries(p, exponents, scaling, 1);
    for (Vertex i = 0; i < n; ++i) {
      EXPECT_LE(std::abs(largest.row[i]), 1) << "row " << i;
      EXPECT_LE(std::abs(largest.column[i]), 1) << "column " << i;
    }
    PowerScaling parallel(n);
    equilibrate(p, exponents, 4, parallel);
    EXPECT_EQ(parallel.row, scaling.row);
    EXPECT_EQ(parallel.column, scaling.column);
  }
}

TEST(Scaling, ZeroRowsAndColumnsKeepTheirScale) {
  const Matrix<double> a = matrix_of(3, {{{0, 0}, 1024.0}, {{1, 1}, 0.0}, {{2, 0}, 1.0}});
  const Pattern p = check_pattern(a.view(), 1);
  const auto exponents = exponents_of(a.values.data(), p.nnz(), 1);
  PowerScaling scaling(3);
  equilibrate(p, exponents, 1, scaling);
  EXPECT_EQ(scaling.row[1], 0);
  EXPECT_THAT(scaling.column, ElementsAre(::testing::_, 0, 0));
  EXPECT_LE(std::abs(10 + scaling.row[0] + scaling.column[0]), 1);
}

TEST(Scaling, SymmetricMatricesGetEqualScalesForRowsAndColumns) {
  std::mt19937 generator(3);
  Entries entries = random_entries(generator, 40, 4.0, 0.9, false);
  Entries mirrored = entries;
  for (const auto& [place, value] : entries) mirrored[{place.second, place.first}] = value * 1e6;
  for (const auto& [place, value] : mirrored) entries[{place.second, place.first}] = entries[place] = value;
  const Matrix<double> a = matrix_of(40, entries);
  const Pattern p = check_pattern(a.view(), 1);
  PowerScaling scaling(40);
  equilibrate(p, exponents_of(a.values.data(), p.nnz(), 1), 1, scaling);
  EXPECT_EQ(scaling.row, scaling.column);
}

// Blocks of ones that entries of 2^-30 link, between scales that differ at random: largest entries say
// nothing of the links, balanced scales bring them back to what they were.
TEST(Scaling, BalancedWhereOnlySmallEntriesLink) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 generator(seed);
    std::uniform_int_distribution<int> grade(-20, 20);
    const Vertex n = 12;
    std::vector<int> left(n), right(n);
    for (Vertex i = 0; i < n; ++i) left[i] = grade(generator), right[i] = grade(generator);
    Entries entries;
    const auto add = [&](Vertex i, Vertex j, int exponent) {
      entries[{i, j}] = std::ldexp(1.0, exponent + left[i] + right[j]);
    };
    for (Vertex i = 0; i < n; i += 2) {
      for (const auto& [row, column] : {std::pair{i, i}, {i, i + 1}, {i + 1, i}, {i + 1, i + 1}})
        add(row, column, 0);
      if (i > 0) add(i, i - 2, -30), add(i - 2, i, -30);
    }
    const Matrix<double> a = matrix_of(n, entries);
    const Pattern p = check_pattern(a.view(), 1);
    const auto exponents = exponents_of(a.values.data(), p.nnz(), 1);
    PowerScaling scaling(n);
    balance(p, exponents, scaling);
    const auto scaled = [&](Vertex i, Vertex j) { return scaled_exponent(p, exponents, scaling, i, j); };
    for (Vertex i = 0; i < n; i += 2) {
      EXPECT_NEAR(scaled(i, i), 0, 2);
      if (i > 0) {
        EXPECT_NEAR(scaled(i, i - 2), scaled(i - 2, i), 8);
      }
    }
  }
}

TEST(Scaling, FindsSlots) {
  const Pattern p = pattern_of(3, {{{0, 0}, 1}, {{0, 2}, 1}, {{2, 1}, 1}});
  EXPECT_EQ(find_slot(p, 0, 0), 0);
  EXPECT_EQ(find_slot(p, 0, 1), -1);
  EXPECT_EQ(find_slot(p, 0, 2), 1);
  EXPECT_EQ(find_slot(p, 1, 1), -1);
  EXPECT_EQ(find_slot(p, 2, 1), 2);
  EXPECT_EQ(find_slot(p, 2, 2), -1);
}

}  // namespace
}  // namespace mfs::test
