// Refinement with an inverse and a residual that are made up, where real ones would fail only by chance.
#include <cmath>
#include <vector>

#include <gmock/gmock.h>

#include "accuracy/refinement.hpp"
#include "kernels/stages/doubled_rows.hpp"
#include "test/stages/in_engine.hpp"

namespace {

using mfs::Vertex;

using Support = std::vector<char>;  // empty: any unknown may differ from zero
const auto any = [](const double*) { return Support(); };

// A = 1, of size 2. The inverse lets 1e-17 of the first entry leak into the second, as rounding does, and
// gets that wrong by 1e-10.
std::vector<double> refined(const std::vector<double>& b, mfs::SolveOutcome& outcome) {
  const Vertex n = 2;
  std::vector<double> right_side = b, x(n), best(n), r(n), d(n), size(n), krylov_space;
  const auto inverse = [](const double* from, double* to, Vertex) {
    const double second = (1 + 1e-10) * from[1] + 1e-17 * from[0];
    to[0] = from[0];
    to[1] = second;
  };
  const auto residual = [&](const double* rhs, const double* at, double* left, double* sizes) {
    double worst = 0;
    for (Vertex i = 0; i < n; ++i) {
      left[i] = (rhs ? rhs[i] : 0) - at[i];
      const double row = std::abs(at[i]) + (rhs ? std::abs(rhs[i]) : 0);
      if (sizes) sizes[i] = row > 0 ? row : 1;
      if (left[i] != 0) worst = std::max(worst, std::abs(left[i]) / row);
    }
    return worst;
  };
  mfs::test::in_engine(1, [&] {
    const Kokkos::Serial exec;
    const auto doubled = [&](const double* rhs, const double* at, const double* low, double* left) {
      for (Vertex i = 0; i < n; ++i) left[i] = (rhs[i] - at[i]) - low[i];
    };
    const mfs::RefinementVectors<double> vectors{right_side.data(), x.data(),    best.data(),  r.data(),
                                                 d.data(),          size.data(), &krylov_space};
    mfs::Refinement(mfs::HostVectors(exec, n, 1, vectors, {}, inverse, residual, doubled, any),
                    mfs::SolveControls{})
        .run(outcome);
  });
  return x;
}

TEST(Refinement, FindsEntriesThatAreZero) {
  mfs::SolveOutcome outcome;
  EXPECT_THAT(refined({3, 0}, outcome), testing::ElementsAre(3, 0));
  EXPECT_EQ(outcome.backward_error, 0);
  EXPECT_EQ(outcome.refinement_steps, 1);
  EXPECT_EQ(outcome.krylov_steps, 0);
}

TEST(Refinement, KeepsSmallEntriesThatAreNotZero) {
  mfs::SolveOutcome outcome;
  EXPECT_THAT(refined({3, 1e-25}, outcome), testing::ElementsAre(3, testing::DoubleNear(1e-25, 1e-37)));
  EXPECT_LE(outcome.backward_error, 1e-12);
}

// Three large unknowns of a block that is nearly singular, known to eps * 1e8 only, and a tiny one that gets
// 1e-7 of what a correction does to the first of them. Zeros that are no solution are taken back.
TEST(Refinement, MakesTinyUnknownsRightInTwiceThePrecision) {
  const Vertex n = 4;
  const mfs::Offset offsets[] = {0, 3, 6, 9, 11};
  const Vertex columns[] = {0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 3};
  const double g[3][3] = {{0.1, 0.7, 0.3}, {0.2, 0.5, 0.9}, {0.3, 1.2, 1.2 + 1e-8}}, chaff = 1e-17;
  const double values[] = {g[0][0], g[0][1], g[0][2], g[1][0], g[1][1], g[1][2],
                           g[2][0], g[2][1], g[2][2], chaff,   1};
  const mfs::RowAccess<double> a{offsets, columns, nullptr, values};
  std::vector<double> b{2.1, 2.3, 0.7, 4e-17}, x(n), best(n), r(n), d(n), size(n), krylov_space;
  const auto minor = [&](int i, int j) {
    const int p = (i + 1) % 3, q = (i + 2) % 3, k = (j + 1) % 3, l = (j + 2) % 3;
    return static_cast<long double>(g[p][k]) * g[q][l] - static_cast<long double>(g[p][l]) * g[q][k];
  };
  const auto inverse = [&](const double* from, double* to, Vertex) {
    const std::vector<double> given(from, from + n);
    long double det = 0;
    for (int j = 0; j < 3; ++j) det += g[0][j] * minor(0, j);
    for (int j = 0; j < 3; ++j) {
      long double sum = 0;
      for (int i = 0; i < 3; ++i) sum += minor(i, j) * given[i];
      to[j] = static_cast<double>(sum / det);
    }
    to[3] = given[3] - chaff * to[0] + 1e-7 * to[0];
  };
  for (const Support& support : {Support(), Support(n, false)}) {
    mfs::SolveOutcome outcome;
    mfs::test::in_engine(1, [&] {
      const Kokkos::Serial exec;
      const auto residual = [&](const double* rhs, const double* at, double* left, double* sizes) {
        double worst = 0;
        mfs::residual(exec, n, a, rhs, at, left, &worst, sizes);
        return worst;
      };
      const auto doubled = [&](const double* rhs, const double* at, const double* low, double* left) {
        mfs::doubled_residual(exec, n, a, rhs, at, low, left);
      };
      const auto known = [&](const double*) { return support; };
      const mfs::RefinementVectors<double> vectors{b.data(), x.data(),    best.data(),  r.data(),
                                                   d.data(), size.data(), &krylov_space};
      mfs::Refinement(mfs::HostVectors(exec, n, 1, vectors, {}, inverse, residual, doubled, known),
                      mfs::SolveControls{})
          .run(outcome);
    });
    EXPECT_LE(outcome.backward_error, 1e-12);
    EXPECT_EQ(outcome.krylov_steps, 0);
    EXPECT_NEAR(x[3], b[3] - chaff * x[0], 1e-12 * std::abs(chaff * x[0]));
  }
}

// Sums that plain doubles lose altogether, real and complex.
TEST(Refinement, ResidualsInTwiceThePrecision) {
  const mfs::Offset offsets[] = {0, 3};
  const Vertex columns[] = {0, 1, 2};
  const double values[] = {1e20, 3, -1e20}, x[] = {1, 1 + 0x1p-52, 1}, low[] = {0, 0x1p-60, 0}, b[] = {3};
  double r = 0;
  const std::complex<double> complex_values[] = {{0, 1e20}, {3, 0}, {0, -1e20}},
                             complex_x[] = {{1, 1}, {0, 1 + 0x1p-52}, {1, 1}}, complex_low[] = {0, 0, 0},
                             complex_b[] = {{0, 3}};
  std::complex<double> complex_r;
  mfs::test::in_engine(1, [&] {
    mfs::doubled_residual(Kokkos::Serial(), 1, mfs::RowAccess<double>{offsets, columns, nullptr, values}, b,
                          x, low, &r);
    mfs::doubled_residual(Kokkos::Serial(), 1,
                          mfs::RowAccess<std::complex<double>>{offsets, columns, nullptr, complex_values},
                          complex_b, complex_x, complex_low, &complex_r);
  });
  EXPECT_EQ(r, -3 * (0x1p-52 + 0x1p-60));
  EXPECT_EQ(complex_r, std::complex<double>(0, -3 * 0x1p-52));
}

}  // namespace
