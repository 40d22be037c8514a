// A system whose coordinates are measured in their scales s, whose time in a unit T and whose constraints in
// units u of their own,
//
//   t = T t',   q = s q',   Phi = u Phi',   F' = s T^2 F   and so   lambda' = u T^2 lambda,
//
// which are powers of two, so that nothing is rounded. Tolerances, the directions of the constraints and
// pivots compare lengths with angles and velocities with both. So they are of use where all these are
// ordinary numbers: in micrometres a velocity of 1 that rounding leaves in a constraint is nothing, and an
// Euler parameter that is 1e-6 off is much. Only where a scale or T is not 1 there is such a system. Its
// vectors are on the host.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/constrained_system.hpp"
#include "dae/mechanics/turning_bodies.hpp"

namespace mfs::dae {

class ScaledSystem final : public ConstrainedSystem, public TurningBodies {
 public:
  static bool is_needed(const ConstrainedSystem& system);
  /// u by Phi_q at `t` and `q`: rows then have a largest entry of about 1. `time`: T. `system` has to live as
  /// long.
  ScaledSystem(const ConstrainedSystem& system, double t, const std::vector<double>& q, double time = 1.0);
  ~ScaledSystem() override;

  /// Of the system given: of this one, and back. Empty vectors stay so.
  State scaled(State state) const;
  State unscaled(State state) const;
  /// Steps and tolerances that are given become those of this one's time; default tolerances stay.
  IntegratorOptions scaled(IntegratorOptions options) const;

  int coordinates() const override { return system_.coordinates(); }
  int constraints() const override { return system_.constraints(); }
  const TangentPattern& tangent_pattern() const override { return system_.tangent_pattern(); }
  void evaluate(const StateView& state, Residual& residual) const override;
  void evaluate(const StateView& state, Tangent& tangent, BlockSet blocks) const override;
  std::vector<RemoteTangent*> remote_tangents() const override;
  std::string coordinate_name(int i) const override { return system_.coordinate_name(i); }
  std::string constraint_name(int row) const override { return system_.constraint_name(row); }
  std::string constraint_owner(int row) const override { return system_.constraint_owner(row); }
  bool is_normalization(int row) const override { return system_.is_normalization(row); }
  bool is_nonholonomic(int row) const override { return system_.is_nonholonomic(row); }
  bool is_measure(int i) const override { return system_.is_measure(i); }
  std::vector<double> ranges(const double* q) const override;
  std::string most_pressed(const double* q) const override;
  double constraint_unit(int row) const override { return unit_[row]; }
  double force_unit(int i) const override { return 1.0 / (scale_[i] * time_ * time_); }
  /// T.
  double time_unit() const { return time_; }
  std::vector<PointRange> turning_bodies() const override;
  bool is_length(int coordinate) const override { return is_length_of(system_, coordinate); }
  double largest_body() const override { return largest_body_of(system_); }
  std::vector<double> marks(const TimeSpan& span) const override;
  std::unique_ptr<ChangeWatch> change_watch() const override;

 private:
  class Remote;
  class Watch;
  /// The state for the system given, in arrays of this one.
  StateView given(const StateView& state) const;
  std::vector<double> given(const double* q) const;

  const ConstrainedSystem& system_;
  const double time_;
  std::vector<double> scale_, unit_;
  std::vector<std::unique_ptr<Remote>> remotes_;
  mutable State there_;
};

/// Tells another observer, in the units of the system given, what a scaled one does.
class UnscalingObserver final : public Observer {
 public:
  UnscalingObserver(const ScaledSystem& system, Observer& observer) : system_(system), observer_(observer) {}

  void step(const StepReport& report, const std::function<const State&()>& state) override {
    StepReport unscaled = report;
    unscaled.t *= system_.time_unit();
    unscaled.h *= system_.time_unit();
    observer_.step(unscaled, [&]() -> const State& { return state_ = system_.unscaled(state()); });
  }
  void output(const State& state) override { observer_.output(system_.unscaled(state)); }

 private:
  const ScaledSystem& system_;
  Observer& observer_;
  State state_;
};

}  // namespace mfs::dae
