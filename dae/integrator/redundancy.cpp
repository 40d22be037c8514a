#include "dae/integrator/redundancy.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <mfs/error.hpp>

#include "dae/integrator/initial_conditions.hpp"
#include "dae/integrator/jumps.hpp"
#include "dae/mechanics/number_text.hpp"
#include "dae/mechanics/turning_bodies.hpp"

namespace mfs::dae {
namespace {

/// Redundant constraints are only as exact as those that they follow from: their violation may be so many
/// times as large.
constexpr double kInexact = 100.0;
/// How far, in the scales of coordinates, a motion is followed to see whether its position is singular: then
/// more than that is left of a constraint, and what follows everywhere is off by the square alone.
constexpr double kBeside = 1e-2;
/// Constraints hold there to that, and a constraint of which more is left did follow in that position alone.
constexpr double kExact = 1e-10, kLeftBeside = 1e-5;
/// What accelerations move bodies by in a moment that is nothing, in the scales of coordinates.
constexpr double kStays = 1e-14;
/// What a way from rest may violate, in parts of the terms that cancel each other on a way out.
constexpr double kOffTheWay = 1e-6;
/// What bodies are off a way when they have left a singular position, in parts of what is left of the
/// constraint that comes back: 4e-4 on one where a thousandth is left, as its curvature shows.
constexpr double kBesideTheWay = 1e-2;
/// What is left of it then, if the motion is on a way: more of it determines velocities better. Where the
/// push is weak the motion without it is off the way by more the more is left, as accelerations are off in
/// proportion to it: by a hundredth of 1e-4, or a tenth. So it comes back where the second part is off.
constexpr double kNextToStart = 1e-4, kDrifts = 2e-3;
/// What is left where bodies are looked at first, at least and at most, and what has to be left at the start
/// of that step.
constexpr double kFirstLook[] = {1e-5, 2e-5}, kBlind = 1e-6;
/// Where a motion leaves a singular position constraints hold to this part of their bounds, as so little is
/// left of one of them that determines a velocity, but not below rounding.
constexpr double kLeaveSingular = 1e-3, kRoundedPosition = 1e-14;
/// A constraint takes part in a contradiction if its share is at least this part of the largest.
constexpr double kTakesPart = 1e-6;
/// How many of them an error message names.
constexpr std::size_t kMostNamed = 6;
constexpr const char* kLevels[] = {"position", "velocity", "acceleration"};

double largest_in(const std::vector<double>& x, const std::vector<double>& scale) {
  double most = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) most = std::max(most, std::abs(x[i]) / scale[i]);
  return most;
}

/// The first of `rows` that is none of the others.
std::optional<int> first_beside(const std::vector<int>& rows, const std::vector<int>& others) {
  for (const int row : rows)
    if (std::find(others.begin(), others.end(), row) == others.end()) return row;
  return std::nullopt;
}

/// With bounds of constraints that are less than local errors, as those of Newton's method: what is left out
/// in a singular position drifts without any bound of its own, at first by less than the given ones.
IntegratorOptions within_local_errors(IntegratorOptions options) {
  options.constraint_position = std::min(options.constraint_position, 0.1 * options.atol_position);
  options.constraint_velocity = std::min(options.constraint_velocity, 0.1 * options.atol_velocity);
  return options;
}

/// What a combination leaves of these values without that of `row`: where it is zero, that of `row` at most.
double left_by_others(const SparseRow& combination, int row, const std::vector<double>& values) {
  double sum = 0.0;
  for (const auto& [other, share] : combination)
    if (other != row) sum += std::abs(share * values[other]);
  return sum;
}

double largest_share(const SparseRow& combination) {
  double most = 0.0;
  for (const auto& entry : combination) most = std::max(most, std::abs(entry.second));
  return most;
}

}  // namespace

Redundancy::Redundancy(const ConstrainedSystem& system, std::vector<double> scale, double time_unit)
    : given_(system), scale_(std::move(scale)), time_unit_(time_unit) {
  for (int row = 0; row < system.constraints(); ++row)
    normalizes_.push_back(system.is_normalization(row) ? 1 : 0);
  for (int row = 0; row < system.constraints(); ++row)
    nonholonomic_.push_back(system.is_nonholonomic(row) ? 1 : 0);
}

const ConstrainedSystem& Redundancy::system() const {
  return filtered_ ? static_cast<const ConstrainedSystem&>(*filtered_) : given_;
}

