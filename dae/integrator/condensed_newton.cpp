#include "dae/integrator/condensed_newton.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <mfs/error.hpp>
#include <mfs/solver.hpp>

#include "dae/integrator/augmentation.hpp"
#include "dae/integrator/composition.hpp"
#include "dae/integrator/constraint_directions.hpp"
#include "dae/integrator/followed_forces.hpp"
#include "dae/integrator/initial_conditions.hpp"
#include "dae/integrator/newton_progress.hpp"
#include "ordering/stopwatch.hpp"

namespace mfs::dae {
namespace {

/// A change of a row of Phi_q, in parts of its largest entry, with which a new Jacobian pays: corrections by
/// the old one shrink by about this, in accelerations while those of q and v look well. The matrix costs
/// about as much as two corrections.
constexpr double kTurned = 3e-4;
/// A correction, in units of the local error allowed, beside which what accelerations have left for the next
/// ones is no slower rate.
constexpr double kSmall = 1e-2;
/// An error of velocities is one of stiff forces where the matrix leaves less than this part of it.
constexpr double kFilters = 0.75;
/// Of one coordinate: those of the frame of a rigid interface are in the constraints of all its nodes.
constexpr int kMostConstraints = 100;
/// Smaller matrices are not worth waking threads.
constexpr int kWorthThreads = 5000;

/// x += factor A y, A in compressed rows.
void add_product(const Pattern& pattern, const std::vector<double>& values, double factor, const double* y,
                 double* x) {
  for (int row = 0; row < pattern.rows; ++row) {
    double sum = 0.0;
    for (int k = pattern.row_start[row]; k < pattern.row_start[row + 1]; ++k)
      sum += values[k] * y[pattern.column[k]];
    x[row] += factor * sum;
  }
}

}  // namespace

class CondensedNewton::Impl {
 public:
  Impl(const ConstrainedSystem& system, const Projection& projection, const IntegratorOptions& options,
       const Executor& executor, IntegrationReport& report)
      : system_(system),
        options_(options),
        executor_(executor),
        report_(report),
        n_(static_cast<std::size_t>(system.coordinates())),
        m_(static_cast<std::size_t>(system.constraints())),
        gradient_(system.tangent_pattern()[Block::position_q]),
        transposed_(gradient_),
        followed_(followed_forces(system)),
        augmentation_(gradient_, transposed_, 1),
        directions_(gradient_, projection),
        matrix_(make_composition()),
        values_(matrix_.pattern().entries()),
        terms_(8),
        solver_(solver_options(system.coordinates() + system.constraints())),
        progress_(options, executor, kSmall, true),
        residual_(make_residual(system)),
        tangent_(make_tangent(system)),
        right_side_(n_ + m_),
        solution_(n_ + m_),
        change_(n_),
        kappa_(m_),
        mu_(m_),
        of_kappa_(m_),
        of_mu_(m_),
        along_(2 * n_),
        y_(2 * n_) {
    predicted_[Block::position_q].resize(gradient_.entries());
    for (std::size_t b = 0; b < kForceByAVQ.size(); ++b)
      diagonal_[b] = find_diagonal(system.tangent_pattern()[kForceByAVQ[b]]);
    for (std::size_t b = 0; b < kBlocks; ++b)
      if (system.tangent_pattern().constant[b]) constant_.insert(static_cast<Block>(b));
  }

  void find_accelerations(StepState& state, double h) {
    StepRelation some_step;
    some_step.v_by_a = some_step.q_by_v = h;
    const StateView there = view(state);
    // The first matrix is what ordering, matching and scales are made for (newton.cpp).
    evaluate_jacobian(there);
    naming_start([this](int unknown) { return name(unknown); },
                 [&] {
                   compose_and_factor(some_step);
                   set_accelerations(state);
                 });
  }

  void make_consistent(StepState& state) {
    const StateView there = view(state);
    evaluate(there);
    const double bound = std::min(options_.constraint_position, 0.1 * options_.atol_position);  // as of steps
    for (int k = 0; k < 3 && largest_size(residual_.position) > bound; ++k) {
      set_directions(there);
      directions_.factor(predicted_[Block::position_q]);
      correct(residual_.position, state.q.data());
      evaluate(there);
    }
    set_directions(there);
    directions_.factor(predicted_[Block::position_q]);
    correct(residual_.velocity, state.v.data());
    std::fill_n(state.a.data(), n_, 0.0);
    std::fill_n(state.lambda.data(), m_, 0.0);
    evaluate_jacobian(there);
    set_accelerations(state);
  }

