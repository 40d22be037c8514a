// Rotations by Euler parameters p = (e0, e1, e2, e3) = (cos(x/2), sin(x/2) axis), a unit quaternion
// (Nikravesh; Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems, chapter 9). They have no
// singular orientation; the price is a fourth number and the constraint p.p = 1. Formulas are templates over
// the scalar, so that the same ones serve for derivatives.
//
// The rotation matrix is taken in its homogeneous form A(p) s = (e0^2 - e.e) s + 2 (e.s) e + 2 e0 e x s,
// which for p.p = 1 is the usual one.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

namespace mfs::dae {

template <class T>
using Triple = std::array<T, 3>;
template <class T>
using Quadruple = std::array<T, 4>;

template <class T, class U>
T dot(const Triple<T>& x, const Triple<U>& y) {
  return T(x[0] * y[0] + x[1] * y[1] + x[2] * y[2]);
}

template <class T>
Triple<T> operator-(const Triple<T>& x, const Triple<T>& y) {
  return {T(x[0] - y[0]), T(x[1] - y[1]), T(x[2] - y[2])};
}

template <class T>
Triple<T> operator+(const Triple<T>& x, const Triple<T>& y) {
  return {T(x[0] + y[0]), T(x[1] + y[1]), T(x[2] + y[2])};
}

/// Its product with x is s x x.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& s) {
  Eigen::Matrix3d matrix;
  matrix << 0, -s[2], s[1], s[2], 0, -s[0], -s[1], s[0], 0;
  return matrix;
}

/// A(p) s.
template <class T>
Triple<T> rotate(const T* p, const Eigen::Vector3d& s) {
  const T diagonal = p[0] * p[0] - p[1] * p[1] - p[2] * p[2] - p[3] * p[3];
  const T along = s[0] * p[1] + s[1] * p[2] + s[2] * p[3];
  const T x = s[2] * p[2] - s[1] * p[3], y = s[0] * p[3] - s[2] * p[1], z = s[1] * p[1] - s[0] * p[2];
  return {T(s[0] * diagonal + 2.0 * (along * p[1] + p[0] * x)),
          T(s[1] * diagonal + 2.0 * (along * p[2] + p[0] * y)),
          T(s[2] * diagonal + 2.0 * (along * p[3] + p[0] * z))};
}

using RotateByP = Eigen::Matrix<double, 3, 4>;

/// The derivatives of A(p) s by p. They are linear in p, and A(p) s = rotate_by_p(p, s) p / 2.
inline RotateByP rotate_by_p(const double* p, const Eigen::Vector3d& s) {
  const double along = p[1] * s[0] + p[2] * s[1] + p[3] * s[2];
  RotateByP by_p;
  by_p << p[0] * s[0] + p[2] * s[2] - p[3] * s[1], along, p[1] * s[1] - s[0] * p[2] + p[0] * s[2],
      p[1] * s[2] - s[0] * p[3] - p[0] * s[1],  //
      p[0] * s[1] + p[3] * s[0] - p[1] * s[2], p[2] * s[0] - s[1] * p[1] - p[0] * s[2], along,
      p[2] * s[2] - s[1] * p[3] + p[0] * s[0],  //
      p[0] * s[2] + p[1] * s[1] - p[2] * s[0], p[3] * s[0] - s[2] * p[1] + p[0] * s[1],
      p[3] * s[1] - s[2] * p[2] - p[0] * s[0], along;
  return 2.0 * by_p;
}

/// The second derivatives of w . A(p) s by p, the same for every p.
inline Eigen::Matrix4d rotate_by_pp(const Eigen::Vector3d& s, const Eigen::Vector3d& w) {
  const double along = s.dot(w);
  Eigen::Matrix4d by_pp;
  by_pp(0, 0) = along;
  by_pp.block<3, 1>(1, 0) = s.cross(w);
  by_pp.block<1, 3>(0, 1) = by_pp.block<3, 1>(1, 0).transpose();
  by_pp.block<3, 3>(1, 1) = s * w.transpose() + w * s.transpose() - along * Eigen::Matrix3d::Identity();
  return 2.0 * by_pp;
}

/// The quaternion product x y: first the rotation y, then x.
template <class T, class U>
Quadruple<T> product(const Quadruple<T>& x, const Quadruple<U>& y) {
  return {T(x[0] * y[0] - x[1] * y[1] - x[2] * y[2] - x[3] * y[3]),
          T(x[0] * y[1] + x[1] * y[0] + x[2] * y[3] - x[3] * y[2]),
          T(x[0] * y[2] - x[1] * y[3] + x[2] * y[0] + x[3] * y[1]),
          T(x[0] * y[3] + x[1] * y[2] - x[2] * y[1] + x[3] * y[0])};
}

/// G(p) x: the 3 x 4 matrix G of w' = 2 G(p) p', angular velocity in body axes.
template <class T>
Triple<T> g_times(const T* p, const T* x) {
  return {T(p[0] * x[1] - p[1] * x[0] + p[3] * x[2] - p[2] * x[3]),
          T(p[0] * x[2] - p[2] * x[0] + p[1] * x[3] - p[3] * x[1]),
          T(p[0] * x[3] - p[3] * x[0] + p[2] * x[1] - p[1] * x[2])};
}

/// G(p)^T y.
template <class T>
Quadruple<T> g_transposed_times(const T* p, const Triple<T>& y) {
  return {T(-(p[1] * y[0] + p[2] * y[1] + p[3] * y[2])), T(p[0] * y[0] - p[3] * y[1] + p[2] * y[2]),
          T(p[3] * y[0] + p[0] * y[1] - p[1] * y[2]), T(p[1] * y[1] - p[2] * y[0] + p[0] * y[2])};
}

/// The Euler parameters of a rotation matrix, e0 >= 0.
inline Eigen::Vector4d euler_parameters(const Eigen::Matrix3d& rotation) {
  const Eigen::Quaterniond q = Eigen::Quaterniond(rotation).normalized();
  const Eigen::Vector4d p(q.w(), q.x(), q.y(), q.z());
  return p[0] < 0 ? Eigen::Vector4d(-p) : p;
}

}  // namespace mfs::dae