std::vector<std::string> Redundancy::names() const {
  std::vector<std::string> names;
  for (const int row : redundant()) names.push_back(given_.constraint_name(row));
  return names;
}

Dependencies Redundancy::find(double t, const std::vector<double>& q, double nothing) const {
  return {given_.tangent_pattern()[Block::position_q],
          constraint_gradient(given_, t, q),
          scale_,
          normalizes_,
          nonholonomic_,
          nothing};
}

void Redundancy::check(const StateView& state, const IntegratorOptions& options) const {
  if (const auto violated = violation(state, options, left_out_)) throw_contradiction(*violated, state.t);
}

void Redundancy::check_start(const StateView& state, const IntegratorOptions& options, double moment,
                             const Accelerations& accelerations) {
  begun_with_ = redundant();
  const auto violated = violation(state, options, left_out_);
  if (!violated) {
    const std::vector<double> way = way_from_rest(state, options, moment, accelerations);
    const auto of_state = [&](const double* x) { return std::vector<double>(x, x + given_.coordinates()); };
    is_in_singular_ =
        singular_row(state.t, of_state(state.q), way.empty() ? of_state(state.v) : way).has_value();
    if (is_in_singular_ && !way.empty()) check_way(state, way);
    if (!is_in_singular_) only_here_ = row_of_here_only(state, options);
    is_in_singular_ = is_in_singular_ || only_here_;
    return;
  }
  // Of what follows everywhere accelerations do where positions and velocities do.
  const bool singular = violated->level == 2;
  const char* const note =
      ": the position is singular, and on none of the ways out of it bodies have these velocities; give them "
      "those of the way that is meant, or begin a little beside it";
  throw_contradiction(*violated, state.t, singular ? note : "");
}

std::optional<int> Redundancy::row_of_here_only(const StateView& state, IntegratorOptions options) const {
  options.constraint_position = kExact;
  State beside{state.t, {state.q, state.q + given_.coordinates()}, {}, {}, {}};
  beside.v.resize(beside.q.size());
  for (std::size_t i = 0; i < beside.q.size(); ++i)
    beside.q[i] += kBeside * scale_[i] * std::sin(static_cast<double>(i + 1));
  try {
    beside = consistent_motion(system(), options, std::move(beside));
  } catch (const Error&) {  // so far off nothing is known
    return std::nullopt;
  }
  return needed_in(find(beside.t, beside.q, kLeftBeside));
}

std::optional<int> Redundancy::needed_in(const Dependencies& there) const {
  if (there.redundant().size() >= redundant().size()) return std::nullopt;
  return first_beside(redundant(), there.redundant());
}

std::optional<int> Redundancy::singular_row(double t, const std::vector<double>& q,
                                            const std::vector<double>& way) const {
  std::vector<double> beside = q;
  const double most = largest_in(way, scale_);
  if (!(most > 0.0)) return std::nullopt;
  for (std::size_t i = 0; i < beside.size(); ++i) beside[i] += kBeside / most * way[i];
  return needed_in(find(t, beside, kNearlySingular));
}

std::vector<double> Redundancy::way_from_rest(const StateView& state, const IntegratorOptions& options,
                                              double moment, const Accelerations& accelerations) const {
  const Pattern& pattern = given_.tangent_pattern()[Block::position_q];
  std::vector<char> takes_part(static_cast<std::size_t>(given_.coordinates()), 0);
  for (std::size_t k = 0; k < redundant().size(); ++k)
    for (const auto& [row, share] : left_out_.combination(k))
      for (int e = pattern.row_start[row]; e < pattern.row_start[row + 1]; ++e)
        takes_part[pattern.column[e]] = 1;
  const auto part_of = [&](std::vector<double> x) {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] *= takes_part[i];
    return x;
  };
  const auto moves = [&](const std::vector<double>& a) {
    return largest_in(a, scale_) * moment * moment > kStays;
  };
  const std::size_t n = takes_part.size();
  if (largest_in(part_of({state.v, state.v + n}), scale_) > options.constraint_velocity) return {};
  std::vector<double> way = part_of({state.a, state.a + n});
  if (!moves(way)) way = part_of(accelerations(state.t + moment));
  return moves(way) ? way : std::vector<double>();
}

