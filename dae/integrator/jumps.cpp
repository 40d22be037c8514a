#include "dae/integrator/jumps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <mfs/error.hpp>

#include "dae/integrator/initial_conditions.hpp"
#include "dae/mechanics/number_text.hpp"

namespace mfs::dae {
namespace {

/// What changes in a moment of some shortest steps by more than so many times what a step may leave of a
/// constraint jumps: smooth motions would have to be faster than any machine.
constexpr double kJump = 1e3;
/// What is smooth changes by less in such a moment, in parts of the largest force or rate.
constexpr double kSmooth = 1e-6;
/// What part of the largest force changes in such a moment only where one jumps or has a pole.
constexpr double kSudden = 0.1;

/// `x` after `moment`, by its rate.
std::vector<double> moved(std::vector<double> x, const std::vector<double>& rate, double moment) {
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += moment * rate[i];
  return x;
}

/// The forces alone.
std::vector<double> forces(const ConstrainedSystem& system, double t, const std::vector<double>& q,
                           const std::vector<double>& v) {
  const std::vector<double> no_multipliers(static_cast<std::size_t>(system.constraints()), 0.0);
  const std::vector<double> no_accelerations(q.size(), 0.0);
  Residual residual = make_residual(system);
  system.evaluate({t, q.data(), v.data(), no_accelerations.data(), no_multipliers.data()}, residual);
  return residual.force;
}

std::size_t place_of_largest(const std::vector<double>& x) {
  const auto less = [](double a, double b) { return std::abs(a) < std::abs(b); };
  return static_cast<std::size_t>(std::max_element(x.begin(), x.end(), less) - x.begin());
}

/// Whether accelerations are larger than those of any machine.
bool accelerates(const State& state, double moment, const IntegratorOptions& options) {
  return largest_size(state.a) * moment > kJump * options.constraint_velocity;
}

/// What has changed by more than a part of the largest force.
std::string changed_force(const ConstrainedSystem& system, const std::vector<double>& before,
                          const std::vector<double>& after) {
  const double bound = kSudden * largest_size(before);
  for (int i = 0; i < system.coordinates(); ++i)
    if (std::abs(after[i] - before[i]) > bound)
      return "the force on " + system.coordinate_name(i) + " jumps or has a pole";
  return {};
}

/// What each constraint asks for by time alone, per unit of time.
std::vector<double> prescribed_rates(const ConstrainedSystem& system, double t,
                                     const std::vector<double>& q) {
  const std::vector<double> zero(q.size() + static_cast<std::size_t>(system.constraints()), 0.0);
  Residual at_rest = make_residual(system);
  system.evaluate({t, q.data(), zero.data(), zero.data(), zero.data()}, at_rest);
  return std::move(at_rest.velocity);
}

std::string fast_text(const std::string& name, double rate) {
  return name + " has become as fast as " + number_text(std::abs(rate)) + " per s";
}

std::string fastest_motion(const ConstrainedSystem& system, const std::vector<double>& rates,
                           double time_unit) {
  const std::size_t row = place_of_largest(rates);
  const auto j = static_cast<int>(row);
  return fast_text(system.constraint_name(j), rates[row] * system.constraint_unit(j) / time_unit);
}

/// The coordinate whose velocity is farthest from what was predicted.
std::string least_foreseen(const ConstrainedSystem& system, const std::vector<double>& v,
                           const std::vector<double>& predicted, const std::vector<double>& weights) {
  int worst = 0;
  double most = 0.0;
  for (int i = 0; i < system.coordinates(); ++i)
    if (const double off = std::abs(v[i] - predicted[i]) / weights[v.size() + i]; off > most) {
      most = off;
      worst = i;
    }
  return system.coordinate_name(worst);
}

/// What is fastest, and how fast: the motion that prescribes the largest rate, or, without any, a coordinate.
std::string find_fastest(const ConstrainedSystem& system, const State& state, double time_unit) {
  const std::vector<double> rates = prescribed_rates(system, state.t, state.q);
  if (largest_size(rates) > 0.0) return fastest_motion(system, rates, time_unit);
  const std::size_t largest = place_of_largest(state.v);
  const auto i = static_cast<int>(largest);
  const double scale = 1.0 / (system.force_unit(i) * time_unit * time_unit);
  return fast_text(system.coordinate_name(i), state.v[largest] * scale / time_unit);
}

}  // namespace

bool jumps_within(const ConstrainedSystem& system, const State& state, double moment) {
  const std::vector<double> no_multipliers(static_cast<std::size_t>(system.constraints()), 0.0);
  const std::vector<double> no_accelerations(state.q.size(), 0.0);
  StateView there{state.t, state.q.data(), state.v.data(), no_accelerations.data(), no_multipliers.data()};
  Residual before = make_residual(system), after = make_residual(system);
  system.evaluate(there, before);
  there.t += moment;
  system.evaluate(there, after);
  const auto jumps = [](const std::vector<double>& x, const std::vector<double>& y) {
    double most = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) most = std::max(most, std::abs(y[i] - x[i]));
    return most > kSmooth * std::max(largest_size(x), largest_size(y));
  };
  return jumps(before.force, after.force) || jumps(before.velocity, after.velocity) ||
         jumps(before.acceleration, after.acceleration);
}

