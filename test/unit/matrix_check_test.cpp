// Check of the input: what is refused, with which place, and what a Pattern is.
#include "ordering/matrix_check.hpp"

#include <gmock/gmock.h>

#include <complex>
#include <limits>
#include <random>
#include <set>
#include <utility>

#include <mfs/error.hpp>

#include "ordering/number_parts.hpp"
#include "test/unit/test_matrices.hpp"

namespace mfs::test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Runs `body`, which must throw InvalidInput, and compares its argument and place.
template <class Body>
void expect_invalid(const Body& body, const std::string& argument, std::int64_t row, std::int64_t column) {
  try {
    body();
    FAIL() << "accepted";
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.argument(), argument) << error.what();
    EXPECT_EQ(error.row(), row) << error.what();
    EXPECT_EQ(error.column(), column) << error.what();
  }
}

template <class Body>
void expect_changed(const Body& body, std::int64_t row) {
  try {
    body();
    FAIL() << "accepted";
  } catch (const PatternChanged& error) {
    EXPECT_EQ(error.row(), row) << error.what();
  }
}

template <class T>
class MatrixCheckWidths : public ::testing::Test {};
template <class O, class C>
struct Widths {
  using Offsets = O;
  using Columns = C;
};
using AllWidths = ::testing::Types<Widths<std::int32_t, std::int32_t>, Widths<std::int64_t, std::int32_t>,
                                   Widths<std::int32_t, std::int64_t>, Widths<std::int64_t, std::int64_t>>;
TYPED_TEST_SUITE(MatrixCheckWidths, AllWidths);

TYPED_TEST(MatrixCheckWidths, SortedRowsAreCopiedWithoutSlots) {
  const Matrix<double, typename TypeParam::Offsets, typename TypeParam::Columns> a{
      {0, 2, 2, 4}, {0, 2, 1, 2}, {1, 2, 3, 4}};
  const Pattern p = check_pattern(a.view(), 1);
  EXPECT_EQ(p.n, 3);
  EXPECT_EQ(p.num_entries, 4);
  EXPECT_THAT(p.offsets, ElementsAre(0, 2, 2, 4));
  EXPECT_THAT(p.columns, ElementsAre(0, 2, 1, 2));
  EXPECT_THAT(p.slot_of_entry, IsEmpty());
  EXPECT_NO_THROW(check_same_pattern(p, a.view(), 1));
}

TYPED_TEST(MatrixCheckWidths, UnsortedRowsAndDuplicatesGetSlots) {
  const Matrix<double, typename TypeParam::Offsets, typename TypeParam::Columns> a{
      {0, 3, 6, 6, 7}, {3, 1, 3, 0, 2, 1, 3}, {1, 2, 4, 8, 16, 32, 64}};
  const Pattern p = check_pattern(a.view(), 1);
  EXPECT_EQ(p.num_entries, 7);
  EXPECT_THAT(p.offsets, ElementsAre(0, 2, 5, 5, 6));
  EXPECT_THAT(p.columns, ElementsAre(1, 3, 0, 1, 2, 3));
  EXPECT_THAT(p.slot_of_entry, ElementsAre(1, 0, 1, 2, 4, 3, 5));
  std::vector<double> slots(6, -1.0);
  sum_into_slots(p, a.view(), slots.data(), 1);
  EXPECT_THAT(slots, ElementsAre(2, 5, 8, 32, 16, 64));
  EXPECT_NO_THROW(check_same_pattern(p, a.view(), 1));
}

