#include "dae/integrator/initial_conditions.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include <mfs/error.hpp>
#include <mfs/solver.hpp>

#include "dae/integrator/composition.hpp"

namespace mfs::dae {
namespace {

constexpr int kMostIterations = 20;
/// Near a solution corrections shrink by at least this factor each.
constexpr double kShrinks = 0.5;
/// The shortest step on the way to a solution.
constexpr double kLeastStep = 1.0 / 1024;

Pattern diagonal(int n) {
  const std::vector<int> columns = consecutive(0, n);
  return {n, n, consecutive(0, n + 1), RawVector<int>(columns.begin(), columns.end())};
}

Pattern rows_on_velocities(const ConstrainedSystem& system) {
  Pattern pattern{system.constraints(), system.constraints(), {0}, {}};
  for (int j = 0; j < system.constraints(); ++j) {
    if (system.is_nonholonomic(j)) pattern.column.push_back(j);
    pattern.row_start.push_back(static_cast<int>(pattern.column.size()));
  }
  return pattern;
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
        nonholonomic_(rows_on_velocities(system)),
        one_(nonholonomic_.entries(), 0.0),
        transposed_(system.tangent_pattern()[Block::position_q]),
        matrix_(n_ + m_,
                {{&k_pattern_, 0, consecutive(0, n_)},
                 {&transposed_.pattern, 0, consecutive(n_, m_), transposed_.source.data()},
                 {&system.tangent_pattern()[Block::position_q], n_, consecutive(0, n_)},
                 {&nonholonomic_, n_, consecutive(n_, m_)}},
                options.threads),
        values_(matrix_.pattern().entries()),
        solver_(solver_options(options)) {}

  /// Solves with `right_side` = [n, m] for changes of positions or velocities; returns [change, mu].
  enum class Of { positions, velocities };
  std::vector<double> solve(std::vector<double> gradient, std::vector<double> right_side, Of of) {
    std::fill(one_.begin(), one_.end(), of == Of::positions ? 1.0 : 0.0);
    const Pattern& rows = system_.tangent_pattern()[Block::position_q];
    for (int j = 0; j < m_ && of == Of::positions; ++j)
      if (nonholonomic_.row_start[j] < nonholonomic_.row_start[j + 1])
        std::fill(&gradient[rows.row_start[j]], &gradient[rows.row_start[j + 1]], 0.0);
    matrix_.compose({{k_.data()}, {gradient.data()}, {gradient.data()}, {one_.data()}}, values_.data());
    const Pattern& pattern = matrix_.pattern();
    const auto name = [this](int i) {
      return i < n_ ? system_.coordinate_name(i) : system_.constraint_name(i - n_);
    };
    naming_start(name, [&] {
      solver_.factor(
          {pattern.rows, pattern.columns, pattern.row_start.data(), pattern.column.data(), values_.data()});
      solver_.solve(right_side.data(), right_side.data());
    });
    return right_side;
  }

 private:
  static Options solver_options(const IntegratorOptions& options) {
    Options chosen;
    chosen.backend = options.backend;
    chosen.threads = options.threads;
    chosen.solve.row_floor = kRowFloor;
    return chosen;
  }

  const ConstrainedSystem& system_;
  const int n_, m_;
  const std::vector<double>& k_;
  Pattern k_pattern_;
  Pattern nonholonomic_;     // a diagonal entry for each constraint on velocities
  std::vector<double> one_;  // its value
  TransposedPattern transposed_;
  Composition matrix_;
  std::vector<double> values_;
  Solver solver_;
};

StateView view(const State& state) {
  return {state.t, state.q.data(), state.v.data(), state.a.data(), state.lambda.data()};
}

/// 1 / scale^2 of all coordinates; of measures 0.
std::vector<double> weights(const ConstrainedSystem& system) {
  std::vector<double> k;
  for (int i = 0; i < system.coordinates(); ++i) {
    const double scale = system.coordinate_scale(i);
    k.push_back(system.is_measure(i) ? 0.0 : 1.0 / (scale * scale));
  }
  return k;
}

/// Moves q and v to where the constraints hold.
class StartFinder {
 public:
  StartFinder(const ConstrainedSystem& system, const IntegratorOptions& options, State& state)
      : system_(system),
        options_(options),
        state_(state),
        n_(system.coordinates()),
        m_(system.constraints()),
        weights_(weights(system)),
        residual_(make_residual(system)),
        right_side_(static_cast<std::size_t>(n_ + m_)) {}

  /// Where the given positions are far off, on a way along which all violations shrink alike, in steps that
  /// Gauss-Newton's method can follow: from afar it may find a mirrored mechanism, or none.
  void move_positions() {
    system_.evaluate(view(state_), residual_);
    given_ = residual_.position;
    double done = 0.0, step = 1.0;
    while (done < 1.0) {
      const double next = std::min(1.0, done + step);
      const std::vector<double> q = state_.q;
      if (approach(1.0 - next)) {
        done = next;
        step *= 2.0;
      } else {
        state_.q = q;
        step *= 0.5;
        if (step < kLeastStep) throw_not_met(1.0 - done);
      }
    }
  }

