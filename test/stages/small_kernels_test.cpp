// Products and triangular solves of small blocks, and the sums of contribution blocks, against plain loops.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <vector>

#include "kernels/dense/blas.hpp"
#include "kernels/dense/row_runs.hpp"
#include "kernels/dense/small_kernels.hpp"
#include "test/reference/random.hpp"

namespace mfs::test {
namespace {

using blas::Transpose;

/// Column-major with rows below that nobody may touch.
template <class Scalar>
struct Block {
  static constexpr Vertex kBelow = 3;
  Block(Vertex rows_, Vertex columns_, std::uint64_t seed)
      : rows(rows_),
        columns(columns_),
        ld(rows_ + kBelow),
        entries(Random(seed).vector<Scalar>(ld * columns_ + 1)) {}
  Scalar* data() { return entries.data(); }
  const Scalar* data() const { return entries.data(); }
  Scalar& at(Vertex i, Vertex j) { return entries[i + j * ld]; }
  Scalar at(Vertex i, Vertex j) const { return entries[i + j * ld]; }
  Vertex rows, columns;
  Offset ld;
  std::vector<Scalar> entries;
};

std::string sizes(Vertex m, Vertex n, Vertex k) {
  return std::to_string(m) + " x " + std::to_string(n) + ", " + std::to_string(k) + " terms";
}

template <class Scalar>
class SmallKernels : public testing::Test {
 protected:
  using Real = decltype(std::abs(Scalar()));
  static constexpr double kTolerance = 20 * static_cast<double>(std::numeric_limits<Real>::epsilon());

