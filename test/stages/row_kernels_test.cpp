// Products and triangular solves whose right-hand sides have the entries of a row beside each other, and rows
// that are gathered and scattered, against plain loops.
#include "kernels/dense/row_kernels.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "test/reference/random.hpp"

namespace mfs::test {
namespace {

constexpr Vertex kWidths[] = {4, 8, 16};
constexpr Vertex kSizes[] = {1, 2, 3, 7, 8, 9, 15, 16, 17, 31, 32, 33, 65, 257};

template <class Scalar>
class RowKernels : public testing::Test {
 protected:
  using Real = decltype(std::abs(Scalar()));
  static constexpr double kTolerance = 20 * static_cast<double>(std::numeric_limits<Real>::epsilon());
  static constexpr Vertex kGuard = 5;  // entries behind a block that nobody may touch

  static std::vector<Scalar> random(Vertex rows, Vertex columns, std::uint64_t seed) {
    return Random(seed).vector<Scalar>(rows * columns + kGuard);
  }
  static void expect_near(const std::vector<Scalar>& found, const std::vector<Scalar>& expected, double size,
                          const std::string& what) {
    for (std::size_t k = 0; k < found.size(); ++k) {
      const bool guard = k + kGuard >= found.size();
      ASSERT_LE(std::abs(found[k] - expected[k]), guard ? 0 : size * kTolerance) << what << ", entry " << k;
    }
  }
  // Small beside the diagonal, and NaN where the kernel must not look; its last entry is `pivot`.
  static std::vector<Scalar> triangle(bool upper, Vertex n, Vertex ld, Scalar pivot) {
    std::vector<Scalar> t = random(ld, n, 17 + n);
    for (Vertex j = 0; j < n; ++j) {
      for (Vertex i = 0; i < ld; ++i) {
        Scalar& entry = t[i + j * ld];
        if (i >= n || (upper ? i > j : i <= j)) {
          entry = std::numeric_limits<Real>::quiet_NaN();
        } else if (i == j) {
          entry += Scalar(static_cast<Real>(2));
        } else {
          entry /= static_cast<Real>(n);
        }
      }
    }
    if (upper && pivot != Scalar(0)) t[n - 1 + (n - 1) * ld] = pivot;
    return t;
  }

  static void expect_product(bool transposed, Vertex m, Vertex width, Vertex k) {
    const Vertex lda = (transposed ? k : m) + 3;
    const std::vector<Scalar> a = random(lda, transposed ? m : k, 1), b = random(k, width, 2),
                              c = random(m, width, 3);
    std::vector<Scalar> expected = c, found = c, again = c;
    for (Vertex i = 0; i < m; ++i) {
      for (Vertex p = 0; p < k; ++p) {
        for (Vertex j = 0; j < width; ++j)
          expected[i * width + j] -= a[transposed ? p + i * lda : i + p * lda] * b[p * width + j];
      }
    }
    const std::string what = std::to_string(m) + " rows of " + std::to_string(width) + ", " +
                             std::to_string(k) + (transposed ? " terms, transposed" : " terms");
    rows::gemm_minus(transposed, m, width, k, a.data(), lda, b.data(), found.data());
    expect_near(found, expected, 1 + k, what);
    rows::gemm_minus(transposed, m, width, k, a.data(), lda, b.data(), again.data());
    ASSERT_EQ(found, again) << what;
  }