  void move_velocities() {
    if (largest_size(residual_.velocity) <= 1e-2 * options_.constraint_velocity) return;
    std::fill(right_side_.begin(), right_side_.end(), 0.0);
    for (int j = 0; j < m_; ++j) right_side_[n_ + j] = -residual_.velocity[j];
    const auto change = solve(SaddlePoint::Of::velocities);
    for (int i = 0; i < n_; ++i) state_.v[i] += change[i];
  }

 private:
  /// Gauss-Newton's method until Phi is `part` of what it was, near the present q; false: it does not
  /// converge as it does near a solution.
  bool approach(double part) {
    const std::vector<double> near = state_.q;
    double last = HUGE_VAL;
    for (int iteration = 0;; ++iteration) {
      system_.evaluate(view(state_), residual_);
      for (int j = 0; j < m_; ++j) right_side_[n_ + j] = part * given_[j] - residual_.position[j];
      const double violation = largest_size({right_side_.begin() + n_, right_side_.end()});
      if (violation <= 1e-2 * options_.constraint_position) return true;
      if (iteration == kMostIterations || std::isinf(violation))
        return violation <= options_.constraint_position;
      for (int i = 0; i < n_; ++i) right_side_[i] = -weights_[i] * (state_.q[i] - near[i]);
      std::vector<double> change;
      try {
        change = solve(SaddlePoint::Of::positions);
      } catch (const SingularMatrix&) {
        return false;
      } catch (const AccuracyNotReached&) {
        return false;
      }
      double size = 0.0;
      for (int i = 0; i < n_; ++i) {
        state_.q[i] += change[i];
        size += weights_[i] * change[i] * change[i];
      }
      if (iteration > 0 && violation > options_.constraint_position && !(size < kShrinks * kShrinks * last))
        return false;
      last = size;
    }
  }

  std::vector<double> solve(SaddlePoint::Of of) {
    if (!matrix_) matrix_.emplace(system_, weights_, options_);
    return matrix_->solve(constraint_gradient(system_, state_.t, state_.q), right_side_, of);
  }

  /// `left`: the part of the violations that could not be brought to zero.
  [[noreturn]] void throw_not_met(double left) const {
    const auto worst = std::max_element(given_.begin(), given_.end(),
                                        [](double a, double b) { return std::abs(a) < std::abs(b); });
    const auto row = static_cast<int>(worst - given_.begin());
    const double off = *worst * system_.constraint_unit(row);
    char text[200];
    std::snprintf(text, sizeof text,
                  "where time begins it is %.6g off, and bodies can be moved only until %.6g of that is "
                  "left, so that the others hold",
                  off, left * off);
    throw InvalidInput(system_.constraint_name(row), text);
  }

  const ConstrainedSystem& system_;
  const IntegratorOptions& options_;
  State& state_;
  const int n_, m_;
  const std::vector<double> weights_;
  Residual residual_;
  std::vector<double> right_side_, given_;
  std::optional<SaddlePoint> matrix_;  // where nothing is to be moved, there is no need of it
};

}  // namespace

double largest_size(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values) most = std::isnan(value) ? HUGE_VAL : std::max(most, std::abs(value));
  return most;
}

std::vector<double> constraint_gradient(const ConstrainedSystem& system, double t,
                                        const std::vector<double>& q) {
  const std::vector<double> zero(q.size() + static_cast<std::size_t>(system.constraints()), 0.0);
  Tangent tangent;
  tangent[Block::position_q].resize(system.tangent_pattern()[Block::position_q].entries());
  system.evaluate(StateView{t, q.data(), zero.data(), zero.data(), zero.data()}, tangent,
                  {Block::position_q});
  return std::move(tangent[Block::position_q]);
}

std::vector<double> constraint_sizes(const ConstrainedSystem& system, double t, const std::vector<double>& q,
                                     const std::vector<double>& scale) {
  const Pattern& pattern = system.tangent_pattern()[Block::position_q];
  const std::vector<double> gradient = constraint_gradient(system, t, q);
  std::vector<double> size(static_cast<std::size_t>(pattern.rows), 0.0);
  for (int row = 0; row < pattern.rows; ++row) {
    for (int k = pattern.row_start[row]; k < pattern.row_start[row + 1]; ++k)
      size[row] = std::max(size[row], std::abs(gradient[k] * scale[pattern.column[k]]));
  }
  return size;
}

void check_constraints(const ConstrainedSystem& system, const State& given) {
  const std::vector<double> zero(given.q.size() + static_cast<std::size_t>(system.constraints()), 0.0);
  Residual residual = make_residual(system);
  system.evaluate({given.t, given.q.data(), given.v.data(), zero.data(), zero.data()}, residual);
  for (int j = 0; j < system.constraints(); ++j)
    if (!std::isfinite(residual.position[j]))
      throw InvalidInput(system.constraint_name(j),
                         "it cannot be evaluated where time begins: a motion may be half a turn off");
}

State consistent_motion(const ConstrainedSystem& system, const IntegratorOptions& options, State state) {
  state.a.assign(static_cast<std::size_t>(system.coordinates()), 0.0);
  state.lambda.assign(static_cast<std::size_t>(system.constraints()), 0.0);
  if (system.constraints() > 0) {
    StartFinder start(system, options, state);
    start.move_positions();
    start.move_velocities();
  }
  return state;
}

}  // namespace mfs::dae
