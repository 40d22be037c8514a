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

/// f(x), given f and its first two derivatives at x.c0.
template <class T>
Taylor<T> composed(const Taylor<T>& x, const T& f, const T& first, const T& second) {
  return {f, T(first * x.c1), T(first * x.c2 + 0.5 * second * x.c1 * x.c1)};
}

template <class T>
Taylor<T> sin(const Taylor<T>& x) {
  using std::cos, std::sin;
  const T s = sin(x.c0);
  return composed(x, s, T(cos(x.c0)), T(-s));
}
template <class T>
Taylor<T> cos(const Taylor<T>& x) {
  using std::cos, std::sin;
  const T c = cos(x.c0);
  return composed(x, c, T(-sin(x.c0)), T(-c));
}
template <class T>
Taylor<T> tan(const Taylor<T>& x) {
  using std::tan;
  const T f = tan(x.c0), first = 1.0 + f * f;
  return composed(x, f, first, T(2.0 * f * first));
}
template <class T>
Taylor<T> asin(const Taylor<T>& x) {
  using std::asin, std::sqrt;
  const T square = 1.0 - x.c0 * x.c0, first = 1.0 / sqrt(square);
  return composed(x, T(asin(x.c0)), first, T(x.c0 * first / square));
}
template <class T>
Taylor<T> acos(const Taylor<T>& x) {
  using std::acos;
  const Taylor<T> complement = asin(x);
  return {T(acos(x.c0)), T(-complement.c1), T(-complement.c2)};
}
template <class T>
Taylor<T> atan(const Taylor<T>& x) {
  using std::atan;
  const T first = 1.0 / (1.0 + x.c0 * x.c0);
  return composed(x, T(atan(x.c0)), first, T(-2.0 * x.c0 * first * first));
}
template <class T>
Taylor<T> sinh(const Taylor<T>& x) {
  using std::cosh, std::sinh;
  const T s = sinh(x.c0);
  return composed(x, s, T(cosh(x.c0)), s);
}
template <class T>
Taylor<T> cosh(const Taylor<T>& x) {
  using std::cosh, std::sinh;
  const T c = cosh(x.c0);
  return composed(x, c, T(sinh(x.c0)), c);
}
template <class T>
Taylor<T> tanh(const Taylor<T>& x) {
  using std::tanh;
  const T f = tanh(x.c0), first = 1.0 - f * f;
  return composed(x, f, first, T(-2.0 * f * first));
}
template <class T>
Taylor<T> exp(const Taylor<T>& x) {
  using std::exp;
  const T f = exp(x.c0);
  return composed(x, f, f, f);
}
template <class T>
Taylor<T> log(const Taylor<T>& x) {
  using std::log;
  return composed(x, T(log(x.c0)), T(1.0 / x.c0), T(-1.0 / (x.c0 * x.c0)));
}
/// A constant power: 0 to the powers 0, 1 and 2 has derivatives.
template <class T>
Taylor<T> pow(const Taylor<T>& x, double power) {
  using std::pow;
  const auto term = [&](double factor, double exponent) {
    return factor == 0 ? T(0.0) : T(factor * pow(x.c0, exponent));
  };
  return composed(x, T(pow(x.c0, power)), term(power, power - 1), term(power * (power - 1), power - 2));
}
/// From z' = (x y' - y x') / (x^2 + y^2), which holds in all four quadrants.
template <class T>
Taylor<T> atan2(const Taylor<T>& y, const Taylor<T>& x) {
  using std::atan2;
  const T square = x.c0 * x.c0 + y.c0 * y.c0, turn = x.c0 * y.c1 - y.c0 * x.c1;
  const T first = turn / square;
  return {T(atan2(y.c0, x.c0)), first,
          T((x.c0 * y.c2 - y.c0 * x.c2 - first * (x.c0 * x.c1 + y.c0 * y.c1)) / square)};
}

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
