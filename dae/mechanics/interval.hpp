// Intervals that contain all values of a formula where its variables are in given intervals (Moore, Kearfott,
// Cloud: Introduction to Interval Analysis, SIAM 2009). Bounds are not rounded outwards: they are for finding
// where a function changes, not for proofs. Where a function is not defined on a part of its argument's
// interval that part is left out; where it is defined nowhere on it, as it then has no value to be bounded,
// the result is any interval.
#pragma once

#include <algorithm>
#include <cmath>

namespace mfs::dae {

struct Interval {
  double low = 0.0, high = 0.0;

  Interval() = default;
  Interval(double value) : Interval(value, value) {}  // NOLINT: numbers are intervals
  Interval(double from, double to)
      : low(std::isnan(from) ? -HUGE_VAL : from), high(std::isnan(to) ? HUGE_VAL : to) {}
  static Interval everything() { return {-HUGE_VAL, HUGE_VAL}; }

  double width() const { return high > low ? high - low : 0.0; }
  bool contains(double x) const { return low <= x && x <= high; }
  bool is_zero() const { return low == 0.0 && high == 0.0; }

  friend Interval operator+(const Interval& x, const Interval& y) { return {x.low + y.low, x.high + y.high}; }
  friend Interval operator-(const Interval& x, const Interval& y) { return {x.low - y.high, x.high - y.low}; }
  friend Interval operator*(const Interval& x, const Interval& y) {
    const auto product = [](double a, double b) { return a == 0.0 || b == 0.0 ? 0.0 : a * b; };
    const auto [low, high] = std::minmax(
        {product(x.low, y.low), product(x.low, y.high), product(x.high, y.low), product(x.high, y.high)});
    return {low, high};
  }
  friend Interval operator/(const Interval& x, const Interval& y) {
    if (!y.contains(0.0)) return x * Interval(1.0 / y.high, 1.0 / y.low);
    if (y.low == 0.0 && y.high > 0.0) return x * Interval(1.0 / y.high, HUGE_VAL);
    if (y.high == 0.0 && y.low < 0.0) return x * Interval(-HUGE_VAL, 1.0 / y.low);
    return everything();
  }
};

inline Interval hull(const Interval& x, const Interval& y) {
  return {std::min(x.low, y.low), std::max(x.high, y.high)};
}
inline Interval widened(const Interval& x, double by) {
  return {x.low - by, x.high + by};
}
/// Of the part of x that is between these.
inline Interval clamped(const Interval& x, double least, double most) {
  return {std::clamp(x.low, least, most), std::clamp(x.high, least, most)};
}

inline Interval exp(const Interval& x) {
  return {std::exp(x.low), std::exp(x.high)};
}
inline Interval log(const Interval& x) {
  const Interval positive = clamped(x, 0.0, HUGE_VAL);
  return {std::log(positive.low), std::log(positive.high)};
}
inline Interval sqrt(const Interval& x) {
  const Interval positive = clamped(x, 0.0, HUGE_VAL);
  return {std::sqrt(positive.low), std::sqrt(positive.high)};
}
inline Interval sin(const Interval& x) {
  const double pi = std::acos(-1.0);
  if (!(x.width() < 2 * pi) || !std::isfinite(x.low)) return {-1.0, 1.0};
  // Whether x contains one of `first` + 2 pi k.
  const auto reaches = [&](double first) {
    return first + 2 * pi * std::ceil((x.low - first) / (2 * pi)) <= x.high;
  };
  const double from = std::sin(x.low), to = std::sin(x.high);
  return {reaches(-pi / 2) ? -1.0 : std::min(from, to), reaches(pi / 2) ? 1.0 : std::max(from, to)};
}
inline Interval cos(const Interval& x) {
  return sin(x + std::acos(0.0));
}
inline Interval tan(const Interval& x) {
  const Interval cosine = cos(x);
  return cosine.contains(0.0) ? Interval::everything() : Interval(std::tan(x.low), std::tan(x.high));
}
inline Interval asin(const Interval& x) {
  const Interval sine = clamped(x, -1.0, 1.0);
  return {std::asin(sine.low), std::asin(sine.high)};
}
inline Interval acos(const Interval& x) {
  return std::acos(0.0) - asin(x);
}
inline Interval atan(const Interval& x) {
  return {std::atan(x.low), std::atan(x.high)};
}
inline Interval atan2(const Interval& y, const Interval& x) {
  const double right = std::acos(0.0);
  if (x.low > 0.0) return atan(y / x);
  if (y.low > 0.0) return right - atan(x / y);
  if (y.high < 0.0) return -right - atan(x / y);
  return {-2 * right, 2 * right};
}
inline Interval sinh(const Interval& x) {
  return {std::sinh(x.low), std::sinh(x.high)};
}
inline Interval cosh(const Interval& x) {
  const double from = std::cosh(x.low), to = std::cosh(x.high);
  return {x.contains(0.0) ? 1.0 : std::min(from, to), std::max(from, to)};
}
inline Interval tanh(const Interval& x) {
  return {std::tanh(x.low), std::tanh(x.high)};
}
inline Interval pow(const Interval& x, const Interval& y) {
  const double n = y.low;
  if (y.low != y.high) return exp(y * log(x));
  if (n < 0.0) return 1.0 / pow(x, -n);
  const Interval base = n == std::floor(n) ? x : clamped(x, 0.0, HUGE_VAL);
  const double from = std::pow(base.low, n), to = std::pow(base.high, n);
  const bool turns = base.contains(0.0) && std::fmod(n, 2.0) == 0.0 && n > 0.0;
  return {turns ? 0.0 : std::min(from, to), std::max(from, to)};
}

}  // namespace mfs::dae
