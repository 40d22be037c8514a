#include "dae/integrator/step_equations.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "dae/integrator/vector_loops.hpp"

namespace mfs::dae {
namespace {

std::vector<int> set_members(const std::vector<char>& flags) {
  std::vector<int> members;
  for (std::size_t i = 0; i < flags.size(); ++i)
    if (flags[i] != 0) members.push_back(static_cast<int>(i));
  return members;
}

constexpr std::array<Block, 3> kForceByAVQ{Block::force_a, Block::force_v, Block::force_q};

/// Where the diagonal entries are, -1 where there are none.
std::vector<int> find_diagonal(const Pattern& pattern) {
  std::vector<int> places;
  for (int row = 0; row < pattern.rows; ++row) {
    const auto begin = pattern.column.begin() + pattern.row_start[row];
    const auto end = pattern.column.begin() + pattern.row_start[row + 1];
    const auto place = std::lower_bound(begin, end, row);
    places.push_back(place != end && *place == row ? static_cast<int>(place - pattern.column.begin()) : -1);
  }
  return places;
}

Pattern make_selection(const std::vector<int>& members, int columns) {
  return {static_cast<int>(members.size()), columns, consecutive(0, static_cast<int>(members.size()) + 1),
          RawVector<int>(members.begin(), members.end())};
}

}  // namespace

StepEquations::StepEquations(const ConstrainedSystem& system, Unknowns unknowns, bool all_levels,
                             const std::vector<char>& independent, int threads)
    : system_(system),
      n_(system.coordinates()),
      m_(system.constraints()),
      levels_(all_levels ? 3 : 1),
      reduced_(unknowns == Unknowns::reduced),
      threads_(threads),
      is_independent_(independent),
      independent_(set_members(independent)),
      size_(number_unknowns()),
      position_transposed_(system.tangent_pattern()[Block::position_q]),
      augmentation_(system.tangent_pattern()[Block::position_q], position_transposed_, threads),
      selection_(make_selection(independent_, n_)),
      ones_(independent_.size(), 1.0),
      minus_ones_(independent_.size(), -1.0),
      residual_(make_residual(system)),
      tangent_(make_tangent(system)),
      composition_(make_composition(threads)) {
  for (std::size_t b = 0; b < kForceByAVQ.size(); ++b)
    diagonal_[b] = find_diagonal(system.tangent_pattern()[kForceByAVQ[b]]);
  diagonal_sum_.resize(is_independent_.size());
  place_remotes();
}

int StepEquations::number_unknowns() {
  column_[kLambda] = consecutive(0, m_);
  column_[kA] = consecutive(first_acceleration(), n_);
  for (int i = 0; i < n_; ++i)
    if (!eliminated(i)) kept_.push_back(i);
  int next = m_ + n_;
  for (const Kind kind : {kV, kQ})
    for (std::size_t i = 0; i < is_independent_.size(); ++i)
      column_[kind].push_back(eliminated(i) ? column_[kA][i] : next++);
  return next;
}

Composition StepEquations::make_composition(int threads) {
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
  if (levels_ == 3) {
    add(kVelocity, Block::position_q, kV);
    add(kVelocity, Block::velocity_q, kQ);
    add(kAcceleration, Block::position_q, kA);
    add(kAcceleration, Block::acceleration_v, kV);
    add(kAcceleration, Block::acceleration_q, kQ);
  }
  if (!reduced_) {
    int row = n_ + levels_ * m_;
    const auto add_relation = [&](Kind upper, Kind lower) {
      terms.push_back({&selection_, row, column_[upper]});
      numbers_.push_back({&ones_, kRelation, upper});
      terms.push_back({&selection_, row, column_[lower]});
      numbers_.push_back({&minus_ones_, kRelation, lower});
      row += selection_.rows;
    };
    add_relation(kA, kV);
    add_relation(kV, kQ);
  }
  for (RemoteTangent* const remote : system_.remote_tangents()) {
    remotes_.push_back({remote, terms.size()});
    for (const Kind kind : {kA, kV, kQ}) {
      terms.push_back({&remote->pattern(), 0, column_[kind], nullptr, true});
      numbers_.push_back({nullptr, kForce, kind});
    }
  }
  return Composition(size_, std::move(terms), threads);
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
  return system_.constraint_name(unknown);
}

void StepEquations::pack(const StepRelation& relation, const std::vector<double>& lambda, double* x) const {
  std::copy(lambda.begin(), lambda.end(), x);
  double* const of_a = x + first_acceleration();
  parallel_for(is_independent_.size(), threads_, [&](std::size_t i) { of_a[i] = relation.a[i]; });
  parallel_for(
      kept_.size(), threads_,
      [&](std::size_t k) {
        const int i = kept_[k];
        x[column_[kV][i]] = relation.v[i];
        x[column_[kQ][i]] = relation.q[i];
      },
      4 * kept_.size());
}

void StepEquations::unpack(const double* x, const StepRelation& relation, State& state) const {
  state.t = relation.t;
  state.lambda.assign(x, x + m_);
  const auto n = is_independent_.size();
  for (auto* part : {&state.q, &state.v, &state.a}) part->resize(n);
  const double* const of_a = x + first_acceleration();
  parallel_for(n, threads_, [&](std::size_t i) {
    state.a[i] = of_a[i];
    const double change = relation.v_by_a * (state.a[i] - relation.a[i]);  // of v, where it is eliminated
    state.v[i] = relation.v[i] + change;
    state.q[i] = relation.q[i] + relation.q_by_v * change;
  });
  parallel_for(
      kept_.size(), threads_,
      [&](std::size_t k) {
        const int i = kept_[k];
        state.v[i] = x[column_[kV][i]];
        state.q[i] = x[column_[kQ][i]];
      },
      4 * kept_.size());
}

/// The product of both, which is finite where a step takes no time.
double StepEquations::Scales::of(Row row, Kind column) const {
  if (row == kRelation || column == kLambda) return 1.0;
  if (row == kForce) return (column == kA ? 1.0 : column == kV ? v_by_a : q_by_a()) / s;
  return (row == kAcceleration && column != kA ? v_by_a : 1.0) *
         (row != kPosition && column == kQ ? q_by_v : 1.0);
}

void StepEquations::scale_rows(const double* h, double* b) const {
  const auto scale = [&](int count, double factor) {
    parallel_for(static_cast<std::size_t>(count), threads_, [&](std::size_t i) { b[i] = factor * h[i]; });
    h += count;
    b += count;
  };
  const double of_position = scales_.s / scales_.q_by_a(), of_velocity = scales_.s / scales_.v_by_a;
  scale(n_, 1.0);
  scale(m_, of_position);
  if (levels_ == 3) {
    scale(m_, of_velocity);
    scale(m_, scales_.s);
  }
  if (reduced_) return;
  scale(selection_.rows, of_velocity);
  scale(selection_.rows, of_position);
}

void StepEquations::correct(const StepRelation& relation, double* x) const {
  const Pattern& gradient = system_.tangent_pattern()[Block::position_q];
  const std::vector<double>& values = constraint_gradient();
  const auto add_to_multiplier = [&](std::size_t row) {
    for (int k = gradient.row_start[row]; k < gradient.row_start[row + 1]; ++k)
      x[row] += values[k] * x[column_[kA][gradient.column[k]]];
  };
  parallel_for(static_cast<std::size_t>(m_), threads_, add_to_multiplier, gradient.entries());
  // Multipliers balance forces, whichever dominate: they are not scaled.
  const double shared = 2.0 * ratio(relation) / (1.0 + ratio(relation)) / scales_.s;
  double* const of_a = x + first_acceleration();
  parallel_for(is_independent_.size(), threads_, [&](std::size_t i) { of_a[i] *= shared; });
  // Where v and q are eliminated the matrix took them for a over its own rates.
  parallel_for(
      kept_.size(), threads_,
      [&](std::size_t k) {
        const int i = kept_[k];
        x[column_[kV][i]] *= shared * relation.v_by_a;
        x[column_[kQ][i]] *= shared * relation.q_by_a();
      },
      4 * kept_.size());
}

namespace {

StateView view(const State& state) {
  return {state.t, state.q.data(), state.v.data(), state.a.data(), state.lambda.data()};
}

}  // namespace

void StepEquations::residual(const State& state, const StepRelation& relation, double* h) const {
  system_.evaluate(view(state), residual_);
  parallel_for(residual_.force.size(), threads_, [&](std::size_t i) { h[i] = residual_.force[i]; });
  h += n_;
  h = std::copy(residual_.position.begin(), residual_.position.end(), h);
  if (levels_ == 3) {
    h = std::copy(residual_.velocity.begin(), residual_.velocity.end(), h);
    h = std::copy(residual_.acceleration.begin(), residual_.acceleration.end(), h);
  }
  if (reduced_) return;
  for (const int i : independent_)
    *h++ = relation.v_by_a * (state.a[i] - relation.a[i]) - (state.v[i] - relation.v[i]);
  for (const int i : independent_)
    *h++ = relation.q_by_v * (state.v[i] - relation.v[i]) - (state.q[i] - relation.q[i]);
}

/// Of the derivatives of F that go to the columns of a, in the mean.
double StepEquations::typical_diagonal(const StepRelation& relation) const {
  const ByAVQ factors{1.0, relation.v_by_a, relation.q_by_a()};
  parallel_for(diagonal_sum_.size(), threads_, [&](std::size_t i) {
    diagonal_sum_[i] = 0.0;
    for (std::size_t b = 0; b < kForceByAVQ.size(); ++b)
      if (diagonal_[b][i] >= 0) diagonal_sum_[i] += factors[b] * tangent_[kForceByAVQ[b]][diagonal_[b][i]];
  });
  for (const Remote& remote : remotes_) remote.tangent->add_diagonal(factors, diagonal_sum_);
  const double sum = parallel_fold(
      diagonal_sum_.size(), threads_, 0.0, [&](std::size_t i) { return std::abs(diagonal_sum_[i]); },
      std::plus<>());
  return sum > 0.0 ? sum / n_ : 1.0;
}

void StepEquations::jacobian(const State& state, const StepRelation& relation, double* values) const {
  for (const Remote& remote : remotes_) remote.tangent->begin_tangent(view(state));
  system_.evaluate(view(state), tangent_, due_);
  due_.erase(constant_);
  compose(relation, values);
}

void StepEquations::initial_jacobian(double* values) const {
  compose({}, values);
}

void StepEquations::compose(const StepRelation& relation, double* values) const {
  augmentation_.compute(constraint_gradient());
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

void StepEquations::initial_right_side(const State& state, double* b) const {
  system_.evaluate(view(state), residual_);
  std::fill(std::copy(residual_.force.begin(), residual_.force.end(), b), b + size_, 0.0);
  const int last_level = first_constraint() + (levels_ - 1) * m_;
  for (int row = 0; row < m_; ++row) b[last_level + row] = scales_.s * residual_.acceleration[row];
}

void StepEquations::change_accelerations(const double* x, State& state) const {
  for (int row = 0; row < m_; ++row) state.lambda[row] -= x[row];
  for (int i = 0; i < n_; ++i) state.a[i] -= x[column_[kA][i]];
}

}  // namespace mfs::dae
