// A slider crank whose connecting rod is a beam in the plane: Simeon, Math. Modelling of Systems 2 (1996) 1,
// problem "slider crank" of the Test Set for Initial Value Problem Solvers (release 2.4), with its reference
// solution at t = 0.1 s.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "test/dae/integrator/dense_system.hpp"

namespace mfs::dae::test {

/// Coordinates: angles of crank and rod, place of the slider, then of the rod in the axes of its pins, which
/// `x` goes along from 0 to l2: q1, q2 of the deflection q1 sin(pi x / l2) + q2 sin(2 pi x / l2), and the
/// stretch of its middle and its end (quadratic between; the test set gives it 15 times the mass that it
/// has). Symbols as in the test set; m, kg, s.
struct SliderCrank {
  /// 0: the crank turns at kSpeed. Otherwise it turns by `turn` in this time, from rest to rest, by a
  /// polynomial of fifth order as smooth_step() has it.
  double duration = 0.0, turn = 0.0;
  double viscosity = 0.0;  ///< s, proportional to stiffness

  int coordinates() const { return 7; }
  int constraints() const { return 3; }

  template <class T>
  std::vector<T> force(double /*t*/, const std::vector<T>& q, const std::vector<T>& v,
                       const std::vector<T>& a) const {
    using std::cos;
    using std::sin;
    const std::vector<T> e(q.begin() + 3, q.end()), de(v.begin() + 3, v.end()), dde(a.begin() + 3, a.end());
    const T cos12 = cos(T(q[0] - q[1])), sin12 = sin(T(q[0] - q[1]));
    const T c1e = dot(c1, e), c2e = dot(c2, e);
    const std::vector<T> mass_e = times(mass, e), mass_dde = times(mass, dde), coupled = times(b, de),
                         elastic = times(stiffness, e), viscous = times(stiffness, de);
    const double rigid = 0.5 * l1 * l2 * m2;

    const T m12 = rigid * cos12 + rho * l1 * (sin12 * c2e + cos12 * c1e);
    const T m22 = j2 + dot(e, mass_e) + 2.0 * rho * dot(c12, e);
    const T f1 = v[1] * v[1] * (rho * l1 * (cos12 * c2e - sin12 * c1e) - rigid * sin12) -
                 2.0 * rho * l1 * v[1] * (cos12 * dot(c1, de) + sin12 * dot(c2, de));
    const T f2 = v[0] * v[0] * (rigid * sin12 + rho * l1 * (sin12 * c1e - cos12 * c2e)) -
                 2.0 * v[1] * (rho * dot(c12, de) + dot(de, mass_e));
    std::vector<T> rows = {T((j1 + m2 * l1 * l1) * a[0] + m12 * a[1] - f1), T(m12 * a[0] + m22 * a[1] - f2),
                           T(m3 * a[2])};
    for (int i = 0; i < 4; ++i) {
      T turned(0.0);
      for (int j = 0; j < 4; ++j) turned += e[j] * b[j][i];
      const T m1e = rho * l1 * (cos12 * c2[i] - sin12 * c1[i]), m2e = rho * (c21[i] + turned);
      rows[0] += m1e * dde[i];
      rows[1] += m2e * dde[i];
      const T centrifugal = v[1] * v[1] * (mass_e[i] + rho * c12[i]) +
                            rho * l1 * v[0] * v[0] * (cos12 * c1[i] + sin12 * c2[i]) +
                            2.0 * rho * v[1] * coupled[i];
      rows.push_back(
          T(m1e * a[0] + m2e * a[1] + mass_dde[i] - centrifugal + elastic[i] + viscosity * viscous[i]));
    }
    return rows;
  }

  template <class T>
  std::vector<T> constraint(const T& t, const std::vector<T>& q) const {
    using std::cos;
    using std::sin;
    const T length = T(l2) + q[6];
    return {T(l1 * sin(q[0]) + length * sin(q[1])), T(q[2] - l1 * cos(q[0]) - length * cos(q[1])),
            T(q[0] - angle(t))};
  }

