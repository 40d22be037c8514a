// Two constrained mechanical systems of the Test Set for Initial Value Problem Solvers (Mazzia and Magherini,
// University of Bari, release 2.4), with its reference solutions: Andrews' squeezing mechanism (problem II-1:
// 7 angles, 6 constraints, t = 0.03 s, computed by PSIDE at 1e-14) and the car axis (problem II-2: 4
// coordinates, 2 constraints that depend on time, t = 3, computed by GAMD in quadruple precision).
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "test/dae/integrator/dense_system.hpp"

namespace mfs::dae::test {

/// Angles beta, theta, gamma, phi, delta, omega, epsilon; symbols as in the test set.
struct AndrewsSqueezer {
  static constexpr double kEnd = 0.03;
  int coordinates() const { return 7; }
  int constraints() const { return 6; }

  template <class T>
  std::vector<T> force(double /*t*/, const std::vector<T>& q, const std::vector<T>& v,
                       const std::vector<T>& a) const {
    using std::cos;
    using std::sin;
    using std::sqrt;
    const T cos_theta = cos(q[1]), sin_theta = sin(q[1]), sin_phi = sin(q[3]), cos_phi = cos(q[3]);
    const T sin_omega = sin(q[5]), cos_omega = cos(q[5]), sin_gamma = sin(q[2]), cos_gamma = cos(q[2]);
    const double e1 = e - ea, f1 = zf - fa;
    const T m11 = m1 * ra * ra + m2 * (rr * rr - 2.0 * da * rr * cos_theta + da * da) + i1 + i2;
    const T m21 = m2 * (da * da - da * rr * cos_theta) + i2;
    const double m22 = m2 * da * da + i2, m33 = m3 * (sa * sa + sb * sb) + i3, m44 = m4 * e1 * e1 + i4;
    const T m54 = m4 * (e1 * e1 + zt * e1 * sin_phi) + i4;
    const T m55 = m4 * (zt * zt + 2.0 * zt * e1 * sin_phi + e1 * e1) + m5 * (ta * ta + tb * tb) + i4 + i5;
    const double m66 = m6 * f1 * f1 + i6;
    const T m76 = m6 * (f1 * f1 - u * f1 * sin_omega) + i6;
    const T m77 = m6 * (f1 * f1 - 2.0 * u * f1 * sin_omega + u * u) + m7 * (ua * ua + ub * ub) + i6 + i7;

    const T xd = sd * cos_gamma + sc * sin_gamma + xb, yd = sd * sin_gamma - sc * cos_gamma + yb;
    const T dx = xd - xc, dy = yd - yc;
    const T length = sqrt(T(dx * dx + dy * dy));
    const T spring = -c0 * (length - l0) / length;
    const T fx = spring * dx, fy = spring * dy;

    const T b_dot = v[0], theta_dot = v[1], phi_dot = v[3], delta_dot = v[4], omega_dot = v[5],
            epsilon_dot = v[6];
    return {
        T(m11 * a[0] + m21 * a[1] - mom + m2 * da * rr * theta_dot * (theta_dot + 2.0 * b_dot) * sin_theta),
        T(m21 * a[0] + m22 * a[1] - m2 * da * rr * b_dot * b_dot * sin_theta),
        T(m33 * a[2] - fx * (sc * cos_gamma - sd * sin_gamma) - fy * (sd * cos_gamma + sc * sin_gamma)),
        T(m44 * a[3] + m54 * a[4] - m4 * zt * e1 * delta_dot * delta_dot * cos_phi),
        T(m54 * a[3] + m55 * a[4] + m4 * zt * e1 * phi_dot * (phi_dot + 2.0 * delta_dot) * cos_phi),
        T(m66 * a[5] + m76 * a[6] + m6 * u * f1 * epsilon_dot * epsilon_dot * cos_omega),
        T(m76 * a[5] + m77 * a[6] - m6 * u * f1 * omega_dot * (omega_dot + 2.0 * epsilon_dot) * cos_omega)};
  }

  template <class T>
  std::vector<T> constraint(const T& /*t*/, const std::vector<T>& q) const {
    using std::cos;
    using std::sin;
    const T x = rr * cos(q[0]) - d * cos(q[0] + q[1]), y = rr * sin(q[0]) - d * sin(q[0] + q[1]);
    return {T(x - ss * sin(q[2]) - xb),
            T(y + ss * cos(q[2]) - yb),
            T(x - e * sin(q[3] + q[4]) - zt * cos(q[4]) - xa),
            T(y + e * cos(q[3] + q[4]) - zt * sin(q[4]) - ya),
            T(x - zf * cos(q[5] + q[6]) - u * sin(q[6]) - xa),
            T(y - zf * sin(q[5] + q[6]) + u * cos(q[6]) - ya)};
  }

