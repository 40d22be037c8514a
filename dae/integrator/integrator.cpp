#include "dae/integrator/integrator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include <mfs/error.hpp>
#include <mfs/version.hpp>

#include "dae/integrator/condensed_newton.hpp"
#include "dae/integrator/dense_output.hpp"
#include "dae/integrator/error_weights.hpp"
#include "dae/integrator/final_errors.hpp"
#include "dae/integrator/formula.hpp"
#include "dae/integrator/initial_conditions.hpp"
#include "dae/integrator/input_checks.hpp"
#include "dae/integrator/jumps.hpp"
#include "dae/integrator/marks.hpp"
#include "dae/integrator/newton.hpp"
#include "dae/integrator/partition.hpp"
#include "dae/integrator/passed_over.hpp"
#include "dae/integrator/planned_step.hpp"
#include "dae/integrator/projection.hpp"
#include "dae/integrator/redundancy.hpp"
#include "dae/integrator/scaled_system.hpp"
#include "dae/integrator/step_equations.hpp"
#include "dae/integrator/step_state.hpp"
#include "dae/integrator/step_watch.hpp"
#include "dae/integrator/time_unit.hpp"
#include "dae/integrator/tolerances.hpp"
#include "dae/mechanics/number_text.hpp"
#include "dae/vectors/loops.hpp"
#include "ordering/stopwatch.hpp"

namespace mfs::dae {
namespace {

/// After a search of Newton's method that failed, the step is multiplied by this (DASSL's).
constexpr double kNewtonRejection = 0.25;
/// A step, in parts of the time to integrate, and one that is so short, where errors are too large, next to a
/// singular position alone.
constexpr double kTypicalStep = 1e-3, kStuck = 1e-5;
/// A step that finds no end near a singular position is tried so much shorter, so many times: the next one,
/// which need not be shorter, passes over it then. Steps that stay short end in it sooner or later.
constexpr double kBeforeSingular = 0.6;
constexpr int kMostBeforeSingular = 3;
/// Rejections by the error in one step after which the formula starts anew.
constexpr int kRestart = 3;
/// The shortest step with which it does, in parts of the one that would be tried otherwise. What a first step
/// may be is known from rates alone, and vibrations that the steps do not follow make it far too short.
constexpr double kLeastRestart = 1.0 / 16;
/// A jump of accelerations that a step sees, by what it does to velocities within it, in units of what is
/// allowed.
constexpr double kSeen = 1.0;
/// Times that a step is made shorter as it passes over something.
constexpr int kMostPassedOver = 8;
/// It is not made shorter than so many of the shortest, in which changes of rates are rounding.
constexpr double kTooShortToPass = 1e4;
/// How far ahead of a step that became too small its cause may be, in shortest steps.
constexpr double kMoment = 64.0;

}  // namespace

class Integrator::Impl {
 public:
  /// `time_unit`: what times are multiplied by in messages.
  Impl(const ConstrainedSystem& system, IntegratorOptions options, double time_unit = 1.0)
      : given_(system), asked_(std::move(options)), time_unit_(time_unit) {
    check_options(asked_);
    for (int i = 0; i < given_.coordinates(); ++i) scale_.push_back(given_.coordinate_scale(i));
  }

  State run(double t0, std::vector<double> q0, std::vector<double> v0, double t_end,
            const std::vector<double>& outputs, Observer& observer) {
    tolerances_.emplace(asked_, options_);
    since_start_ = {};
    observed_ = 0;
    report_ = {};
    needs_whole_matrix_ = false;
    condensed_failures_ = 0;
    watch_.emplace(t0, t_end);
    t_end_ = t_end;
    marks_ = Marks(options_.fixed_step > 0.0 ? std::vector<double>() : given_.marks({t0, t_end}));
    bodies_ = turning_bodies_of(given_);
    most_past_ = outputs.empty() || bodies_.empty() ? 1 : kMostPast;
    start({t0, std::move(q0), std::move(v0), {}, {}});

    std::size_t next_output = 0;
    if (!outputs.empty() && outputs[0] == t0) {
      tell([&] { observer.output(whole_state()); });
      ++next_output;
    }
    while (state_.t < t_end_) {
      const bool ends_step = next_output < outputs.size() && between_ends_ == BetweenEnds::nothing;
      const double next = marks_.next(state_.t, t_end_, smallest_step());
      mark_ = next < t_end_ ? next : HUGE_VAL;
      step(ends_step ? std::min(next, outputs[next_output]) : next, observer);
      const bool marked = state_.t == mark_;
      for (; next_output < outputs.size() && outputs[next_output] <= state_.t; ++next_output) {
        const State& state = state_at(outputs[next_output]);
        tell([&] { observer.output(state); });
      }
      if (marked) pass_mark();
    }
    report_.time_total = elapsed();
    return whole_state();
  }