TYPED_TEST(MatrixCheckWidths, ChangedPatternNamesTheFirstRow) {
  using M = Matrix<double, typename TypeParam::Offsets, typename TypeParam::Columns>;
  const M a{{0, 2, 3, 5}, {0, 2, 1, 0, 2}, {1, 1, 1, 1, 1}};
  const Pattern p = check_pattern(a.view(), 1);
  expect_changed(
      [&] {
        check_same_pattern(p, M{{0, 2, 3, 5}, {0, 2, 1, 1, 2}, {1, 1, 1, 1, 1}}.view(), 1);
      },
      2);
  expect_changed(
      [&] {
        check_same_pattern(p, M{{0, 2, 4, 5}, {0, 2, 0, 1, 2}, {1, 1, 1, 1, 1}}.view(), 1);
      },
      1);
  expect_changed(
      [&] {
        check_same_pattern(p, M{{0, 2, 3, 6}, {0, 2, 1, 0, 1, 2}, {1, 1, 1, 1, 1, 1}}.view(), 1);
      },
      2);
  expect_changed([&] { check_same_pattern(p, M{{0, 2, 3}, {0, 1, 1}, {1, 1, 1}}.view(), 1); }, 2);
}

TYPED_TEST(MatrixCheckWidths, ChangedUnsortedPatternNamesTheFirstRow) {
  using M = Matrix<double, typename TypeParam::Offsets, typename TypeParam::Columns>;
  const M a{{0, 3, 3, 5}, {2, 0, 2, 2, 1}, {1, 1, 1, 1, 1}};
  const Pattern p = check_pattern(a.view(), 1);
  EXPECT_NO_THROW(check_same_pattern(p, a.view(), 1));
  expect_changed([&] { check_same_pattern(p, M{{0, 3, 3, 5}, {2, 0, 2, 2, 0}, a.values}.view(), 1); }, 2);
  expect_changed([&] { check_same_pattern(p, M{{0, 3, 4, 5}, {2, 0, 2, 2, 1}, a.values}.view(), 1); }, 1);
  expect_changed([&] { check_same_pattern(p, M{{0, 2, 3, 5}, {2, 0, 2, 2, 1}, a.values}.view(), 1); }, 0);
  expect_changed([&] { check_same_pattern(p, M{{0, 3, 3, 4}, {2, 0, 2, 2}, {1, 1, 1, 1}}.view(), 1); }, 2);
  expect_changed([&] { check_same_pattern(p, M{{0, 3, 2, 5}, {2, 0, 2, 2, 1}, a.values}.view(), 1); }, 1);
}

TEST(MatrixCheck, ShapeIsRefused) {
  const Matrix<double> a{{0, 1}, {0}, {1}};
  CsrView<double> view = a.view();
  view.rows = -1;
  expect_invalid([&] { check_pattern(view, 1); }, "rows", -1, -1);
  view = a.view();
  view.columns = -1;
  expect_invalid([&] { check_pattern(view, 1); }, "columns", -1, -1);
  view.columns = 2;
  expect_invalid([&] { check_pattern(view, 1); }, "columns", -1, -1);
  view.rows = view.columns = 0;
  expect_invalid([&] { check_pattern(view, 1); }, "rows", -1, -1);
  view.rows = view.columns = std::int64_t(1) << 31;
  expect_invalid([&] { check_pattern(view, 1); }, "rows", -1, -1);
}

TEST(MatrixCheck, NullPointersAreRefused) {
  const Matrix<double> a{{0, 1}, {0}, {1}};
  CsrView<double> view = a.view();
  view.row_offsets = IndexSpan();
  expect_invalid([&] { check_pattern(view, 1); }, "row_offsets", -1, -1);
  view = a.view();
  view.column_indices = IndexSpan();
  expect_invalid([&] { check_pattern(view, 1); }, "column_indices", -1, -1);
  view = a.view();
  view.values = nullptr;
  EXPECT_NO_THROW(check_pattern(view, 1));
  expect_invalid([&] { check_values(view, 1); }, "values", -1, -1);
  const Pattern p = check_pattern(a.view(), 1);
  view.row_offsets = IndexSpan();
  expect_invalid([&] { check_same_pattern(p, view, 1); }, "row_offsets", -1, -1);
  view = a.view();
  view.column_indices = IndexSpan();
  expect_invalid([&] { check_same_pattern(p, view, 1); }, "column_indices", -1, -1);
}

