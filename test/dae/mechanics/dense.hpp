#pragma once

#include <Eigen/Dense>
#include <vector>

#include "dae/mechanics/constrained_system.hpp"

namespace mfs::test {

/// The matrix with `values` at the entries of `pattern` and 0 elsewhere.
inline Eigen::MatrixXd dense(const dae::Pattern& pattern, const std::vector<double>& values) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(pattern.rows, pattern.columns);
  for (int i = 0; i < pattern.rows; ++i)
    for (int k = pattern.row_start[i]; k < pattern.row_start[i + 1]; ++k)
      matrix(i, pattern.column[k]) = values[k];
  return matrix;
}

}  // namespace mfs::test
