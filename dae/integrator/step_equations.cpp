#include "dae/integrator/step_equations.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>
#include <utility>

#include <mfs/error.hpp>

#include "dae/integrator/followed_forces.hpp"
#include "dae/vectors/loops.hpp"
#include "dae/vectors/operations.hpp"

namespace mfs::dae {
namespace {

/// Coordinates whose role is one of these.
std::vector<int> members(const std::vector<Role>& roles, std::initializer_list<Role> wanted) {
  std::vector<int> found;
  for (std::size_t i = 0; i < roles.size(); ++i)
    if (std::find(wanted.begin(), wanted.end(), roles[i]) != wanted.end())
      found.push_back(static_cast<int>(i));
  return found;
}

/// x = [lambda, a, v, q, kappa, mu], v and q of those coordinates that are kept.
struct Pack {
  const int* kept;
  const double *lambda, *a, *v, *q;
  double* x;
  std::size_t first_a, first_v, first_q, first_kappa;
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    x[i] = i < first_a       ? lambda[i]
           : i < first_v     ? a[i - first_a]
           : i < first_q     ? v[kept[i - first_v]]
           : i < first_kappa ? q[kept[i - first_q]]
                             : 0.0;
  }
};

/// The other way; v and q of coordinates that are not kept follow from a.
struct Unpack {
  const int* kept_place;  ///< of each coordinate among those that are kept, or -1
  const double* x;
  const double *q0, *v0, *a0;
  double *lambda, *q, *v, *a;
  std::size_t first_a, first_v, first_q;
  double v_by_a, q_by_v;
  MFS_HOST_DEVICE void operator()(std::size_t k) const {
    if (k < first_a) {
      lambda[k] = x[k];
      return;
    }
    const std::size_t i = k - first_a;
    const int place = kept_place[i];
    a[i] = x[k];
    if (place < 0) {
      const double change = v_by_a * (x[k] - a0[i]);
      v[i] = v0[i] + change;
      q[i] = q0[i] + q_by_v * change;
    } else {
      v[i] = x[first_v + static_cast<std::size_t>(place)];
      q[i] = x[first_q + static_cast<std::size_t>(place)];
    }
  }
};

/// Groups of rows, each with a factor.
struct ScaleGroups {
  static constexpr int kMost = 6;
  const double* h;
  double* b;
  std::size_t end[kMost];
  double factor[kMost];
  int groups = 0;
  void add(int rows, double with) {
    end[groups] = (groups > 0 ? end[groups - 1] : 0) + static_cast<std::size_t>(rows);
    factor[groups++] = with;
  }
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    int group = 0;
    while (i >= end[group]) ++group;
    b[i] = factor[group] * h[i];
  }
};

/// lambda + Phi_q a, then a, v, q, kappa and mu, each with a factor.
struct Correct {
  const int *start, *column;  ///< of the entries of Phi_q; columns of x
  const double *gradient, *solution;
  double* x;
  std::size_t first_a, first_v, first_q, first_kappa, first_mu;
  double of_a, of_v, of_q;
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    if (i >= first_a) {
      const bool rates = i < first_q || (i >= first_kappa && i < first_mu);
      x[i] = (i < first_v ? of_a : rates ? of_v : of_q) * solution[i];
      return;
    }
    double sum = solution[i];
    for (int k = start[i]; k < start[i + 1]; ++k) sum += gradient[k] * solution[column[k]];
    x[i] = sum;
  }
};

/// The rows that tie v and q to a.
struct Relations {
  const int *related, *start, *column;  ///< coordinates; their entries of B
  const double *direction, *kappa, *mu;
  const double *q, *v, *a, *q0, *v0, *a0;
  double v_by_a, q_by_v;
  double* h;
  std::size_t count;
  MFS_HOST_DEVICE void operator()(std::size_t k) const {
    const int i = related[k];
    double of_v = 0.0, of_q = 0.0;
    for (int e = start[k]; e < start[k + 1]; ++e) {
      of_v += direction[e] * kappa[column[e]];
      of_q += direction[e] * mu[column[e]];
    }
    h[k] = v_by_a * (a[i] - a0[i]) - (v[i] - v0[i]) + of_v;
    h[count + k] = q_by_v * (v[i] - v0[i]) - (q[i] - q0[i]) + of_q;
  }
};

