// Jacobi's elliptic functions, for exact motions.
#pragma once

#include <array>
#include <cmath>
#include <vector>

namespace mfs::dae::test {

/// sn, cn and dn of parameter m = k^2 by the arithmetic-geometric mean (Abramowitz and Stegun, 16.4).
inline std::array<double, 3> jacobi(double u, double m) {
  std::vector<double> a{1.0}, c{std::sqrt(m)};
  double b = std::sqrt(1.0 - m);
  while (std::abs(c.back()) > 1e-16) {
    const double mean = 0.5 * (a.back() + b);
    c.push_back(0.5 * (a.back() - b));
    b = std::sqrt(a.back() * b);
    a.push_back(mean);
  }
  double phi = std::ldexp(a.back() * u, static_cast<int>(a.size()) - 1), last = phi;
  for (std::size_t n = a.size() - 1; n > 0; --n) {
    last = phi;
    phi = 0.5 * (phi + std::asin(c[n] * std::sin(phi) / a[n]));
  }
  return {std::sin(phi), std::cos(phi), std::cos(phi) / std::cos(last - phi)};
}

}  // namespace mfs::dae::test