  /// Of the crank.
  template <class T>
  T angle(const T& t) const {
    if (duration == 0) return kSpeed * t;
    const T s = (1 / duration) * t;
    return turn * (s * s * s * (10.0 - s * (15.0 - 6.0 * s)));
  }

  static constexpr double kEnd = 0.1, kSpeed = 150.0;
  /// "Close to smooth motion".
  static std::vector<double> start() {
    return {0.0, 0.0, 0.450016933, 0.0, 0.0, 0.103339863e-4, 0.169327969e-4};
  }
  static std::vector<double> start_velocity() {
    return {150.0,          -74.9957670,     -0.268938672e-5, 0.444896105,
            0.463434311e-2, -0.178591076e-5, -0.268938672e-5};
  }
  static std::vector<double> reference() {
    return {15.0,
            -3.311734987910881e-1,
            1.697373326718410e-1,
            1.893192460247178e-4,
            2.375751865617931e-5,
            -5.323907988763734e-6,
            -8.363283141616840e-6};
  }
  static std::vector<double> reference_velocity() {
    return {150.0,
            6.025346682645789e1,
            -8.753116989887888,
            -3.005536801092212e-2,
            -5.500488291932075e-3,
            4.978243404809343e-4,
            1.104933470696396e-3};
  }

  static constexpr double l1 = 0.15, l2 = 0.30, m2 = 0.151104, m3 = 0.075552, j1 = 0.002727,
                          j2 = 0.0045339259, young = 2e11, rho = 7870.0, side = 0.008;

 private:
  using Vector = std::array<double, 4>;
  using Matrix = std::array<Vector, 4>;

  static constexpr double pi = 3.1415927, area = side * side, volume = area * l2;
  static constexpr double b13 = -16.0 / (pi * pi * pi), b14 = 8.0 / (pi * pi * pi) - 1.0 / pi, b24 = 0.5 / pi;
  static constexpr Matrix b{{{0.0, 0.0, b13* volume, b14* volume},
                             {0.0, 0.0, 0.0, b24* volume},
                             {-b13 * volume, 0.0, 0.0, 0.0},
                             {-b14 * volume, -b24* volume, 0.0, 0.0}}};
  static constexpr Vector c1{0.0, 0.0, volume * 2.0 / 3.0, volume / 6.0},
      c2{volume * 2.0 / pi, 0.0, 0.0, 0.0}, c12{0.0, 0.0, l2*volume / 3.0, l2*volume / 6.0},
      c21{l2 * volume / pi, -l2*volume * 0.5 / pi, 0.0, 0.0};

  static constexpr double bending_mass = 0.5 * rho * volume, stretch_mass = rho * volume;
  static constexpr Matrix mass{{{bending_mass, 0.0, 0.0, 0.0},
                                {0.0, bending_mass, 0.0, 0.0},
                                {0.0, 0.0, 8.0 * stretch_mass, stretch_mass},
                                {0.0, 0.0, stretch_mass, 2.0 * stretch_mass}}};
  static constexpr double axial = young * area / l2,
                          bending = axial * pi * pi * pi * pi / 24.0 * (side / l2) * (side / l2);
  static constexpr Matrix stiffness{{{bending, 0.0, 0.0, 0.0},
                                     {0.0, 16.0 * bending, 0.0, 0.0},
                                     {0.0, 0.0, axial * 16.0 / 3.0, axial * -8.0 / 3.0},
                                     {0.0, 0.0, axial * -8.0 / 3.0, axial * 7.0 / 3.0}}};

  template <class A, class T>
  static T dot(const A& x, const std::vector<T>& y) {
    return T(x[0] * y[0] + x[1] * y[1] + x[2] * y[2] + x[3] * y[3]);
  }
  template <class T>
  static std::vector<T> times(const Matrix& m, const std::vector<T>& x) {
    return {dot(m[0], x), dot(m[1], x), dot(m[2], x), dot(m[3], x)};
  }
};

}  // namespace mfs::dae::test