/// Where constraints on velocities have no Phi: their mu.
struct NoPosition {
  const int *row, *mu;
  const double* x;
  double* h;
  MFS_HOST_DEVICE void operator()(std::size_t k) const { h[row[k]] = x[mu[k]]; }
};

/// Of all rows but those of F and one group, which gets a factor: zero.
struct KeepForceAnd {
  double* b;
  std::size_t n, begin, end;
  double factor;
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    if (i >= n) b[i] = i >= begin && i < end ? factor * b[i] : 0.0;
  }
};

/// Of the rows of constraints, those of accelerations times a factor go to all levels, what follows them is
/// zero.
struct SpreadAccelerations {
  double* b;  ///< the first of these rows
  std::size_t m;
  double factor;
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    if (i < m)
      b[i] = b[m + i] = b[2 * m + i] = factor * b[2 * m + i];
    else if (i >= 3 * m)
      b[i] = 0.0;
  }
};

struct SetZero {
  const int* row;
  double* b;
  MFS_HOST_DEVICE void operator()(std::size_t k) const { b[row[k]] = 0.0; }
};

struct TakeVelocities {
  const int* kept_place;  ///< of each coordinate among those that are kept, or -1
  const double* x;
  double* v;
  std::size_t first_a, first_v;
  double v_by_a;
  MFS_HOST_DEVICE void operator()(std::size_t i) const {
    const int place = kept_place[i];
    v[i] = place < 0 ? v_by_a * x[first_a + i] : x[first_v + static_cast<std::size_t>(place)];
  }
};

/// lambda - x, a - x.
struct Subtract {
  const double* x;
  double *lambda, *a;
  std::size_t m;
  MFS_HOST_DEVICE void operator()(std::size_t i) const { (i < m ? lambda[i] : a[i - m]) -= x[i]; }
};

Pattern make_selection(const std::vector<int>& members, int columns) {
  return {static_cast<int>(members.size()), columns, consecutive(0, static_cast<int>(members.size()) + 1),
          RawVector<int>(members.begin(), members.end())};
}

}  // namespace

StepEquations::StepEquations(const ConstrainedSystem& system, Unknowns unknowns, Projection projection,
                             const Executor& executor, RemoteResidual* remote)
    : system_(system),
      n_(system.coordinates()),
      m_(system.constraints()),
      reduced_(unknowns == Unknowns::reduced),
      executor_(executor),
      remote_(remote),
      projection_(std::move(projection)),
      related_(reduced_ ? members(projection_.role, {Role::shared})
                        : members(projection_.role, {Role::free, Role::shared})),
      size_(number_unknowns()),
      position_transposed_(system.tangent_pattern()[Block::position_q]),
      augmentation_(system.tangent_pattern()[Block::position_q], position_transposed_, executor.threads()),
      selection_(make_selection(related_, n_)),
      ones_(std::max(related_.size(), static_cast<std::size_t>(system.constraints())), 1.0),
      minus_ones_(related_.size(), -1.0),
      residual_(make_residual(system)),
      tangent_(make_tangent(system)),
      composition_(make_composition(executor.threads())) {
  direction_tangent_[Block::position_q].resize(tangent_[Block::position_q].size());
  for (std::size_t b = 0; b < kForceByAVQ.size(); ++b)
    diagonal_[b] = find_diagonal(system.tangent_pattern()[kForceByAVQ[b]]);
  for (auto& diagonal : diagonals_) diagonal.resize(projection_.role.size());
  followed_.assign(executor_, followed_forces(system));
  find_ringing();
  place_remotes();
  place_numbers();
}

/// What the passes over vectors look up.
void StepEquations::place_numbers() {
  std::vector<int> kept_place(projection_.role.size(), -1), gradient_column;
  for (std::size_t k = 0; k < kept_.size(); ++k) kept_place[kept_[k]] = static_cast<int>(k);
  const Pattern& gradient = system_.tangent_pattern()[Block::position_q];
  for (const int coordinate : gradient.column) gradient_column.push_back(column_[kA][coordinate]);
  kept_there_.assign(executor_, kept_);
  kept_place_.assign(executor_, kept_place);
  related_there_.assign(executor_, related_);
  direction_start_.assign(executor_, directions_.row_start);
  direction_column_.assign(executor_, std::vector<int>(directions_.column.begin(), directions_.column.end()));
  no_multipliers_.assign(executor_, std::vector<double>(static_cast<std::size_t>(m_), 0.0));
  gradient_start_.assign(executor_, gradient.row_start);
  gradient_column_.assign(executor_, gradient_column);
  std::vector<int> row, mu;
  for (int j = 0; j < nonholonomic_.rows; ++j)
    for (int k = nonholonomic_.row_start[j]; k < nonholonomic_.row_start[j + 1]; ++k) {
      row.push_back(n_ + j);
      mu.push_back(static_cast<int>(first_mu()) + nonholonomic_.column[k]);
    }
  nonholonomic_row_.assign(executor_, row);
  nonholonomic_mu_.assign(executor_, mu);
}

