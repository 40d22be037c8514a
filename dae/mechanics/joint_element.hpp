// The element of joint equations (joint_equations.hpp), with derivatives in closed form.
//
// Every equation is made of products u . w of a few vectors, of which each turns with one frame: axes of a
// and b, and d = P_b - P_a. A(p) c is quadratic in the Euler parameters, so a vector has a gradient that is
// linear and second derivatives that are constant (rotation.hpp). Along the motion q + v s + a s^2/2 vectors
// and gradients are series in s, cut after the second power, as in taylor.hpp: those of a gradient are the
// derivatives of x, x' and x''/2 by q. Automatic differentiation of the same formulas takes twenty times as
// long.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "dae/mechanics/joint_equations.hpp"
#include "dae/mechanics/single_element.hpp"

namespace mfs::dae {

/// A number x along the motion and its gradient by the N coordinates, power by power.
template <int N>
struct NumberSeries {
  std::array<double, 3> value;
  std::array<Eigen::Matrix<double, N, 1>, 3> gradient;
};

/// The same of a vector; a column of the gradient for each component.
template <int N>
struct VectorSeries {
  std::array<Eigen::Vector3d, 3> value;
  std::array<Eigen::Matrix<double, N, 3>, 3> gradient;
};

/// What an element's equations are made of, in one state.
template <int N>
class JointVectors {
 public:
  using Vector = JointEquations::Vector;
  using Hessian = Eigen::Matrix<double, N, N, Eigen::RowMajor>;

  /// Gradients are made for the first `gradients` powers.
  JointVectors(const JointEquations& equations, const LocalState& state, int gradients)
      : sides_(equations.sides()), state_(state), gradients_(gradients) {
    for (const JointEquation& equation : equations.all())
      for (const auto& [left, right] : JointEquations::products(equation)) {
        make(left);
        make(right);
      }
  }

  NumberSeries<N> product(Vector left, Vector right) const {
    const VectorSeries<N>&u = of(left), &w = of(right);
    NumberSeries<N> x;
    for (int power = 0; power < 3; ++power) {
      x.value[power] = 0.0;
      for (int k = 0; k <= power; ++k) x.value[power] += u.value[k].dot(w.value[power - k]);
    }
    for (int power = 0; power < gradients_; ++power) {
      x.gradient[power].setZero();
      for (int k = 0; k <= power; ++k) {
        x.gradient[power].noalias() += w.gradient[k] * u.value[power - k];
        if (!is_fixed(left)) x.gradient[power].noalias() += u.gradient[k] * w.value[power - k];
      }
    }
    return x;
  }

  /// Adds `factor` times the second derivatives of left . right.
  void add_hessian(double factor, Vector left, Vector right, Hessian& hessian) const {
    const VectorSeries<N>&u = of(left), &w = of(right);
    add_second(right, factor * u.value[0], hessian);
    if (is_fixed(left)) return;
    add_second(left, factor * w.value[0], hessian);
    const Hessian half = factor * u.gradient[0] * w.gradient[0].transpose();
    hessian += half + half.transpose();
  }

 private:
  static std::size_t number(Vector vector) { return static_cast<std::size_t>(vector); }
  /// Axes of the ground, the only vectors that no coordinate moves; they stand on the left.
  static bool is_fixed(Vector vector) { return vector <= Vector::ground_z; }
  const VectorSeries<N>& of(Vector vector) const { return series_[number(vector)]; }

  void make(Vector vector) {
    if (made_[number(vector)]) return;
    made_[number(vector)] = true;
    VectorSeries<N>& u = series_[number(vector)];
    for (int power = 0; power < 3; ++power) {
      u.value[power].setZero();
      if (power < gradients_) u.gradient[power].setZero();
    }
    if (is_fixed(vector)) {
      u.value[0][static_cast<Eigen::Index>(number(vector))] = 1.0;
    } else if (vector == Vector::apart) {
      add_place(sides_.b, 1.0, u);
      add_place(sides_.a, -1.0, u);
    } else {
      add_turned(side_of(vector), axis_of(vector), 1.0, u);
    }
  }