TEST(MatrixCheck, EmptyRowsNeedNoColumns) {
  const std::vector<std::int32_t> offsets{0, 0, 0};
  const CsrView<double> view{2, 2, offsets.data(), IndexSpan(), nullptr};
  const Pattern p = check_pattern(view, 1);
  EXPECT_EQ(p.nnz(), 0);
  EXPECT_NO_THROW(check_same_pattern(p, view, 1));
  EXPECT_NO_THROW(check_values(view, 1));
}

TEST(MatrixCheck, OffsetsAreRefused) {
  expect_invalid(
      [] {
        check_pattern(Matrix<double>{{1, 2}, {0, 0}, {1, 1}}.view(), 1);
      },
      "row_offsets", 0, -1);
  expect_invalid(
      [] {
        check_pattern(Matrix<double>{{0, 2, 1}, {0, 1}, {1, 1}}.view(), 1);
      },
      "row_offsets", 1, -1);
  const std::int32_t overflowed = std::numeric_limits<std::int32_t>::min();
  expect_invalid(
      [&] {
        check_pattern(Matrix<double>{{0, 1, overflowed}, {0}, {1}}.view(), 1);
      },
      "row_offsets", 1, -1);
}

TEST(MatrixCheck, ColumnsOutsideAreRefusedAtTheFirstPlace) {
  expect_invalid(
      [] {
        check_pattern(Matrix<double>{{0, 1, 3}, {0, 1, 2}, {1, 1, 1}}.view(), 1);
      },
      "column_indices", 1, 2);
  expect_invalid(
      [] {
        check_pattern(Matrix<double>{{0, 1, 3}, {-7, 2, 1}, {1, 1, 1}}.view(), 1);
      },
      "column_indices", 0, -7);
  const std::int64_t huge = std::int64_t(1) << 40;
  using Wide = Matrix<double, std::int64_t, std::int64_t>;
  expect_invalid(
      [&] {
        check_pattern(Wide{{0, 1, 2}, {0, huge}, {1, 1}}.view(), 1);
      },
      "column_indices", 1, huge);
}

TEST(MatrixCheck, FirstBadPlaceIsTheSameForAnyNumberOfThreads) {
  Matrix<double> a;
  const int n = 5000;
  for (int i = 0; i <= n; ++i) a.offsets.push_back(i);
  a.columns.assign(n, 0);
  a.values.assign(n, 1.0);
  a.columns[4321] = a.columns[1234] = n;
  for (const int threads : {1, 2, 4}) {
    expect_invalid([&] { check_pattern(a.view(), threads); }, "column_indices", 1234, n);
  }
  a.columns.assign(n, 0);
  const Pattern p = check_pattern(a.view(), 1);
  a.columns[4321] = a.columns[1234] = 1;
  for (const int threads : {1, 2, 4}) {
    expect_changed([&] { check_same_pattern(p, a.view(), threads); }, 1234);
  }
  a.values[4999] = a.values[4097] = std::numeric_limits<double>::quiet_NaN();
  for (const int threads : {1, 2, 4})
    expect_invalid([&] { check_values(a.view(), threads); }, "values", 4097, 0);
}

template <class Scalar>
class MatrixCheckScalars : public ::testing::Test {};
using AllScalars = ::testing::Types<float, double, std::complex<float>, std::complex<double>>;
TYPED_TEST_SUITE(MatrixCheckScalars, AllScalars);

