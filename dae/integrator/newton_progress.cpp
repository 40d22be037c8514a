#include "dae/integrator/newton_progress.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dae/vectors/operations.hpp"

namespace mfs::dae {
namespace {

/// Corrections have to shrink at least by this factor each, or the search ends without success (DASSL's 0.9).
constexpr double kDivergence = 0.9;
/// What may be left of the correction, in units of the local error allowed.
constexpr double kTolerance = 0.1;
/// The tolerances (the default ones) of the largest local error of which that is taken. What is left of a
/// stiff coordinate is a force, and a vibration as soon as steps are short: with a tenth of rtol 1e-2, 1 cm
/// of the spin-up beam's 8 cm at 10 m, steps fell to 2e-6 s.
constexpr double kLoosestRelative = 1e-4, kLoosestPosition = 1e-6;
/// The vibration that the forces that are left may make, in parts of what may be left of the correction. A
/// beam of steel, 10 m long and 2 cm thick, spun up as the spin-up beam takes 17 023 steps without a bound,
/// 5986 with 1, 4855 with 0.5 and 5235 with 0.25 (docs/experiments/integrator-rotation.md).
constexpr double kVibration = 0.5;
/// A correction that forces have to follow, in units of the local error allowed, and what it may leave of
/// them, in parts of what they were before it and at first: less may be rounding.
constexpr double kFollowed = 1e-4, kLeftByOne = 0.5, kLeftByAll = 1e-2;
/// The least that is assumed to be left by a kept matrix after the first correction.
constexpr double kLeastLeftOver = 0.1;
/// What rounding may leave of a constraint, in roundings of the norm of what it is made of.
constexpr double kRoundings = 64.0;

}  // namespace

void NewtonProgress::start(const StepRelation& relation, bool fresh, double rate) {
  tolerance_ = kTolerance *
               std::min({1.0, kLoosestRelative / options_.rtol, kLoosestPosition / options_.atol_position});
  const double of_velocity = kTolerance * options_.atol_velocity;
  bounds_ = {std::min(options_.constraint_position, kTolerance * options_.atol_position),
             std::min(options_.constraint_velocity, of_velocity),
             std::min(options_.constraint_acceleration, of_velocity / relation.v_by_a)};
  relation_ = &relation;
  // What was seen in an earlier step says less the older the matrix gets.
  left_over_ = fresh ? kUnknownRate : std::max({2.0 * left_over_, rate / (1.0 - rate), kLeastLeftOver});
  since_jacobian_ = 0;
  new_ = fresh;
  slow_when_new_ = false;
  kept_rate_ = 0.0;
  began_fresh_ = fresh;
  by_newest_ = -1;
}

NewtonProgress::Verdict NewtonProgress::judge(const NewtonNorms& norms, int corrections) {
  const bool first = corrections == 0;
  last_correction_ = norms_.correction;
  last_residual_ = norms_.residual;
  last_followed_ = norms_.followed;
  norms_ = norms;
  wants_jacobian_ = false;
  if (!std::isfinite(norms.residual) || !(first || std::isfinite(norms.correction))) return Verdict::failed;
  if (first) {
    first_residual_ = norms.residual;
    first_followed_ = norms.followed;
    return Verdict::go_on;
  }
  ++since_jacobian_;
  if (by_newest_ >= 0) ++by_newest_;
  if (!rate_is_good()) {
    if (by_newest_ >= 0 || !began_fresh_) return Verdict::failed;
    by_newest_ = 0;
  }
  if (has_converged(bounds_)) return Verdict::converged;
  if (corrections >= options_.newton_iterations)
    return has_converged(bounds_of_rounding()) ? Verdict::converged : Verdict::failed;
  const bool slow = since_jacobian_ > 1 && (rate_ > kSlow || !forces_follow());
  slow_when_new_ = slow_when_new_ || (slow && new_);
  if (!options_.keep_factors || slow || by_newest_ >= 0) {
    wants_jacobian_ = new_ = true;
    since_jacobian_ = 0;
  }
  return Verdict::go_on;
}

/// Whether corrections shrink.
bool NewtonProgress::rate_is_good() {
  rate_ = 0.0;
  if ((since_jacobian_ < 2 && by_newest_ < 2) || last_correction_ == 0.0) return true;
  if (norms_.correction < small_) return true;
  rate_ = norms_.correction / last_correction_;
  if (!new_) kept_rate_ = rate_;
  left_over_ = rate_ < kDivergence ? rate_ / (1.0 - rate_) : kUnknownRate;
  return rate_ < kDivergence;
}

/// Whether the forces that are left, in what they push away, are too little for a vibration that the control
/// of steps would see. They are known, so what is left of them needs no rate.
bool NewtonProgress::vibration_is_small() const {
  const double left = last_residual_ > 0.0 ? norms_.residual / last_residual_ : left_over_;
  return std::min(left_over_, left) * norms_.vibration <= kVibration * tolerance_;
}

/// Whether the last correction has brought the forces to what its matrix said. A body that is stuck in
/// friction of 1e-5 m/s, by atol_velocity 1e-4, stayed so until a fifth more than friction could hold pulled
/// at it, as corrections by its steepness are small whatever it takes.
bool NewtonProgress::forces_follow() const {
  const auto follows = [](double now, double last, double first) {
    return now <= std::max(kLeftByOne * last, kLeftByAll * first);
  };
  return norms_.correction <= kFollowed ||
         (follows(norms_.followed, last_followed_, first_followed_) &&
          (!rigid_ || follows(norms_.residual, last_residual_, first_residual_)));
}

bool NewtonProgress::has_converged(const std::array<double, 3>& bounds) const {
  for (std::size_t level = 0; level < bounds.size(); ++level)
    if (norms_.violation[level] > bounds[level]) return false;
  return left_over_ * norms_.correction <= tolerance_ && vibration_is_small() && forces_follow();
}

/// Bounds that are not less than rounding: with v in m/h 1e-4 m/h^2 is less than 1e-16 of what v and the step
/// make of a.
std::array<double, 3> NewtonProgress::bounds_of_rounding() const {
  const auto rounding = [this](const Array<double>& x) {
    return kRoundings * std::numeric_limits<double>::epsilon() * norm(executor_, x.size(), x.data());
  };
  const double of_v = rounding(relation_->v);
  const std::array<double, 3> least{rounding(relation_->q), of_v,
                                    rounding(relation_->a) + of_v / relation_->v_by_a};
  std::array<double, 3> bounds = bounds_;
  for (std::size_t level = 0; level < bounds.size(); ++level)
    bounds[level] = std::max(bounds[level], least[level]);
  return bounds;
}

}  // namespace mfs::dae