  const Side& side_of(Vector vector) const { return vector <= Vector::a_z ? sides_.a : sides_.b; }
  Eigen::Vector3d axis_of(Vector vector) const {
    const Vector first = vector <= Vector::a_z ? Vector::a_x : Vector::b_x;
    return side_of(vector).axes.col(static_cast<Eigen::Index>(number(vector) - number(first)));
  }

  /// `sign` times the place of the side's point.
  void add_place(const Side& side, double sign, VectorSeries<N>& u) const {
    add_turned(side, side.point, sign, u);
    if (side.first < 0) return;
    for (int i = 0; i < 3; ++i) {
      const int k = side.first + i;
      u.value[0][i] += sign * state_.q[k];
      u.value[1][i] += sign * state_.v[k];
      u.value[2][i] += sign * 0.5 * state_.a[k];
      u.gradient[0](k, i) += sign;
    }
  }

  /// `sign` times A(p) c.
  void add_turned(const Side& side, const Eigen::Vector3d& c, double sign, VectorSeries<N>& u) const {
    if (side.first < 0) {
      u.value[0] += sign * c;
      return;
    }
    const int first = side.first + 3;
    const Eigen::Map<const Eigen::Vector4d> p(state_.q + first), rate(state_.v + first),
        acceleration(state_.a + first);
    const RotateByP by_p = rotate_by_p(p.data(), c), by_rate = rotate_by_p(rate.data(), c);
    u.value[0].noalias() += 0.5 * sign * (by_p * p);
    u.value[1].noalias() += sign * (by_p * rate);
    u.value[2].noalias() += 0.5 * sign * (by_p * acceleration + by_rate * rate);
    u.gradient[0].template middleRows<4>(first) += sign * by_p.transpose();
    if (gradients_ < 3) return;
    u.gradient[1].template middleRows<4>(first) += sign * by_rate.transpose();
    u.gradient[2].template middleRows<4>(first) +=
        0.5 * sign * rotate_by_p(acceleration.data(), c).transpose();
  }

  /// Adds the second derivatives of weight . vector.
  void add_second(Vector vector, const Eigen::Vector3d& weight, Hessian& hessian) const {
    const auto add = [&](const Side& side, const Eigen::Vector3d& c, double sign) {
      if (side.first < 0) return;
      const int first = side.first + 3;
      hessian.template block<4, 4>(first, first) += sign * rotate_by_pp(c, weight);
    };
    if (vector != Vector::apart) return add(side_of(vector), axis_of(vector), 1.0);
    add(sides_.b, sides_.b.point, 1.0);
    add(sides_.a, sides_.a.point, -1.0);
  }

  const FramePair& sides_;
  const LocalState& state_;
  const int gradients_;
  std::array<bool, JointEquations::kVectors> made_{};
  std::array<VectorSeries<N>, JointEquations::kVectors> series_;
};

template <class Equations, int N>
class JointElement final : public SingleElement<N> {
 public:
  JointElement(std::string name, const std::array<int, N>& coordinates, Equations equations)
      : SingleElement<N>(std::move(name), coordinates), equations_(std::move(equations)) {}

  int local_constraints() const override { return equations_.count(); }
  std::string direction(int row) const override { return equations_.direction(row); }
  LocalStructure structure() const override { return {}; }
  void add_marks(const TimeSpan& span, std::vector<double>& marks) const override {
    for (const JointEquation& equation : equations_.all())
      if (equation.function) equation.function->add_marks(span, marks);
  }

  void residual(int, const LocalState& state, LocalResidual& residual) const override {
    const JointVectors<N> vectors(equations_, state, 1);
    Eigen::Map<Eigen::Matrix<double, N, 1>> force(residual.force);
    for (int i = 0; i < equations_.count(); ++i) {
      const NumberSeries<N> x = left_side(i, state.t, vectors, 1);
      residual.position[i] = x.value[0];
      residual.velocity[i] = x.value[1];
      residual.acceleration[i] = 2 * x.value[2];
      force += state.lambda[i] * x.gradient[0];
    }
  }