  NewtonOutcome solve(const StepRelation& relation, const Array<double>& lambda, const Array<double>& weights,
                      StepState& state) {
    NewtonOutcome outcome;
    relation_ = &relation;
    weights_ = weights.data();
    try {
      set_directions({relation.t, relation.q.data(), relation.v.data(), relation.a.data(), of_mu_.data()});
    } catch (...) {
      outcome.thrown = std::current_exception();
      return outcome;
    }
    const double ratio = q_by_a_ / relation.q_by_a();
    const bool known = factored_ && options_.keep_factors && n_ != m_;
    const bool fresh = !known || ratio < kKeptRates[0] || ratio > kKeptRates[1] || has_turned();
    outcome.converged = search(lambda, fresh, std::abs(ratio - 1.0) / (ratio + 1.0), outcome);
    if (!outcome.converged && !fresh) outcome.converged = search(lambda, true, 0.0, outcome);
    if (progress_.was_slow_when_new()) ++slow_steps_;
    if (outcome.converged) std::swap(state, state_);
    return outcome;
  }

  // By M and Phi_q of the last Jacobian, as the matrix is.
  bool filter_error(Array<double>& e) {
    if (relation_ == nullptr || n_ == m_) return false;
    const double v_by_a = relation_->v_by_a;
    try {
      if (!factored_ || q_by_a_ != relation_->q_by_a()) compose_and_factor(*relation_);
      std::fill(right_side_.begin(), right_side_.end(), 0.0);
      add_product(system_.tangent_pattern()[Block::force_a], tangent_[Block::force_a], 1.0 / v_by_a, e.data(),
                  right_side_.data());
      std::fill(of_kappa_.begin(), of_kappa_.end(), 0.0);
      add_product(gradient_, tangent_[Block::position_q], 1.0, e.data(), of_kappa_.data());
      for (std::size_t i = 0; i < m_; ++i) right_side_[n_ + i] = scale_ / v_by_a * of_kappa_[i];
      solve_linear();
    } catch (...) {  // the step is rejected, as it would be without this
      return false;
    }
    for (std::size_t i = 0; i < n_; ++i) change_[i] = v_by_a / scale_ * solution_[m_ + i];
    const double* const of_velocities = weights_ + n_;
    if (!(weighted_square(change_.data(), of_velocities) <
          kFilters * kFilters * weighted_square(e.data(), of_velocities)))
      return false;
    std::copy(change_.begin(), change_.end(), e.data());
    return true;
  }

  const ConstrainedSystem& system_;
  const Composition& composition() const { return matrix_; }
  const std::vector<double>& constraint_gradient() const { return tangent_[Block::position_q]; }
  int slow_steps() const { return slow_steps_; }

 private:
  Options solver_options(int size) const {
    Options chosen;
    chosen.backend = options_.backend;
    chosen.threads = size < kWorthThreads ? 1 : options_.threads;
    chosen.analysis.threads = options_.analysis_threads;
    chosen.solve.row_floor = kRowFloor;
    return chosen;
  }

  /// Unknowns: multipliers, accelerations; rows: F, constraints on accelerations.
  Composition make_composition() const {
    const TangentPattern& patterns = system_.tangent_pattern();
    const int n = static_cast<int>(n_), m = static_cast<int>(m_);
    const std::vector<int> a = consecutive(m, n);
    std::vector<Composition::Term> terms;
    for (const Block block : kForceByAVQ) terms.push_back({&patterns[block], 0, a});
    terms.push_back({&augmentation_.pattern(), 0, a});
    terms.push_back({&transposed_.pattern, 0, consecutive(0, m), transposed_.source.data()});
    for (const Block block : {Block::position_q, Block::acceleration_v, Block::acceleration_q})
      terms.push_back({&patterns[block], n, a});
    return Composition(n + m, std::move(terms), 1);
  }

  std::string name(int unknown) const {
    const int m = static_cast<int>(m_);
    return unknown < m ? system_.constraint_name(unknown) : system_.coordinate_name(unknown - m);
  }

