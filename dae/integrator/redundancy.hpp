// The constraints of a system of which some follow from the others: which are left out, what their
// multipliers are, and whether they really follow. Which they are may change along a motion: in a singular
// position one more follows from the others than before and after it.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dae/integrator/dependencies.hpp"
#include "dae/integrator/independent_constraints.hpp"
#include "dae/integrator/integrator.hpp"

namespace mfs::dae {

class Redundancy {
 public:
  /// Nothing is left out yet. `system` has to live as long; `scale`: per coordinate; `time_unit`: what times
  /// are multiplied by in messages.
  Redundancy(const ConstrainedSystem& system, std::vector<double> scale, double time_unit = 1.0);

  /// The system without what is left out. Another object after leave_out().
  const ConstrainedSystem& system() const;
  /// Whether anything has been left out.
  bool filters() const { return filtered_.has_value(); }
  const std::vector<int>& redundant() const { return left_out_.redundant(); }
  std::vector<std::string> names() const;

  Dependencies find(double t, const std::vector<double>& q, double nothing = Dependencies::kRounding) const;
  /// What is redundant in `found` is left out from now on.
  void leave_out(Dependencies found);

  /// Multipliers of all constraints from those of system(); those left out have none.
  std::vector<double> all_multipliers(const std::vector<double>& kept) const;
  /// The other way: multipliers of system() for the same forces.
  std::vector<double> kept_multipliers(std::vector<double> all) const;
  /// A state of system() as one of all constraints, with multipliers of least squares.
  State whole(State state) const;

  /// Throws InvalidInput, with the names of what contradicts each other, where what is left out is violated.
  void check(const StateView& state, const IntegratorOptions& options) const;
  /// Accelerations (n) at time t of what is where the motion begins, with its velocities.
  using Accelerations = std::function<std::vector<double>(double t)>;
  /// The same where the motion begins. Bodies that are at rest in a singular position go where forces push
  /// them, at once or `moment` later; throws InvalidInput where that is on none of the ways out of it.
  void check_start(const StateView& state, const IntegratorOptions& options, double moment,
                   const Accelerations& accelerations);
  /// Whether look_at() has just taken back what was left out in a singular position, where the motion began
  /// or look_for_singular() found it: it does not hold exactly, as nothing kept to it.
  bool has_left_singular() { return std::exchange(has_left_singular_, false); }
  /// Whether the motion began in a singular position out of which nothing has said the way yet.
  bool waits_for_way() const { return only_here_.has_value(); }
  /// A state of system() near the given one in which it holds again, as well as it can.
  State brought_back(State state, const IntegratorOptions& options) const;
  /// Says that it began in a singular position, which has no unique motion; empty: it did not.
  std::string singular_start() const;
  /// Looks at where a step has arrived with what is left out. Returns what is to be left out
  /// instead, where some of it does not follow any more; then the step is to be tried again. Throws
  /// as check() where it is violated although it follows.
  std::optional<Dependencies> look_at(const StateView& there, const IntegratorOptions& options);
  /// Whether the step that look_at() has seen leave the position in which the motion began, for `found`,
  /// comes from so close to it (t, q) that nothing tells on which way, or has gone so far off all ways that
  /// it may have been on one. Then it has to be shorter.
  bool leaves_blindly(double t, const std::vector<double>& q, const StateView& there,
                      const IntegratorOptions& options, const Dependencies& found);
  /// What is to be left out from this position on. What is left out now and is next to nothing stays so.
  Dependencies choose(double t, const std::vector<double>& q) const;
  /// What is to be left out until look_at() takes it back, where in a position more constraints determine
  /// next to nothing.
  std::optional<Dependencies> look_for_singular(double t, const std::vector<double>& q);
  /// A constraint that is left out, as it follows from others in a position, and does not where `way` (n)
  /// leads from there; none: there is no such one, or `way` is zero.
  std::optional<int> singular_row(double t, const std::vector<double>& q,
                                  const std::vector<double>& way) const;
  /// Says which constraint determines next to nothing in a position, besides the `usual` redundant ones, and
  /// what it nearly follows from; empty: there is none. So it is where a motion leads beyond a dead point.
  std::string nearly_redundant(double t, const std::vector<double>& q, const std::vector<std::string>& usual,
                               double left = kNearlySingular) const;
  /// The same where no step leads on: from a dead point it may be a little farther.
  std::string dead_point(double t, const std::vector<double>& q,
                         const std::vector<std::string>& usual) const {
    return nearly_redundant(t, q, usual, 1e-2);
  }

 private:
  /// What multipliers in a state are multiplied by to be forces of the model; 0: of a normalization.
  std::vector<double> units_of_forces(const State& state) const;
  /// What is left of a constraint, in parts of its largest entry, where it determines motions well.
  static constexpr double kNearlySingular = 1e-3;
  /// By what a constraint that is left out is violated.
  struct Violation {
    int row;
    int level;  ///< 0: position, 1: velocity, 2: acceleration
    double value;
  };
  /// Of what is left out, measured by its shares in these combinations.
  std::optional<Violation> violation(const StateView& state, const IntegratorOptions& options,
                                     const Dependencies& by) const;
  Dependencies choose(Dependencies exact, double t, const std::vector<double>& q) const;
  /// Where coordinates of what is left out go (n; of others 0) if they are at rest; empty: they are not, or
  /// stay where they are.
  std::vector<double> way_from_rest(const StateView& state, const IntegratorOptions& options, double moment,
                                    const Accelerations& accelerations) const;
  /// Throws InvalidInput where on a way from rest, q + x t^2, constraints that follow from others do not
  /// hold.
  void check_way(const StateView& state, const std::vector<double>& x) const;
  /// A constraint that is left out and does not follow where what is kept holds beside the position.
  std::optional<int> row_of_here_only(const StateView& state, IntegratorOptions options) const;
  /// One that is left out and not redundant `there`, where fewer are.
  std::optional<int> needed_in(const Dependencies& there) const;
  /// The state near the given one that fulfils the constraints of `system`, as well as rounding lets it.
  std::optional<State> moved_to_way(const ConstrainedSystem& system, const State& state,
                                    IntegratorOptions options) const;
  /// Whether `moved` is farther from it than this part of what determines more than `redundant` leave.
  bool is_off(const State& state, const State& moved, double part, std::size_t redundant) const;
  /// The same of where all constraints hold but those that are redundant in `kept_but`.
  bool is_off(const State& state, const IntegratorOptions& options, double part,
              const Dependencies& kept_but) const;
  /// Throws InvalidInput where more than what is left out follows in `found`: the motion has left the
  /// singular position, in which nothing kept to that, so far off all ways that what is left of it is as
  /// small.
  void throw_off_the_way(const Dependencies& found, double t) const;
  /// Names of those besides the owner of `row` that take part in a combination.
  std::string others_of(int row, SparseRow shares) const;
  [[noreturn]] void throw_contradiction(const Violation& violation, double t,
                                        const std::string& note = "") const;

  const ConstrainedSystem& given_;
  std::vector<double> scale_;
  double time_unit_;
  std::vector<char> normalizes_, nonholonomic_;
  Dependencies left_out_;
  std::vector<int> begun_with_;  ///< redundant where the motion began
  bool may_be_singular_ = true;  ///< the position for which that was found
  bool is_in_singular_ = false, has_left_singular_ = false;
  /// What followed from others where the motion began, in a singular position out of which neither velocities
  /// nor forces said the way then.
  std::optional<int> only_here_;
  std::optional<IndependentConstraints> filtered_;
};

}  // namespace mfs::dae