/// Leaves both patterns empty where there are no constraints on velocities.
void StepEquations::find_nonholonomic() {
  const Pattern& gradient = system_.tangent_pattern()[Block::position_q];
  Pattern kept{m_, n_, {0}, {}}, left{m_, static_cast<int>(projection_.rows.size()), {0}, {}};
  std::vector<int> source;
  for (int j = 0; j < m_; ++j) {
    if (system_.is_nonholonomic(j)) {
      const auto place = std::lower_bound(projection_.rows.begin(), projection_.rows.end(), j);
      left.column.push_back(static_cast<int>(place - projection_.rows.begin()));
    } else {
      for (int k = gradient.row_start[j]; k < gradient.row_start[j + 1]; ++k) {
        kept.column.push_back(gradient.column[k]);
        source.push_back(k);
      }
    }
    kept.row_start.push_back(static_cast<int>(source.size()));
    left.row_start.push_back(static_cast<int>(left.column.size()));
  }
  if (left.entries() == 0) return;
  holonomic_ = std::move(kept);
  holonomic_source_ = std::move(source);
  nonholonomic_ = std::move(left);
}

int StepEquations::number_unknowns() {
  column_[kLambda] = consecutive(0, m_);
  column_[kA] = consecutive(m_, n_);
  for (int i = 0; i < n_; ++i)
    if (!eliminated(i)) kept_.push_back(i);
  int next = m_ + n_;
  for (const Kind kind : {kV, kQ})
    for (std::size_t i = 0; i < projection_.role.size(); ++i)
      column_[kind].push_back(eliminated(i) ? column_[kA][i] : next++);
  return next + 2 * static_cast<int>(projection_.rows.size());
}

Composition StepEquations::make_composition(int threads) {
  find_nonholonomic();
  const TangentPattern& patterns = system_.tangent_pattern();
  std::vector<Composition::Term> terms;
  const auto add = [&](Row row, Block block, Kind kind) {
    const int level = row == kForce ? -1 : row - kPosition;
    terms.push_back({&patterns[block], row == kForce ? 0 : n_ + level * m_, column_[kind]});
    due_.insert(block);
    if (patterns.constant[static_cast<std::size_t>(block)]) constant_.insert(block);
    numbers_.push_back({&tangent_[block], row, kind});
  };
  add(kForce, Block::force_a, kA);
  add(kForce, Block::force_v, kV);
  add(kForce, Block::force_q, kQ);
  terms.push_back({&position_transposed_.pattern, 0, column_[kLambda], position_transposed_.source.data()});
  numbers_.push_back({&tangent_[Block::position_q], kForce, kLambda});
  // Row by row of Phi_q^T, Phi_q as it stands in the rows of constraints.
  terms.push_back({&augmentation_.pattern(), 0, column_[kA]});
  numbers_.push_back({&augmentation_.values(), kPosition, kA});
  add(kPosition, Block::position_q, kQ);
  if (nonholonomic_.rows > 0) {
    terms.back().block = &holonomic_;
    terms.back().source = holonomic_source_.data();
    terms.push_back({&nonholonomic_, n_, consecutive(static_cast<int>(first_mu()), nonholonomic_.columns)});
    numbers_.push_back({&ones_, kRelation, kQ});
  }
  add(kVelocity, Block::position_q, kV);
  add(kVelocity, Block::velocity_q, kQ);
  add(kAcceleration, Block::position_q, kA);
  add(kAcceleration, Block::acceleration_v, kV);
  add(kAcceleration, Block::acceleration_q, kQ);
  add_relations(terms);
  for (RemoteTangent* const remote : system_.remote_tangents()) {
    remotes_.push_back({remote, terms.size()});
    for (const Kind kind : {kA, kV, kQ}) {
      terms.push_back({&remote->pattern(), 0, column_[kind], nullptr, true});
      numbers_.push_back({nullptr, kForce, kind});
    }
  }
  return Composition(size_, std::move(terms), threads);
}

