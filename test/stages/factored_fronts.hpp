// A whole factorization as it lies in memory, and what holds for it whatever order its pivots were taken in:
// the factors multiply out to the matrix with the noted shifts added.
#pragma once

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "kernels/stages/front_store.hpp"
#include "test/stages/front_blocks.hpp"

namespace mfs::test {

/// Fronts, exchanges and shifts after a whole factorization.
template <class Scalar>
struct FactoredFronts {
  std::vector<FrontBlocks<Scalar>> fronts;
  std::vector<std::vector<Vertex>> row_at;
  std::vector<std::vector<Scalar>> shift;
  FactorStatus status{};
};

template <class Scalar>
std::vector<Scalar> all_shifts(const FactoredFronts<Scalar>& result) {
  std::vector<Scalar> shifts;
  for (const auto& front : result.shift) shifts.insert(shifts.end(), front.begin(), front.end());
  return shifts;
}

/// Sum over all fronts of (rows exchanged back) [L_P; L] [U_P U], by position: what the factors multiply out
/// to, and the same of absolute values: what rounding is measured by. n x n, column-major.
template <class Scalar>
struct Product {
  std::vector<Scalar> value;
  std::vector<double> size;
};

template <class Scalar>
Product<Scalar> multiplied_out(const SymbolicPlan& plan, const FactoredFronts<Scalar>& result) {
  const std::size_t n = static_cast<std::size_t>(plan.n);
  Product<Scalar> product{std::vector<Scalar>(n * n), std::vector<double>(n * n)};
  for (Vertex f = 0; f < plan.num_fronts; ++f) {
    const Vertex p = plan.pivots(f), rows = p + plan.border_rows(f), first = plan.pivot_begin[f];
    const auto position = [&](Vertex i) {
      return i < p ? first + i : plan.border[plan.border_begin[f] + i - p];
    };
    const auto& lower = result.fronts[f].lower;
    const auto& upper = result.fronts[f].upper;
    std::vector<Scalar> column(rows);
    std::vector<double> size(rows);
    for (Vertex j = 0; j < rows; ++j) {
      std::fill(column.begin(), column.end(), Scalar(0));
      std::fill(size.begin(), size.end(), 0.0);
      for (Vertex k = 0; k < std::min(p, j + 1); ++k) {
        const Scalar u =
            j < p ? lower[k + static_cast<Offset>(j) * rows] : upper[k + static_cast<Offset>(j - p) * p];
        const Scalar* const l = lower.data() + static_cast<Offset>(k) * rows;
        column[k] += u;
        size[k] += std::abs(u);
        for (Vertex i = k + 1; i < rows; ++i) {
          column[i] += l[i] * u;
          size[i] += std::abs(l[i] * u);
        }
      }
      for (Vertex i = 0; i < rows; ++i) {
        const Vertex row = i < p ? first + result.row_at[f][i] : position(i);
        const std::size_t place = static_cast<std::size_t>(row) + position(j) * n;
        product.value[place] += column[i];
        product.size[place] += size[i];
      }
    }
  }
  return product;
}

/// The scaled matrix by position, with the shifts added; n x n, column-major.
template <class Scalar>
std::vector<Scalar> shifted_matrix(const StageProblem<Scalar>& problem,
                                   const FactoredFronts<Scalar>& result) {
  const SymbolicPlan& plan = *problem.plan;
  const std::size_t n = static_cast<std::size_t>(plan.n);
  const std::vector<Vertex> row_position = inverse(plan.row_of), column_position = inverse(plan.column_of);
  std::vector<Scalar> a(n * n);
  for (Vertex row = 0; row < plan.n; ++row) {
    for (Offset k = problem.pattern->offsets[row]; k < problem.pattern->offsets[row + 1]; ++k) {
      const Vertex column = problem.pattern->columns[k];
      a[row_position[row] + column_position[column] * n] +=
          problem.values[k] * Scalar(problem.row_scale[row] * problem.column_scale[column]);
    }
  }
  for (Vertex f = 0; f < plan.num_fronts; ++f) {
    const std::size_t first = static_cast<std::size_t>(plan.pivot_begin[f]);
    for (Vertex i = 0; i < plan.pivots(f); ++i)
      a[first + result.row_at[f][i] + (first + i) * n] += result.shift[f][i];
  }
  return a;
}

/// What a residual is compared with: its own entry, or, where diagonal blocks were inverted and back, which
/// leaves rounding in place of zeros and loses up to two digits beside small pivots, 50 times the largest of
/// its row.
enum class Measure { entry, row };

template <class Scalar>
void expect_exact_factors(const StageProblem<Scalar>& problem, const FactoredFronts<Scalar>& result,
                          Measure measure = Measure::entry) {
  const Product<Scalar> product = multiplied_out(*problem.plan, result);
  const std::vector<Scalar> expected = shifted_matrix(problem, result);
  const std::size_t n = static_cast<std::size_t>(problem.plan->n);
  std::vector<double> size = product.size, row(n, 0.0);
  for (std::size_t i = 0; i < size.size(); ++i) {
    size[i] += std::abs(expected[i]);
    row[i % n] = std::max(row[i % n], size[i]);
  }
  double worst = 0;
  for (std::size_t i = 0; i < size.size(); ++i) {
    const double off = std::abs(product.value[i] - expected[i]);
    const double of = measure == Measure::entry ? size[i] : 50 * row[i % n];
    if (!(off <= worst * of)) worst = std::isfinite(off) ? off / of : HUGE_VAL;
  }
  constexpr double kRounding = 45 * static_cast<double>(std::numeric_limits<RealOf<Scalar>>::epsilon());
  EXPECT_LT(worst, kRounding * std::sqrt(static_cast<double>(n)));
  Vertex shifted = 0;
  for (const Scalar& shift : all_shifts(result)) shifted += shift != Scalar(0);
  EXPECT_EQ(result.status.perturbed, static_cast<unsigned long long>(shifted));
  EXPECT_EQ(result.status.nonfinite, 0u);
}

}  // namespace mfs::test
