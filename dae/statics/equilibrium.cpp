#include "dae/statics/equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <mfs/error.hpp>

#include "dae/integrator/initial_conditions.hpp"
#include "dae/integrator/scaled_system.hpp"
#include "dae/integrator/time_unit.hpp"
#include "dae/mechanics/number_text.hpp"
#include "dae/statics/constrained_matrix.hpp"
#include "dae/statics/independent_system.hpp"
#include "dae/statics/instability.hpp"
#include "dae/statics/modes.hpp"

namespace mfs::dae {
namespace {

/// And so many more for each body that turns: a chain that stands on its head comes down link by link, in
/// some eight steps each (docs/experiments/statics.md).
constexpr int kMostSteps = 300, kMostOfEach = 12;
/// The longest step, in ranges of coordinates (Euler parameters: a third of a turn at most), and the one that
/// s is chosen for.
constexpr double kLongest = 0.3, kAim = 0.24;
/// They are so much shorter after a search that ended where what is left out does not hold, as longer steps
/// may lead to another solution of the constraints that are kept; so many times.
constexpr double kShorter = 0.25;
constexpr int kMostShorter = 2;
/// Steps that are still so many times as long after s has grown do not depend on it.
constexpr double kUnchanged = 0.7;
/// Of the last step; steps converge quadratically in the end.
constexpr double kConverged = 1e-9;
/// Steps that are as short and do not get shorter are rounding.
constexpr double kRounding = 1e-6;
/// What s grows by at least and at most where a step does not succeed.
constexpr double kSlower = 3.0, kMuchSlower = 10.0;
/// s, over the square of the unit of time: at first, and between a period of ten minutes, which is that of no
/// mechanism, and what stiff springs and small masses have.
constexpr double kFirst = 1.0, kLeast = 1e-4, kMost = 1e16;
/// Unstable equilibria that are left.
constexpr int kMostEscapes = 20;
/// How far along the motion that grows, in ranges of coordinates, and s there, in squares of its rate: below
/// 1 a step would lead back.
constexpr double kEscape = 0.02, kEscapeRate = 2.0;
/// A kappa (instability.hpp) is rounding that is this part of the square of the rate of forces where the
/// search began, or of s where it ended: multipliers that hold nothing are s M times the last step.
constexpr double kPartOfForces = 1e-10, kPartOfEnd = 1e-12;
/// Modes that are looked at where forces have no potential; one grows where that is this part of its rate.
constexpr int kModes = 10;
constexpr double kGrows = 1e-5;
/// Searches with other constraints left out.
constexpr int kMostRanks = 4;
/// What has moved by less, in ranges, is where it was given.
constexpr double kAsGiven = 1e-6;

double dot(const std::vector<double>& x, const std::vector<double>& y) {
  double sum = 0.0;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) sum += x[i] * y[i];
  return sum;
}

bool all_finite(const std::vector<double>& x) {
  return std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
}

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

class Search {
 public:
  /// `part`: of the longest steps, what they are at most.
  Search(const ConstrainedSystem& system, const IntegratorOptions& options, State& state,
         EquilibriumReport& report, double part)
      : system_(system),
        options_(options),
        longest_(part * kLongest),
        aim_(part * kAim),
        n_(system.coordinates()),
        m_(system.constraints()),
        state_(state),
        report_(report),
        matrix_(system, options.threads, options.backend),
        rest_(static_cast<std::size_t>(n_), 0.0),
        residual_(make_residual(system)),
        tangent_(make_tangent(system)),
        most_(kMostSteps) {
    for (int row = 0; row < m_; ++row)
      if (system.is_normalization(row)) most_ += kMostOfEach;
  }

  /// false: no equilibrium has been found (why_not()).
  bool run(const std::function<bool()>& go_on) {
    project();
    const double time = time_unit_at_rest(system_, state_.t, state_.q);
    per_square_ = 1.0 / (time * time);
    rate_ = rate_at_rest(system_, state_.t, state_.q);
    if (report_.begin.empty()) report_.begin = state_.q;
    s_ = kFirst * std::max(1.0, per_square_);
    return come_to_rest(go_on);
  }

  std::string why_not() const {
    return "no static equilibrium has been found in " + std::to_string(report_.iterations) +
           " steps: " + system_.coordinate_name(moves_most_) + " moves most, by " +
           number_text(report_.last_step) + " in the last one" + what_rolls() + what_is_pressed();
  }