  static void expect_solution(bool upper, bool transposed, Vertex n, Vertex width, Scalar pivot = Scalar(0)) {
    const Vertex ld = n + 3;
    const std::vector<Scalar> t = triangle(upper, n, ld, pivot), b = random(n, width, 4);
    std::vector<Scalar> expected = b, found = b;
    const auto entry = [&](Vertex i, Vertex j) { return transposed ? t[j + i * ld] : t[i + j * ld]; };
    for (Vertex turn = 0; turn < n; ++turn) {
      const bool downwards = upper == transposed;
      const Vertex i = downwards ? turn : n - 1 - turn;
      for (Vertex j = 0; j < width; ++j) {
        for (Vertex p = downwards ? 0 : i + 1; p < (downwards ? i : n); ++p)
          expected[i * width + j] -= entry(i, p) * expected[p * width + j];
        if (upper) expected[i * width + j] /= entry(i, i);
      }
    }
    rows::solve_triangle(upper, transposed, n, width, t.data(), ld, found.data());
    double size = 4;
    for (const Scalar& value : expected) size = std::max(size, static_cast<double>(std::abs(value)));
    expect_near(found, expected, size,
                std::string(upper ? "upper" : "lower") + (transposed ? ", transposed, " : ", ") +
                    std::to_string(n) + " rows of " + std::to_string(width));
  }
};
using Scalars = testing::Types<double, float, std::complex<double>, std::complex<float>>;
TYPED_TEST_SUITE(RowKernels, Scalars);

TEST(RowWidths, HoldAllColumns) {
  EXPECT_EQ(rows::width_of(1), 1);
  for (Vertex columns = 2; columns <= 16; ++columns) {
    const Vertex width = rows::width_of(columns);
    EXPECT_GE(width, columns);
    EXPECT_NE(std::count(std::begin(kWidths), std::end(kWidths), width), 0);
  }
}

TYPED_TEST(RowKernels, SubtractProducts) {
  for (const bool transposed : {false, true}) {
    for (const Vertex width : kWidths) {
      for (const Vertex m : kSizes) {
        for (const Vertex k : kSizes) {
          this->expect_product(transposed, m, width, k);
          if (this->HasFatalFailure()) return;
        }
      }
    }
  }
}

TYPED_TEST(RowKernels, AnEmptyProductLeavesWhatWasThere) {
  for (const bool transposed : {false, true}) {
    this->expect_product(transposed, 0, 16, 5);
    this->expect_product(transposed, 5, 16, 0);
  }
}

TYPED_TEST(RowKernels, SolveWithTriangles) {
  for (const bool upper : {false, true}) {
    for (const bool transposed : {false, true}) {
      for (const Vertex width : kWidths) {
        for (const Vertex n : kSizes) {
          this->expect_solution(upper, transposed, n, width);
          if (this->HasFatalFailure()) return;
        }
      }
    }
  }
}

// The reciprocal of such a pivot is infinite, what is divided by it is not.
TYPED_TEST(RowKernels, DivideByTheSmallestPivots) {
  using Real = decltype(std::abs(TypeParam()));
  const auto number = [](Real real) { return TypeParam(real); };
  const TypeParam least = number(std::numeric_limits<Real>::denorm_min() * 8);
  for (const bool transposed : {false, true}) {
    for (const Vertex n : {1, 2, 8, 11}) {  // such a pivot is that of the row that is solved for last
      std::vector<TypeParam> t(static_cast<std::size_t>(n * n), TypeParam(0));
      const Vertex last = transposed ? n - 1 : 0,
                   before = transposed ? std::max(0, n - 2) : std::min(1, n - 1);
      for (Vertex i = 0; i < n; ++i) t[i + i * n] = number(2);
      if (n > 1) t[std::min(before, last) + std::max(before, last) * n] = least;
      t[last + last * n] = least;
      for (const Vertex width : kWidths) {
        std::vector<TypeParam> b(static_cast<std::size_t>(n * width), number(4));
        for (Vertex j = 0; j < width; ++j) b[last * width + j] = least * number(n > 1 ? 5 : 3);
        rows::solve_triangle(true, transposed, n, width, t.data(), n, b.data());
        for (Vertex i = 0; i < n; ++i) {
          for (Vertex j = 0; j < width; ++j)
            EXPECT_EQ(b[i * width + j], number(i == last ? 3 : 2))
                << n << " rows, row " << i << ", width " << width;
        }
      }
    }
  }
}

TYPED_TEST(RowKernels, RowsAreGatheredScatteredAndAdded) {
  const std::vector<Vertex> row = {4, 1, 6, 3};
  const Vertex count = 4, all = 7;
  for (const Vertex width : {1, 4, 8, 16}) {
    const std::vector<TypeParam> whole = this->random(all, width, 5), part = this->random(count, width, 6);
    std::vector<TypeParam> gathered = part, scattered = whole, added = whole;
    std::vector<TypeParam> expected_part = part, expected = whole, sums = whole;
    for (Vertex i = 0; i < count; ++i) {
      for (Vertex j = 0; j < width; ++j) {
        expected_part[i * width + j] = whole[row[i] * width + j];
        expected[row[i] * width + j] = part[i * width + j];
        sums[(row[i] - 1) * width + j] += part[i * width + j];
      }
    }
    rows::gather(count, width, row.data(), whole.data(), gathered.data());
    EXPECT_EQ(gathered, expected_part) << width;
    rows::scatter(count, width, row.data(), part.data(), scattered.data());
    EXPECT_EQ(scattered, expected) << width;
    rows::scatter_add(count, width, row.data(), 1, part.data(), added.data());
    EXPECT_EQ(added, sums) << width;
  }
}

}  // namespace
}  // namespace mfs::test
