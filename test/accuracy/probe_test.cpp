// The probe on the host with inverses that are made up: of [1 1; 1 1 + d] beside ones, whose first two
// unknowns have the null vector (1, -1) but for d, wrong along that and along some of the others.
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "accuracy/probe.hpp"
#include "test/stages/in_engine.hpp"

namespace mfs::test {
namespace {

constexpr Vertex n = 40;

/// What is taken for the inverse has 1 / 2 for (1, 1), `of_null` for (1, -1) and `others` for the first
/// unknowns behind them, else 1.
NullDirection probe(double d, double of_null, const std::vector<double>& others) {
  std::vector<Offset> offsets{0, 2};
  std::vector<Vertex> columns{0, 1, 0, 1};
  std::vector<double> values{1, 1, 1, 1 + d};
  for (Vertex i = 2; i < n; ++i) {
    columns.push_back(i);
    values.push_back(1);
  }
  for (Vertex i = 1; i < n; ++i) offsets.push_back(i + 3);
  const std::vector<double> scale(n, 1.0);
  const RowAccess<double> rows{offsets.data(), columns.data(), nullptr, values.data()};
  const auto inverse = [&](double* x) {
    const double sum = (x[0] + x[1]) / 2 / 2, difference = (x[0] - x[1]) / 2 * of_null;
    x[0] = sum + difference;
    x[1] = sum - difference;
    for (std::size_t i = 0; i < others.size(); ++i) x[2 + i] *= others[i];
  };
  NullDirection found;
  in_engine(1, [&] {
    found = null_direction(OneThread(),
                           ScaledRows<double>{rows, scale.data(), scale.data(), [&] { return scale.data(); }},
                           n, inverse);
  });
  return found;
}

TEST(Probe, ProvesARegularMatrixByStepsThatGetShorter) {
  for (const double d : {1e-3, 1e-9}) EXPECT_TRUE(probe(d, 1.8 / d, {0.9}).regular) << d;
}

// The first steps make the residual two, three and nine times as large there, or hardly less.
TEST(Probe, ProvesARegularMatrixWhoseInverseIsWrongAlongAFewVectors) {
  for (const std::vector<double>& wrong :
       {std::vector<double>{-1}, {-1, 4, -8}, {0.05}, {-1, -1, 4, -8, 0.1, 2}}) {
    for (const double d : {1e-3, 1e-9, 1e-13}) {
      EXPECT_TRUE(probe(d, 2 / d, wrong).regular) << d << ' ' << wrong.size();
      EXPECT_TRUE(probe(d, -2 / d, wrong).regular) << d << ' ' << wrong.size();
    }
  }
}

// Also where d is rounding: then a solution exists, but is as long as a null vector.
TEST(Probe, ProvesASingularMatrixAlsoWhereItsInverseIsWrongAlongAFewVectors) {
  for (const double d : {0.0, 0x1p-52, -0x1p-52}) {
    for (const std::vector<double>& wrong : {std::vector<double>{}, {-1}, {-1, 4, -8}}) {
      for (const double of_null : {1e15, -3e15, 1e16}) {
        const NullDirection found = probe(d, of_null, wrong);
        EXPECT_FALSE(found.regular) << d << ' ' << of_null << ' ' << wrong.size();
        EXPECT_TRUE(found.null) << d << ' ' << of_null << ' ' << wrong.size();
        EXPECT_LE(found.smallness, 1e-14);
      }
    }
  }
}

}  // namespace
}  // namespace mfs::test
