// Derivatives of a few formulas x(t, q) of positions: the equations of a joint, the deformations of a spring.
// They are written once, as
//
//   struct Formulas {
//     int count() const;                                               // at most kMostFormulas
//     template <class T> void positions(double t, const T* q, T* x) const;
//   };
//
// where functions of time enter by AlongTime<T>::of(f.at(t)), and are evaluated with the scalar that brings
// the derivatives wanted: Taylor series in time (taylor.hpp), dual numbers for gradients (Eigen's
// AutoDiffScalar), series of dual numbers for gradients of x' and x'', dual numbers of dual numbers for
// second derivatives. N is the number of coordinates.
#pragma once

#include <array>
#include <unsupported/Eigen/AutoDiff>

#include "dae/mechanics/element_group.hpp"
#include "dae/mechanics/taylor.hpp"

namespace mfs::dae {

constexpr int kMostFormulas = 6;

template <int N>
using Dual = Eigen::AutoDiffScalar<Eigen::Matrix<double, N, 1>>;
template <int N>
using Dual2 = Eigen::AutoDiffScalar<Eigen::Matrix<Dual<N>, N, 1>>;

template <int N>
std::array<Dual<N>, N> seeded(const double* q) {
  std::array<Dual<N>, N> dual;
  for (int k = 0; k < N; ++k) dual[k] = Dual<N>(q[k], N, k);
  return dual;
}

/// x, x' and x'' / 2 along the motion of `state`.
template <int N, class Formulas>
std::array<Taylor<double>, kMostFormulas> along_motion(const Formulas& formulas, const LocalState& state) {
  std::array<Taylor<double>, N> q;
  for (int k = 0; k < N; ++k) q[k] = {state.q[k], state.v[k], 0.5 * state.a[k]};
  std::array<Taylor<double>, kMostFormulas> x;
  formulas.positions(state.t, q.data(), x.data());
  return x;
}

/// The same, each with its gradient by q.
template <int N, class Formulas>
std::array<Taylor<Dual<N>>, kMostFormulas> along_motion_with_gradients(const Formulas& formulas,
                                                                       const LocalState& state) {
  const std::array<Dual<N>, N> dual = seeded<N>(state.q);
  std::array<Taylor<Dual<N>>, N> q;
  for (int k = 0; k < N; ++k) q[k] = {dual[k], Dual<N>(state.v[k]), Dual<N>(0.5 * state.a[k])};
  std::array<Taylor<Dual<N>>, kMostFormulas> x;
  formulas.positions(state.t, q.data(), x.data());
  return x;
}

/// Adds the gradient of sum_i weight[i] x_i to `gradient` (N).
template <int N, class Formulas>
void add_gradient(const Formulas& formulas, double t, const double* q, const double* weight,
                  double* gradient) {
  const std::array<Dual<N>, N> dual = seeded<N>(q);
  std::array<Dual<N>, kMostFormulas> x;
  formulas.positions(t, dual.data(), x.data());
  for (int i = 0; i < formulas.count(); ++i)
    for (int k = 0; k < N; ++k) gradient[k] += weight[i] * x[i].derivatives()[k];
}

/// Adds the second derivatives of sum_i weight[i] x_i to `hessian` (N x N).
template <int N, class Formulas>
void add_hessian(const Formulas& formulas, double t, const double* q, const double* weight, double* hessian) {
  const std::array<Dual<N>, N> inner = seeded<N>(q);
  std::array<Dual2<N>, N> dual;
  for (int k = 0; k < N; ++k) {
    dual[k].value() = inner[k];
    for (int j = 0; j < N; ++j) dual[k].derivatives()[j] = Dual<N>(j == k ? 1.0 : 0.0);
  }
  std::array<Dual2<N>, kMostFormulas> x;
  formulas.positions(t, dual.data(), x.data());
  for (int i = 0; i < formulas.count(); ++i)
    for (int k = 0; k < N; ++k)
      for (int j = 0; j < N; ++j) hessian[k * N + j] += weight[i] * x[i].derivatives()[k].derivatives()[j];
}

}  // namespace mfs::dae
