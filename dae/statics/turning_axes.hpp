// Small motions of what turns. About a motion q(t) the coefficients of
//
//   M x'' + D x' + K x + Phi_q^T mu = 0,   Phi_q x = 0
//
// change with time, as Euler parameters and the places of nodes do, even where the motion is steady. They are
// constant for x = T(t) y with turns and places y along axes that do not change what they see:
//
//   axes of the ground    of bodies that turn about an axis of symmetry: rotors, wheels, sleeping tops
//   axes that turn along  where all turns as a whole: blades, governors, satellites
//   axes that precess     where bodies turn about an axis of symmetry, and all as a whole besides: tops
//
// With T = 1 at the time of the state, x' = y' + W y and x'' = y'' + 2 W y' + U y, W = T', U = T''. So y has
// D + 2 M W in place of D and K + D W + M U in place of K. W and U are blocks: of the Euler parameters p of a
// frame the change dp = (turn / 2) p is a product of quaternions, of places it is turn x r. Whether the
// coefficients are constant then is another question (steady_motion.hpp). Constraints on velocities, A x' + B
// x = 0, have B + A W in place of B.
#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <vector>

#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae {

/// Largest `rtol` of a motion to a state about which modes are asked for. Whether all turns as one body is
/// told by thousandths of velocities, and a motion may be off by some hundred times what a step may leave.
constexpr double kMotionRtol = 1e-6;

class TurningAxes {
 public:
  enum class Kind { of_ground, along, precessing };

  /// Axes that turn along where all turns as one body, else those of the ground. Places of nodes are turned
  /// where `system` is TurningBodies as well.
  TurningAxes(const ConstrainedSystem& system, const State& state);
  /// Those of the ground.
  static TurningAxes of_ground(const ConstrainedSystem& system, const State& state);
  /// Those that turn as velocities and accelerations do from `state` to `later`.
  static TurningAxes precessing(const ConstrainedSystem& system, const State& state, const State& later);

  /// Whether anything moves.
  bool moves() const { return moves_; }
  Kind kind() const { return kind_; }
  /// Whether all turns as one body, which is when the axes turn along.
  bool turn_along() const { return kind_ == Kind::along; }
  /// Whether that is at a rate that stays as it is.
  bool steady() const { return steady_; }
  /// Of the turn of all as one body: its angular acceleration over its square.
  double change() const { return rate_.norm() > 0.0 ? change_.norm() / rate_.squaredNorm() : 0.0; }
  /// How fast anything turns, or moves by what all of it measures, 1/s.
  static double fastest(const ConstrainedSystem& system, const State& state);
  /// Of the axes, rad/s.
  double rate() const { return kind_ == Kind::of_ground ? 0.0 : rate_.norm(); }

  /// Three or four coordinates from `first` on.
  struct Part {
    int first, size;
    Eigen::Matrix4d w, u;
  };
  const std::vector<Part>& parts() const { return parts_; }

 private:
  TurningAxes() = default;
  /// Whether all turns as one body.
  bool find_common_turn(const std::vector<int>& frames, const std::vector<int>& places, const State& state);
  void make_parts(const std::vector<int>& frames, const std::vector<int>& places, const State& state);

  Kind kind_ = Kind::of_ground;
  bool moves_ = false, steady_ = false;
  Eigen::Vector3d rate_ = Eigen::Vector3d::Zero(), change_ = Eigen::Vector3d::Zero();  // of the axes
  std::vector<Part> parts_;
};

/// The system with y for x in a state that does not change: of its blocks those of F, position_q and the rows
/// of velocity_q of constraints on velocities are for use.
class TurnedSystem : public ConstrainedSystem {
 public:
  /// `system` and `axes` have to live as long.
  TurnedSystem(const ConstrainedSystem& system, const TurningAxes& axes);

  int coordinates() const override { return system_.coordinates(); }
  int constraints() const override { return system_.constraints(); }
  const TangentPattern& tangent_pattern() const override { return pattern_; }
  void evaluate(const StateView& state, Residual& residual) const override {
    system_.evaluate(state, residual);
  }
  /// F_a, F_v and F_q together, velocity_q with position_q.
  void evaluate(const StateView& state, Tangent& tangent, BlockSet blocks) const override;
  std::string coordinate_name(int i) const override { return system_.coordinate_name(i); }
  std::string constraint_name(int row) const override { return system_.constraint_name(row); }
  std::string constraint_owner(int row) const override { return system_.constraint_owner(row); }
  bool is_normalization(int row) const override { return system_.is_normalization(row); }
  bool is_nonholonomic(int row) const override { return system_.is_nonholonomic(row); }
  double coordinate_scale(int i) const override { return system_.coordinate_scale(i); }

 private:
  const TurningAxes::Part* part_of(int coordinate) const;
  /// Makes room for what `by` times W or U adds to `wide`.
  void widen(Block wide, std::initializer_list<Block> by);
  /// Adds the row's values of `from` times W or U, `times`, to `to`.
  void add_row(int row, Block from, const std::vector<double>& values, double factor,
               Eigen::Matrix4d TurningAxes::Part::*times, Block to, std::vector<double>& sum) const;

  const ConstrainedSystem& system_;
  const std::vector<TurningAxes::Part>& parts_;
  std::vector<int> number_;  // of the block of a coordinate; -1: none
  TangentPattern pattern_;
};

}  // namespace mfs::dae
