// The directions B in which the formula gives way to the constraints (projection.hpp), and multipliers of
// them by which a change of the coordinates fulfils linear constraints.
//
// For most constraints B is Phi_q^T at the prediction; Phi_q B is factored at Jacobians, where it is
// symmetric. A constraint with a tied coordinate, in which no other has a part, comes after those.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

#include "dae/integrator/augmentation.hpp"
#include "dae/integrator/composition.hpp"
#include "dae/integrator/projection.hpp"

namespace mfs::dae {

class ConstraintDirections {
 public:
  /// `gradient`: the pattern of Phi_q, which has to live as long.
  ConstraintDirections(const Pattern& gradient, const Projection& projection);

  /// By values of Phi_q. Throws SingularMatrix where constraints are no more than dependent on each other.
  void factor(const std::vector<double>& gradient);
  /// Sets B, and Phi_q as solve() sees it, by these values of Phi_q, which have to live as long.
  void set(const std::vector<double>& gradient) { now_ = gradient.data(); }
  /// change (n) += B x (m).
  void add(const std::vector<double>& x, double* change) const;
  /// Adds B x to `change` so that Phi_q change = b (m).
  void solve(const std::vector<double>& b, std::vector<double>& change, std::vector<double>& x);

 private:
  double product(int row, const double* change) const;
  /// change += x times a row of Phi_q.
  void add_row(int row, double x, double* change) const;

  const Pattern& gradient_;
  std::vector<int> shared_;  ///< constraints whose directions are Phi_q^T
  struct Tied {
    int row, entry, coordinate;
  };
  std::vector<Tied> tied_;  ///< the others
  std::pair<Pattern, std::vector<int>>
      rows_;                              ///< of Phi_q, those of shared_, and where their entries lie in it
  TransposedPattern transposed_, again_;  ///< of the rows and of their transpose
  Augmentation square_;
  std::vector<double> values_;
  const double* now_ = nullptr;
  Eigen::SparseMatrix<double> matrix_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors_;
  Eigen::VectorXd right_side_, solution_;
};

}  // namespace mfs::dae
