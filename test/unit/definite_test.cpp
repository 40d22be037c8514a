// What looks definite, entry by entry.
#include "ordering/definite.hpp"

#include <gtest/gtest.h>

#include <complex>
#include <random>

#include "ordering/matrix_check.hpp"
#include "test/unit/test_matrices.hpp"

namespace mfs::test {
namespace {

template <class Scalar>
bool looks(Vertex n, const std::map<std::pair<Vertex, Vertex>, Scalar>& entries) {
  const Matrix<Scalar> a = matrix_of(n, entries);
  const Pattern pattern = check_pattern(a.view(), 1);
  const bool found = looks_definite(pattern, a.values.data(), 1);
  for (const int threads : {2, 3, 8}) EXPECT_EQ(looks_definite(pattern, a.values.data(), threads), found);
  return found;
}
using Reals = std::map<std::pair<Vertex, Vertex>, double>;
using Complexes = std::map<std::pair<Vertex, Vertex>, std::complex<double>>;

TEST(Definite, SmallMatrices) {
  EXPECT_TRUE(looks(1, Reals{{{0, 0}, 3.0}}));
  EXPECT_TRUE(looks(1, Reals{{{0, 0}, -3.0}}));
  EXPECT_FALSE(looks(1, Reals{{{0, 0}, 0.0}}));
  EXPECT_TRUE(looks(2, Reals{{{0, 0}, 4.0}, {{0, 1}, 2.0}, {{1, 0}, 2.0}, {{1, 1}, 1.0}}));  // 2^2 = 4 * 1
  EXPECT_FALSE(looks(2, Reals{{{0, 0}, 4.0}, {{0, 1}, 2.001}, {{1, 0}, 2.001}, {{1, 1}, 1.0}}));
  EXPECT_TRUE(looks(2, Reals{{{0, 0}, -4.0}, {{0, 1}, 1.0}, {{1, 0}, 1.0}, {{1, 1}, -1.0}}));
  EXPECT_FALSE(looks(2, Reals{{{0, 0}, 4.0}, {{0, 1}, 1.0}, {{1, 0}, 1.0}, {{1, 1}, -1.0}}));
  EXPECT_FALSE(looks(2, Reals{{{0, 0}, 4.0}, {{0, 1}, 1.0}, {{1, 0}, 1.0}}));  // no diagonal
}

TEST(Definite, SymmetryButForRounding) {
  const auto with = [](double upper, double lower) {
    return looks(2, Reals{{{0, 0}, 1.0}, {{0, 1}, upper}, {{1, 0}, lower}, {{1, 1}, 1.0}});
  };
  EXPECT_TRUE(with(0.3, 0.3 + 1e-16));
  EXPECT_FALSE(with(0.3, 0.3 + 1e-8));
  EXPECT_FALSE(with(0.3, -0.3));
  // Entries without one opposite, on either side; zeros are none.
  for (const bool upper : {false, true}) {
    const std::pair<Vertex, Vertex> place = upper ? std::pair(0, 1) : std::pair(1, 0);
    EXPECT_FALSE(looks(2, Reals{{{0, 0}, 1.0}, {{1, 1}, 1.0}, {place, 0.1}}));
    EXPECT_TRUE(looks(2, Reals{{{0, 0}, 1.0}, {{1, 1}, 1.0}, {place, 0.0}}));
  }
}

TEST(Definite, ComplexMatricesAreHermitian) {
  const std::complex<double> off(0.2, 0.1);
  const auto with = [&](std::complex<double> lower) {
    return looks(2, Complexes{{{0, 0}, 1.0}, {{0, 1}, off}, {{1, 0}, lower}, {{1, 1}, 1.0}});
  };
  EXPECT_TRUE(with(std::conj(off)));
  EXPECT_FALSE(with(off));
}

// B B^T + diagonal in every size; one entry altered anywhere is seen.
TEST(Definite, SumsOfSquares) {
  for (const Vertex n : {1, 2, 31, 33, 257}) {
    std::mt19937 generator(static_cast<unsigned>(n));
    Reals entries;
    for (Vertex i = 0; i < n; ++i) entries[{i, i}] += 1e-6;
    for (Vertex k = 0; k < 2 * n; ++k) {
      const Vertex i = static_cast<Vertex>(generator() % static_cast<unsigned>(n)),
                   j = static_cast<Vertex>(generator() % static_cast<unsigned>(n));
      const double a = 1 + 1e3 * static_cast<double>(generator()) / 4e9, b = -2.0;
      entries[{i, i}] += a * a;
      entries[{j, j}] += b * b;
      entries[{i, j}] += a * b;
      entries[{j, i}] += a * b;
    }
    EXPECT_TRUE(looks(n, entries)) << n;
    for (const Vertex at : {Vertex(0), n / 2, n - 1}) {
      Reals altered = entries;
      altered[{at, at}] = -altered[{at, at}];
      EXPECT_EQ(looks(n, altered), n == 1) << n << ' ' << at;
      altered = entries;
      altered[{at, (at + 1) % n}] += n == 1 ? 0 : 0.5;
      EXPECT_EQ(looks(n, altered), n == 1) << n << ' ' << at;
    }
  }
}

template <class Scalar>
bool dominated(Vertex n, const std::map<std::pair<Vertex, Vertex>, Scalar>& entries,
               const std::vector<Vertex>& row_order = {}) {
  const Matrix<Scalar> a = matrix_of(n, entries);
  const Pattern pattern = check_pattern(a.view(), 1);
  const bool found = rows_are_dominated(pattern, row_order, a.values.data(), 1);
  for (const int threads : {2, 3, 8})
    EXPECT_EQ(rows_are_dominated(pattern, row_order, a.values.data(), threads), found);
  return found;
}

TEST(Dominated, RowsButForRounding) {
  const auto with = [](double diagonal) {
    return dominated(3,
                     Reals{{{0, 0}, 1.0}, {{1, 0}, -0.1}, {{1, 1}, diagonal}, {{1, 2}, 0.2}, {{2, 2}, 9.0}});
  };
  EXPECT_TRUE(with(0.5));
  EXPECT_TRUE(with(-0.3));  // 0.1 + 0.2 is larger by rounding
  EXPECT_FALSE(with(0.2999999));
  EXPECT_FALSE(with(0.0));
  EXPECT_FALSE(dominated(2, Reals{{{0, 1}, 1.0}, {{1, 1}, 1.0}})) << "no diagonal";
  EXPECT_TRUE(dominated(1, Reals{{{0, 0}, 0.0}}));
}

// Columns count for nothing: 1 is not as large as 4.
TEST(Dominated, ByRowsAlone) {
  EXPECT_TRUE(dominated(2, Reals{{{0, 0}, 1.0}, {{1, 0}, 4.0}, {{1, 1}, 5.0}}));
  EXPECT_FALSE(dominated(2, Reals{{{0, 0}, 1.0}, {{0, 1}, 4.0}, {{1, 1}, 5.0}}));
}

TEST(Dominated, OfTheEntryThatIsMatched) {
  const Reals entries{{{0, 0}, 1.0}, {{0, 1}, 4.0}, {{1, 0}, 5.0}, {{1, 1}, 1.0}};
  EXPECT_FALSE(dominated(2, entries));
  EXPECT_TRUE(dominated(2, entries, {1, 0}));
}

TEST(Dominated, ComplexNumbersByTheirSize) {
  const std::complex<double> off(3, 4);
  EXPECT_TRUE(dominated(2, Complexes{{{0, 0}, {0, -5}}, {{0, 1}, off}, {{1, 1}, 1.0}}));
  EXPECT_FALSE(dominated(2, Complexes{{{0, 0}, {0, -4.9}}, {{0, 1}, off}, {{1, 1}, 1.0}}));
}

}  // namespace
}  // namespace mfs::test