  const IntegrationReport& report() const { return report_; }

 private:
  void start(State given) {
    check_constraints(given_, given);
    redundancy_.emplace(given_, scale_, time_unit_);
    redundancy_->leave_out(redundancy_->find(given.t, given.q));
    State begun = consistent_motion(redundancy_->system(), options_, std::move(given));
    // Where the start had to be moved other constraints may be redundant.
    if (redundancy_->filters()) {
      redundancy_->leave_out(redundancy_->find(begun.t, begun.q));
      begun = consistent_motion(redundancy_->system(), options_, std::move(begun));
    }
    system_ = &redundancy_->system();
    choose_executor();
    assign(*executor_, begun, state_);
    scale_there_.assign(*executor_, scale_);
    report_.coordinates = system_->coordinates();
    report_constraints();
    make_equations();
    find_accelerations(state_);
    if (redundancy_->filters())
      redundancy_->check_start(view(state_), options_, typical_step(), [this](double t) {
        assign(*executor_, on_host(*executor_, state_), between_);
        between_.t = t;
        find_accelerations(between_);
        return between_.a.on_host(*executor_);
      });
    if (redundancy_->waits_for_way()) tolerances_->make_small();
    formula_ = make_formula(options_, *executor_);
    start_formula();
    changes_ = PassedOver(options_.fixed_step > 0.0 ? nullptr : given_.change_watch());
    changes_.go_on(*executor_, state_);
  }

  double typical_step() const { return kTypicalStep * (t_end_ - state_.t); }
  void find_accelerations(StepState& state) {
    const double h = typical_step();
    condensed_ ? condensed_->find_accelerations(state, h) : newton_->find_accelerations(state, h);
  }
  void start_formula() {
    set_weights();
    step_ = first_step();
    formula_->start(state_, step_, typical_step());
  }

  /// What moves the system may change here. Where forces jump by what a step would see, the formula starts
  /// anew with accelerations of behind the mark.
  void pass_mark() {
    formula_->distrust_past();
    if (options_.fixed_step > 0.0 || !jumps_within(given_, whole_state(), resolved_step())) return;
    assign(*executor_, on_host(*executor_, state_), between_);
    between_.t += resolved_step();
    try {
      find_accelerations(between_);
    } catch (...) {  // as in a singular position
      return rethrow_if_final(std::current_exception());
    }
    if (step_ * jump(*executor_, state_, between_, weights_) < kSeen) return;
    std::swap(state_, between_);
    start_formula();
  }

  /// From where what was left out holds again.
  void leave_singular() {
    assign(*executor_, redundancy_->brought_back(on_host(*executor_, state_), options_), state_);
    find_accelerations(state_);
    tolerances_->leave_singular();
    start_formula();
  }

  void report_constraints() {
    report_.constraints = system_->constraints();
    report_.redundant = redundancy_->names();
  }

  /// Leaves out what is redundant in `found`. Multipliers have to be those of the constraints then.
  void leave_out(Dependencies found) {
    if (found.redundant() == redundancy_->redundant()) return;
    drop_equations();
    std::vector<double> lambda = redundancy_->all_multipliers(state_.lambda.on_host(*executor_));
    redundancy_->leave_out(std::move(found));
    state_.lambda.assign(*executor_, redundancy_->kept_multipliers(std::move(lambda)));
    past_.forget_multipliers();
    system_ = &redundancy_->system();
    // What is left out in a singular position is no news.
    if (redundancy_->redundant().size() <= report_.redundant.size()) report_constraints();
  }