  // Of the entries' own rows; those below are as they were.
  static void expect_near(const Block<Scalar>& found, const Block<Scalar>& expected, double size,
                          const std::string& what) {
    for (Vertex j = 0; j < found.columns; ++j) {
      for (Vertex i = 0; i < found.rows; ++i)
        ASSERT_LE(std::abs(found.at(i, j) - expected.at(i, j)), size * kTolerance)
            << what << ", entry " << i << ", " << j;
      for (Vertex i = found.rows; i < found.ld; ++i)
        ASSERT_EQ(found.at(i, j), expected.at(i, j)) << what << ": row " << i << " is beyond the block";
    }
  }
  // C - op(A) B, twice.
  static void expect_product(Transpose transpose, Vertex m, Vertex n, Vertex k) {
    const bool plain = transpose == Transpose::no;
    const Block<Scalar> a(plain ? m : k, plain ? k : m, 1), b(k, n, 2), before(m, n, 3);
    Block<Scalar> expected = before;
    for (Vertex j = 0; j < n; ++j) {
      for (Vertex p = 0; p < k; ++p) {
        for (Vertex i = 0; i < m; ++i) expected.at(i, j) -= (plain ? a.at(i, p) : a.at(p, i)) * b.at(p, j);
      }
    }
    Block<Scalar> found = before, again = before;
    blas::gemm_minus(transpose, m, n, k, a.data(), a.ld, b.data(), b.ld, found.data(), found.ld);
    expect_near(found, expected, 1 + k, sizes(m, n, k));
    if (HasFatalFailure()) return;
    blas::gemm_minus(transpose, m, n, k, a.data(), a.ld, b.data(), b.ld, again.data(), again.ld);
    ASSERT_EQ(found.entries, again.entries) << sizes(m, n, k);
  }
  // Small beside the diagonal, and NaN where the kernel must not look.
  static Block<Scalar> triangle(Vertex n, bool upper) {
    Block<Scalar> t(n, n, 17 + n);
    for (Vertex j = 0; j < n; ++j) {
      for (Vertex i = 0; i < n; ++i) {
        if (upper ? i > j : i <= j) {
          t.at(i, j) = std::numeric_limits<Real>::quiet_NaN();
        } else if (i == j) {
          t.at(i, j) += Scalar(static_cast<Real>(2));
        } else {
          t.at(i, j) /= static_cast<Real>(n);
        }
      }
    }
    return t;
  }
};
using Scalars = testing::Types<double, float, std::complex<double>, std::complex<float>>;
TYPED_TEST_SUITE(SmallKernels, Scalars);

// Around the registers of all kinds, two and three of them, and past the bound where BLAS comes in.
constexpr Vertex kSizes[] = {0, 1, 2, 3, 4, 5, 7, 8, 9, 12, 16, 23, 24, 25, 31, 32, 33, 65, 129, 257};

TYPED_TEST(SmallKernels, SubtractProducts) {
  for (const Vertex m : kSizes) {
    for (const Vertex n : kSizes) {
      for (const Vertex k : {0, 1, 2, 5, 31, 65, 257, 600}) {
        if (k > 65 && n > 17) continue;  // more terms at once, as solves have them
        this->expect_product(Transpose::no, m, n, k);
        if (this->HasFatalFailure()) return;
      }
    }
  }
}

TYPED_TEST(SmallKernels, SubtractTransposedProducts) {
  for (const Vertex m : kSizes) {
    for (const Vertex n : {0, 1, 2, 3, 4, 5, 7, 16, 17, 33}) {
      for (const Vertex k : {0, 1, 2, 5, 8, 9, 16, 31, 65, 257, 600}) {
        this->expect_product(Transpose::yes, m, n, k);
        if (this->HasFatalFailure()) return;
      }
    }
  }
}

TYPED_TEST(SmallKernels, SolveWithTransposedTriangles) {
  for (const Vertex n : kSizes) {
    if (n == 0) continue;
    const Block<TypeParam> u = this->triangle(n, true), l = this->triangle(n, false);
    for (const Vertex columns : {0, 1, 2, 3, 4, 5, 7, 16, 17}) {
      const Block<TypeParam> before(n, columns, 4);
      Block<TypeParam> by_upper = before, by_lower = before;
      for (Vertex j = 0; j < columns; ++j) {
        for (Vertex i = 0; i < n; ++i) {
          for (Vertex p = 0; p < i; ++p) by_upper.at(i, j) -= u.at(p, i) * by_upper.at(p, j);
          by_upper.at(i, j) /= u.at(i, i);
        }
        for (Vertex i = n - 1; i >= 0; --i) {
          for (Vertex p = i + 1; p < n; ++p) by_lower.at(i, j) -= l.at(p, i) * by_lower.at(p, j);
        }
      }
      Block<TypeParam> found = before;
      blas::solve_upper(Transpose::yes, n, columns, u.data(), u.ld, found.data(), found.ld);
      this->expect_near(found, by_upper, 4, "upper, " + sizes(n, columns, n));
      found = before;
      blas::solve_unit_lower(Transpose::yes, n, columns, l.data(), l.ld, found.data(), found.ld);
      this->expect_near(found, by_lower, 4, "lower, " + sizes(n, columns, n));
      if (this->HasFatalFailure()) return;
    }
  }
}

TYPED_TEST(SmallKernels, SolveWithUnitLowerTriangles) {
  for (const Vertex n : kSizes) {
    const Block<TypeParam> t = this->triangle(n, false);
    for (const Vertex columns : kSizes) {
      if (n == 0) continue;
      const Block<TypeParam> before(n, columns, 4);
      Block<TypeParam> expected = before;
      for (Vertex j = 0; j < columns; ++j) {
        for (Vertex p = 0; p < n; ++p) {
          for (Vertex i = p + 1; i < n; ++i) expected.at(i, j) -= t.at(i, p) * expected.at(p, j);
        }
      }
      Block<TypeParam> found = before;
      blas::solve_unit_lower(Transpose::no, n, columns, t.data(), t.ld, found.data(), found.ld);
      this->expect_near(found, expected, 4, sizes(n, columns, n));
      if (this->HasFatalFailure()) return;
    }
  }
}

TYPED_TEST(SmallKernels, SolveWithUpperTriangles) {
  for (const Vertex n : kSizes) {
    const Block<TypeParam> u = this->triangle(n, true);
    for (const Vertex columns : kSizes) {
      if (n == 0) continue;
      const Block<TypeParam> before(n, columns, 4);
      Block<TypeParam> expected = before;
      for (Vertex j = 0; j < columns; ++j) {
        for (Vertex p = n - 1; p >= 0; --p) {
          expected.at(p, j) /= u.at(p, p);
          for (Vertex i = 0; i < p; ++i) expected.at(i, j) -= u.at(i, p) * expected.at(p, j);
        }
      }
      Block<TypeParam> found = before, again = before;
      blas::solve_upper(Transpose::no, n, columns, u.data(), u.ld, found.data(), found.ld);
      this->expect_near(found, expected, 4, sizes(n, columns, n));
      blas::solve_upper(Transpose::no, n, columns, u.data(), u.ld, again.data(), again.ld);
      ASSERT_EQ(found.entries, again.entries) << sizes(n, columns, n);
      if (this->HasFatalFailure()) return;
    }
  }
}

TYPED_TEST(SmallKernels, SolveWithUpperTrianglesFromTheRight) {
  for (const Vertex n : kSizes) {
    const Block<TypeParam> u = this->triangle(n, true);
    for (const Vertex rows : kSizes) {
      const Block<TypeParam> before(rows, n, 5);
      Block<TypeParam> expected = before;
      for (Vertex j = 0; j < n; ++j) {
        for (Vertex i = 0; i < rows; ++i) {
          for (Vertex p = 0; p < j; ++p) expected.at(i, j) -= expected.at(i, p) * u.at(p, j);
          expected.at(i, j) /= u.at(j, j);
        }
      }
      Block<TypeParam> found = before;
      blas::solve_upper_right(rows, n, u.data(), u.ld, found.data(), found.ld);
      this->expect_near(found, expected, 4, sizes(rows, n, n));
      if (this->HasFatalFailure()) return;
    }
  }
}

// Pivots may be tiny (TinyPivots::data): what they divide is what overflows, not their reciprocal.
TYPED_TEST(SmallKernels, DivideByPivotsWhoseReciprocalOverflows) {
  using Real = decltype(std::abs(TypeParam()));
  const Real tiny = std::numeric_limits<Real>::denorm_min() * 4;
  Block<TypeParam> u = this->triangle(3, true), b(10, 3, 6);
  u.at(1, 1) = tiny;
  for (Vertex i = 0; i < 10; ++i) {
    b.at(i, 0) = 0;
    b.at(i, 1) = tiny;
  }
  Block<TypeParam> found = b;
  EXPECT_FALSE(small::solve_upper_right(Vertex(10), Vertex(3), u.data(), u.ld, found.data(), found.ld));
  EXPECT_EQ(found.entries, b.entries);
  EXPECT_FALSE(small::solve_upper(Vertex(3), Vertex(2), u.data(), u.ld, found.data(), found.ld));
  EXPECT_EQ(found.entries, b.entries);
}

// A solve of a window of rows looks at rows that are done: they stay as they are, whatever they hold.
TYPED_TEST(SmallKernels, LeaveRowsThatAreDone) {
  const Vertex n = 19;
  const Block<TypeParam> t = this->triangle(n, false);
  Block<TypeParam> b(n, 9, 7);
  for (Vertex j = 0; j < 9; ++j) b.at(0, j) *= static_cast<decltype(std::abs(TypeParam()))>(1e6);
  Block<TypeParam> first = b, all = b;
  small::solve_unit_lower(n, Vertex(9), t.data(), t.ld, all.data(), all.ld);
  small::solve_unit_lower(Vertex(16), Vertex(9), t.data(), t.ld, first.data(), first.ld);
  for (Vertex j = 0; j < 9; ++j) {
    for (Vertex i = 0; i < 16; ++i) ASSERT_EQ(all.at(i, j), first.at(i, j)) << i << ", " << j;
  }
}

TYPED_TEST(SmallKernels, LeaveRowsBelowThatAreDone) {
  const Vertex n = 19, rest = 16, above = n - rest;
  const Block<TypeParam> u = this->triangle(n, true);
  Block<TypeParam> b(n, 9, 7);
  for (Vertex j = 0; j < 9; ++j) b.at(n - 1, j) *= static_cast<decltype(std::abs(TypeParam()))>(1e6);
  Block<TypeParam> last = b, all = b;
  ASSERT_TRUE(small::solve_upper(n, Vertex(9), u.data(), u.ld, all.data(), all.ld));
  ASSERT_TRUE(small::solve_upper(rest, Vertex(9), u.data() + above + above * u.ld, u.ld, last.data() + above,
                                 last.ld));
  for (Vertex j = 0; j < 9; ++j) {
    for (Vertex i = above; i < n; ++i) ASSERT_EQ(all.at(i, j), last.at(i, j)) << i << ", " << j;
  }
}

TEST(RowRuns, AreFoundInPieces) {
  const std::vector<Vertex> map{3, 4, 5, 9, 10, 14};
  RowRun runs[kRunsAtOnce];
  Vertex row = 0;
  ASSERT_EQ(find_runs(map.data(), 6, 2, row, runs), 3);
  EXPECT_EQ(row, 6);
  const std::vector<std::vector<Vertex>> expected{{0, 1, 3}, {3, 7, 2}, {5, 12, 1}};
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ((std::vector<Vertex>{runs[k].from, runs[k].to, runs[k].count}), expected[k]);
  }
  std::vector<Vertex> scattered;
  for (Vertex i = 0; i < 2 * kRunsAtOnce + 1; ++i) scattered.push_back(2 * i);
  row = 0;
  std::vector<Vertex> counts;
  while (row < static_cast<Vertex>(scattered.size()))
    counts.push_back(find_runs(scattered.data(), static_cast<Vertex>(scattered.size()), 0, row, runs));
  EXPECT_EQ(counts, (std::vector<Vertex>{kRunsAtOnce, kRunsAtOnce, 1}));
}

TYPED_TEST(SmallKernels, AddRuns) {
  const std::vector<Vertex> map{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 14, 20};
  const auto rows = static_cast<Vertex>(map.size());
  const Block<TypeParam> from(rows, rows, 8);
  Block<TypeParam> to(21, 21, 9), expected = to;
  RowRun runs[kRunsAtOnce];
  Vertex row = 2;
  const Vertex count = find_runs(map.data(), rows, 1, row, runs);
  add_runs(runs, count, from.data(), from.ld, map.data(), Vertex(3), Vertex(12), Vertex(2), to.data(), to.ld);
  for (Vertex j = 3; j < 12; ++j) {
    for (Vertex i = 2; i < rows; ++i) expected.at(map[i] - 1, map[j] - 2) += from.at(i, j);
  }
  EXPECT_EQ(to.entries, expected.entries);
}

}  // namespace
}  // namespace mfs::test
