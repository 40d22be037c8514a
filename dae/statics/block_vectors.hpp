// Blocks of a tangent on vectors of Eigen, for modes.hpp and instability.hpp.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae {

/// block x, or block^T x where `transposed`.
Eigen::VectorXd product(const Pattern& pattern, const std::vector<double>& values, const Eigen::VectorXd& x,
                        bool transposed = false);
/// |a_ii|, 0 where there is no entry.
Eigen::VectorXd diagonal_sizes(const Pattern& pattern, const std::vector<double>& values);
/// The upper one where their number is even; there is one at least.
double median(std::vector<double> numbers);
/// Of no symmetry that a motion could have; others for other numbers.
Eigen::VectorXd irregular(Eigen::Index size, int number = 1);

}  // namespace mfs::dae