  /// To what F and the constraints ask for, from zero, by the last Jacobian, that of `state`.
  void set_accelerations(StepState& state) {
    compose_and_factor({});
    evaluate(view(state));
    std::copy(residual_.force.begin(), residual_.force.end(), right_side_.begin());
    for (std::size_t i = 0; i < m_; ++i) right_side_[n_ + i] = scale_ * residual_.acceleration[i];
    solve_linear();
    take_solution(state);
    factored_ = false;  // that matrix is of no step
  }

  /// Changes x along the directions so that the constraints violated by `violation` hold.
  void correct(const std::vector<double>& violation, double* x) {
    std::fill(change_.begin(), change_.end(), 0.0);
    directions_.solve(violation, change_, of_mu_);
    for (std::size_t i = 0; i < n_; ++i) x[i] -= change_[i];
  }

  void evaluate(const StateView& state) {
    const Stopwatch watch;
    system_.evaluate(state, residual_);
    report_.time_assembly += watch.seconds();
  }

  /// B is Phi_q^T there; multipliers do not matter.
  void set_directions(const StateView& there) {
    const Stopwatch watch;
    system_.evaluate(there, predicted_, {Block::position_q});
    report_.time_assembly += watch.seconds();
    const std::vector<double>& values = predicted_[Block::position_q];
    for (std::size_t k = 0; k < values.size(); ++k)
      if (!std::isfinite(values[k]))
        throw InvalidInput("constraints", "their derivatives are not finite", static_cast<std::int64_t>(k));
    directions_.set(values);
  }

  /// Whether the directions of the constraints are no more those of the last Jacobian.
  bool has_turned() const {
    const std::vector<double>&now = predicted_[Block::position_q], &then = tangent_[Block::position_q];
    for (int row = 0; row < gradient_.rows; ++row) {
      double most = 0.0, change = 0.0;
      for (int k = gradient_.row_start[row]; k < gradient_.row_start[row + 1]; ++k) {
        most = std::max(most, std::abs(then[k]));
        change = std::max(change, std::abs(now[k] - then[k]));
      }
      if (change > kTurned * most) return true;
    }
    return false;
  }

  void evaluate_jacobian(const StateView& state) {
    const Stopwatch watch;
    system_.evaluate(state, tangent_, due_);
    due_.erase(constant_);
    augmentation_.compute(tangent_[Block::position_q]);
    ++report_.jacobians;
    report_.time_assembly += watch.seconds();
  }

  /// The matrix of the last Jacobian in the step of `relation`.
  void compose_and_factor(const StepRelation& relation) {
    Stopwatch watch;
    factored_ = false;
    const double v_by_a = relation.v_by_a, q_by_a = relation.q_by_a();
    scale_ = typical_diagonal(v_by_a, q_by_a);
    const auto values = [&](Block block) { return tangent_[block].data(); };
    terms_ = {{values(Block::force_a), 1.0 / scale_},    {values(Block::force_v), v_by_a / scale_},
              {values(Block::force_q), q_by_a / scale_}, {augmentation_.values().data(), 1.0},
              {values(Block::position_q), 1.0},          {values(Block::position_q), 1.0},
              {values(Block::acceleration_v), v_by_a},   {values(Block::acceleration_q), q_by_a}};
    matrix_.compose(terms_, values_.data());
    report_.time_assembly += watch.seconds();
    watch = Stopwatch();
    factor();
    directions_.factor(tangent_[Block::position_q]);
    report_.time_factor += watch.seconds();
    q_by_a_ = q_by_a;
    factored_ = true;
  }

  void factor() {
    const Pattern& pattern = matrix_.pattern();
    ++report_.factorizations;
    if (solver_.analyzed()) {
      solver_.refactor(values_.data());
      return;
    }
    solver_.factor(
        {pattern.rows, pattern.columns, pattern.row_start.data(), pattern.column.data(), values_.data()});
    const double analysis = solver_.report().time_order + solver_.report().time_symbolic;
    ++report_.analyses;
    report_.time_analysis += analysis;
    report_.time_factor -= analysis;
    report_.bytes_solver = std::max(report_.bytes_solver, solver_.report().bytes_used);
  }

  /// Of F's derivatives by a, v, q in the columns of a, in the mean.
  double typical_diagonal(double v_by_a, double q_by_a) {
    std::fill(change_.begin(), change_.end(), 0.0);
    const double factors[] = {1.0, v_by_a, q_by_a};
    for (std::size_t b = 0; b < kForceByAVQ.size(); ++b)
      for (std::size_t i = 0; i < n_; ++i)
        if (const int k = diagonal_[b][i]; k >= 0) change_[i] += factors[b] * tangent_[kForceByAVQ[b]][k];
    double sum = 0.0;
    for (const double x : change_) sum += std::abs(x);
    return sum > 0.0 ? sum / static_cast<double>(n_) : 1.0;
  }

