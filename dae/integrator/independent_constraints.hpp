// A system without those of its constraints that follow from the others: with them, multipliers would not be
// unique and no Newton matrix regular.
#pragma once

#include <string>
#include <vector>

#include "dae/mechanics/constrained_system.hpp"
#include "dae/mechanics/turning_bodies.hpp"

namespace mfs::dae {

class IndependentConstraints : public ConstrainedSystem, public TurningBodies {
 public:
  /// `redundant`: rows of Phi to leave out, ascending. `system` has to live as long.
  IndependentConstraints(const ConstrainedSystem& system, const std::vector<int>& redundant);

  int coordinates() const override { return system_.coordinates(); }
  int constraints() const override { return static_cast<int>(kept_.size()); }
  const TangentPattern& tangent_pattern() const override { return pattern_; }
  void evaluate(const StateView& state, Residual& residual) const override;
  void evaluate(const StateView& state, Tangent& tangent, BlockSet blocks) const override;
  std::vector<RemoteTangent*> remote_tangents() const override { return system_.remote_tangents(); }
  std::string coordinate_name(int i) const override { return system_.coordinate_name(i); }
  std::string constraint_name(int row) const override { return system_.constraint_name(kept_[row]); }
  std::string constraint_owner(int row) const override { return system_.constraint_owner(kept_[row]); }
  bool is_normalization(int row) const override { return system_.is_normalization(kept_[row]); }
  bool is_nonholonomic(int row) const override { return system_.is_nonholonomic(kept_[row]); }
  double coordinate_scale(int i) const override { return system_.coordinate_scale(i); }
  std::vector<double> ranges(const double* q) const override { return system_.ranges(q); }
  std::string most_pressed(const double* q) const override { return system_.most_pressed(q); }
  double constraint_unit(int row) const override { return system_.constraint_unit(kept_[row]); }
  double force_unit(int i) const override { return system_.force_unit(i); }
  bool is_measure(int i) const override { return system_.is_measure(i); }
  std::vector<PointRange> turning_bodies() const override { return turning_bodies_of(system_); }
  bool is_length(int coordinate) const override { return is_length_of(system_, coordinate); }
  double largest_body() const override { return largest_body_of(system_); }

 private:
  StateView with_all_multipliers(const StateView& state) const;

  const ConstrainedSystem& system_;
  std::vector<int> kept_;
  TangentPattern pattern_;
  std::array<std::vector<int>, kBlocks>
      source_;  ///< of a block's entry in the whole system's; empty: the same
  mutable std::vector<double> lambda_;
  mutable Residual residual_;
  mutable Tangent tangent_;
};

}  // namespace mfs::dae