  static std::vector<double> start() {
    return {-0.0617138900142764496358948458001, 0.0,
            0.455279819163070380255912382449,   0.222668390165885884674473185609,
            0.487364979543842550225598953530,   -0.222668390165885884674473185609,
            1.23054744454982119249735015568};
  }
  /// Angles at kEnd.
  static std::vector<double> reference() {
    return {0.1581077119629904e+2, -0.1575637105984298e+2, 0.4082224013073101e-1, -0.5347301163226948e+0,
            0.5244099658805304e+0, 0.5347301163226948e+0,  0.1048080741042263e+1};
  }

  static constexpr double m1 = 0.04325, m2 = 0.00365, m3 = 0.02373, m4 = 0.00706, m5 = 0.07050, m6 = 0.00706,
                          m7 = 0.05498;
  static constexpr double i1 = 2.194e-6, i2 = 4.410e-7, i3 = 5.255e-6, i4 = 5.667e-7, i5 = 1.169e-5,
                          i6 = 5.667e-7, i7 = 1.912e-5;
  static constexpr double xa = -0.06934, ya = -0.00227, xb = -0.03635, yb = 0.03273, xc = 0.014, yc = 0.072,
                          c0 = 4530.0, l0 = 0.07785, mom = 0.033;
  static constexpr double d = 28e-3, da = 115e-4, e = 2e-2, ea = 1421e-5, rr = 7e-3, ra = 92e-5, ss = 35e-3,
                          sa = 1874e-5, sb = 1043e-5, sc = 18e-3, sd = 2e-2, ta = 2308e-5, tb = 916e-5,
                          u = 4e-2, ua = 1228e-5, ub = 449e-5, zf = 2e-2, zt = 4e-2, fa = 1421e-5;
};

/// Left and right end of the axis: xl, yl, xr, yr.
struct CarAxis {
  static constexpr double kEnd = 3.0;
  int coordinates() const { return 4; }
  int constraints() const { return 2; }

  template <class T>
  std::vector<T> force(double t, const std::vector<T>& q, const std::vector<T>& /*v*/,
                       const std::vector<T>& a) const {
    using std::sqrt;
    const double road_y = r * std::sin(w * t), road_x = std::sqrt(l * l - road_y * road_y);
    const T right_x = q[2] - road_x, right_y = q[3] - road_y;
    const T left = sqrt(T(q[0] * q[0] + q[1] * q[1]));
    const T right = sqrt(T(right_x * right_x + right_y * right_y));
    const double mass = 0.5 * m * eps * eps;
    return {T(mass * a[0] - (l0 - left) * q[0] / left), T(mass * a[1] - (l0 - left) * q[1] / left + mass * g),
            T(mass * a[2] - (l0 - right) * right_x / right),
            T(mass * a[3] - (l0 - right) * right_y / right + mass * g)};
  }
  template <class T>
  std::vector<T> constraint(const T& t, const std::vector<T>& q) const {
    using std::sin;
    using std::sqrt;
    const T road_y = r * sin(w * t), road_x = sqrt(l * l - road_y * road_y);
    return {T(road_x * q[0] + road_y * q[1]),
            T((q[0] - q[2]) * (q[0] - q[2]) + (q[1] - q[3]) * (q[1] - q[3]) - l * l)};
  }

  static std::vector<double> start() { return {0.0, l0, l, l0}; }
  static std::vector<double> start_velocity() { return {-l0 / l, 0.0, -l0 / l, 0.0}; }
  static std::vector<double> reference() {
    return {0.493455784275402809122e-1, 0.496989460230171153861, 0.104174252488542151681e+1,
            0.373911027265361256927};
  }
  static std::vector<double> reference_velocity() {
    return {-0.770583684040972357970e-1, 0.744686658723778553466e-2, 0.175568157537232222276e-1,
            0.770341043779251976443};
  }
  static constexpr double eps = 0.01, m = 10.0, l = 1.0, l0 = 0.5, r = 0.1, w = 10.0, g = 1.0;
};

}  // namespace mfs::dae::test
