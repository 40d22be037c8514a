// Refinement with an inverse and a residual that are made up, where real ones would fail only by chance.
#include <cmath>
#include <vector>

#include <gmock/gmock.h>

#include "kernels/refinement.hpp"
#include "test/stages/in_engine.hpp"

namespace {

using mfs::Vertex;

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
    mfs::Refinement<Kokkos::Serial, double, decltype(inverse), decltype(residual)> refinement(
        exec, n, 1, mfs::SolveControls{},
        {right_side.data(), x.data(), best.data(), r.data(), d.data(), size.data()}, inverse, residual);
    refinement.run(krylov_space, outcome);
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

}  // namespace