  /// Whether what is left out holds in `there`, where a step of `h` has arrived, or the step is to be tried
  /// again, with it or with another h.
  bool redundant_hold(const StepState& there, double& h) {
    if (!redundancy_->filters()) return true;  // otherwise the state is on the host
    auto found = redundancy_->look_at(view(there), options_);
    if (!found) return true;
    if (redundancy_->leaves_blindly(state_.t, state_.q.on_host(*executor_), view(there), options_, *found)) {
      h *= kNewtonRejection;
      return false;
    }
    leave_out(std::move(*found));
    make_equations();
    if (redundancy_->has_left_singular()) leave_singular();
    return false;
  }

  /// Looks anew at what is left out. In a singular position nothing is left out besides: it would be needed
  /// on the other side.
  void choose_redundant() {
    if (!redundancy_->filters()) return;
    Dependencies found = redundancy_->choose(state_.t, state_.q.on_host(*executor_));
    if (found.redundant().size() <= redundancy_->redundant().size()) leave_out(std::move(found));
  }

  /// Whether the step, for which no solution was found, was to end near a singular position.
  bool ends_near_singular() const {
    if (remote_ || !redundancy_->filters()) return false;  // the state has to be on the host
    try {
      return !redundancy_->nearly_redundant(relation_.t, relation_.q.on_host(*executor_), report_.redundant)
                  .empty();
    } catch (...) {  // as the step before it
      rethrow_if_final(std::current_exception());
      return false;
    }
  }

  /// Whether it was to end in one, where the equations are singular, too. Then more is left out until it is
  /// needed again.
  bool ends_singular() {
    if (remote_) return false;  // the state has to be on the host
    std::optional<Dependencies> found;
    try {
      found = redundancy_->look_for_singular(relation_.t, relation_.q.on_host(*executor_));
    } catch (...) {  // as the step before it
      rethrow_if_final(std::current_exception());
    }
    if (!found) return false;
    leave_out(std::move(*found));
    make_equations();
    return true;
  }

  /// Vectors lie on the device where the system takes them there.
  void choose_executor() {
    drop_equations();
    formula_.reset();
    remote_.reset();
    for (auto* state : {&state_, &next_, &between_}) *state = StepState();
    relation_ = StepRelation();
    past_ = PastStates(most_past_);
    for (auto* array : {&weights_, &scale_there_, &lambda_}) *array = Array<double>();
    if (backend_info(options_.backend).memory == MemorySpace::device) {
      executor_ = std::make_unique<Executor>(Executor::Place::device, options_.threads);
      remote_ = system_->remote_residual(*executor_);
    }
    if (!remote_) executor_ = std::make_unique<Executor>(Executor::Place::host, options_.threads);
  }

  void drop_equations() {
    newton_.reset();
    equations_.reset();
    condensed_.reset();
    for_outputs_.reset();
    partition_.reset();
  }

  void make_equations() {
    drop_equations();
    const std::vector<double> q = state_.q.on_host(*executor_);
    if (redundancy_->filters()) {
      const Pattern& pattern = system_->tangent_pattern()[Block::position_q];
      partition_.emplace(pattern, constraint_gradient(*system_, state_.t, q), scale_, options_.threads);
    }
    Projection projection = find_projection(*system_, state_.t, q, t_end_);
    judged_jacobians_ = report_.jacobians;
    if (options_.unknowns == Unknowns::reduced && !executor_->on_device() && !needs_whole_matrix_ &&
        CondensedNewton::suits(*system_)) {
      condensed_ = std::make_unique<CondensedNewton>(*system_, projection, options_, *executor_, report_);
      report_.unknowns = condensed_->size();
      report_.entries = static_cast<std::int64_t>(condensed_->entries());
      choose_between_ends();
      return;
    }
    equations_.emplace(*system_, options_.unknowns, std::move(projection), *executor_, remote_.get());
    newton_ = std::make_unique<Newton>(*equations_, options_, *executor_, report_);
    report_.unknowns = equations_->size();
    report_.entries = static_cast<std::int64_t>(equations_->pattern().entries());
    choose_between_ends();
  }

  /// Looks for the end of a step of `h`.
  NewtonOutcome search(double h) {
    const Array<double>& lambda = extrapolated_multipliers(h);
    if (!condensed_) return newton_->solve(relation_, lambda, weights_, next_);
    NewtonOutcome outcome = condensed_->solve(relation_, lambda, weights_, next_);
    if (!outcome.converged) ++condensed_failures_;
    return outcome;
  }

