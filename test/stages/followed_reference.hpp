// The plain reference on the pivots that another factorization chose: which of the rows that it searched came
// first may depend on rounding, what follows from that may not. Whether the choice was right, and whether it
// replaced just the pivots that are too small, is checked on the way.
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "test/stages/factored_fronts.hpp"

namespace mfs::test {

/// The default pivot tolerance.
template <class Scalar>
double default_tolerance() {
  return std::sqrt(static_cast<double>(std::numeric_limits<RealOf<Scalar>>::epsilon()));
}

/// How far from its bounds the rule must have decided as it says.
constexpr double kRuleSlack = 0.5;
/// Pivots are compared by their leading bits only.
constexpr double kAsLarge = 1.001;
/// What rows that were not searched may have as multipliers: kMostGrowth of kernels/cuda/factor/block_lu.hpp,
/// beyond which the device searches all rows of the front.
constexpr double kMostMultiplier = 1000 * kAsLarge;

/// The rows in which a pivot was searched, and how much larger than it entries below it may be there.
struct SearchedRows {
  Vertex end;
  double most = 1;
};

/// Whether `shift` was to be added to pivot k of the front, all columns before being eliminated.
template <class Scalar>
void expect_rule(const ReferenceFront<Scalar>& front, Vertex k, const Scalar& shift,
                 const ReferenceRule& rule) {
  double border = 0;
  for (Vertex i = front.pivots; i < front.rows(); ++i)
    border = std::max(border, static_cast<double>(std::abs(front.at(i, k))));
  const double size = std::abs(front.at(k, k));
  const auto replaced = [&](double factor) {
    return size * factor < rule.bound &&
           (size * factor <= rule.tiny || size * factor < rule.border_threshold * border);
  };
  if (replaced(1 + kRuleSlack)) {
    EXPECT_NE(shift, Scalar(0)) << "pivot " << k << " of size " << size << ", border " << border;
  }
  if (!replaced(1 - kRuleSlack)) {
    EXPECT_EQ(shift, Scalar(0)) << "pivot " << k << " of size " << size << ", border " << border;
  }
  if (shift == Scalar(0)) return;
  const double made = std::abs(front.at(k, k) + shift), empty = rule.empty_border * rule.tiny;
  if (size <= rule.tiny && border * (1 + kRuleSlack) <= empty) {
    EXPECT_NEAR(made / rule.largest, 1, 1e-2);
  }
  if (border * (1 - kRuleSlack) > empty) {
    EXPECT_NEAR(made / rule.bound, 1, 1e-2);
  }
}

/// Stage "variable factor" in the given order; pivot k was searched in searched(k).
template <class Scalar>
void follow_pivots(ReferenceFront<Scalar>& front, const std::vector<Vertex>& row_at,
                   const std::vector<Scalar>& shift, const ReferenceRule& rule,
                   const std::function<SearchedRows(Vertex)>& searched) {
  const Vertex p = front.pivots, rows = front.rows();
  const ReferenceFront<Scalar> before = front;
  for (Vertex j = 0; j < rows; ++j) {
    for (Vertex i = 0; i < p; ++i) front.at(i, j) = before.at(row_at[i], j);
  }
  front.row_at = row_at;
  front.shift = shift;
  for (Vertex k = 0; k < p; ++k) {
    expect_rule(front, k, shift[k], rule);
    const double rounded_zero = shift[k] != Scalar(0) ? (1 + kRuleSlack) * rule.tiny : 0;
    const double size = std::abs(front.at(k, k));
    const SearchedRows where = searched(k);
    for (Vertex i = k + 1; i < p; ++i) {
      const double most = i < where.end ? where.most * kAsLarge : kMostMultiplier;
      EXPECT_LE(std::abs(front.at(i, k)), most * size + rounded_zero) << "row " << i << " below pivot " << k;
    }
    front.at(k, k) += shift[k];
    for (Vertex i = k + 1; i < rows; ++i) front.at(i, k) /= front.at(k, k);
    for (Vertex j = k + 1; j < rows; ++j) {
      for (Vertex i = k + 1; i < (j < p ? rows : p); ++i) front.at(i, j) -= front.at(i, k) * front.at(k, j);
    }
  }
}

/// All fronts, deepest first; searched(f, k) as above.
template <class Scalar>
std::vector<ReferenceFront<Scalar>> follow(const StageProblem<Scalar>& problem,
                                           const FactoredFronts<Scalar>& result, const ReferenceRule& rule,
                                           const std::function<SearchedRows(Vertex, Vertex)>& searched) {
  std::vector<ReferenceFront<Scalar>> fronts;
  for (Vertex f = 0; f < problem.plan->num_fronts && !testing::Test::HasFailure(); ++f) {
    SCOPED_TRACE("front " + std::to_string(f));
    const Vertex p = problem.plan->pivots(f);
    std::vector<Vertex> sorted = result.row_at[f];
    std::sort(sorted.begin(), sorted.end());
    for (Vertex i = 0; i < p; ++i) EXPECT_EQ(sorted[i], i) << "the row exchanges are no permutation";
    if (testing::Test::HasFailure()) break;
    fronts.push_back(assemble(*problem.plan, problem.scaled(), fronts, f));
    follow_pivots(fronts.back(), result.row_at[f], result.shift[f], rule,
                  [&](Vertex k) { return searched(f, k); });
    variable_update(fronts.back());
  }
  return fronts;
}

/// The rule for a pivot tolerance relative to the largest scaled entry.
template <class Scalar>
ReferenceRule rule_of(const StageProblem<Scalar>& problem, double tolerance) {
  double largest = 0;
  for (Vertex row = 0; row < problem.pattern->n; ++row) {
    for (Offset k = problem.pattern->offsets[row]; k < problem.pattern->offsets[row + 1]; ++k) {
      const double scale = problem.row_scale[row] * problem.column_scale[problem.pattern->columns[k]];
      largest = std::max(largest, static_cast<double>(std::abs(problem.values[k])) * scale);
    }
  }
  const double epsilon = std::numeric_limits<RealOf<Scalar>>::epsilon();
  return {tolerance * largest, std::sqrt(epsilon) * largest, largest};
}

}  // namespace mfs::test