std::string find_jump(const ConstrainedSystem& system, const State& state, double moment,
                      const IntegratorOptions& options, double time_unit) {
  const std::vector<double> no_multipliers(static_cast<std::size_t>(system.constraints()), 0.0);
  const std::vector<double> no_accelerations(state.a.size(), 0.0);  // leave F the forces alone
  StateView there{state.t, state.q.data(), state.v.data(), no_accelerations.data(), no_multipliers.data()};
  Residual before = make_residual(system), after = before;
  std::vector<double> rates;
  try {
    system.evaluate(there, before);
    there.t += moment;
    system.evaluate(there, after);
    rates = prescribed_rates(system, state.t, state.q);
  } catch (const InvalidInput& e) {
    return e.what();
  }
  for (int row = 0; row < system.constraints(); ++row) {
    const auto same = [&](const std::vector<double>& now, const std::vector<double>& then, double bound) {
      return std::abs(then[row] - now[row]) <= kJump * bound;
    };
    if (std::abs(rates[row]) * moment > kJump * options.constraint_position)
      return fast_text(system.constraint_name(row), rates[row] * system.constraint_unit(row) / time_unit);
    if (!same(before.position, after.position, options.constraint_position) ||
        !same(before.velocity, after.velocity, options.constraint_velocity) ||
        !same(before.acceleration, after.acceleration, options.constraint_acceleration))
      return system.constraint_name(row) + " jumps";
  }
  // A force that is near zero changes by as large a part of itself, but accelerates nothing like that.
  if (!accelerates(state, moment, options)) return {};
  return changed_force(system, before.force, after.force);
}

std::string find_too_fast(const ConstrainedSystem& system, double t, const std::vector<double>& q,
                          const IntegratorOptions& options, double time_unit) {
  const std::vector<double> rates = prescribed_rates(system, t, q);
  const double rounded = std::numeric_limits<double>::epsilon() * std::abs(t);
  if (!(largest_size(rates) * rounded > options.constraint_position)) return {};
  return fastest_motion(system, rates, time_unit);
}

std::string find_obstacle(const ConstrainedSystem& system, const State& state, double moment,
                          const IntegratorOptions& options, const Redundancy& redundancy,
                          const std::vector<std::string>& redundant, double time_unit) {
  std::string text = find_jump(system, state, moment, options, time_unit);
  if (text.empty()) text = redundancy.singular_start();
  if (text.empty()) text = redundancy.dead_point(state.t, state.q, redundant);
  if (text.empty()) text = find_pole(system, state, moment, options);
  if (text.empty()) text = system.most_pressed(state.q.data());
  return text.empty() ? text : "; " + text;
}

std::string find_pole(const ConstrainedSystem& system, const State& state, double moment,
                      const IntegratorOptions& options) {
  if (!accelerates(state, moment, options)) return {};
  try {
    const std::vector<double> before = forces(system, state.t, state.q, state.v);
    std::string text = changed_force(
        system, before,
        forces(system, state.t + moment, moved(state.q, state.v, moment), moved(state.v, state.a, moment)));
    if (!text.empty()) return text;
    const std::size_t largest = place_of_largest(before);
    const auto i = static_cast<int>(largest);
    return "the force on " + system.coordinate_name(i) + " has become " +
           number_text(before[largest] * system.force_unit(i));
  } catch (const InvalidInput& e) {
    return e.what();
  }
}

std::string find_what_keeps_steps_short(const ConstrainedSystem& system, const State& state,
                                        StepWatch::Verdict verdict, const std::vector<double>& predicted,
                                        const std::vector<double>& weights, double time_unit) {
  const std::string until = " until t = " + number_text(state.t * time_unit) + " s";
  if (verdict == StepWatch::Verdict::ever_faster)
    return "they have become ever shorter" + until + ", as " + find_fastest(system, state, time_unit);
  if (verdict == StepWatch::Verdict::end_too_far) return "the end is too far for steps as they are" + until;
  return "the last " + std::to_string(StepWatch::kLooksBack) + until +
         " were short, and many were tried again: a force jumps or turns about by the motion itself, on " +
         least_foreseen(system, state.v, predicted, weights);
}

}  // namespace mfs::dae