  /// Whether the condensed matrix lets searches converge badly, as where stiff springs pull across
  /// constraints. Then they go on with the whole one. `failures`: in the present step.
  bool turn_to_whole_matrix(int failures) {
    if (!condensed_) return false;
    const std::int64_t troubles = 5 * condensed_failures_ + condensed_->slow_steps();
    if (failures < 2 && troubles <= 20 + report_.steps / 10) return false;
    needs_whole_matrix_ = true;
    make_equations();
    return true;
  }

  void set_weights() { weigh(*executor_, state_, scale_there_, options_, weights_); }
  double first_step() const {
    return dae::first_step(*executor_, state_, weights_, options_, typical_step());
  }

  double resolved_step() const {
    return 16.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(state_.t), std::abs(t_end_));
  }
  double smallest_step() const { return std::max(options_.min_step, resolved_step()); }
  double shortest_to_pass() const { return std::max(options_.min_step, kTooShortToPass * resolved_step()); }

  /// One accepted step on the way to `target`.
  void step(double target, Observer& observer) {
    const double began = elapsed();
    renew_equations();
    const std::int64_t factorizations = report_.factorizations;
    StepReport line;
    int error_rejections = 0, search_failures = 0;
    int shortened = 0, passed_over = 0;
    double h = planned_step(options_, step_, target - state_.t), wanted = step_;
    for (;;) {
      const bool last = h >= (target - state_.t) * (1.0 - 1e-12);
      if (last && target == mark_) formula_->distrust_past();
      formula_->predict(h, relation_);
      relation_.t = last ? target : state_.t + h;
      const NewtonOutcome outcome = search(h);
      line.newton_iterations += outcome.iterations;
      if (outcome.converged) look_ = changes_.look(*executor_, next_);
      if (outcome.converged && !redundant_hold(next_, h)) {
        ++report_.newton_rejections;
        for (double* each : {&h, &wanted}) *each = std::min(*each, kStretch * step_);  // less if begun anew
      } else if (outcome.converged) {
        const double error = formula_->local_error(next_, weights_, filter_);
        const bool good = options_.fixed_step > 0.0 || error <= 1.0;
        if (good && (look_.part == 1.0 || passed_over == kMostPassedOver || h <= shortest_to_pass())) {
          outcome.tell(line, report_);
          break;
        }
        ++report_.error_rejections;
        if (good) {
          ++passed_over;
          ++line.rejections;
          h = std::max(shortest_to_pass(), h * look_.part);
          continue;
        }
        h = wanted = formula_->reject(++error_rejections);
        const bool stuck = redundancy_->filters() && error_rejections > 1 && h < kStuck * (t_end_ - state_.t);
        if ((stuck && ends_singular()) || error_rejections >= kRestart) {
          h = wanted = std::min(h, std::max(first_step(), kLeastRestart * h));
          formula_->start(state_, h, h);
        }
        give_up_below(h, "the local error is " + number_text(error) + " times what is allowed");
      } else {
        if (outcome.thrown) rethrow_if_final(outcome.thrown);
        ++(outcome.thrown ? report_.solver_rejections : report_.newton_rejections);
        if (search_failures == 0 && shortened < kMostBeforeSingular && ends_near_singular()) {
          ++shortened;
          ++line.rejections;
          h *= kBeforeSingular;
          continue;
        }
        const bool singular = search_failures++ == 0 && ends_singular();
        const bool relaxed = tolerances_->relax();
        if (relaxed) set_weights();
        if (!singular && !relaxed) h *= kNewtonRejection;
        wanted = h;
        give_up_below(h, outcome.failure());
        if (search_failures == 2 && redundancy_->filters()) {
          choose_redundant();
          make_equations();
        }
        turn_to_whole_matrix(search_failures);
      }
      ++line.rejections;
      h = std::min(h, target - state_.t);
    }
    line.h = h;
    line.order = formula_->order();
    accept(h, wanted);
    if (passed_over > 0) formula_->distrust_past();
    line.number = ++report_.steps;
    line.t = state_.t;
    line.factorizations = static_cast<int>(report_.factorizations - factorizations);
    report_.newton_iterations += line.newton_iterations;
    give_up_where_steps_stay_short(line);
    line.wall = elapsed() - began;
    report_.time_total = elapsed();
    tell([&] { observer.step(line, [&]() -> const State& { return whole_state(); }); });
  }

