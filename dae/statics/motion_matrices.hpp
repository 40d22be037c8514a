// M, D and K of modes.hpp in a state, Phi_q, and what constraints on velocities, s A x + B x = 0, have of
// positions.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/constrained_system.hpp"
#include "dae/statics/modes.hpp"

namespace mfs::dae {

class MotionMatrices {
 public:
  /// `system` has to live as long.
  MotionMatrices(const ConstrainedSystem& system, const State& state, Damping damping);

  /// Of constraints on velocities: the first that has B; -1: none, so that A x = 0 is all that they ask for.
  int first_moving() const;
  /// A and B.
  std::pair<Eigen::MatrixXd, Eigen::MatrixXd> rolling() const {
    return {dense(Block::position_q, rolling_), dense(Block::velocity_q, rolling_)};
  }
  /// Phi_q of the others.
  Eigen::MatrixXd held() const { return dense(Block::position_q, held_); }
  const Tangent& tangent() const { return tangent_; }
  Eigen::VectorXd times(Block block, const Eigen::VectorXd& x) const;
  /// Of x, a complex one.
  Eigen::VectorXcd complex_times(Block block, const Eigen::VectorXcd& x) const;
  /// The sum of the sizes of what makes an entry of block x, for rounding.
  Eigen::VectorXd terms(Block block, const Eigen::VectorXcd& x) const;
  Eigen::MatrixXd dense(Block block) const;
  /// 1/s: the median over coordinates that have both a mass and a stiffness that is no rounding, as the
  /// stiffest and the heaviest have it where no coordinate has both; 1 where nothing is stiff.
  double typical_frequency() const;

 private:
  Eigen::VectorXd diagonal(Block block) const;
  Eigen::MatrixXd dense(Block block, const std::vector<int>& rows) const;

  const TangentPattern& pattern_;
  Tangent tangent_;
  std::vector<int> held_, rolling_;  // rows of constraints on positions, on velocities alone
};

}  // namespace mfs::dae
