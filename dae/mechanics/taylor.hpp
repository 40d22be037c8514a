// A quantity along the motion of a system, as its Taylor series in time cut after the second power:
//
//   x(t + s) = c0 + c1 s + c2 s^2      so  x = c0,  x' = c1,  x'' = 2 c2.
//
// Formulas of positions, computed with series of the coordinates q + v s + a/2 s^2, give their own first two
// derivatives by time. T is double, or a dual number when derivatives of these by q are wanted as well.
#pragma once

#include <cmath>

#include "dae/mechanics/smooth_function.hpp"

namespace mfs::dae {

template <class T>
struct Taylor {
  T c0{0.0}, c1{0.0}, c2{0.0};

  Taylor() = default;
  Taylor(double constant) : c0(constant) {}  // NOLINT: numbers are series
  Taylor(const T& x, const T& first, const T& half_second) : c0(x), c1(first), c2(half_second) {}

  friend Taylor operator+(const Taylor& x, const Taylor& y) {
    return {T(x.c0 + y.c0), T(x.c1 + y.c1), T(x.c2 + y.c2)};
  }
  friend Taylor operator-(const Taylor& x, const Taylor& y) {
    return {T(x.c0 - y.c0), T(x.c1 - y.c1), T(x.c2 - y.c2)};
  }
  friend Taylor operator*(const Taylor& x, const Taylor& y) {
    return {T(x.c0 * y.c0), T(x.c0 * y.c1 + x.c1 * y.c0), T(x.c0 * y.c2 + x.c1 * y.c1 + x.c2 * y.c0)};
  }
  friend Taylor operator*(double x, const Taylor& y) { return {T(x * y.c0), T(x * y.c1), T(x * y.c2)}; }
  /// From x = z y, power by power.
  friend Taylor operator/(const Taylor& x, const Taylor& y) {
    const T z0 = x.c0 / y.c0;
    const T z1 = (x.c1 - z0 * y.c1) / y.c0;
    return {z0, z1, T((x.c2 - z0 * y.c2 - z1 * y.c1) / y.c0)};
  }
  friend Taylor operator-(const Taylor& x) { return -1.0 * x; }
  /// From x = z z, power by power.
  friend Taylor sqrt(const Taylor& x) {
    using std::sqrt;
    const T z0 = sqrt(x.c0);
    const T z1 = x.c1 / (2.0 * z0);
    return {z0, z1, T((x.c2 - z1 * z1) / (2.0 * z0))};
  }
};

/// The number without its derivatives.
inline double value_of(double x) {
  return x;
}
template <class Dual>
double value_of(const Dual& x) {
  return value_of(x.value());
}
template <class T>
double value_of(const Taylor<T>& x) {
  return value_of(x.c0);
}

/// A function of time as a quantity of type T: its series where T is one, its value otherwise.
template <class T>
struct AlongTime {
  static T of(const Jet& f) { return T(f.value); }
};
template <class T>
struct AlongTime<Taylor<T>> {
  static Taylor<T> of(const Jet& f) { return {T(f.value), T(f.first), T(0.5 * f.second)}; }
};

}  // namespace mfs::dae
