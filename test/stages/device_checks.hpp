// What must hold for every factorization on the device: factors, shifts and exchanges against the reference.
#pragma once

#include <string>
#include <vector>

#include "test/stages/device_bench.hpp"
#include "test/stages/followed_reference.hpp"

namespace mfs::test {

/// Multiplies rows and columns by random phases: real problems become complex ones with the same ranks.
template <class Scalar>
StageProblem<Scalar> turned(const StageProblem<double>& problem) {
  StageProblem<Scalar> other = in_numbers_of<Scalar>(problem);
  Random random(5);
  const auto phases = [&] {
    std::vector<std::complex<double>> made(problem.pattern->n);
    for (auto& phase : made) phase = std::polar(1.0, 6.283185307179586 * random.unit());
    return made;
  };
  const auto row = phases(), column = phases();
  for (Vertex i = 0; i < problem.pattern->n; ++i) {
    for (Offset k = problem.pattern->offsets[i]; k < problem.pattern->offsets[i + 1]; ++k) {
      if constexpr (std::is_same_v<Scalar, RealOf<Scalar>>) {
        other.values[k] = static_cast<Scalar>(problem.values[k]);
      } else {
        other.values[k] = Scalar(problem.values[k] * row[i] * column[problem.pattern->columns[k]]);
      }
    }
  }
  return other;
}

/// Of the largest entry of a block: pivots are large, so nothing grows but by the inverted blocks.
template <class Scalar>
constexpr double kDeviceTolerance = 20000 *
                                    static_cast<double>(std::numeric_limits<RealOf<Scalar>>::epsilon());
/// cuda::kDiagonalThreshold, which only the device's compiler sees.
constexpr double kDiagonalThreshold = 0.1;
/// Small fronts of up to so many rows have one warp, which searches every pivot.
constexpr Vertex kOneWarpRows = 32;

template <class Scalar>
bool is_small(const SymbolicPlan& plan, const DeviceBench<Scalar>& bench, Vertex f) {
  return plan.pivots(f) + plan.border_rows(f) <= bench.small_rows();
}
/// Where pivot k of front f is searched: in all rows, or in those of its tile, where the diagonal comes
/// first; in roots that the library has it must do, beside all rows.
template <class Scalar>
SearchedRows searched(const SymbolicPlan& plan, const DeviceBench<Scalar>& bench,
                      const std::vector<int>& strict, Vertex f, Vertex k) {
  const Vertex tile = bench.tile();
  const Vertex p = plan.pivots(f);
  const double searched = bench.preference(), swept = std::max(searched, 1 / kDiagonalThreshold);
  if (bench.library_roots() && plan.parent[f] < 0 && !is_small(plan, bench, f))
    return {p, 1 / kBorderThreshold};
  if (p + plan.border_rows(f) <= kOneWarpRows) return {p, searched};
  if (is_small(plan, bench, f)) return {p, swept};
  if (strict[f]) return {p, searched};
  return {std::min(p, k / tile * tile + tile), swept};
}

/// How much larger errors of a solve, and of fronts whose tiles are small, may be because multipliers of rows
/// that were not searched are, and U with them: the tolerance is for multipliers of at most 1 /
/// kBorderThreshold.
template <class Scalar>
double growth_of(const std::vector<ReferenceFront<Scalar>>& fronts) {
  double most = 0;
  for (const ReferenceFront<Scalar>& front : fronts)
    for (Vertex k = 0; k < front.pivots; ++k)
      for (Vertex i = k + 1; i < front.pivots; ++i)
        most = std::max(most, static_cast<double>(std::abs(front.at(i, k))));
  const double growth = std::max(1.0, kBorderThreshold * most);
  return growth * growth;
}

/// Factors, shifts and exchanges against the reference on the same pivots; returns that.
template <class Scalar>
std::vector<ReferenceFront<Scalar>> followed(const StageProblem<Scalar>& problem,
                                             const DeviceBench<Scalar>& bench, double tolerance) {
  const SymbolicPlan& plan = *problem.plan;
  const std::vector<int> strict = bench.strict();
  return follow<Scalar>(problem, bench.factored(), rule_of(problem, tolerance),
                        [&](Vertex f, Vertex k) { return searched(plan, bench, strict, f, k); });
}

template <class Scalar>
void expect_reference(const StageProblem<Scalar>& problem, const DeviceBench<Scalar>& bench,
                      const std::vector<ReferenceFront<Scalar>>& reference,
                      double tolerance = kDeviceTolerance<Scalar>) {
  ASSERT_EQ(reference.size(), static_cast<std::size_t>(problem.plan->num_fronts));
  const FactoredFronts<Scalar> result = bench.factored();
  for (Vertex f = 0; f < problem.plan->num_fronts; ++f) {
    SCOPED_TRACE("front " + std::to_string(f) + " of " + std::to_string(problem.plan->pivots(f)) +
                 " pivots, border " + std::to_string(problem.plan->border_rows(f)));
    const FrontBlocks<Scalar> expected = blocks_of(reference[f]);
    EXPECT_LT(difference(result.fronts[f].lower, expected.lower), tolerance) << "P and L";
    EXPECT_LT(difference(result.fronts[f].upper, expected.upper), tolerance) << "U";
  }
  // Of the contribution blocks those of the last two depths are left.
  for (Vertex f = 0; f < problem.plan->num_fronts; ++f) {
    const Vertex parent = problem.plan->parent[f];
    if (parent < 0 || problem.plan->parent[parent] >= 0) continue;
    EXPECT_LT(difference(result.fronts[f].contribution, blocks_of(reference[f]).contribution), tolerance)
        << "C of front " << f;
  }
}

/// Fronts whose pivots are all large.
template <class Scalar>
void check_regular(const StageProblem<double>& of_doubles) {
  const StageProblem<Scalar> problem = in_numbers_of<Scalar>(of_doubles);
  DeviceBench<Scalar> bench(problem);
  const FactorStatus status = bench.factor(default_tolerance<Scalar>());
  // Pivots searched in tiles may let something below them grow: then a front becomes strict, once.
  EXPECT_LE(bench.passes(), 2);
  EXPECT_EQ(status.perturbed, 0u);
  EXPECT_EQ(status.nonfinite, 0u);
  const auto reference = followed(problem, bench, default_tolerance<Scalar>());
  expect_reference(problem, bench, reference, kDeviceTolerance<Scalar> * growth_of(reference));
}

/// Fronts of which some pivots are too small.
template <class Scalar>
FactorStatus check_weak(const StageProblem<Scalar>& problem, double tolerance) {
  DeviceBench<Scalar> bench(problem);
  const FactorStatus status = bench.factor(tolerance);
  followed(problem, bench, tolerance);
  expect_exact_factors(problem, bench.factored(), Measure::row);
  return status;
}

template <class Scalar>
void expect_same_bits(const FactoredFronts<Scalar>& actual, const FactoredFronts<Scalar>& expected) {
  EXPECT_EQ(actual.row_at, expected.row_at);
  EXPECT_EQ(actual.shift, expected.shift);
  for (std::size_t f = 0; f < expected.fronts.size(); ++f) {
    EXPECT_TRUE(actual.fronts[f].lower == expected.fronts[f].lower) << "P and L of front " << f;
    EXPECT_TRUE(actual.fronts[f].upper == expected.fronts[f].upper) << "U of front " << f;
  }
}

}  // namespace mfs::test
