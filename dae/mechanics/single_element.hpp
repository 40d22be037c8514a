// Groups of one element made of formulas, as a spring or a measure. The formulas are given once; all
// derivatives come from autodiff.hpp. Of those that most mechanisms consist of, joints (joint_element.hpp)
// and rigid bodies (rigid_body.cpp), derivatives are in closed form.
#pragma once

#include <array>
#include <string>
#include <utility>

#include "dae/mechanics/autodiff.hpp"
#include "dae/mechanics/element_group.hpp"

namespace mfs::dae {

/// One element of N coordinates.
template <int N>
class SingleElement : public ElementGroup {
 public:
  SingleElement(std::string name, const std::array<int, N>& coordinates)
      : name_(std::move(name)), coordinates_(coordinates) {}

  int size() const override { return 1; }
  int local_coordinates() const override { return N; }
  const int* coordinates(int) const override { return coordinates_.data(); }
  std::string name(int) const override { return name_; }

 protected:
  const std::array<int, N>& own() const { return coordinates_; }

 private:
  std::string name_;
  std::array<int, N> coordinates_;
};

/// Constraints x(t, q) = 0. Beside what autodiff.hpp asks for, Formulas has the names of
/// ElementGroup::direction and kNormalizes for ElementGroup::normalizes. With g = (Phi_q v + Phi_t) the
/// derivative of d^2/dt^2 Phi by v is 2 g_q.
template <class Formulas, int N>
class ConstraintElement final : public SingleElement<N> {
 public:
  ConstraintElement(std::string name, const std::array<int, N>& coordinates, Formulas formulas)
      : SingleElement<N>(std::move(name), coordinates), formulas_(std::move(formulas)) {}

  int local_constraints() const override { return formulas_.count(); }
  std::string direction(int row) const override { return formulas_.direction(row); }
  bool normalizes() const override { return Formulas::kNormalizes; }
  LocalStructure structure() const override { return {}; }

  void residual(int, const LocalState& state, LocalResidual& residual) const override {
    const auto x = along_motion<N>(formulas_, state);
    for (int i = 0; i < formulas_.count(); ++i) {
      residual.position[i] = x[i].c0;
      residual.velocity[i] = x[i].c1;
      residual.acceleration[i] = 2 * x[i].c2;
    }
    add_gradient<N>(formulas_, state.t, state.q, state.lambda, residual.force);
  }

  void tangent(int, const LocalState& state, LocalTangent& tangent) const override {
    if (!tangent.asked.meets(kAllButPositions)) return add_gradients(state, tangent.position_q);
    const auto x = along_motion_with_gradients<N>(formulas_, state);
    for (int i = 0; i < formulas_.count(); ++i)
      for (int k = 0; k < N; ++k) {
        tangent.position_q[i * N + k] = x[i].c0.derivatives()[k];
        tangent.velocity_q[i * N + k] = x[i].c1.derivatives()[k];
        tangent.acceleration_q[i * N + k] = 2 * x[i].c2.derivatives()[k];
        tangent.acceleration_v[i * N + k] = 2 * x[i].c1.derivatives()[k];
      }
    add_hessian<N>(formulas_, state.t, state.q, state.lambda, tangent.force_q);
  }

 private:
  static constexpr BlockSet kAllButPositions{Block::force_q, Block::velocity_q, Block::acceleration_q,
                                             Block::acceleration_v};
  void add_gradients(const LocalState& state, double* position_q) const {
    const std::array<Dual<N>, N> q = seeded<N>(state.q);
    std::array<Dual<N>, kMostFormulas> x;
    formulas_.positions(state.t, q.data(), x.data());
    for (int i = 0; i < formulas_.count(); ++i)
      for (int k = 0; k < N; ++k) position_q[i * N + k] += x[i].derivatives()[k];
  }

  Formulas formulas_;
};

/// Constraints on velocities x(t, q, v) = A(q) v + b(t, q) = 0: Formulas has count() and direction() as above
/// and `template <class T> void rates(double t, const T* q, const T* v, T* x) const`.
template <class Formulas, int N>
class VelocityConstraintElement final : public SingleElement<N> {
 public:
  VelocityConstraintElement(std::string name, const std::array<int, N>& coordinates, Formulas formulas)
      : SingleElement<N>(std::move(name), coordinates), formulas_(std::move(formulas)) {}

  int local_constraints() const override { return formulas_.count(); }
  std::string direction(int row) const override { return formulas_.direction(row); }
  bool is_nonholonomic() const override { return true; }
  LocalStructure structure() const override { return {}; }

  void residual(int, const LocalState& state, LocalResidual& residual) const override {
    std::array<Taylor<double>, N> q, v;
    std::array<Dual<N>, N> q_now, v_now = seeded<N>(state.v);
    for (int k = 0; k < N; ++k) {
      q[k] = {state.q[k], state.v[k], 0.5 * state.a[k]};
      v[k] = {state.v[k], state.a[k], 0.0};
      q_now[k] = Dual<N>(state.q[k]);
    }
    std::array<Taylor<double>, kMostFormulas> x;
    std::array<Dual<N>, kMostFormulas> by_v;
    formulas_.rates(state.t, q.data(), v.data(), x.data());
    formulas_.rates(state.t, q_now.data(), v_now.data(), by_v.data());
    for (int i = 0; i < formulas_.count(); ++i) {
      residual.velocity[i] = x[i].c0;
      residual.acceleration[i] = x[i].c1;
      for (int k = 0; k < N; ++k) residual.force[k] += state.lambda[i] * by_v[i].derivatives()[k];
    }
  }

  void tangent(int, const LocalState& state, LocalTangent& tangent) const override {
    using T = Dual<2 * N>;
    std::array<Taylor<T>, N> q, v;
    for (int k = 0; k < N; ++k) {
      const T q_k(state.q[k], 2 * N, k), v_k(state.v[k], 2 * N, N + k);
      q[k] = {q_k, v_k, T(0.5 * state.a[k])};
      v[k] = {v_k, T(state.a[k]), T(0.0)};
    }
    std::array<Taylor<T>, kMostFormulas> x;
    formulas_.rates(state.t, q.data(), v.data(), x.data());
    for (int i = 0; i < formulas_.count(); ++i)
      for (int k = 0; k < N; ++k) {
        tangent.position_q[i * N + k] = x[i].c0.derivatives()[N + k];
        tangent.velocity_q[i * N + k] = x[i].c0.derivatives()[k];
        tangent.acceleration_q[i * N + k] = x[i].c1.derivatives()[k];
        tangent.acceleration_v[i * N + k] = x[i].c1.derivatives()[N + k];
      }
    add_force_tangent(state, tangent.force_q);
  }

 private:
  /// Column k of A is x with unit velocity v_k, less x at rest.
  void add_force_tangent(const LocalState& state, double* force_q) const {
    const std::array<Dual<N>, N> q = seeded<N>(state.q);
    std::array<Dual<N>, N> v;
    v.fill(Dual<N>(0.0));
    std::array<Dual<N>, kMostFormulas> x, at_rest;
    formulas_.rates(state.t, q.data(), v.data(), at_rest.data());
    for (int k = 0; k < N; ++k) {
      v[k] = Dual<N>(1.0);
      formulas_.rates(state.t, q.data(), v.data(), x.data());
      v[k] = Dual<N>(0.0);
      for (int i = 0; i < formulas_.count(); ++i)
        for (int j = 0; j < N; ++j)
          force_q[k * N + j] += state.lambda[i] * (x[i].derivatives()[j] - at_rest[i].derivatives()[j]);
    }
  }

  Formulas formulas_;
};

}  // namespace mfs::dae