  void give_up_below(double h, const std::string& why) const {
    if (h >= smallest_step()) return;
    const std::string cause =
        report_.steps > 0 && state_.t < resolved_step()
            ? "times until " + time_text(t_end_) + " are resolved to " + time_text(resolved_step()) + " only"
            : why + find_obstacle(given_, on_host(*executor_, state_), kMoment * resolved_step(), options_,
                                  *redundancy_, report_.redundant, time_unit_);
    throw Error("the step became too small (" + time_text(h) + ") at t = " + time_text(state_.t) +
                " with order " + std::to_string(formula_->order()) + ": " + cause);
  }

  std::string time_text(double t) const { return number_text(t * time_unit_) + " s"; }

  void give_up_where_steps_stay_short(const StepReport& line) {
    const StepWatch::Verdict verdict = watch_->judge(line.number, line.t, line.rejections);
    if (verdict == StepWatch::Verdict::go_on) return;
    throw Error(number_text(watch_->left()) + " more steps would be needed: " +
                find_what_keeps_steps_short(given_, on_host(*executor_, state_), verdict,
                                            relation_.v.on_host(*executor_), weights_.on_host(*executor_),
                                            time_unit_));
  }

  /// Goes on to next_.
  void accept(double h, double wanted) {
    const int order = formula_->order();
    const double suited = formula_->accept(next_, weights_);
    // A step that was shortened to meet an output or the end says nothing against the one that was wanted.
    step_ = h < wanted && suited >= h ? std::max(wanted, suited) : suited;
    if (options_.fixed_step > 0.0) step_ = back_to_fixed(options_, step_, wanted);
    last_step_ = h;
    last_order_ = order;
    past_.add(state_);
    std::swap(state_, next_);
    tolerances_->go_on();
    set_weights();
    changes_.go_on(*executor_, state_);
  }

  /// Of constraints that depend on each other others may have to be left out in another position. That is
  /// seen at a new Jacobian.
  void renew_equations() {
    if (partition_ && std::exchange(judged_jacobians_, report_.jacobians) < report_.jacobians &&
        partition_->degraded(condensed_ ? condensed_->constraint_gradient()
                                        : equations_->constraint_gradient())) {
      choose_redundant();
      make_equations();
    }
    turn_to_whole_matrix(0);
  }

  /// Multipliers at the end of a step of `h`, where Newton's method starts.
  const Array<double>& extrapolated_multipliers(double h) {
    if (!past_.knows_multipliers()) return state_.lambda;
    extrapolate(*executor_, state_.lambda, past_[0].lambda, h / last_step_, lambda_);
    return lambda_;
  }

  /// At its end, or within the last step.
  const State& state_at(double t) {
    if (t == state_.t) return whole_state();
    if (between_ends_ == BetweenEnds::interpolated)
      interpolate(*executor_, bodies_, t, state_, past_, last_order_, between_);
    else
      find_consistent(t);
    return whole_ = redundancy_->whole(host_states_.take(*executor_, between_, std::move(whole_)));
  }

  void find_consistent(double t) {
    const State guess = state_between(t, past_[0], state_);
    assign(*executor_, guess, between_);
    try {
      if (!for_outputs_)
        for_outputs_ = std::make_unique<CondensedNewton>(
            *system_, find_projection(*system_, state_.t, state_.q.on_host(*executor_), t_end_), options_,
            *executor_, not_reported_);
      for_outputs_->make_consistent(between_);
    } catch (...) {  // as in a singular position
      rethrow_if_final(std::current_exception());
      assign(*executor_, guess, between_);
    }
  }

  /// Says what is done for outputs.
  void choose_between_ends() {
    if (!bodies_.empty())
      between_ends_ = BetweenEnds::interpolated;
    else if (condensed_ || (!needs_whole_matrix_ && !remote_ && CondensedNewton::is_of_joints(*system_)))
      between_ends_ = BetweenEnds::consistent;
    else
      between_ends_ = BetweenEnds::nothing;
  }

  /// The state with multipliers of all constraints.
  const State& whole_state() {
    return whole_ = redundancy_->whole(host_states_.take(*executor_, state_, std::move(whole_)));
  }

  template <class Call>
  void tell(const Call& call) {
    const Stopwatch watch;
    call();
    observed_ += watch.seconds();
  }
  double elapsed() const { return since_start_.seconds() - observed_; }

