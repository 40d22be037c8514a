#include "dae/integrator/initial_conditions.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include <mfs/error.hpp>
#include <mfs/solver.hpp>

#include "dae/integrator/composition.hpp"

namespace mfs::dae {
namespace {

constexpr int kMostIterations = 20;

Pattern diagonal(int n) {
  const std::vector<int> columns = consecutive(0, n);
  return {n, n, consecutive(0, n + 1), RawVector<int>(columns.begin(), columns.end())};
}

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values) most = std::isnan(value) ? HUGE_VAL : std::max(most, std::abs(value));
  return most;
}

/// The matrix above.
class SaddlePoint {
 public:
  SaddlePoint(const ConstrainedSystem& system, const std::vector<double>& k, const IntegratorOptions& options)
      : system_(system),
        n_(system.coordinates()),
        m_(system.constraints()),
        k_(k),
        k_pattern_(diagonal(n_)),
        transposed_(system.tangent_pattern()[Block::position_q]),
        matrix_(n_ + m_,
                {{&k_pattern_, 0, consecutive(0, n_)},
                 {&transposed_.pattern, 0, consecutive(n_, m_), transposed_.source.data()},
                 {&system.tangent_pattern()[Block::position_q], n_, consecutive(0, n_)}},
                options.threads),
        values_(matrix_.pattern().entries()),
        solver_(solver_options(options)) {}

  /// Solves with `right_side` = [n, m]; returns [change, mu].
  std::vector<double> solve(const std::vector<double>& gradient, std::vector<double> right_side) {
    matrix_.compose({{k_.data()}, {gradient.data()}, {gradient.data()}}, values_.data());
    const Pattern& pattern = matrix_.pattern();
    try {
      solver_.factor(
          {pattern.rows, pattern.columns, pattern.row_start.data(), pattern.column.data(), values_.data()});
      solver_.solve(right_side.data(), right_side.data());
    } catch (SingularMatrix& e) {
      const auto i = static_cast<int>(e.column());
      if (i >= 0)
        e.append(" (initial conditions: " +
                 (i < n_ ? system_.coordinate_name(i) : system_.constraint_name(i - n_)) + ")");
      throw;
    }
    return right_side;
  }

 private:
  static Options solver_options(const IntegratorOptions& options) {
    Options chosen;
    chosen.backend = options.backend;
    chosen.threads = options.threads;
    return chosen;
  }

  const ConstrainedSystem& system_;
  const int n_, m_;
  const std::vector<double>& k_;
  Pattern k_pattern_;
  TransposedPattern transposed_;
  Composition matrix_;
  std::vector<double> values_;
  Solver solver_;
};

StateView view(const State& state) {
  return {state.t, state.q.data(), state.v.data(), state.a.data(), state.lambda.data()};
}

/// 1 / scale^2 of all coordinates.
std::vector<double> inverse_squares(const ConstrainedSystem& system) {
  std::vector<double> k;
  for (int i = 0; i < system.coordinates(); ++i)
    k.push_back(1.0 / (system.coordinate_scale(i) * system.coordinate_scale(i)));
  return k;
}

[[noreturn]] void throw_not_met(const ConstrainedSystem& system, const std::vector<double>& phi) {
  const auto worst = std::max_element(
      phi.begin(), phi.end(), [](double a, double b) { return std::isnan(b) || std::abs(a) < std::abs(b); });
  throw InvalidInput("q0", "no coordinates near the given ones fulfil the constraints: " +
                               system.constraint_name(static_cast<int>(worst - phi.begin())) + " leaves " +
                               std::to_string(*worst));
}

/// Moves q and v to where the constraints hold.
void project(const ConstrainedSystem& system, const IntegratorOptions& options, State& state) {
  const int n = system.coordinates(), m = system.constraints();
  const std::vector<double> k = inverse_squares(system), q0 = state.q;
  std::optional<SaddlePoint> matrix;  // where nothing is to be moved, there is no need of it
  const auto solve = [&](const std::vector<double>& right_side) {
    if (!matrix) matrix.emplace(system, k, options);
    return matrix->solve(constraint_gradient(system, state.t, state.q), right_side);
  };
  Residual residual = make_residual(system);
  std::vector<double> right_side(static_cast<std::size_t>(n + m));
  for (int iteration = 0;; ++iteration) {
    system.evaluate(view(state), residual);
    const double violation = largest(residual.position);
    if (violation <= 1e-2 * options.constraint_position) break;
    if (iteration == kMostIterations || std::isinf(violation)) {
      if (violation <= options.constraint_position) break;
      throw_not_met(system, residual.position);
    }
    for (int i = 0; i < n; ++i) right_side[i] = -k[i] * (state.q[i] - q0[i]);
    for (int j = 0; j < m; ++j) right_side[n + j] = -residual.position[j];
    const auto change = solve(right_side);
    for (int i = 0; i < n; ++i) state.q[i] += change[i];
  }
  if (largest(residual.velocity) > 1e-2 * options.constraint_velocity) {
    std::fill(right_side.begin(), right_side.end(), 0.0);
    for (int j = 0; j < m; ++j) right_side[n + j] = -residual.velocity[j];
    const auto change = solve(right_side);
    for (int i = 0; i < n; ++i) state.v[i] += change[i];
  }
}

}  // namespace

std::vector<double> constraint_gradient(const ConstrainedSystem& system, double t,
                                        const std::vector<double>& q) {
  const std::vector<double> zero(q.size() + static_cast<std::size_t>(system.constraints()), 0.0);
  Tangent tangent;
  tangent[Block::position_q].resize(system.tangent_pattern()[Block::position_q].entries());
  system.evaluate(StateView{t, q.data(), zero.data(), zero.data(), zero.data()}, tangent,
                  {Block::position_q});
  return std::move(tangent[Block::position_q]);
}

State consistent_motion(const ConstrainedSystem& system, const IntegratorOptions& options, State state) {
  state.a.assign(static_cast<std::size_t>(system.coordinates()), 0.0);
  state.lambda.assign(static_cast<std::size_t>(system.constraints()), 0.0);
  if (system.constraints() > 0) project(system, options, state);
  return state;
}

}  // namespace mfs::dae