// Of a combination c that is zero, c^T Phi = t^4 / 2 c^T Phi_qq x x + ..., and Phi_qq x x is the part of the
// accelerations of constraints that is quadratic in velocities.
void Redundancy::check_way(const StateView& state, const std::vector<double>& x) const {
  const std::vector<double> none(x.size() + static_cast<std::size_t>(given_.constraints()), 0.0);
  const double most = largest_in(x, scale_);
  const auto accelerations = [&](double factor) {
    std::vector<double> v = x;
    for (double& each : v) each *= factor / most;
    Residual residual = make_residual(given_);
    given_.evaluate({state.t, state.q, v.data(), none.data(), none.data()}, residual);
    return residual.acceleration;
  };
  const std::vector<double> there = accelerations(1.0), back = accelerations(-1.0), rest = accelerations(0.0);
  for (std::size_t k = 0; k < redundant().size(); ++k) {
    double sum = 0.0, terms = 0.0;
    for (const auto& [row, share] : left_out_.combination(k)) {
      const double term = share * (0.5 * (there[row] + back[row]) - rest[row]);
      sum += term;
      terms += std::abs(term);
    }
    if (std::abs(sum) <= std::max(kOffTheWay * terms, kStays)) continue;
    const int row = redundant()[k];
    throw InvalidInput(given_.constraint_name(row),
                       "where time begins the position is singular, as it follows from " +
                           others_of(row, left_out_.combination(k)) +
                           ", and bodies are at rest: forces and motions push them on none of the ways out "
                           "of it; begin a little beside it, on the way that is meant");
  }
}

State Redundancy::brought_back(State state, const IntegratorOptions& options) const {
  const auto brought = moved_to_way(system(), state, options);
  if (only_here_ && (!brought || is_off(state, *brought, kBesideTheWay, redundant().size())))
    throw_off_the_way(find(state.t, state.q, kNearlySingular), state.t);
  return brought ? *brought : std::move(state);
}

std::optional<State> Redundancy::moved_to_way(const ConstrainedSystem& system, const State& state,
                                              IntegratorOptions options) const {
  const double most = kLeaveSingular * options.constraint_position;
  options.constraint_velocity = 0.0;  // one linear system, whatever is left of them
  for (double bound = kRoundedPosition; bound <= std::max(most, kRoundedPosition); bound *= 10.0) {
    options.constraint_position = bound;
    try {
      return consistent_motion(system, options, state);
    } catch (const InvalidInput&) {  // it is off the way, or so little is left that rounding is more
    }
  }
  return std::nullopt;
}

bool Redundancy::is_off(const State& state, const State& moved, double part, std::size_t redundant) const {
  double distance = 0.0;
  for (std::size_t i = 0; i < scale_.size(); ++i)
    distance = std::max(distance, std::abs(moved.q[i] - state.q[i]) / scale_[i]);
  return find(state.t, moved.q, distance / part).redundant().size() > redundant;
}

bool Redundancy::is_off(const State& state, const IntegratorOptions& options, double part,
                        const Dependencies& kept_but) const {
  const IndependentConstraints system(given_, kept_but.redundant());
  const auto moved = moved_to_way(system, state, options);
  return !moved || is_off(state, *moved, part, kept_but.redundant().size());
}

void Redundancy::throw_off_the_way(const Dependencies& found, double t) const {
  for (std::size_t k = 0; k < found.redundant().size(); ++k) {
    const int row = found.redundant()[k];
    if (std::find(redundant().begin(), redundant().end(), row) != redundant().end()) continue;
    throw InvalidInput(given_.constraint_name(row),
                       "where time begins the position is singular, as there it follows from " +
                           others_of(row, found.combination(k)) +
                           ": until t = " + number_text(t * time_unit_) +
                           " forces and motions have pushed bodies on none of the ways out of it; begin a "
                           "little beside it, on the way that is meant");
  }
}

std::string Redundancy::singular_start() const {
  std::optional<int> needed = only_here_;
  if (begun_with_.size() > redundant().size()) needed = first_beside(begun_with_, redundant());
  if (!needed) return {};
  return "where time began, " + given_.constraint_name(*needed) +
         " followed from others, as it does not later: a singular position leaves open how bodies go on; "
         "begin a little beside it";
}