  const ConstrainedSystem& given_;
  const IntegratorOptions asked_;
  const double time_unit_;
  IntegratorOptions options_;  ///< with tolerances of the local error
  std::optional<LocalTolerances> tolerances_;
  std::vector<double> scale_;
  IntegrationReport report_;
  Stopwatch since_start_;
  double observed_ = 0;  // s, in the observer

  double t_end_ = 0.0;
  Marks marks_{{}};
  double mark_ = HUGE_VAL;  ///< the next one
  std::optional<Redundancy> redundancy_;
  const ConstrainedSystem* system_ = nullptr;  ///< the one given, or without what is redundant
  std::unique_ptr<Executor> executor_;
  std::unique_ptr<RemoteResidual> remote_;
  std::optional<Partition> partition_;          ///< where constraints are redundant
  std::unique_ptr<CondensedNewton> condensed_;  ///< where it suits; otherwise the next two
  std::optional<StepEquations> equations_;
  std::unique_ptr<Newton> newton_;
  bool needs_whole_matrix_ = false;
  std::int64_t condensed_failures_ = 0;
  std::unique_ptr<Formula> formula_;

  StepState state_, next_;  ///< now, and what a step arrives at
  State whole_;
  HostStates host_states_;
  StepState between_;                             ///< an output within a step
  std::unique_ptr<CondensedNewton> for_outputs_;  ///< of its own: steps are as they would be without outputs
  IntegrationReport not_reported_;
  /// How states between the ends of a step are found (dense_output.hpp).
  enum class BetweenEnds { nothing, consistent, interpolated } between_ends_ = BetweenEnds::nothing;
  std::vector<PointRange> bodies_;
  PastStates past_;
  int most_past_ = 1;
  std::optional<StepWatch> watch_;
  double last_step_ = 0.0;  ///< that led to state_, and the order of the formula in it
  int last_order_ = 1;
  StepRelation relation_;
  std::int64_t judged_jacobians_ = 0;    ///< at how many of them the constraints left out were looked at
  Array<double> weights_, scale_there_;  ///< of [q, v]; of the coordinates
  Array<double> lambda_;                 ///< where Newton's method starts
  PassedOver changes_;
  ChangeWatch::Verdict look_;  ///< of the last attempt at a step
  const ErrorFilter filter_ = [this](Array<double>& e) {
    if (look_.turned) return false;  // forces are not those whose stiffness the matrix has
    return condensed_ ? condensed_->filter_error(e) : newton_->filter_error(next_, e);
  };
  double step_ = 0.0;  ///< wanted next
};

Integrator::Integrator(const ConstrainedSystem& system, IntegratorOptions options)
    : system_(&system), options_(options), impl_(std::make_unique<Impl>(system, std::move(options))) {}
Integrator::~Integrator() = default;
Integrator::Integrator(Integrator&&) noexcept = default;

State Integrator::run(double t0, std::vector<double> q0, std::vector<double> v0, double t_end,
                      const std::vector<double>& outputs, Observer& observer) {
  check_vector(q0, system_->coordinates(), "q0");
  check_vector(v0, system_->coordinates(), "v0");
  check_times(t0, t_end, outputs);
  check_step_number(options_, t_end - t0);
  const double unit = time_unit(*system_, {t0, q0, v0, {}, {}}, t_end);
  if (unit == 1.0 && !ScaledSystem::is_needed(*system_)) {
    if (scaled_) impl_ = std::make_unique<Impl>(*system_, options_);
    scaled_.reset();
    return impl_->run(t0, std::move(q0), std::move(v0), t_end, outputs, observer);
  }
  auto scaled = std::make_unique<ScaledSystem>(*system_, t0, q0, unit);
  impl_ = std::make_unique<Impl>(*scaled, scaled->scaled(options_), unit);
  scaled_ = std::move(scaled);
  State start = scaled_->scaled({t0, std::move(q0), std::move(v0), {}, {}});
  std::vector<double> scaled_outputs = outputs;
  for (double& t : scaled_outputs) t /= unit;
  UnscalingObserver unscaling(*scaled_, observer);
  return scaled_->unscaled(
      impl_->run(start.t, std::move(start.q), std::move(start.v), t_end / unit, scaled_outputs, unscaling));
}

const IntegrationReport& Integrator::report() const {
  return impl_->report();
}

}  // namespace mfs::dae
