// How far a search of Newton's method has come, whoever makes its corrections.
//
// A correction ends the search when what is left of it, by the rate at which corrections have shrunk so far,
// is a part of what the user's tolerances allow (and of the default ones, where these are looser: stiff
// forces take what is left for a vibration), what the forces that are left can make a body vibrate by is as
// small (lengths do not show it: 1e-7 m along a bar of steel are 1e-3 m/s), and the constraints hold to their
// own tolerances, or, in a search that would fail otherwise, to what rounding leaves of them. Forces that may
// be friction (followed_forces.hpp) have to shrink besides, and where bodies are rigid all that is left:
// friction that is as steep as the tolerance makes corrections small while a body is stuck, though it may not
// hold it any more. When corrections shrink too slowly a new Jacobian is asked for; when they do not shrink,
// although the first Jacobian was new, one for each further correction (what turns a body that is next to a
// point, as one hung by a sphere, changes altogether by a
// correction). When they do not shrink then, the search has failed.
#pragma once

#include <array>

#include "dae/integrator/formula.hpp"
#include "dae/integrator/integrator.hpp"
#include "dae/integrator/newton_norms.hpp"

namespace mfs::dae {

/// q_by_a of a kept matrix / q_by_a: between these it is kept.
constexpr double kKeptRates[] = {0.6, 1.7};
/// The rate of corrections above which a new Jacobian is worth its price.
constexpr double kSlow = 0.3;

class NewtonProgress {
 public:
  enum class Verdict { go_on, converged, failed };

  /// `options` and `executor`, that of the vectors, have to live as long. Corrections below `small`, in units
  /// of the local error allowed, say nothing about the rate at which they shrink. `rigid`: whether all
  /// residuals have to follow corrections, as they need not where bodies are stiff.
  NewtonProgress(const IntegratorOptions& options, const Executor& executor, double small, bool rigid)
      : options_(options), executor_(executor), small_(small), rigid_(rigid) {}

  /// Before a search. `fresh`: with a new Jacobian; otherwise corrections by the kept one are expected to
  /// shrink by `rate`, if not more slowly. `relation` has to live as long as the search.
  void start(const StepRelation& relation, bool fresh, double rate);
  /// After so many corrections, the first time after none.
  Verdict judge(const NewtonNorms& norms, int corrections);
  /// Whether the next correction is to be by a new Jacobian; set by judge().
  bool wants_jacobian() const { return wants_jacobian_; }
  /// Whether corrections by a new Jacobian have shrunk slowly in this search.
  bool was_slow_when_new() const { return slow_when_new_; }
  /// At which corrections by a kept Jacobian have shrunk last in this search; 0: none were seen to.
  double kept_rate() const { return kept_rate_; }
  /// Of the last judge().
  const NewtonNorms& norms() const { return norms_; }

 private:
  bool rate_is_good();
  bool has_converged(const std::array<double, 3>& bounds) const;
  bool vibration_is_small() const;
  bool forces_follow() const;
  std::array<double, 3> bounds_of_rounding() const;

  const IntegratorOptions& options_;
  const Executor& executor_;
  const double small_;
  const bool rigid_;
  const StepRelation* relation_ = nullptr;
  NewtonNorms norms_;
  int since_jacobian_ = 0;  ///< corrections by the present Jacobian, in this search
  bool began_fresh_ = false;
  int by_newest_ = -1;  ///< corrections since each is by a Jacobian of its own; -1: none is
  bool wants_jacobian_ = false, new_ = false, slow_when_new_ = false;
  double tolerance_ = 0.0;  ///< what may be left of the correction, in units of the local error allowed
  double last_correction_ = 0.0, first_residual_ = 0.0, last_residual_ = 0.0, first_followed_ = 0.0,
         last_followed_ = 0.0, rate_ = 0.0, kept_rate_ = 0.0, left_over_ = kUnknownRate;
  /// What constraints may be left at: no more than the local error may be, or it would be lost in this noise.
  std::array<double, 3> bounds_{};

  /// Left-over over last correction, before a rate has been seen: the first correction alone ends the search
  /// only where it is far below the tolerance.
  static constexpr double kUnknownRate = 20.0;
};

}  // namespace mfs::dae
