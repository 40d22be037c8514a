// The residual of one column and of eight at once against plain loops in long double: real and complex, A and
// A^T by slots, groups of rows, rows with more terms than a sum takes in one block.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numeric>
#include <vector>

#include "kernels/stages/residual_columns.hpp"
#include "test/reference/random.hpp"

namespace mfs::test {
namespace {

constexpr Vertex K = kResidualColumns;

/// Row i has 7 i mod 31 entries, row 3 as many as two blocks of a sum and more.
template <class Scalar>
struct Rows {
  explicit Rows(Vertex n) : random(5) {
    for (Vertex i = 0; i < n; ++i) {
      const Vertex count = i == 3 ? 600 : 7 * i % 31;
      for (Vertex k = 0; k < count; ++k) columns.push_back(static_cast<Vertex>(random.integer(0, n)));
      offsets.push_back(static_cast<Offset>(columns.size()));
    }
    values = random.vector<Scalar>(static_cast<std::int64_t>(columns.size()));
    slots.resize(columns.size());
    std::iota(slots.rbegin(), slots.rend(), Offset(0));
  }
  RowAccess<Scalar> access(bool by_slots) const {
    return {offsets.data(), columns.data(), by_slots ? slots.data() : nullptr, values.data()};
  }
  Random random;
  std::vector<Offset> offsets{0}, slots;
  std::vector<Vertex> columns;
  std::vector<Scalar> values;
};

template <class Scalar>
class ResidualColumns : public testing::Test {};
using Scalars = testing::Types<double, float, std::complex<double>, std::complex<float>>;
TYPED_TEST_SUITE(ResidualColumns, Scalars);

template <class Scalar>
auto exact(const Scalar& x) {
  if constexpr (std::is_floating_point_v<Scalar>) {
    return static_cast<long double>(x);
  } else {
    return std::complex<long double>(x.real(), x.imag());
  }
}

TYPED_TEST(ResidualColumns, AreThoseOfEachColumn) {
  using Real = decltype(std::abs(TypeParam()));
  for (const Vertex n : {1, 5, 40, 257}) {
    const Rows<TypeParam> a(n);
    const std::vector<TypeParam> b = Random(6).vector<TypeParam>(n * K),
                                 x = Random(7).vector<TypeParam>(n * K);
    for (const bool by_slots : {false, true}) {
      const Offset first = n / 3, last = n - n / 5;
      const TypeParam untouched(static_cast<Real>(99));
      std::vector<TypeParam> r(b.size(), untouched);
      double error[K];
      residual_rows(a.access(by_slots), first, last, n, b.data(), x.data(), r.data(), error);
      for (Vertex c = 0; c < K; ++c) {
        double worst = 0;
        for (Offset i = 0; i < n; ++i) {
          if (i < first || i >= last) {
            ASSERT_EQ(r[i + c * n], untouched) << i;
            continue;
          }
          auto sum = exact(b[i + c * n]);
          long double size = std::abs(sum);
          for (Offset k = a.offsets[i]; k < a.offsets[i + 1]; ++k) {
            const auto term = exact(a.values[by_slots ? a.slots[k] : k]) * exact(x[a.columns[k] * K + c]);
            sum -= term;
            size += std::abs(term);
          }
          const double bound = 4 * std::numeric_limits<Real>::epsilon() * static_cast<double>(size);
          ASSERT_LE(std::abs(exact(r[i + c * n]) - sum), bound)
              << "n " << n << ", row " << i << ", column " << c;
          worst = std::max(worst, static_cast<double>(std::abs(sum) / size));
        }
        ASSERT_NEAR(error[c], worst, 1e-13) << "n " << n << ", column " << c;
      }
    }
  }
}

// Rows of as many terms as end within a block of a sum, with it and behind it.
TYPED_TEST(ResidualColumns, OfOneColumn) {
  using Real = decltype(std::abs(TypeParam()));
  const std::vector<Vertex> counts{0, 1, 3, 255, 256, 257, 512, 513, 2000};
  const Vertex n = static_cast<Vertex>(counts.size());
  Random random(8);
  std::vector<Offset> offsets{0};
  std::vector<Vertex> columns;
  for (const Vertex count : counts) {
    for (Vertex k = 0; k < count; ++k) columns.push_back(static_cast<Vertex>(random.integer(0, n)));
    offsets.push_back(static_cast<Offset>(columns.size()));
  }
  const auto values = random.vector<TypeParam>(static_cast<std::int64_t>(columns.size()));
  const std::vector<TypeParam> b = random.vector<TypeParam>(n), x = random.vector<TypeParam>(n);
  const RowAccess<TypeParam> a{offsets.data(), columns.data(), nullptr, values.data()};
  std::vector<TypeParam> r(b.size());
  std::vector<double> sizes(b.size());
  double error = -1;
  residual(OneThread(), n, a, b.data(), x.data(), r.data(), &error, sizes.data());
  double worst = 0;
  for (Vertex i = 0; i < n; ++i) {
    auto sum = exact(b[i]);
    long double size = std::abs(sum);
    for (Offset k = offsets[i]; k < offsets[i + 1]; ++k) {
      const auto term = exact(values[k]) * exact(x[columns[k]]);
      sum -= term;
      size += std::abs(term);
    }
    EXPECT_LE(std::abs(exact(r[i]) - sum), 4 * std::numeric_limits<Real>::epsilon() * size) << "row " << i;
    EXPECT_NEAR(sizes[i], static_cast<double>(size), 1e-12 * static_cast<double>(size));
    worst = std::max(worst, static_cast<double>(std::abs(sum) / size));
  }
  EXPECT_NEAR(error, worst, 1e-13);
}

// A plain sum of so many equal terms is off by 2e-12 of their size.
TEST(ResidualColumns, OfALongRowOfEqualTerms) {
  const std::int64_t count = 100000;
  const std::vector<Offset> offsets{0, count};
  const std::vector<Vertex> columns(count, 0);
  const std::vector<double> values(count, 0.1);
  const double b = 0, x = 1;
  double r = 0, error = 0;
  residual(OneThread(), 1, RowAccess<double>{offsets.data(), columns.data(), nullptr, values.data()}, &b, &x,
           &r, &error);
  EXPECT_NEAR(r, -0.1 * count, 1e-14 * 0.1 * count);
  EXPECT_NEAR(error, 1, 1e-11);
}

// Exact rows, rows without entries, and the last row wrong: the worst is found wherever it stands.
TEST(ResidualColumns, WorstOfAllRows) {
  const std::vector<Offset> offsets{0, 1, 1, 2, 3};
  const std::vector<Vertex> columns{0, 1, 2};
  const std::vector<double> values{1, 2, 4};
  const std::vector<double> x{1, 1, 1, 1};
  const RowAccess<double> a{offsets.data(), columns.data(), nullptr, values.data()};
  const double infinity = std::numeric_limits<double>::infinity(), huge = std::numeric_limits<double>::max();
  const auto error_for = [&](const std::vector<double>& b, const std::vector<double>& unknowns) {
    std::vector<double> r(4);
    double error = -1;
    residual(OneThread(), 4, a, b.data(), unknowns.data(), r.data(), &error);
    return error;
  };
  EXPECT_EQ(error_for({0, 0, 0, 0}, {0, 0, 0, 0}), 0);
  EXPECT_EQ(error_for({1, 0, 2, 4}, x), 0);
  EXPECT_EQ(error_for({1, 0, 2, 8}, x), 4.0 / 12);
  EXPECT_EQ(error_for({3, 0, 2, 8}, x), 0.5);
  EXPECT_EQ(error_for({3, 0, 2, 28}, x), 0.75);
  EXPECT_EQ(error_for({1, 1, 2, 8}, x), 1);
  EXPECT_EQ(error_for({1, infinity, 2, 8}, x), infinity);
  EXPECT_EQ(error_for({1, 0, std::nan(""), 8}, x), infinity);
  EXPECT_EQ(error_for({1, 0, 2, huge}, {1, 1, huge, 1}), infinity) << "a product beyond the range";
  EXPECT_EQ(error_for({3, 0, 2, huge}, {1, 1, huge / 4 * (1 - 1e-15), 1}), infinity) << "a size beyond it";
}

// A row that is zero has no error, one that is not finite an infinite one, in its own column.
TEST(ResidualColumns, RowsWithoutASize) {
  const std::vector<Offset> offsets{0, 1, 2};
  const std::vector<Vertex> columns{0, 1};
  const std::vector<double> values{1, 1};
  std::vector<double> b(2 * K, 0.0), x(2 * K, 0.0), r(2 * K);
  x[1 * K + 2] = std::numeric_limits<double>::quiet_NaN();
  b[1 + 4 * 2] = std::numeric_limits<double>::infinity();
  double error[K];
  residual_rows({offsets.data(), columns.data(), nullptr, values.data()}, 0, 2, 2, b.data(), x.data(),
                r.data(), error);
  for (Vertex c = 0; c < K; ++c)
    EXPECT_EQ(error[c], c == 2 || c == 4 ? std::numeric_limits<double>::infinity() : 0.0) << c;
}

/// The error of x as a solution of [a 2a; 0 a] x = b, whose other column is right.
template <class Scalar>
double error_of(Scalar a, const std::vector<Scalar>& b, const std::vector<Scalar>& x, bool columns) {
  const std::vector<Offset> offsets{0, 2, 3};
  const std::vector<Vertex> indices{0, 1, 1};
  const std::vector<Scalar> values{a, a + a, a};
  const RowAccess<Scalar> rows{offsets.data(), indices.data(), nullptr, values.data()};
  std::vector<Scalar> all_b(2 * K, Scalar(0)), all_x(2 * K, Scalar(0)), r(2 * K);
  double error[K];
  if (!columns) {
    residual(OneThread(), 2, rows, b.data(), x.data(), r.data(), error);
    return error[0];
  }
  for (Vertex i = 0; i < 2; ++i) {
    all_b[2 * (K - 1) + i] = b[i];
    all_x[i * K + K - 1] = x[i];
  }
  residual_rows(rows, 0, 2, 2, all_b.data(), all_x.data(), r.data(), error);
  for (Vertex c = 0; c + 1 < K; ++c) EXPECT_EQ(error[c], 0);
  return error[K - 1];
}

// Some least numbers for each unknown are free.
TYPED_TEST(ResidualColumns, UnknownsWithoutDigitsAreNoError) {
  using Real = decltype(std::abs(TypeParam()));
  const Real least = std::numeric_limits<Real>::min(), step = std::numeric_limits<Real>::denorm_min();
  const auto scalars = [](Real x, Real y) { return std::vector<TypeParam>{TypeParam(x), TypeParam(y)}; };
  for (const bool columns : {false, true}) {
    const auto error = [&](Real a, const std::vector<TypeParam>& b, const std::vector<TypeParam>& x) {
      return error_of(TypeParam(a), b, x, columns);
    };
    EXPECT_EQ(error(1, scalars(0, 0), scalars(0, 0)), 0);
    EXPECT_NEAR(error(1, scalars(0, least), scalars(0, 0)), 1, 1e-5);
    EXPECT_EQ(error(1, scalars(0, 0), scalars(8 * step, 0)), 0);
    EXPECT_EQ(error(1, scalars(24 * step, 0), scalars(0, 0)), 0);
    EXPECT_NEAR(error(1, scalars(0, 0), scalars(100 * step, 0)), 0.76, 1e-12);
    EXPECT_NEAR(error(1024, scalars(0, 0), scalars(0, least)), 1, 1e-5);
    const Real small = least * Real(0x1p20);
    EXPECT_NEAR(error(1, scalars(small, 0), scalars(2 * small, 0)), 1.0 / 3, 1e-5);
    EXPECT_NEAR(error(1, scalars(0, small), scalars(-2 * small, small)), 0, 1e-9);
  }
}

// The modulus of such a number is beyond the range.
TEST(ResidualColumns, LargestComplexNumbersAreNotFreeOfError) {
  using Scalar = std::complex<double>;
  const double most = std::numeric_limits<double>::max();
  for (const bool columns : {false, true})
    EXPECT_NEAR(
        error_of(Scalar(most, most) / 2.0, {Scalar(0.5, -1), Scalar(0)}, {Scalar(0), Scalar(0)}, columns), 1,
        1e-12);
}

}  // namespace
}  // namespace mfs::test