void StepEquations::add_relations(std::vector<Composition::Term>& terms) {
  if (related_.empty()) return;
  std::vector<int> place;
  std::tie(directions_, place) = take_rows(projection_.directions, related_);
  const std::vector<int>& start = system_.tangent_pattern()[Block::position_q].row_start;
  for (const int k : place) {
    const int entry = projection_.source[k];
    direction_source_.push_back(entry);
    const auto after = std::upper_bound(start.begin(), start.end(), entry);
    direction_rows_.push_back(static_cast<int>(after - start.begin()) - 1);
  }
  std::sort(direction_rows_.begin(), direction_rows_.end());
  direction_rows_.erase(std::unique(direction_rows_.begin(), direction_rows_.end()), direction_rows_.end());
  direction_values_.resize(place.size());
  int row = n_ + kLevels * m_;
  const auto add = [&](Kind upper, Kind lower, std::size_t first_multiplier) {
    terms.push_back({&selection_, row, column_[upper]});
    numbers_.push_back({&ones_, kRelation, upper});
    terms.push_back({&selection_, row, column_[lower]});
    numbers_.push_back({&minus_ones_, kRelation, lower});
    if (directions_.entries() > 0) {
      terms.push_back(
          {&directions_, row, consecutive(static_cast<int>(first_multiplier), directions_.columns)});
      numbers_.push_back({&direction_values_, kRelation, lower});
    }
    row += selection_.rows;
  };
  add(kA, kV, first_kappa());
  add(kV, kQ, first_mu());
}

void StepEquations::place_remotes() {
  if (remotes_.empty()) return;
  remote_matrix_ =
      remotes_.front().tangent->make_matrix(composition_.pattern().entries(), composition_.own_entries());
  for (const Remote& remote : remotes_) {
    const RawVector<int> target[] = {composition_.take_targets(remote.first_term),
                                     composition_.take_targets(remote.first_term + 1),
                                     composition_.take_targets(remote.first_term + 2)};
    remote.tangent->place({target[0].data(), target[1].data(), target[2].data()}, *remote_matrix_);
  }
}

std::string StepEquations::unknown_name(int unknown) const {
  for (const Kind kind : {kA, kV, kQ}) {
    const auto place = std::find(column_[kind].begin(), column_[kind].end(), unknown);
    if (place != column_[kind].end())
      return system_.coordinate_name(static_cast<int>(place - column_[kind].begin()));
  }
  const auto kappa = static_cast<int>(first_kappa());
  if (unknown < kappa) return system_.constraint_name(unknown);
  return system_.constraint_name(projection_.rows[(unknown - kappa) % directions_.columns]);
}

void StepEquations::set_directions(const StateView& state) const {
  if (direction_values_.empty()) return;
  const StateView there{state.t, state.q, state.v, state.a, no_multipliers_.data()};
  std::vector<double>& gradient = direction_tangent_[Block::position_q];
  system_.evaluate_gradient(remote_ != nullptr ? remote_->bring(there) : there, direction_rows_,
                            direction_tangent_);
  for (std::size_t k = 0; k < direction_values_.size(); ++k) {
    direction_values_[k] = gradient[direction_source_[k]];
    if (!std::isfinite(direction_values_[k]))
      throw InvalidInput("constraints", "their derivatives are not finite", direction_source_[k]);
  }
  directions_there_.assign(executor_, direction_values_);
}

void StepEquations::pack(const StepRelation& relation, const double* lambda, double* x) const {
  for_each(executor_, static_cast<std::size_t>(size_),
           Pack{kept_there_.data(), lambda, relation.a.data(), relation.v.data(), relation.q.data(), x,
                first_acceleration(), first_velocity(), first_position(), first_kappa()});
}

void StepEquations::unpack(const double* x, const StepRelation& relation, StepState& state) const {
  state.t = relation.t;
  const auto n = static_cast<std::size_t>(n_), m = static_cast<std::size_t>(m_);
  state.lambda.resize(executor_, m);
  for (auto* part : {&state.q, &state.v, &state.a}) part->resize(executor_, n);
  for_each(executor_, m + n,
           Unpack{kept_place_.data(), x, relation.q.data(), relation.v.data(), relation.a.data(),
                  state.lambda.data(), state.q.data(), state.v.data(), state.a.data(), first_acceleration(),
                  first_velocity(), first_position(), relation.v_by_a, relation.q_by_v});
}

