// The mathematical pendulum in Cartesian coordinates: mass 1 kg, length 1 m, x^2 + y^2 = 1. Its exact motion
// is an elliptic function; started at rest with amplitude A, its period is 4 sqrt(l/g) K(sin(A/2)) (Landau
// and Lifshitz, Mechanics, section 11).
#pragma once

#include <cmath>
#include <vector>

#include "test/dae/integrator/dense_system.hpp"

namespace mfs::dae::test {

struct Pendulum {
  static constexpr double kGravity = 9.81;
  int coordinates() const { return 2; }
  int constraints() const { return 1; }
  template <class T>
  std::vector<T> force(double /*t*/, const std::vector<T>& /*q*/, const std::vector<T>& /*v*/,
                       const std::vector<T>& a) const {
    return {a[0], T(a[1] + kGravity)};
  }
  template <class T>
  std::vector<T> constraint(const T& /*t*/, const std::vector<T>& q) const {
    return {T(0.5 * (q[0] * q[0] + q[1] * q[1] - 1.0))};
  }
};

/// [q, v] at rest with amplitude `angle` from the lowest point.
inline std::vector<double> pendulum_at(double angle) {
  return {std::sin(angle), -std::cos(angle)};
}

inline double pendulum_period(double angle) {
  return 4.0 / std::sqrt(Pendulum::kGravity) * std::comp_ellint_1(std::sin(0.5 * angle));
}

/// Of unit mass: kinetic and potential.
template <class State>
double pendulum_energy(const State& s) {
  return 0.5 * (s.v[0] * s.v[0] + s.v[1] * s.v[1]) + Pendulum::kGravity * s.q[1];
}

}  // namespace mfs::dae::test
