// Backend kokkos' code for devices on matrices with so many tiny pivots that they are divided by: U is
// substituted with, and its factors do what those of the host do. Multiplied by inverses of U's diagonal
// blocks, they miss the tolerance for some.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <string>
#include <vector>

#include "ordering/transpose.hpp"
#include "test/accuracy/device_code.hpp"
#include "test/adversarial/engineering_matrices.hpp"
#include "test/reference/random.hpp"

namespace mfs::test {
namespace {

constexpr double kTolerance = 1e-12;
const double kTiny = std::sqrt(std::numeric_limits<double>::epsilon());
PivotPolicy dividing() {
  return {kTiny, TinyPivots::data, kTiny};
}

void expect_solves(const std::string& name, const SparseMatrix& a, int most_passes, int most_steps) {
  in_engine(1, [&] {
    DeviceCode code(a);
    EXPECT_LE(code.factor(dividing()), most_passes + 0.5);
    for (Vertex levels = 3; code.perturbed() > 0 && levels <= 48; levels *= 2) {  // as a solver does
      code.delay_failed_pivots(a, levels);
      code.factor(dividing());
    }
    const TransposedPattern pattern = transpose(code.pattern(), 1);
    for (const Vertex columns : {1, 3}) {
      for (const bool transposed : {false, true}) {
        SCOPED_TRACE(name + ", columns " + std::to_string(columns) + (transposed ? " transposed" : ""));
        const std::vector<double> b = Random(7).vector(a.n * columns);
        Factorization<double>& factors = code.factorization();
        std::copy(b.begin(), b.end(), factors.rhs(columns));
        SolveControls controls;
        controls.tolerance = kTolerance;
        const SolveOutcome outcome = factors.solve(columns, transposed ? &pattern : nullptr, controls);
        EXPECT_EQ(outcome.dependent_rows, 0);
        EXPECT_LE(outcome.backward_error, kTolerance);
        EXPECT_LE(outcome.refinement_steps, most_steps);
        EXPECT_EQ(outcome.krylov_steps, 0);
      }
    }
  });
}

TEST(Substitution, SolvesCurlCurlByTheFactorsAlone) {
  for (const double mass : {1e-10, 1e-12, 1e-14}) {
    expect_solves("mass " + std::to_string(mass), curl_curl(12, mass), 1,
                  0);  // no front need be strict: whole rows are tiny
  }
}

TEST(Substitution, SolvesWhatEngineersMake) {
  for (std::uint64_t seed = 0; seed < 440; ++seed) {
    const HardMatrix hard = engineering_matrix(seed);
    if (hard.singular || !hard.solution_sizes.empty() || hard.name.rfind(kGrowing, 0) == 0) continue;
    expect_solves(hard.name, hard.matrix, 2, 1);
  }
}

// Factors that perturb too many pivots to be of use are not made again for strict fronts, and those that
// divide instead begin with none.
TEST(Substitution, ComesAfterOneFactorizationThatPerturbs) {
  const SparseMatrix a = curl_curl(12, 1e-12);
  in_engine(1, [&] {
    DeviceCode code(a);
    PivotPolicy perturbing = kTiny;
    EXPECT_GT(code.factor(perturbing), 1.5);
    EXPECT_LE(code.factor(dividing()), 1.5);
    perturbing.most_perturbed = 300;
    EXPECT_LE(code.factor(perturbing), 1.5);
    EXPECT_LE(code.factor(dividing()), 1.5);
  });
}

// The diagonal holds pivots where U is substituted with, else their inverses.
TEST(Substitution, LeavesPivotsOnTheDiagonal) {
  const SparseMatrix a = curl_curl(5, 1);
  in_engine(1, [&] {
    DeviceCode code(a);
    std::vector<std::complex<double>> of_inverses(static_cast<std::size_t>(a.n)), kept(of_inverses);
    code.factor(kTiny);
    code.factorization().factors().diagonal_pivots(of_inverses.data());
    code.factor(dividing());
    code.factorization().factors().diagonal_pivots(kept.data());
    for (std::size_t i = 0; i < kept.size(); ++i)
      EXPECT_NEAR(std::abs(kept[i] - of_inverses[i]), 0, 1e-10 * std::abs(kept[i]));
  });
}

}  // namespace
}  // namespace mfs::test
