// A unit mass on a unit circle, driven by a tangential force of the angle's second derivative: its angle is
// the given function of time exactly. Smooth, so orders of convergence show; or turning round and round, so
// that no choice of an independent coordinate lasts.
#pragma once

#include <cmath>
#include <vector>

#include "test/dae/integrator/dense_system.hpp"

namespace mfs::dae::test {

struct DrivenCircle {
  double amplitude = 1.0;  ///< angle = amplitude sin(t) + speed t
  double speed = 0.0;

  double angle(double t) const { return amplitude * std::sin(t) + speed * t; }
  double angular_velocity(double t) const { return amplitude * std::cos(t) + speed; }
  std::vector<double> position(double t) const { return {std::cos(angle(t)), std::sin(angle(t))}; }
  std::vector<double> velocity(double t) const {
    return {-angular_velocity(t) * std::sin(angle(t)), angular_velocity(t) * std::cos(angle(t))};
  }
  std::vector<double> acceleration(double t) const {
    const double w2 = angular_velocity(t) * angular_velocity(t), alpha = -amplitude * std::sin(t);
    const double c = std::cos(angle(t)), s = std::sin(angle(t));
    return {-alpha * s - w2 * c, alpha * c - w2 * s};
  }
  /// The multiplier of (x^2 + y^2 - 1) / 2 gives the centripetal force.
  double multiplier(double t) const { return angular_velocity(t) * angular_velocity(t); }

  int coordinates() const { return 2; }
  int constraints() const { return 1; }
  template <class T>
  std::vector<T> force(double t, const std::vector<T>& q, const std::vector<T>& /*v*/,
                       const std::vector<T>& a) const {
    const double alpha = -amplitude * std::sin(t);
    return {T(a[0] + alpha * q[1]), T(a[1] - alpha * q[0])};
  }
  template <class T>
  std::vector<T> constraint(const T& /*t*/, const std::vector<T>& q) const {
    return {T(0.5 * (q[0] * q[0] + q[1] * q[1] - 1.0))};
  }
};

}  // namespace mfs::dae::test