  void solve_linear() {
    const Stopwatch watch;
    solver_.solve(right_side_.data(), solution_.data());
    report_.time_solve += watch.seconds();
  }

  /// Corrects lambda and a by the solution, which becomes the correction.
  void take_solution(StepState& state) {
    double* const a = solution_.data() + m_;
    add_product(gradient_, tangent_[Block::position_q], 1.0, a, solution_.data());
    for (std::size_t i = 0; i < m_; ++i) state.lambda.data()[i] -= solution_[i];
    for (std::size_t i = 0; i < n_; ++i) state.a.data()[i] -= (a[i] /= scale_);
  }

  double weighted_square(const double* x, const double* weights) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < n_; ++i) sum += (x[i] / weights[i]) * (x[i] / weights[i]);
    return sum;
  }

  bool search(const Array<double>& lambda, bool fresh, double rate, NewtonOutcome& outcome) {
    outcome.thrown = nullptr;
    bool converged = false;
    try {
      progress_.start(*relation_, fresh, rate);
      begin(lambda);
      bool wanted = fresh;
      for (int corrections = 0;; ++corrections) {
        const auto verdict = progress_.judge(norms(), corrections);
        converged = verdict == NewtonProgress::Verdict::converged;
        if (verdict != NewtonProgress::Verdict::go_on) break;
        if (wanted || progress_.wants_jacobian()) {
          evaluate_jacobian(view(state_));
          compose_and_factor(*relation_);
        }
        wanted = false;
        correct();
        ++outcome.iterations;
      }
    } catch (...) {
      outcome.thrown = std::current_exception();
      converged = false;
    }
    outcome.residual = progress_.norms().residual;
    outcome.violation = progress_.norms().violation;
    return converged;
  }

  /// At the prediction.
  void begin(const Array<double>& lambda) {
    state_.t = relation_->t;
    for (auto* part : {&state_.q, &state_.v, &state_.a}) part->resize(executor_, n_);
    state_.lambda.resize(executor_, m_);
    std::copy_n(relation_->q.data(), n_, state_.q.data());
    std::copy_n(relation_->v.data(), n_, state_.v.data());
    std::copy_n(relation_->a.data(), n_, state_.a.data());
    std::copy_n(lambda.data(), m_, state_.lambda.data());
    std::fill(kappa_.begin(), kappa_.end(), 0.0);
    std::fill(mu_.begin(), mu_.end(), 0.0);
    evaluate(view(state_));
  }

  void correct() {
    std::copy(residual_.force.begin(), residual_.force.end(), right_side_.begin());
    for (std::size_t i = 0; i < m_; ++i) right_side_[n_ + i] = scale_ * residual_.acceleration[i];
    solve_linear();
    take_solution(state_);
    const double* const a = solution_.data() + m_;
    const double v_by_a = relation_->v_by_a, q_by_a = relation_->q_by_a();
    for (std::size_t i = 0; i < n_; ++i) change_[i] = q_by_a * a[i];
    directions_.solve(residual_.position, change_, of_mu_);
    add_product(system_.tangent_pattern()[Block::velocity_q], tangent_[Block::velocity_q], -1.0,
                change_.data(), residual_.velocity.data());
    for (std::size_t i = 0; i < n_; ++i) change_[i] = v_by_a * a[i];
    directions_.solve(residual_.velocity, change_, of_kappa_);
    for (std::size_t i = 0; i < m_; ++i) {
      kappa_[i] -= of_kappa_[i];
      mu_[i] -= of_mu_[i];
    }
    set_q_and_v();
    evaluate(view(state_));
  }

  void set_q_and_v() {
    const double v_by_a = relation_->v_by_a, q_by_a = relation_->q_by_a();
    for (std::size_t i = 0; i < n_; ++i) {
      const double change = state_.a.data()[i] - relation_->a.data()[i];
      along_[i] = q_by_a * change;
      along_[n_ + i] = v_by_a * change;
    }
    directions_.add(mu_, along_.data());
    directions_.add(kappa_, along_.data() + n_);
    for (std::size_t i = 0; i < n_; ++i) {
      state_.q.data()[i] = relation_->q.data()[i] + along_[i];
      state_.v.data()[i] = relation_->v.data()[i] + along_[n_ + i];
    }
  }

  /// Of the residual and the last correction.
  NewtonNorms norms() {
    NewtonNorms norms;
    norms.violation = {largest_size(residual_.position), largest_size(residual_.velocity),
                       largest_size(residual_.acceleration)};
    norms.residual = std::max(largest_size(residual_.force),
                              *std::max_element(norms.violation.begin(), norms.violation.end()));
    for (std::size_t i = 0; i < n_; ++i)
      norms.followed = std::max(norms.followed, followed_[i] * std::abs(residual_.force[i]));
    double sum = 0.0;
    for (std::size_t i = 0; i < 2 * n_; ++i) {
      const double value = i < n_ ? state_.q.data()[i] : state_.v.data()[i - n_];
      const double change = (value - y_[i]) / weights_[i];
      y_[i] = value;
      sum += change * change;
    }
    norms.correction = n_ == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(2 * n_));
    return norms;
  }

  const IntegratorOptions& options_;
  const Executor& executor_;
  IntegrationReport& report_;
  const std::size_t n_, m_;
  const Pattern& gradient_;
  const TransposedPattern transposed_;
  const std::vector<double> followed_;  ///< followed_forces()
  Augmentation augmentation_;
  ConstraintDirections directions_;
  Composition matrix_;
  std::vector<double> values_;
  std::vector<Composition::Values> terms_;
  Solver solver_;
  NewtonProgress progress_;
  Residual residual_;
  Tangent tangent_, predicted_;  ///< of the last Jacobian; Phi_q at the prediction
  BlockSet due_ = BlockSet::all(), constant_;
  std::array<std::vector<int>, kForceByAVQ.size()> diagonal_;
  std::vector<double> right_side_, solution_, change_;
  std::vector<double> kappa_, mu_, of_kappa_, of_mu_;  ///< in this search; of the last correction
  std::vector<double> along_, y_;  ///< changes of [q, v]; [q, v] before the last correction
  StepState state_;
  const StepRelation* relation_ = nullptr;
  const double* weights_ = nullptr;
  bool factored_ = false;
  double scale_ = 1.0, q_by_a_ = 1.0;  ///< of the last matrix
  int slow_steps_ = 0;
};