/// The product of both, which is finite where a step takes no time.
double StepEquations::Scales::of(Row row, Kind column) const {
  if (row == kRelation || column == kLambda) return 1.0;
  if (row == kForce) return (column == kA ? 1.0 : column == kV ? v_by_a : q_by_a()) / s;
  return (row == kAcceleration && column != kA ? v_by_a : 1.0) *
         (row != kPosition && column == kQ ? q_by_v : 1.0);
}

void StepEquations::scale_rows(const StepRelation& relation, const double* h, double* b) const {
  const double r = ratio(relation), of_acceleration = scales_.s * (1.0 + r) / (2.0 * r);  // 1 / shared there
  const double of_position = of_acceleration / relation.q_by_a(),
               of_velocity = of_acceleration / relation.v_by_a;
  ScaleGroups scale{h, b, {}, {}};
  scale.add(n_, 1.0);
  scale.add(m_, of_position);
  scale.add(m_, of_velocity);
  scale.add(m_, of_acceleration);
  if (!related_.empty()) {
    scale.add(selection_.rows, of_velocity);
    scale.add(selection_.rows, of_position);
  }
  for_each(executor_, static_cast<std::size_t>(size_), scale);
}

void StepEquations::correct(const StepRelation& relation, const double* solution, double* x) const {
  // Multipliers balance forces, whichever dominate: they are not scaled.
  const double shared = 2.0 * ratio(relation) / (1.0 + ratio(relation)) / scales_.s;
  // Where v and q are eliminated the matrix took them for a over its own rates.
  for_each(executor_, static_cast<std::size_t>(size_),
           Correct{gradient_start_.data(), gradient_column_.data(), gradient_.array().data(), solution, x,
                   first_acceleration(), first_velocity(), first_position(), first_kappa(), first_mu(),
                   shared, shared * relation.v_by_a, shared * relation.q_by_a()},
           static_cast<std::size_t>(size_) + gradient_.array().size());
}

/// F and the constraints.
void StepEquations::evaluate(const StateView& state, double* h) const {
  if (remote_ != nullptr) return remote_->evaluate(state, kLevels, h);
  system_.evaluate(state, residual_);
  parallel_for(residual_.force.size(), executor_.threads(),
               [&](std::size_t i) { h[i] = residual_.force[i]; });
  h = std::copy(residual_.position.begin(), residual_.position.end(), h + n_);
  h = std::copy(residual_.velocity.begin(), residual_.velocity.end(), h);
  std::copy(residual_.acceleration.begin(), residual_.acceleration.end(), h);
}

void StepEquations::residual(const double* x, const StepState& state, const StepRelation& relation,
                             double* h) const {
  evaluate(view(state), h);
  if (related_.empty()) return;
  for_each(executor_, related_.size(),
           Relations{related_there_.data(), direction_start_.data(), direction_column_.data(),
                     directions_there_.data(), x + first_kappa(), x + first_mu(), state.q.data(),
                     state.v.data(), state.a.data(), relation.q.data(), relation.v.data(), relation.a.data(),
                     relation.v_by_a, relation.q_by_v, h + n_ + kLevels * m_, related_.size()});
  if (nonholonomic_row_.size() > 0)
    for_each(executor_, nonholonomic_row_.size(),
             NoPosition{nonholonomic_row_.data(), nonholonomic_mu_.data(), x, h});
}

/// Of the derivatives of F that go to the columns of a, in the mean.
double StepEquations::typical_diagonal(const StepRelation& relation) const {
  const double v_by_a = relation.v_by_a, q_by_a = relation.q_by_a();
  const double sum = parallel_fold(
      diagonals_[0].size(), executor_.threads(), 0.0,
      [&](std::size_t i) {
        return std::abs(diagonals_[0][i] + v_by_a * diagonals_[1][i] + q_by_a * diagonals_[2][i]);
      },
      std::plus<>());
  return sum > 0.0 ? sum / n_ : 1.0;
}

/// Of the last Jacobian.
void StepEquations::find_ringing() const {
  const std::size_t n = diagonals_[0].size();
  double* const inertia = inertia_.room(executor_, n);
  double* const ringing = ringing_.room(executor_, n);
  parallel_for(n, executor_.threads(), [&](std::size_t i) {
    const double elastic = std::abs(diagonals_[0][i] * diagonals_[2][i]);
    const double viscous = diagonals_[1][i] * diagonals_[1][i], share = elastic / viscous;
    inertia[i] = diagonals_[0][i];
    ringing[i] = viscous > elastic ? share * share : 1.0;
  });
  inertia_.send(executor_);
  ringing_.send(executor_);
}

