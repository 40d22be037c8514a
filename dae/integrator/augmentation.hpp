// The augmented Lagrangian of one step's linear systems (Bauchau, Epple and Bottasso, Scaling of constraints
// and augmented Lagrangian formulations in multibody dynamics simulations, J. Comput. Nonlinear Dynamics 4,
// 2009). In place of the multipliers the matrix has the unknowns lambda' of
//
//     lambda = lambda' + s Phi_q a,        so that      F:  (M' + s Phi_q^T Phi_q) a + Phi_q^T lambda' ...
//
// Coordinates without mass and stiffness of their own, such as the frames of rigid interfaces, have no
// diagonal in M'. Without the augmentation their pivots have to come from multipliers; then the multipliers
// of other bodies' constraints wait until all of the body is eliminated, which floats without them, and
// factors grow by the ratio of its stiffness to its inertia, 1e6 and more. With s as large as a typical
// diagonal of M', every coordinate has a good pivot where it stands.
#pragma once

#include <cstddef>
#include <vector>

#include "dae/integrator/composition.hpp"

namespace mfs::dae {

/// Phi_q^T Phi_q for one Phi_q after another.
class Augmentation {
 public:
  /// `gradient`: the pattern of Phi_q, `transposed` its transpose; both have to live as long.
  Augmentation(const Pattern& gradient, const TransposedPattern& transposed, int threads);

  /// n x n.
  const Pattern& pattern() const { return pattern_; }
  /// In the order of the entries of the pattern.
  const std::vector<double>& values() const { return values_; }
  void compute(const std::vector<double>& gradient);

 private:
  template <class Visit>
  void for_each_product(int row, const Visit& visit) const;
  template <class Visit>
  void for_rows(const Visit& visit) const;

  const Pattern& gradient_;
  const TransposedPattern& transposed_;
  const int threads_;
  Pattern pattern_;
  std::vector<int> rows_;                   ///< those of coordinates that have constraints
  std::vector<std::size_t> product_start_;  ///< by number in rows_: where its products are in place_
  std::vector<int> place_;                  ///< of each product: the entry that it belongs to
  std::vector<double> values_;
};

}  // namespace mfs::dae