bool CondensedNewton::suits(const ConstrainedSystem& system) {
  for (int row = 0; row < system.constraints(); ++row)
    if (system.is_nonholonomic(row)) return false;
  return is_of_joints(system);
}

bool CondensedNewton::is_of_joints(const ConstrainedSystem& system) {
  if (!system.remote_tangents().empty()) return false;
  std::vector<int> constraints_of(static_cast<std::size_t>(system.coordinates()), 0);
  for (const int coordinate : system.tangent_pattern()[Block::position_q].column)
    ++constraints_of[coordinate];
  const auto few = [&](int most) {
    return std::count_if(constraints_of.begin(), constraints_of.end(), [most](int k) { return k <= most; });
  };
  const auto all = static_cast<std::ptrdiff_t>(constraints_of.size());
  return 2 * few(0) < all && few(kMostConstraints) == all;
}

CondensedNewton::CondensedNewton(const ConstrainedSystem& system, const Projection& projection,
                                 const IntegratorOptions& options, const Executor& executor,
                                 IntegrationReport& report)
    : impl_(std::make_unique<Impl>(system, projection, options, executor, report)) {}
CondensedNewton::~CondensedNewton() = default;

void CondensedNewton::make_consistent(StepState& state) {
  impl_->make_consistent(state);
}
void CondensedNewton::find_accelerations(StepState& state, double h) {
  impl_->find_accelerations(state, h);
}
NewtonOutcome CondensedNewton::solve(const StepRelation& relation, const Array<double>& lambda,
                                     const Array<double>& weights, StepState& state) {
  return impl_->solve(relation, lambda, weights, state);
}
bool CondensedNewton::filter_error(Array<double>& e) {
  return impl_->filter_error(e);
}
int CondensedNewton::size() const {
  return impl_->composition().pattern().rows;
}
std::size_t CondensedNewton::entries() const {
  return impl_->composition().pattern().entries();
}
const std::vector<double>& CondensedNewton::constraint_gradient() const {
  return impl_->constraint_gradient();
}
int CondensedNewton::slow_steps() const {
  return impl_->slow_steps();
}

}  // namespace mfs::dae
