// Matrices with more tiny pivots than the exact correction takes: solved where they are regular, whichever of
// them, singular said only of those that are.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include <mfs/mfs.hpp>

#include "test/adversarial/engineering_matrices.hpp"
#include "test/reference/random.hpp"

namespace mfs::test {
namespace {

constexpr double kTolerance = 1e-12;

/// Grounded pairs of unknowns whose springs are 1 / weak times as stiff as the ground: pivots of 1 and about
/// 2 weak by turns. Without ground each pair is singular.
SparseMatrix weakly_held_pairs(std::int64_t pairs, double weak) {
  std::vector<Entry> entries;
  for (std::int64_t k = 0; k < pairs; ++k) {
    const std::int64_t i = 2 * k, j = i + 1;
    entries.insert(entries.end(), {{i, i, 1 + weak}, {i, j, -1.0}, {j, i, -1.0}, {j, j, 1 + weak}});
    if (k > 0) entries.insert(entries.end(), {{i, i - 2, weak / 8}, {i - 2, i, weak / 8}});
  }
  return from_entries_summed(2 * pairs, entries);
}

std::vector<Backend> host_backends() {
  return {Backend::serial, Backend::openmp, Backend::kokkos};
}
Options on(Backend backend) {
  Options options;
  options.backend = backend;
  return options;
}

TEST(TinyPivots, AreDividedByWhereTheyAreTooManyToCorrect) {
  for (const double weak : {0x1p-30, 0x1p-40, 0x1p-47}) {
    const SparseMatrix a = weakly_held_pairs(700, weak);
    const std::vector<double> b = Random(5).vector(a.n);
    for (const Backend backend : host_backends()) {
      SCOPED_TRACE(std::string(backend_name(backend)) + ", " + std::to_string(weak));
      Solver solver(on(backend));
      std::vector<double> x(b.size());
      for (const bool transposed : {false, true}) {
        solver.factor(a.view());
        EXPECT_EQ(solver.report().perturbed_pivots, 0);
        transposed ? solver.solve_transpose(b.data(), x.data()) : solver.solve(b.data(), x.data());
        EXPECT_LE(backward_error(a, b, x), kTolerance);  // A is symmetric
      }
      solver.refactor(a.values.data());
      solver.solve(b.data(), x.data());
      EXPECT_LE(backward_error(a, b, x), kTolerance);
      EXPECT_EQ(solver.report().dependent_rows, 0);
    }
  }
}

// The first solve proves that A is regular.
TEST(TinyPivots, ThatWereCorrectedAreDividedByInLaterFactorizations) {
  const SparseMatrix a = weakly_held_pairs(5, 0x1p-35);
  const std::vector<double> b = Random(6).vector(a.n);
  for (const Backend backend : host_backends()) {
    SCOPED_TRACE(backend_name(backend));
    Solver solver(on(backend));
    std::vector<double> x(b.size());
    const auto expect = [&](std::int64_t corrected) {
      solver.solve(b.data(), x.data());
      EXPECT_LE(backward_error(a, b, x), kTolerance);
      EXPECT_EQ(solver.report().corrected_pivots, corrected);
      EXPECT_EQ(solver.report().perturbed_pivots, corrected);
    };
    for (int analysis = 0; analysis < 2; ++analysis) {
      solver.analyze(a.view());
      solver.factor(a.view());
      for (int k = 0; k < 2; ++k) expect(5);
      for (int k = 0; k < 2; ++k) {
        solver.refactor(a.view());
        expect(0);
      }
    }
  }
}

// The correction of some tens of pivots takes longer than a factorization that divides by them.
TEST(TinyPivots, SomeTensAreDividedByAtOnce) {
  for (const std::int64_t pairs : {32, 33, 100}) {
    const SparseMatrix a = weakly_held_pairs(pairs, 0x1p-35);
    const std::vector<double> b = Random(6).vector(a.n);
    for (const Backend backend : host_backends()) {
      SCOPED_TRACE(std::string(backend_name(backend)) + ", pairs " + std::to_string(pairs));
      Solver solver(on(backend));
      std::vector<double> x(b.size());
      solver.factor(a.view());
      solver.solve(b.data(), x.data());
      EXPECT_LE(backward_error(a, b, x), kTolerance);
      EXPECT_EQ(solver.report().corrected_pivots, pairs <= 32 ? pairs : 0);
    }
  }
}

// Rows and columns scaled at random by up to 10^(+-6): the scales of the factors may differ from pair to
// pair, and a vector that is large in one of them looks like a null vector there.
TEST(TinyPivots, OfGradedPairsAreNotCalledSingular) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    for (const std::int64_t pairs : {3, 20, 700}) {
      SparseMatrix a = weakly_held_pairs(pairs, 0x1p-30);
      Random random(seed);
      const auto grade = [&] {
        std::vector<double> scale = random.vector(a.n);
        for (double& entry : scale) entry = std::pow(10.0, 6 * entry);
        return scale;
      };
      const std::vector<double> left = grade(), right = grade();
      for (std::int64_t i = 0; i < a.n; ++i) {
        for (std::int64_t k = a.offsets[i]; k < a.offsets[i + 1]; ++k)
          a.values[k] *= left[i] * right[a.columns[k]];
      }
      const std::vector<double> b = Random(9).vector(a.n);
      for (const Backend backend : host_backends()) {
        SCOPED_TRACE(std::string(backend_name(backend)) + ", pairs " + std::to_string(pairs) + ", seed " +
                     std::to_string(seed));
        Solver solver(on(backend));
        std::vector<double> x(b.size());
        solver.factor(a.view());
        for (int k = 0; k < 2; ++k) {
          EXPECT_NO_THROW(solver.solve(b.data(), x.data()));
          EXPECT_LE(backward_error(a, b, x), kTolerance);
          solver.refactor(a.values.data());
        }
      }
    }
  }
}

