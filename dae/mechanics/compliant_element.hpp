// Springs and dampers: groups of one element that answers to its deformations, given by formulas as those of
// single_element.hpp.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "dae/mechanics/integral.hpp"
#include "dae/mechanics/single_element.hpp"

namespace mfs::dae {

/// What a deformation is answered with, and its derivatives by the deformation and by its rate.
struct Reaction {
  double force = 0.0, stiffness = 0.0, damping = 0.0;
};

/// Formulas of one deformation, of which a function tells the elastic part of the reaction.
struct SpringLaw {
  double free, damping;
  Function force;  // of the deformation over `free`

  int count() const { return 1; }
  Reaction reaction(double, int, double x, double rate) const {
    const Jet elastic = force->slope(x - free);
    return {elastic.value + damping * rate, elastic.first, damping};
  }
  double energy(int, double x) const { return integral(*force, 0.0, x - free); }
};

/// The law of a spring along a step. Its argument is the deformation or, of a length, the square: that is a
/// parabola where the ends move straight and evenly, and constant where they turn about each other.
template <class Formulas, int N>
class WatchedLaw final : public WatchedFunction {
 public:
  WatchedLaw(const std::array<int, N>& coordinates, Formulas formulas)
      : coordinates_(coordinates), formulas_(std::move(formulas)) {}

  Arguments arguments(const double* q, const double* v) const override {
    std::array<double, N> q_own, v_own, rest{};
    for (int k = 0; k < N; ++k) {
      q_own[k] = q[coordinates_[k]];
      v_own[k] = v[coordinates_[k]];
    }
    const Taylor<double> x =
        along_motion<N>(formulas_, {0.0, q_own.data(), v_own.data(), rest.data(), nullptr})[0];
    const Taylor<double> argument = Formulas::kIsLength ? x * x : x;
    return {{argument.c0}, {argument.c1}};
  }
  void enclose(const Interval&, const Interval* arguments, const Interval*,
               std::vector<Interval>& results) const override {
    const Interval x = Formulas::kIsLength ? sqrt(*arguments) : *arguments;
    formulas_.force->enclose(x - formulas_.free, results);
  }
  std::vector<int> changing_operations() const override { return formulas_.force->changing_operations(); }
  bool compares(int operation) const override { return formulas_.force->compares(operation); }
  double range(int operation) const override { return formulas_.force->range(operation); }

 private:
  std::array<int, N> coordinates_;
  Formulas formulas_;
};

/// Forces that answer to deformations x(t, q): by virtual work F = sum_i reaction_i x_i,q. Beside what
/// autodiff.hpp asks for, Formulas has `Reaction reaction(double t, int i, double x, double rate) const`,
/// of which the part that does not depend on the rate is elastic, and `double energy(int i, double x) const`.
template <class Formulas, int N>
class CompliantElement final : public SingleElement<N> {
 public:
  CompliantElement(std::string name, const std::array<int, N>& coordinates, Formulas formulas)
      : SingleElement<N>(std::move(name), coordinates), formulas_(std::move(formulas)) {}

  LocalStructure structure() const override {
    LocalStructure structure;
    structure.force_v = LocalStructure::Kind::dense;
    return structure;
  }

  void residual(int, const LocalState& state, LocalResidual& residual) const override {
    const auto x = along_motion<N>(formulas_, state);
    std::array<double, kMostFormulas> force{};
    for (int i = 0; i < formulas_.count(); ++i)
      force[i] = formulas_.reaction(state.t, i, x[i].c0, x[i].c1).force;
    add_gradient<N>(formulas_, state.t, state.q, force.data(), residual.force);
  }

  void tangent(int, const LocalState& state, LocalTangent& tangent) const override {
    const auto x = along_motion_with_gradients<N>(formulas_, state);
    std::array<double, kMostFormulas> force{};
    for (int i = 0; i < formulas_.count(); ++i) {
      const Reaction reaction = formulas_.reaction(state.t, i, x[i].c0.value(), x[i].c1.value());
      const auto &by_q = x[i].c0.derivatives(), &rate_by_q = x[i].c1.derivatives();
      force[i] = reaction.force;
      for (int k = 0; k < N; ++k)
        for (int j = 0; j < N; ++j) {
          tangent.force_q[k * N + j] +=
              by_q[k] * (reaction.stiffness * by_q[j] + reaction.damping * rate_by_q[j]);
          tangent.force_v[k * N + j] += by_q[k] * reaction.damping * by_q[j];
        }
    }
    add_hessian<N>(formulas_, state.t, state.q, force.data(), tangent.force_q);
  }

  Energy energy(int, const LocalState& state) const override {
    Energy energy;
    const auto x = along_motion<N>(formulas_, state);
    for (int i = 0; i < formulas_.count(); ++i) energy.elastic += formulas_.energy(i, x[i].c0);
    return energy;
  }

  void add_watched(WatchedFunctions& functions) const override {
    if constexpr (std::is_base_of_v<SpringLaw, Formulas>)
      functions.push_back(std::make_shared<WatchedLaw<Formulas, N>>(this->own(), formulas_));
  }

  Power power(int, const LocalState& state) const override {
    const auto x = along_motion<N>(formulas_, state);
    Power power;
    for (int i = 0; i < formulas_.count(); ++i) {
      const double rate = x[i].c1, force = formulas_.reaction(state.t, i, x[i].c0, rate).force;
      power.dissipated += (force - formulas_.reaction(state.t, i, x[i].c0, 0.0).force) * rate;
    }
    return power;
  }

 private:
  Formulas formulas_;
};

}  // namespace mfs::dae
