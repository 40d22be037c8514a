// A body that is stiff and turns.
#pragma once

#include <cmath>
#include <vector>

namespace mfs::dae::test {

/// A point of 1 kg that turns about the origin with kSpeed, held at a distance of 1 m by a stiff damped
/// spring: what it is at order 1 makes an error of its radial velocity that no step makes smaller.
struct TurningPoint {
  static constexpr double kSpeed = 30.0;
  double stiffness = 1e9, damping = 1e5;
  int coordinates() const { return 2; }
  int constraints() const { return 0; }
  template <class T>
  std::vector<T> force(double /*t*/, const std::vector<T>& q, const std::vector<T>& v,
                       const std::vector<T>& a) const {
    using std::sqrt;
    const T r = sqrt(q[0] * q[0] + q[1] * q[1]), x = q[0] / r, y = q[1] / r;
    const T pull = stiffness * (r - 1.0) + kSpeed * kSpeed + damping * (x * v[0] + y * v[1]);
    return {T(a[0] + pull * x), T(a[1] + pull * y)};
  }
  template <class T>
  std::vector<T> constraint(const T& /*t*/, const std::vector<T>& /*q*/) const {
    return {};
  }
};

}  // namespace mfs::dae::test