// As a mechanism turns, other rows of a joint, which are along ground axes, become those that follow. Near
// where they change, the rows that are kept determine badly what is left out: the state is a little off, so
// that exactly nothing follows there, and what is left out is off by more than its share when it was chosen.
// A motion that begins in a singular position cannot do without what is left out there for long, but near it
// that would determine nothing exactly.
std::optional<Dependencies> Redundancy::look_at(const StateView& there, const IntegratorOptions& options) {
  if (redundant().empty()) return std::nullopt;
  auto violated = violation(there, options, left_out_);
  const bool drifts =
      is_in_singular_ && !only_here_ && violation(there, within_local_errors(options), left_out_);
  if (!violated && !may_be_singular_ && !is_in_singular_) return std::nullopt;
  const std::vector<double> q(there.q, there.q + given_.coordinates());
  Dependencies exact = find(there.t, q), found = choose(exact, there.t, q);
  if (only_here_ && found.redundant().size() >= redundant().size()) {
    Dependencies first = find(there.t, q, kFirstLook[0]);
    if (first.redundant().size() < redundant().size() &&
        is_off({there.t, q, {there.v, there.v + q.size()}, {}, {}}, options, kDrifts, first))
      found = std::move(first);
  }
  const bool as_many = found.redundant().size() == redundant().size();
  if (violated && as_many) {
    if (found.redundant() != redundant()) return found;
    violated = violation(there, options, found);
  }
  const bool fewer = exact.redundant().size() < redundant().size();
  if (violated && !fewer) {
    const std::string too_fast = find_too_fast(given_, there.t, q, options, time_unit_);
    const std::string dead = dead_point(there.t, q, names());
    throw_contradiction(*violated, there.t,
                        !too_fast.empty() ? ", as " + too_fast
                        : dead.empty()    ? ""
                                          : "; " + dead);
  }
  if (violated)
    found = std::move(exact);
  else if (drifts && fewer && found.redundant().size() >= redundant().size())
    found = find(there.t, q, kFirstLook[0]);
  may_be_singular_ = fewer && found.redundant().size() >= redundant().size();
  if (!fewer || may_be_singular_) return std::nullopt;
  has_left_singular_ = std::exchange(is_in_singular_, false);
  return found;
}

bool Redundancy::leaves_blindly(double t, const std::vector<double>& q, const StateView& there,
                                const IntegratorOptions& options, const Dependencies& found) {
  if (!only_here_ || !has_left_singular_) return false;
  const auto follows_more = [&](double at, const std::vector<double>& where, double nothing) {
    return find(at, where, nothing).redundant().size() > found.redundant().size();
  };
  State arrived{there.t, {there.q, there.q + q.size()}, {there.v, there.v + q.size()}, {}, {}};
  // What is off later may have been on the way where it could be looked at first.
  if (!follows_more(t, q, kBlind) &&
      (follows_more(there.t, arrived.q, kFirstLook[1]) || !is_off(arrived, options, kBesideTheWay, found)))
    return false;
  has_left_singular_ = false;
  is_in_singular_ = true;
  return true;
}

Dependencies Redundancy::choose(Dependencies exact, double t, const std::vector<double>& q) const {
  if (exact.redundant().size() >= redundant().size()) return exact;
  return find(t, q, only_here_ ? kNextToStart : kNearlySingular);
}

Dependencies Redundancy::choose(double t, const std::vector<double>& q) const {
  return choose(find(t, q), t, q);
}

void Redundancy::leave_out(Dependencies found) {
  left_out_ = std::move(found);
  if (filtered_ || !redundant().empty()) filtered_.emplace(given_, redundant());
}

std::optional<Dependencies> Redundancy::look_for_singular(double t, const std::vector<double>& q) {
  Dependencies found = find(t, q, kNearlySingular);
  if (found.redundant().size() <= redundant().size()) return std::nullopt;
  is_in_singular_ = true;
  only_here_.reset();
  return found;
}

std::vector<double> Redundancy::all_multipliers(const std::vector<double>& kept) const {
  std::vector<double> all = kept;
  for (const int row : redundant()) all.insert(all.begin() + row, 0.0);
  return all;
}

std::vector<double> Redundancy::kept_multipliers(std::vector<double> all) const {
  left_out_.make_basic(all);
  std::vector<double> kept;
  auto out = redundant().begin();
  for (int row = 0; row < given_.constraints(); ++row) {
    if (out != redundant().end() && *out == row)
      ++out;
    else
      kept.push_back(all[row]);
  }
  return kept;
}

State Redundancy::whole(State state) const {
  if (redundant().empty()) return state;
  state.lambda = all_multipliers(state.lambda);
  find(state.t, state.q).make_least(state.lambda, units_of_forces(state));
  return state;
}

