// Backend kokkos' code for devices, here with a space of the host, on matrices with so many tiny pivots that
// they are divided by: U is substituted with, and its factors do what those of the host do. Multiplied by
// inverses of U's diagonal blocks, they miss the tolerance for most of these matrices.
#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "accuracy/factorization.hpp"
#include "kernels/portable/portable_factors_def.hpp"
#include "ordering/transpose.hpp"
#include "solver/analysis.hpp"
#include "test/adversarial/engineering_matrices.hpp"
#include "test/reference/random.hpp"
#include "test/stages/in_engine.hpp"

namespace mfs::test {
namespace {

constexpr double kTolerance = 1e-12;
const double kTiny = std::sqrt(std::numeric_limits<double>::epsilon());

using DeviceCode =
    portable::PortableFactors<Kokkos::Serial, double, double, portable::OwnDense<double>, /*kResident=*/true>;

/// Runs work(factorization, transposed pattern) with factors of A that divide by tiny pivots.
template <class Work>
void with_factors(const SparseMatrix& a, const Work& work) {
  in_engine(1, [&] {
    const Analysis analysis =
        analyze_matrix(a.view(), AnalysisOptions(), kAssemblyTurns, 1, [](const char*, double) {});
    auto factors = std::make_unique<DeviceCode>(analysis.plan, analysis.pattern, 1,
                                                DeviceCode::lists_for(*analysis.plan, 1));
    std::copy(a.values.begin(), a.values.end(), factors->matrix_values());
    std::copy(analysis.matched.row_scale.begin(), analysis.matched.row_scale.end(), factors->row_scale());
    std::copy(analysis.matched.column_scale.begin(), analysis.matched.column_scale.end(),
              factors->column_scale());
    const auto factorization = make_factorization<double>(HostSpace::serial, std::move(factors),
                                                          analysis.plan, analysis.pattern);
    factorization->factor({kTiny, TinyPivots::data, kTiny}, {});
    const TransposedPattern transposed = transpose(*analysis.pattern, 1);
    work(*factorization, transposed);
  });
}

void expect_solves(const SparseMatrix& a) {
  with_factors(a, [&](Factorization<double>& factors, const TransposedPattern& pattern) {
    for (const Vertex columns : {1, 3}) {
      for (const bool transposed : {false, true}) {
        SCOPED_TRACE(std::to_string(columns) + (transposed ? " transposed" : ""));
        const std::vector<double> b = Random(7).vector(a.n * columns);
        std::copy(b.begin(), b.end(), factors.rhs(columns));
        SolveControls controls;
        controls.tolerance = kTolerance;
        const SolveOutcome outcome = factors.solve(columns, transposed ? &pattern : nullptr, controls);
        EXPECT_EQ(outcome.dependent_rows, 0);
        EXPECT_LE(outcome.backward_error, kTolerance);
        printf("  n %ld columns %d t %d error %.2e steps %d krylov %d\n", long(a.n), columns, transposed,
               outcome.backward_error, int(outcome.refinement_steps), int(outcome.krylov_steps));
      }
    }
  });
}

TEST(Substitution, SolvesCurlCurl) {
  for (const double mass : {1e-10, 1e-12, 1e-14, 1e-15}) {
    SCOPED_TRACE(mass);
    printf("mass %g\n", mass);
    expect_solves(curl_curl(12, mass));
  }
}

TEST(Substitution, SolvesEngineers) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const HardMatrix hard = engineering_matrix(seed);
    if (hard.singular || !hard.solution_sizes.empty()) continue;
    SCOPED_TRACE(hard.name);
    printf("%s\n", hard.name.c_str());
    expect_solves(hard.matrix);
  }
}

}  // namespace
}  // namespace mfs::test