  /// Leaves unstable equilibria, as far as it can, after run().
  void leave_unstable(const std::function<bool()>& go_on) {
    for (; !report_.stopped; ++report_.escapes) {
      const Stability stability = examine(go_on);
      if (stability.may_swing) look_among_modes(stability.rounding, go_on);
      if (!stability.growing) return;
      const UnstableMotion& motion = *stability.growing;
      tell(motion.rate, [&](int i) { return std::abs(motion.x[i]); });
      report_.as_given = reach_of(state_.q, report_.begin) < kAsGiven;
      if (report_.as_given || report_.escapes == kMostEscapes || !leave(motion, go_on)) return;
    }
  }

 private:
  StateView view(const State& state) const {
    return {state.t, state.q.data(), rest_.data(), rest_.data(), state.lambda.data()};
  }

  /// From state_; false: no equilibrium has been found.
  bool come_to_rest(const std::function<bool()>& go_on) {
    least_ = kLeast * std::min(1.0, per_square_);
    before_ = too_long_ = HUGE_VAL;
    is_tangent_there_ = false;
    system_.evaluate(view(state_), residual_);
    for (int steps = 0; steps < most_; ++steps) {
      ++report_.iterations;
      report_.stopped = go_on && !go_on();
      if (report_.stopped) {
        finish();
        return true;
      }
      if (!step()) {
        s_ *= std::clamp(1.5 * reach_ / aim_, kSlower, kMuchSlower);
        if (s_ > kMost * std::max(1.0, per_square_)) return false;
        continue;
      }
      const bool slow = s_ > least_;
      s_ = std::max({least_, reach_ / aim_ * s_, s_ / kMuchSlower});
      const bool at_rounding = report_.last_step < kRounding && report_.last_step > 0.5 * before_;
      before_ = report_.last_step;
      if (!slow && (report_.last_step < kConverged || at_rounding)) {
        finish();
        return true;
      }
    }
    return false;
  }

  Stability examine(const std::function<bool()>& go_on) {
    system_.evaluate(view(state_), tangent_,
                     {Block::force_q, Block::force_v, Block::force_a, Block::position_q});
    const double rounding = std::max(kPartOfForces * rate_ * rate_, kPartOfEnd * s_);
    return examine_rest({system_, tangent_, residual_.force, rounding}, matrix_, go_on);
  }

  /// `rounding`: 1/time^2, the square of a rate that may be 0.
  void look_among_modes(double rounding, const std::function<bool()>& go_on) {
    std::vector<Mode> modes;
    try {
      modes =
          find_modes(system_, state_, kModes, options_.threads, Damping::as_it_is, go_on, options_.backend);
    } catch (const Error&) {  // where they are not found nothing is known
      return;
    }
    for (const Mode& mode : modes) {
      if (!(mode.s.real() > std::max(kGrows * std::abs(mode.s), report_.growth)) ||
          !(std::norm(mode.s) > rounding))
        continue;
      tell(mode.s.real(), [&](int i) { return std::abs(mode.x[i]); });
      report_.is_mode = true;
      report_.swings = mode.s.imag();
    }
  }

  /// Takes a step along it and comes to rest elsewhere. Where that fails the state is as before.
  bool leave(const UnstableMotion& motion, const std::function<bool()>& go_on) {
    const State unstable = state_;
    const EquilibriumReport there = report_;
    const double reach = reach_of(motion.x);
    for (const double way : {kEscape, -kEscape}) {
      state_ = unstable;
      for (int i = 0; i < n_; ++i) state_.q[i] += way / reach * motion.x[i];
      s_ = std::max(kFirst * std::max(1.0, per_square_), kEscapeRate * motion.rate * motion.rate);
      try {
        if (come_to_rest(go_on)) {
          report_.growth = 0.0;
          report_.grows_most.clear();
          return true;
        }
      } catch (const InvalidInput&) {  // as of springs whose ends come together, on this side
      } catch (const SingularMatrix&) {
      }
    }
    state_ = unstable;
    system_.evaluate(view(state_), residual_);
    const int iterations = report_.iterations;
    report_ = there;
    report_.iterations = iterations;
    return false;
  }

  /// Of a motion that grows by `rate`, with |x_i|.
  template <class Sizes>
  void tell(double rate, const Sizes& x) {
    const auto size = [&](int i) { return x(i) / system_.coordinate_scale(i); };
    int most = 0;
    for (int i = 0; i < n_; ++i)
      if (size(i) > size(most)) most = i;
    report_.growth = rate;
    report_.grows_most = system_.coordinate_name(most);
  }

