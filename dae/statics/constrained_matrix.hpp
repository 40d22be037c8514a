// The linear systems of statics and of small motions about a state,
//
//   [ A      Phi_q^T ] [ x  ]   [ b ]        A = alpha dF/da + beta dF/dv + gamma dF/dq
//   [ Phi_q     0    ] [ mu ] = [ c ]
//
// solved by mfs::Solver, with the augmentation of the integrator (augmentation.hpp), which gives a pivot to
// coordinates without inertia and stiffness of their own.
#pragma once

#include <vector>

#include <mfs/solver.hpp>

#include "dae/integrator/augmentation.hpp"
#include "dae/integrator/composition.hpp"
#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae {

class ConstrainedMatrix {
 public:
  /// Constraints have to be independent. `threads` 0: all. `system` has to live as long.
  ConstrainedMatrix(const ConstrainedSystem& system, int threads, Backend backend = Backend::openmp);

  /// Throws SingularMatrix with the name of a coordinate or a constraint, and what mfs::Solver throws.
  void factor(const Tangent& tangent, const ByAVQ& factors);
  /// `right_side`: [b, c], n + m; returns [x, mu].
  std::vector<double> solve(std::vector<double> right_side);

 private:
  const ConstrainedSystem& system_;
  const int n_, m_;
  const TransposedPattern transposed_;
  Augmentation augmentation_;
  Composition matrix_;
  std::vector<double> values_;
  double augmented_by_ = 0.0;
  std::vector<double> gradient_;  // Phi_q of the last factorization
  Solver solver_;
};

/// y = block x, or block^T x where `transposed`.
std::vector<double> product(const Pattern& pattern, const std::vector<double>& values,
                            const std::vector<double>& x, bool transposed = false);

}  // namespace mfs::dae