TEST(TinyPivots, OfCurlCurlAreDividedBy) {
  const SparseMatrix a = curl_curl(9, 1e-12);
  const std::vector<double> b = Random(8).vector(a.n);
  for (const Backend backend : host_backends()) {
    SCOPED_TRACE(backend_name(backend));
    Solver solver(on(backend));
    std::vector<double> x(b.size());
    solver.factor(a.view());
    solver.solve(b.data(), x.data());
    EXPECT_LE(backward_error(a, b, x), kTolerance);
    EXPECT_EQ(solver.report().rung, Rung::factors);
  }
}

TEST(TinyPivots, SingularIsProved) {
  const SparseMatrix a = weakly_held_pairs(700, 0.0);
  const std::vector<double> b = Random(6).vector(a.n);
  for (const Backend backend : host_backends()) {
    SCOPED_TRACE(backend_name(backend));
    Solver solver(on(backend));
    std::vector<double> x(b.size());
    solver.factor(a.view());
    try {
      solver.solve(b.data(), x.data());
      ADD_FAILURE() << "not refused";
    } catch (const SingularMatrix& error) {
      EXPECT_EQ(error.kind(), SingularMatrix::Kind::numerical);
      EXPECT_EQ(error.dependent_rows(), 700);
      EXPECT_NE(std::string(error.what()).find("|A z| = "), std::string::npos) << error.what();
    }
    EXPECT_EQ(solver.determinant().phase, 0);
    EXPECT_TRUE(std::isinf(solver.condition_estimate()));
  }
}

// Found singular either way: by the correction (few pivots) and by the probe (many).
TEST(TinyPivots, SingularIsSolvedOnRequest) {
  for (const std::int64_t pairs : {20, 700}) {
    const SparseMatrix a = weakly_held_pairs(pairs, 0.0);
    const std::vector<double> b = multiply(a, Random(7).vector(a.n));
    for (const Backend backend : host_backends()) {
      SCOPED_TRACE(std::string(backend_name(backend)) + ", pairs " + std::to_string(pairs));
      Options options = on(backend);
      options.solve.solve_singular = true;
      Solver solver(options);
      std::vector<double> x(b.size());
      solver.factor(a.view());
      solver.solve(b.data(), x.data());
      EXPECT_LE(backward_error(a, b, x), kTolerance);
      EXPECT_GT(solver.report().dependent_rows, 0);
      EXPECT_LE(solver.report().singularity, 1e-14);
    }
  }
}

TEST(TinyPivots, WhatOverflowsIsSaid) {
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < 20; ++i) entries.push_back({i, i, i == 7 ? 1e-200 : 1.0});
  const SparseMatrix a = from_entries_summed(20, entries);
  std::vector<double> b(20, 1.0), x(20);
  b[7] = 1e200;
  Solver solver;
  solver.factor(a.view());
  try {
    solver.solve(b.data(), x.data());
    ADD_FAILURE() << "not refused";
  } catch (const AccuracyNotReached& error) {
    EXPECT_NE(std::string(error.what()).find("entry 7 of the solution"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace mfs::test