  /// Why a wheel has none, whose leaning nothing but its motion holds up; empty: nothing rolls.
  std::string what_rolls() const {
    for (int row = 0; row < m_; ++row)
      if (system_.is_nonholonomic(row))
        return "; what rolls (" + system_.constraint_owner(row) +
               ") may be held up by its motion alone, and falls over or rolls away at rest";
    return "";
  }

  std::string what_is_pressed() const {
    const std::string pressed = system_.most_pressed(state_.q.data());
    return pressed.empty() ? pressed : "; " + pressed;
  }

  void project() {
    State moved = consistent_motion(system_, options_, {state_.t, state_.q, rest_, {}, {}});
    state_.q = std::move(moved.q);
  }

  /// Whether it has succeeded.
  bool step() {
    reach_ = HUGE_VAL;
    if (!is_tangent_there_) {
      system_.evaluate(view(state_), tangent_, {Block::force_q, Block::force_a, Block::position_q});
      is_tangent_there_ = true;
    }
    std::vector<double> change;
    try {
      matrix_.factor(tangent_, {s_, 0.0, 1.0});
      change = matrix_.solve(right_side());
    } catch (const SingularMatrix&) {
      return not_solved();
    } catch (const AccuracyNotReached&) {
      return not_solved();
    }
    if (!all_finite(change)) return false;
    find_largest(change);
    double reach = reach_of(change);
    if (reach > longest_) {
      // What mends the constraints does not become shorter with a larger s, so a part of it is taken.
      if (!(reach > kUnchanged * std::exchange(too_long_, reach))) {
        reach_ = reach;
        return false;
      }
      for (double& each : change) each *= aim_ / reach;
      reach = aim_;
    }
    too_long_ = HUGE_VAL;
    State trial{state_.t, state_.q, {}, {}, state_.lambda};
    for (int i = 0; i < n_; ++i) trial.q[i] += change[i];
    for (int j = 0; j < m_; ++j) trial.lambda[j] += change[n_ + j];
    Residual residual = make_residual(system_);
    try {
      system_.evaluate(view(trial), residual);
    } catch (const InvalidInput&) {  // as of springs whose ends come together
      return false;
    }
    if (!all_finite(residual.force) || !all_finite(residual.position)) return false;
    if (report_.last_step > kRounding && !(work_of(change) > 0)) return false;
    std::swap(state_, trial);
    residual_ = std::move(residual);
    is_tangent_there_ = false;
    reach_ = reach;
    return true;
  }

  /// Of all forces along a step, less what it takes to mend the constraints against their multipliers at its
  /// end.
  double work_of(const std::vector<double>& change) const {
    double work = -dot(change, residual_.force);
    for (int j = 0; j < m_; ++j) work += change[n_ + j] * residual_.position[j];
    return work;
  }

  /// Near the equilibrium, where a free motion has no stiffness, s stays larger.
  bool not_solved() {
    if (before_ < kRounding) least_ = 10 * s_;
    return false;
  }

  std::vector<double> right_side() const {
    std::vector<double> right_side(static_cast<std::size_t>(n_ + m_));
    for (int i = 0; i < n_; ++i) right_side[i] = -residual_.force[i];
    for (int j = 0; j < m_; ++j) right_side[n_ + j] = -residual_.position[j];
    return right_side;
  }

  void find_largest(const std::vector<double>& change) {
    report_.last_step = 0.0;
    for (int i = 0; i < n_; ++i) {
      const double size = std::abs(change[i]) / system_.coordinate_scale(i);
      if (size > report_.last_step) {
        report_.last_step = size;
        moves_most_ = i;
      }
    }
  }

  double reach_of(const std::vector<double>& change) const {
    const std::vector<double> range = system_.ranges(state_.q.data());
    double reach = 0.0;
    for (int i = 0; i < n_; ++i) reach = std::max(reach, std::abs(change[i]) / range[i]);
    return reach;
  }
  double reach_of(std::vector<double> to, const std::vector<double>& from) const {
    for (int i = 0; i < n_; ++i) to[i] -= from[i];
    return reach_of(to);
  }

  void finish() {
    const bool holds = largest(residual_.position) <= options_.constraint_position;
    if (!holds && !report_.stopped) project();
    system_.evaluate(view(state_), residual_);
    report_.force = largest(residual_.force);
    state_.v = state_.a = rest_;
  }

