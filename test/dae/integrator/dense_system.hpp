// Small systems for the tests, written as their equations: a model says what its constraints are and what its
// equations of motion are without multipliers; all derivatives come by automatic differentiation, of first
// order in q, v, a (Eigen's AutoDiffScalar) and of second order in time (Taylor polynomials).
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <unsupported/Eigen/AutoDiff>

#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae::test {

/// x + d1 s + d2 s^2 / 2 + ..., up to second order in s.
template <class T>
struct Taylor {
  T x, d1 = T(0.0), d2 = T(0.0);
  Taylor(double value = 0.0) : x(value) {}  // NOLINT: numbers are polynomials
  Taylor(T x_, T d1_, T d2_) : x(std::move(x_)), d1(std::move(d1_)), d2(std::move(d2_)) {}
};

template <class T>
Taylor<T> operator+(const Taylor<T>& a, const Taylor<T>& b) {
  return {T(a.x + b.x), T(a.d1 + b.d1), T(a.d2 + b.d2)};
}
template <class T>
Taylor<T> operator-(const Taylor<T>& a, const Taylor<T>& b) {
  return {T(a.x - b.x), T(a.d1 - b.d1), T(a.d2 - b.d2)};
}
template <class T>
Taylor<T> operator*(const Taylor<T>& a, const Taylor<T>& b) {
  return {T(a.x * b.x), T(a.d1 * b.x + a.x * b.d1), T(a.d2 * b.x + 2.0 * a.d1 * b.d1 + a.x * b.d2)};
}
template <class T>
Taylor<T> operator*(double a, const Taylor<T>& b) {
  return Taylor<T>(a) * b;
}
template <class T>
Taylor<T> operator-(const Taylor<T>& a, double b) {
  return a - Taylor<T>(b);
}
template <class T>
Taylor<T> operator-(double a, const Taylor<T>& b) {
  return Taylor<T>(a) - b;
}
/// f(a), where f, f', f'' are the values at a.x.
template <class T>
Taylor<T> chain(const Taylor<T>& a, const T& f, const T& f1, const T& f2) {
  return {f, T(f1 * a.d1), T(f2 * a.d1 * a.d1 + f1 * a.d2)};
}
template <class T>
Taylor<T> sin(const Taylor<T>& a) {
  using std::cos;
  using std::sin;
  return chain(a, T(sin(a.x)), T(cos(a.x)), T(-sin(a.x)));
}
template <class T>
Taylor<T> cos(const Taylor<T>& a) {
  using std::cos;
  using std::sin;
  return chain(a, T(cos(a.x)), T(-sin(a.x)), T(-cos(a.x)));
}
template <class T>
Taylor<T> sqrt(const Taylor<T>& a) {
  using std::sqrt;
  const T root = sqrt(a.x);
  return chain(a, root, T(0.5 / root), T(-0.25 / (root * a.x)));
}

/// Model: int coordinates() const, int constraints() const and, for any scalar T,
///   std::vector<T> force(double t, q, v, a) const    M a - Q, with std::vector<T> q, v, a
///   std::vector<T> constraint(T t, q) const          Phi
template <class Model>
class DenseSystem : public ConstrainedSystem {
 public:
  explicit DenseSystem(Model model = {}) : model_(std::move(model)) {
    const int n = coordinates(), m = constraints();
    for (std::size_t b = 0; b < kBlocks; ++b) {
      const bool of_constraints = b >= static_cast<std::size_t>(Block::position_q);
      pattern_.block[b] = dense(of_constraints ? m : n, n);
    }
  }

  int coordinates() const override { return model_.coordinates(); }
  int constraints() const override { return model_.constraints(); }
  const TangentPattern& tangent_pattern() const override { return pattern_; }

  void evaluate(const StateView& state, Residual& residual) const override {
    const Sides<double> sides = evaluate_as<double>(state, [](double value, int) { return value; });
    residual = {sides.force, sides.position, sides.velocity, sides.acceleration};
  }

  void evaluate(const StateView& state, Tangent& tangent, BlockSet blocks) const override {
    using Ad = Eigen::AutoDiffScalar<Eigen::VectorXd>;
    const int n = coordinates();
    const Sides<Ad> sides = evaluate_as<Ad>(state, [n](double value, int i) { return Ad(value, 3 * n, i); });
    const auto fill = [&](const std::vector<Ad>& rows, int first, Block block) {
      if (!blocks.has(block)) return;
      auto value = tangent[block].begin();
      for (const Ad& row : rows)
        for (int j = 0; j < n; ++j, ++value)
          *value = row.derivatives().size() > 0 ? row.derivatives()[first + j] : 0.0;
    };
    fill(sides.force, 0, Block::force_q);
    fill(sides.force, n, Block::force_v);
    fill(sides.force, 2 * n, Block::force_a);
    fill(sides.position, 0, Block::position_q);
    fill(sides.velocity, 0, Block::velocity_q);
    fill(sides.acceleration, 0, Block::acceleration_q);
    fill(sides.acceleration, n, Block::acceleration_v);
  }

 private:
  template <class T>
  struct Sides {
    std::vector<T> force, position, velocity, acceleration;
  };

  static Pattern dense(int rows, int columns) {
    Pattern pattern{rows, columns, {0}, {}};
    for (int i = 0; i < rows; ++i) {
      for (int j = 0; j < columns; ++j) pattern.column.push_back(j);
      pattern.row_start.push_back(static_cast<int>(pattern.column.size()));
    }
    return pattern;
  }

  /// `variable(value, k)`: the k-th of the 3 n variables [q, v, a].
  template <class T, class Variable>
  Sides<T> evaluate_as(const StateView& state, const Variable& variable) const {
    const int n = coordinates(), m = constraints();
    std::vector<T> q, v, a;
    for (int i = 0; i < n; ++i) {
      q.push_back(variable(state.q[i], i));
      v.push_back(variable(state.v[i], n + i));
      a.push_back(variable(state.a[i], 2 * n + i));
    }
    Sides<T> sides;
    sides.force = model_.force(state.t, q, v, a);
    // Along the motion.
    std::vector<Taylor<T>> path;
    for (int i = 0; i < n; ++i) path.emplace_back(q[i], v[i], a[i]);
    for (const Taylor<T>& phi : model_.constraint(Taylor<T>(T(state.t), T(1.0), T(0.0)), path)) {
      sides.position.push_back(phi.x);
      sides.velocity.push_back(phi.d1);
      sides.acceleration.push_back(phi.d2);
    }
    // Along each coordinate.
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) path[j] = Taylor<T>(q[j], T(i == j ? 1.0 : 0.0), T(0.0));
      const auto phi = model_.constraint(Taylor<T>(state.t), path);
      for (int k = 0; k < m; ++k) {
        const T share = phi[k].d1 * state.lambda[k];  // without derivatives, where the constraint is linear
        sides.force[i] += share;
      }
    }
    return sides;
  }

  Model model_;

 protected:
  TangentPattern pattern_;
};

}  // namespace mfs::dae::test
