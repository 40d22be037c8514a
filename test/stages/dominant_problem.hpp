// Problems whose pivots stay where they are.
#pragma once

#include <cmath>
#include <stdexcept>
#include <vector>

#include "test/stages/artificial_problem.hpp"

namespace mfs::test {

/// The same pattern with each diagonal entry larger than the rest of its column: pivots stay where they are.
inline StageProblem<double> column_dominant(StageProblem<double> problem) {
  const SymbolicPlan& plan = *problem.plan;
  const std::vector<Vertex> column_position = inverse(plan.column_of);
  std::vector<double> sum(plan.n, 0.0);
  std::vector<Offset> diagonal(plan.n, -1);
  for (Vertex row = 0; row < plan.n; ++row) {
    for (Offset k = problem.pattern->offsets[row]; k < problem.pattern->offsets[row + 1]; ++k) {
      const Vertex column = problem.pattern->columns[k];
      sum[column] += std::abs(problem.values[k] * problem.row_scale[row]);
      if (plan.row_of[column_position[column]] == row) diagonal[column] = k;
    }
  }
  for (Vertex position = 0; position < plan.n; ++position) {
    const Vertex column = plan.column_of[position];
    if (diagonal[column] < 0) throw std::logic_error("no diagonal entry");
    problem.values[diagonal[column]] = 2 * sum[column] / problem.row_scale[plan.row_of[position]];
  }
  return problem;
}

}  // namespace mfs::test