  const ConstrainedSystem& system_;
  const IntegratorOptions& options_;
  const double longest_, aim_;
  const int n_, m_;
  State& state_;
  EquilibriumReport& report_;
  ConstrainedMatrix matrix_;
  const std::vector<double> rest_;
  Residual residual_;  // of state_
  Tangent tangent_;    // of state_, where is_tangent_there_
  bool is_tangent_there_ = false;
  int most_;                              // steps
  double per_square_ = 1.0, rate_ = 0.0;  // of the unit of time and of forces, where the search began
  double s_ = 0.0, least_ = 0.0;
  double before_ = HUGE_VAL;  // the accepted step before
  int moves_most_ = 0;
  double too_long_ = HUGE_VAL;  // the step before in ranges, where that was rejected for its length
  double reach_ = 0.0;  // of the last step, in ranges; infinite: it was rejected, and not for its length
};

/// Searches without what follows from other constraints where the search begins. That may be less where it
/// ends, if it begins in a singular position, and more if it ends in one; then it goes on with what is so
/// there.
class SearchByRank {
 public:
  SearchByRank(const ConstrainedSystem& system, const IntegratorOptions& options, State& state,
               EquilibriumReport& report)
      : independent_(system, state.t, state.q),
        options_(options),
        begun_(state),
        state_(state),
        report_(report) {
    at_rest_.constraint_velocity = at_rest_.constraint_acceleration = HUGE_VAL;  // those of no motion
  }

  State run(const std::function<bool()>& go_on) {
    for (int left = kMostRanks;; --left) {
      state_.lambda.assign(static_cast<std::size_t>(independent_.system().constraints()), 0.0);
      Search search(independent_.system(), options_, state_, report_, part_);
      if (!search.run(go_on)) {
        if (left == 0 || !leave_out_more()) throw Error(search.why_not());
        continue;
      }
      // In a singular position motions that only constraints of second order hold up would count as unstable.
      if (!is_singular_) search.leave_unstable(go_on);
      if (report_.stopped || holds(left == 0)) return independent_.whole(std::move(state_));
    }
  }

 private:
  bool leave_out_more() {
    auto found = independent_.look_for_singular(state_.t, state_.q);
    if (!found) return false;
    is_singular_ = true;
    independent_.leave_out(std::move(*found));
    return true;
  }

  /// Whether what is left out does; false: less is left out from now on, or the search begins again with
  /// shorter steps. Throws InvalidInput where it does not and cannot, or where `is_last`.
  bool holds(bool is_last) {
    const std::vector<double> none(state_.q.size(), 0.0);
    const StateView there{state_.t, state_.q.data(), none.data(), none.data(), state_.lambda.data()};
    try {
      independent_.check(there, at_rest_);
      return true;
    } catch (const InvalidInput&) {
      Dependencies found = independent_.find(state_.t, state_.q);
      if (is_last) throw;
      if (found.redundant().size() >= independent_.redundant().size()) {
        if (shortened_++ == kMostShorter) throw;
        part_ *= kShorter;
        state_ = begun_;
        is_singular_ = false;
        independent_.leave_out(independent_.find(state_.t, state_.q));
        return false;
      }
      is_singular_ = false;
      independent_.leave_out(std::move(found));
      return false;
    }
  }

  IndependentSystem independent_;
  const IntegratorOptions& options_;
  const State begun_;
  double part_ = 1.0;  // of the longest steps
  int shortened_ = 0;
  IntegratorOptions at_rest_ = options_;
  State& state_;
  EquilibriumReport& report_;
  bool is_singular_ = false;  // where more is left out than around it
};

}  // namespace

State find_equilibrium(const ConstrainedSystem& system, const IntegratorOptions& options, State state,
                       EquilibriumReport* report, const std::function<bool()>& go_on) {
  EquilibriumReport own;
  EquilibriumReport& told = report ? *report : own;
  told = {};
  const auto n = static_cast<std::size_t>(system.coordinates());
  if (state.q.size() != n) throw InvalidInput("q0", "it has not one number for each coordinate");
  if (ScaledSystem::is_needed(system)) {
    const ScaledSystem scaled(system, state.t, state.q);
    state = scaled.unscaled(find_equilibrium(scaled, options, scaled.scaled(std::move(state)), &told, go_on));
    told.begin = scaled.unscaled({state.t, std::move(told.begin), {}, {}, {}}).q;
    Residual residual = make_residual(system);
    system.evaluate({state.t, state.q.data(), state.v.data(), state.a.data(), state.lambda.data()}, residual);
    told.force = largest(residual.force);
    return state;
  }
  return SearchByRank(system, options, state, told).run(go_on);
}

}  // namespace mfs::dae