/// Least are the forces of the model, of which multipliers are multiples where it is seen in other units, and
/// the forces at the arm of its largest body that make moments: so they are the same in all units of length.
std::vector<double> Redundancy::units_of_forces(const State& state) const {
  const Pattern& pattern = given_.tangent_pattern()[Block::position_q];
  const std::vector<double> gradient = constraint_gradient(given_, state.t, state.q);
  const auto moves_places = [&](int row) {
    for (int k = pattern.row_start[row]; k < pattern.row_start[row + 1]; ++k)
      if (gradient[k] != 0 && is_length_of(given_, pattern.column[k])) return true;
    return false;
  };
  const double arm = largest_body_of(given_);
  std::vector<double> units;
  for (int row = 0; row < given_.constraints(); ++row)
    units.push_back(
        normalizes_[row] != 0 ? 0.0 : 1.0 / (given_.constraint_unit(row) * (moves_places(row) ? 1.0 : arm)));
  return units;
}

std::optional<Redundancy::Violation> Redundancy::violation(const StateView& state,
                                                           const IntegratorOptions& options,
                                                           const Dependencies& by) const {
  if (redundant().empty()) return std::nullopt;
  const std::vector<double> no_multipliers(static_cast<std::size_t>(given_.constraints()), 0.0);
  StateView all = state;
  all.lambda = no_multipliers.data();
  Residual residual = make_residual(given_);
  given_.evaluate(all, residual);
  const auto find = [&](const std::vector<double>& values, double bound,
                        int level) -> std::optional<Violation> {
    for (std::size_t k = 0; k < redundant().size(); ++k) {
      const int row = redundant()[k];
      const double value = values[row], allowed = largest_share(by.combination(k)) * bound;
      // In a step of 1e-14 s rounding of velocities leaves as much of accelerations of those that are kept.
      const double kept = left_by_others(by.combination(k), row, values);
      if (!(std::abs(value) <= kInexact * std::max(allowed, kept))) return Violation{row, level, value};
    }
    return std::nullopt;
  };
  if (auto found = find(residual.position, options.constraint_position, 0)) return found;
  if (auto found = find(residual.velocity, options.constraint_velocity, 1)) return found;
  return find(residual.acceleration, options.constraint_acceleration, 2);
}

std::string Redundancy::nearly_redundant(double t, const std::vector<double>& q,
                                         const std::vector<std::string>& usual, double left) const {
  const Dependencies found = find(t, q, left);
  if (found.redundant().size() <= usual.size()) return {};
  for (std::size_t k = found.redundant().size(); k-- > 0;) {
    const int row = found.redundant()[k];
    const std::string name = given_.constraint_name(row);
    if (std::find(usual.begin(), usual.end(), name) == usual.end())
      return name + " nearly follows from " + others_of(row, found.combination(k));
  }
  return {};
}

std::string Redundancy::others_of(int row, SparseRow shares) const {
  const double least = kTakesPart * largest_share(shares);
  std::stable_sort(shares.begin(), shares.end(),
                   [](const auto& a, const auto& b) { return std::abs(a.second) > std::abs(b.second); });
  std::vector<std::string> others;
  const std::string own = given_.constraint_owner(row);
  for (const auto& [other, share] : shares) {
    const std::string owner = given_.constraint_owner(other);
    if (normalizes_[other] == 0 && std::abs(share) > least && owner != own &&
        std::find(others.begin(), others.end(), owner) == others.end())
      others.push_back(owner);
  }
  std::string list;
  for (std::size_t i = 0; i < std::min(others.size(), kMostNamed); ++i)
    list += (i == 0 ? "" : ", ") + others[i];
  if (others.size() > kMostNamed) list += ", ...";
  return list.empty() ? "itself" : list;
}

void Redundancy::throw_contradiction(const Violation& violation, double t, const std::string& note) const {
  const auto place = std::find(redundant().begin(), redundant().end(), violation.row) - redundant().begin();
  const SparseRow& shares = left_out_.combination(static_cast<std::size_t>(place));
  const double unit = given_.constraint_unit(violation.row) / std::pow(time_unit_, violation.level);
  throw InvalidInput(given_.constraint_name(violation.row),
                     "it contradicts " + others_of(violation.row, shares) +
                         " at t = " + number_text(t * time_unit_) + ": of its " + kLevels[violation.level] +
                         " " + number_text(violation.value * unit) + " is left" + note);
}

}  // namespace mfs::dae