void StepEquations::send_gradient() const {
  const std::vector<double>& values = tangent_[Block::position_q];
  double* const gradient = gradient_.room(executor_, values.size());
  parallel_for(values.size(), executor_.threads(), [&](std::size_t k) { gradient[k] = values[k]; });
  gradient_.send(executor_);
}

void StepEquations::find_diagonals() const {
  for (std::size_t b = 0; b < kForceByAVQ.size(); ++b) {
    const std::vector<double>& values = tangent_[kForceByAVQ[b]];
    parallel_for(diagonals_[b].size(), executor_.threads(), [&](std::size_t i) {
      diagonals_[b][i] = diagonal_[b][i] >= 0 ? values[diagonal_[b][i]] : 0.0;
    });
  }
  for (const Remote& remote : remotes_) remote.tangent->add_diagonals({1.0, 1.0, 1.0}, diagonals_);
}

void StepEquations::jacobian(const StepState& state, const StepRelation& relation, double* values) const {
  const StateView there = view(state);
  const StateView here = remote_ != nullptr ? remote_->bring(there) : there;
  for (const Remote& remote : remotes_)
    remote_ != nullptr ? remote.tangent->begin_tangent(executor_, there)
                       : remote.tangent->begin_tangent(there);
  system_.evaluate(here, tangent_, due_);
  due_.erase(constant_);
  compose(relation, values);
  send_gradient();
}

void StepEquations::initial_jacobian(double* values) const {
  compose({}, values);
}

void StepEquations::compose(const StepRelation& relation, double* values) const {
  augmentation_.compute(tangent_[Block::position_q]);
  find_diagonals();
  find_ringing();
  scales_ = {typical_diagonal(relation), relation.v_by_a, relation.q_by_v};
  std::vector<Composition::Values> terms;
  for (const Numbers& numbers : numbers_)
    terms.push_back({numbers.block != nullptr ? numbers.block->data() : nullptr,
                     scales_.of(numbers.row, numbers.column)});
  composition_.compose(terms, remote_matrix_ ? remote_matrix_->own() : values);
  if (!remote_matrix_) return;
  remote_matrix_->begin();
  for (const Remote& remote : remotes_)
    remote.tangent->begin_sum({scales_.of(kForce, kA), scales_.of(kForce, kV), scales_.of(kForce, kQ)});
}

void StepEquations::initial_right_side(const StepState& state, double* b) const {
  evaluate(view(state), b);
  const auto n = static_cast<std::size_t>(n_), m = static_cast<std::size_t>(m_);
  const std::size_t last_level = n + static_cast<std::size_t>(kLevels - 1) * m;
  for_each(executor_, static_cast<std::size_t>(size_),
           KeepForceAnd{b, n, last_level, last_level + m, scales_.s});
}

void StepEquations::error_right_side(const StepState& state, const StepRelation& relation,
                                     const Array<double>& e, double* b) const {
  const auto n = static_cast<std::size_t>(n_);
  changed_a_.resize(executor_, n);
  copy(executor_, n, state.a.data(), changed_a_.data());
  combine(executor_, n, 1.0, changed_a_.data(), {1.0 / relation.v_by_a}, {e.data()});
  evaluate({state.t, state.q.data(), state.v.data(), changed_a_.data(), state.lambda.data()}, b);
  // What e is in the directions of constraints stays on all levels.
  for_each(executor_, static_cast<std::size_t>(size_) - n,
           SpreadAccelerations{b + n, static_cast<std::size_t>(m_), scales_.s});
  if (nonholonomic_row_.size() > 0)
    for_each(executor_, nonholonomic_row_.size(), SetZero{nonholonomic_row_.data(), b});
}

void StepEquations::take_velocities(const StepRelation& relation, const double* x, double* v) const {
  for_each(executor_, static_cast<std::size_t>(n_),
           TakeVelocities{kept_place_.data(), x, v, first_acceleration(), first_velocity(), relation.v_by_a});
}

void StepEquations::change_accelerations(const double* x, StepState& state) const {
  const auto m = static_cast<std::size_t>(m_);
  for_each(executor_, m + static_cast<std::size_t>(n_), Subtract{x, state.lambda.data(), state.a.data(), m});
}

}  // namespace mfs::dae