  void tangent(int, const LocalState& state, LocalTangent& tangent) const override {
    const bool all = tangent.asked.meets({Block::velocity_q, Block::acceleration_q, Block::acceleration_v});
    const int gradients = all ? 3 : 1;
    const JointVectors<N> vectors(equations_, state, gradients);
    using Row = Eigen::Map<Eigen::Matrix<double, N, 1>>;
    for (int i = 0; i < equations_.count(); ++i) {
      const NumberSeries<N> x = left_side(i, state.t, vectors, gradients);
      Row(tangent.position_q + i * N) = x.gradient[0];
      if (!all) continue;
      Row(tangent.velocity_q + i * N) = x.gradient[1];
      Row(tangent.acceleration_q + i * N) = 2 * x.gradient[2];
      Row(tangent.acceleration_v + i * N) = 2 * x.gradient[1];
    }
    if (!tangent.asked.has(Block::force_q)) return;
    typename JointVectors<N>::Hessian hessian = JointVectors<N>::Hessian::Zero();
    for (int i = 0; i < equations_.count(); ++i) add_hessian(i, state, vectors, hessian);
    Eigen::Map<typename JointVectors<N>::Hessian>(tangent.force_q) += hessian;
  }

 private:
  NumberSeries<N> left_side(int i, double t, const JointVectors<N>& vectors, int gradients) const {
    const JointEquation& equation = equations_.all()[static_cast<std::size_t>(i)];
    const auto products = JointEquations::products(equation);
    NumberSeries<N> x = vectors.product(products[0].first, products[0].second);
    const Jet f = equation.function ? equation.function->at(t) : Jet{};
    if (equation.kind != JointEquation::Kind::turned) {
      x.value[0] -= f.value;
      x.value[1] -= f.first;
      x.value[2] -= 0.5 * f.second;
      return x;
    }
    return turned(f, x, vectors.product(products[1].first, products[1].second), gradients);
  }

  /// Of 2 tan((x - f) / 2), from `along` = cos x and `across` = sin x: its derivatives by these two are
  /// series as well, which multiply their gradients.
  static NumberSeries<N> turned(const Jet& f, const NumberSeries<N>& along, const NumberSeries<N>& across,
                                int gradients) {
    using T = Dual<2>;
    const Taylor<T> c(T(along.value[0], 2, 0), T(along.value[1]), T(along.value[2]));
    const Taylor<T> s(T(across.value[0], 2, 1), T(across.value[1]), T(across.value[2]));
    const Taylor<T> y = JointEquations::angle(f, c, s);
    NumberSeries<N> x;
    x.value = {y.c0.value(), y.c1.value(), y.c2.value()};
    const std::array<Eigen::Vector2d, 3> by{y.c0.derivatives(), y.c1.derivatives(), y.c2.derivatives()};
    for (int power = 0; power < gradients; ++power) {
      x.gradient[power].setZero();
      for (int k = 0; k <= power; ++k)
        x.gradient[power] += by[k][0] * along.gradient[power - k] + by[k][1] * across.gradient[power - k];
    }
    return x;
  }

  void add_hessian(int i, const LocalState& state, const JointVectors<N>& vectors,
                   typename JointVectors<N>::Hessian& hessian) const {
    const JointEquation& equation = equations_.all()[static_cast<std::size_t>(i)];
    const auto products = JointEquations::products(equation);
    const double weight = state.lambda[i];
    if (equation.kind != JointEquation::Kind::turned) {
      vectors.add_hessian(weight, products[0].first, products[0].second, hessian);
      return;
    }
    using T = Dual2<2>;
    std::array<NumberSeries<N>, 2> x;
    std::array<T, 2> dual;
    for (int k = 0; k < 2; ++k) {
      x[k] = vectors.product(products[k].first, products[k].second);
      dual[k].value() = Dual<2>(x[k].value[0], 2, k);
      for (int j = 0; j < 2; ++j) dual[k].derivatives()[j] = Dual<2>(j == k ? 1.0 : 0.0);
    }
    const Jet f = equation.function ? equation.function->at(state.t) : Jet{};
    const T y = JointEquations::angle(f, dual[0], dual[1]);
    for (int k = 0; k < 2; ++k) {
      vectors.add_hessian(weight * y.value().derivatives()[k], products[k].first, products[k].second,
                          hessian);
      for (int j = 0; j < 2; ++j)
        hessian.noalias() +=
            weight * y.derivatives()[k].derivatives()[j] * x[k].gradient[0] * x[j].gradient[0].transpose();
    }
  }

  Equations equations_;
};

}  // namespace mfs::dae
