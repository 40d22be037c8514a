// Which constraints follow from the others, and how: combinations of rows of Phi_q that are zero.
//
// In the scales of the coordinates, with rows of largest entry 1 and without their parts along the
// normalizations, which stay as they are:
//
//   1. A sparse LU of Phi_q^T (UMFPACK) gives rows that certainly are independent: those with large pivots
//      when all others are left out. Once a pivot is small, what is eliminated with it says nothing, so the
//      rows left out may be too many.
//   2. Each of these is expressed by the independent ones (KLU). What is left of them is eliminated with the
//      largest entry first: a row with something left is independent as well, the others are combinations.
//   3. Of the rows of a combination the last one that has a share worth mentioning is called redundant. So
//      the answer is that of reading constraints in their order, and hinges on no pivot. Constraints on
//      velocities come after all others: what they hold would drift in positions.
//
// The combinations span the left null space of Phi_q: multipliers may be changed by them without any effect
// on the motion.
#pragma once

#include <utility>
#include <vector>

#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae {

/// Numbers of some rows, which ascend.
using SparseRow = std::vector<std::pair<int, double>>;

class Dependencies {
 public:
  Dependencies() = default;
  /// What is left of a row below this part of its largest entry is rounding.
  static constexpr double kRounding = 1e-8;
  /// `values`: of `position_q`; `scale`: per coordinate; `normalizes`: per row,
  /// ConstrainedSystem::is_normalization; `nonholonomic`: the same of is_nonholonomic, empty: none;
  /// `nothing`: the part of a row that is taken for zero. Throws InvalidInput where a value is not finite,
  /// OutOfMemory, BackendError.
  Dependencies(const Pattern& position_q, const std::vector<double>& values, const std::vector<double>& scale,
               const std::vector<char>& normalizes, const std::vector<char>& nonholonomic = {},
               double nothing = kRounding);

  /// Rows that follow from the others, ascending.
  const std::vector<int>& redundant() const { return redundant_; }
  /// The combination that is zero by which redundant()[k] follows; its own factor is 1, that of the other
  /// redundant rows 0.
  const SparseRow& combination(std::size_t k) const { return combination_[k]; }

  /// Changes multipliers (of all rows) of the same forces so that those of the redundant rows are zero.
  void make_basic(std::vector<double>& lambda) const;
  /// Changes them so that the sum of the squares of what they are in `units` (of all rows; 0: of one that
  /// does not count, as a normalization) is least.
  void make_least(std::vector<double>& lambda, const std::vector<double>& units) const;

 private:
  std::vector<int> redundant_;
  std::vector<SparseRow> combination_;
};

}  // namespace mfs::dae
