// Whipple's bicycle, linearized, of the benchmark (Meijaard, Papadopoulos, Ruina and Schwab, Proc. Royal
// Society A 463 (2007) 1955-1982), whose matrices were derived by hand and by two programs.
#pragma once

#include <Eigen/Dense>

namespace mfs::dae::test {

/// M x'' + v C1 x' + (g K0 + v^2 K2) x = 0 for lean and steer.
struct LinearBicycle {
  Eigen::Matrix2d m, c, k;
  explicit LinearBicycle(double v) {
    m << 80.81722, 2.31941332208709, 2.31941332208709, 0.29784188199686;
    c << 0, 33.86641391492494, -0.85035641456978, 1.68540397397560;
    c *= v;
    Eigen::Matrix2d k0, k2;
    k0 << -80.95, -2.59951685249872, -2.59951685249872, -0.80329488458618;
    k2 << 0, 76.59734589573222, 0, 2.65431523794604;
    k = 9.81 * k0 + v * v * k2;
  }
  Eigen::Vector4d rate(const Eigen::Vector4d& y) const {
    Eigen::Vector4d rate;
    rate << y.tail<2>(), m.ldlt().solve(-c * y.tail<2>() - k * y.head<2>());
    return rate;
  }
};

}  // namespace mfs::dae::test