TYPED_TEST(MatrixCheckScalars, ValuesThatAreNotFiniteAreRefused) {
  using Real = decltype(std::abs(TypeParam()));
  Matrix<TypeParam> a{{0, 0, 2, 3}, {2, 0, 1}, {TypeParam(1), TypeParam(0), TypeParam(-3)}};
  EXPECT_NO_THROW(check_values(a.view(), 1));
  a.values[1] = TypeParam(std::numeric_limits<Real>::max());
  EXPECT_NO_THROW(check_values(a.view(), 1));
  a.values[1] = TypeParam(std::numeric_limits<Real>::infinity());
  expect_invalid([&] { check_values(a.view(), 1); }, "values", 1, 0);
  a.values[1] = TypeParam(std::numeric_limits<Real>::quiet_NaN());
  expect_invalid([&] { check_values(a.view(), 1); }, "values", 1, 0);
  a.values[1] = TypeParam(0);
  a.values[2] = TypeParam(-std::numeric_limits<Real>::infinity());
  expect_invalid([&] { check_values(a.view(), 1); }, "values", 2, 1);
}

TEST(MatrixCheck, ImaginaryPartsAreLookedAt) {
  Matrix<std::complex<double>> a{{0, 1}, {0}, {{1.0, std::numeric_limits<double>::infinity()}}};
  expect_invalid([&] { check_values(a.view(), 1); }, "values", 0, 0);
}

TEST(MatrixCheck, ASumThatOverflowsIsRefused) {
  const double big = std::numeric_limits<double>::max();
  const Matrix<double> a{{0, 1, 3}, {0, 1, 1}, {1, big, big}};
  const Pattern p = check_pattern(a.view(), 1);
  std::vector<double> slots(p.nnz());
  expect_invalid([&] { sum_into_slots(p, a.view(), slots.data(), 1); }, "values", 1, -1);
}

TYPED_TEST(MatrixCheckScalars, FingerprintsAreOfEachValueAndItsPlace) {
  Matrix<TypeParam> a{{0, 2, 3, 6}, {0, 2, 1, 0, 1, 2}, {1, 2, 3, 4, 5, 6}};
  const auto fingerprint = [&](int threads) {
    std::uint64_t found = 0;
    check_values(a.view(), threads, &found);
    return found;
  };
  const std::uint64_t first = fingerprint(1);
  EXPECT_EQ(fingerprint(3), first);
  std::set<std::uint64_t> seen{first};
  const auto expect_new = [&] { EXPECT_TRUE(seen.insert(fingerprint(2)).second); };
  std::swap(a.values[1], a.values[4]);
  expect_new();
  std::swap(a.values[1], a.values[4]);
  for (TypeParam& value : a.values) {
    const TypeParam kept = value;
    value *= 1 + std::numeric_limits<typename NumberParts<TypeParam>::type>::epsilon();
    expect_new();
    value = -kept;
    expect_new();
    value = kept;
  }
  EXPECT_EQ(fingerprint(1), first);
}

TEST(MatrixCheck, RandomRowsAgainstSets) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 generator(seed);
    const int n = 1 + static_cast<int>(generator() % 12);
    Matrix<double> a;
    std::vector<std::map<int, double>> rows(n);
    a.offsets.push_back(0);
    for (int i = 0; i < n; ++i) {
      for (unsigned k = generator() % 6; k > 0; --k) {
        const int j = static_cast<int>(generator() % n);
        const double value = static_cast<double>(generator() % 16);
        a.columns.push_back(j);
        a.values.push_back(value);
        rows[i][j] += value;
      }
      a.offsets.push_back(static_cast<int>(a.columns.size()));
    }
    const Pattern p = check_pattern(a.view(), 1 + seed % 3);
    std::vector<double> slots(p.nnz());
    sum_into_slots(p, a.view(), slots.data(), 1 + seed % 3);
    for (int i = 0; i < n; ++i) {
      ASSERT_EQ(p.offsets[i + 1] - p.offsets[i], static_cast<Offset>(rows[i].size()));
      Offset k = p.offsets[i];
      for (const auto& [column, value] : rows[i]) {
        ASSERT_EQ(p.columns[k], column);
        ASSERT_EQ(slots[k++], value);
      }
    }
    ASSERT_NO_THROW(check_same_pattern(p, a.view(), 1));
  }
}

}  // namespace
}  // namespace mfs::test
