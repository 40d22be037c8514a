#include "dae/integrator/step_equations.hpp"

#include <algorithm>
#include <cmath>

#include "dae/integrator/vector_loops.hpp"

namespace mfs::dae {
namespace {

std::vector<int> set_members(const std::vector<char>& flags) {
  std::vector<int> members;
  for (std::size_t i = 0; i < flags.size(); ++i)
    if (flags[i] != 0) members.push_back(static_cast<int>(i));
  return members;
}

Pattern make_selection(const std::vector<int>& members, int columns) {
  return {static_cast<int>(members.size()), columns, consecutive(0, static_cast<int>(members.size()) + 1),
          members};
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
      selection_(make_selection(independent_, n_)),
      ones_(independent_.size(), 1.0),
      residual_(make_residual(system)),
      tangent_(make_tangent(system)),
      composition_(make_composition(threads)) {
  const auto n = static_cast<std::size_t>(n_);
  for (auto* factor : {&factor_v_, &factor_q_, &relation_a_, &relation_v_}) factor->assign(n, 1.0);
  minus_.assign(n, -1.0);
}

int StepEquations::number_unknowns() {
  column_[kLambda] = consecutive(0, m_);
  column_[kA] = consecutive(m_, n_);
  int next = m_ + n_;
  for (const Kind kind : {kV, kQ})
    for (std::size_t i = 0; i < is_independent_.size(); ++i)
      column_[kind].push_back(eliminated(i) ? column_[kA][i] : next++);
  return next;
}

Composition StepEquations::make_composition(int threads) {
  const TangentPattern& patterns = system_.tangent_pattern();
  std::vector<Composition::Term> terms;
  const auto add = [&](int first_row, Block block, Kind kind) {
    terms.push_back({&patterns[block], first_row, column_[kind]});
    due_.insert(block);
    if (patterns.constant[static_cast<std::size_t>(block)]) constant_.insert(block);
    numbers_.push_back({&tangent_[block], kind == kV ? &factor_v_ : kind == kQ ? &factor_q_ : nullptr});
  };
  int row = 0;
  add(row, Block::force_a, kA);
  add(row, Block::force_v, kV);
  add(row, Block::force_q, kQ);
  terms.push_back({&position_transposed_.pattern, row, column_[kLambda], position_transposed_.source.data()});
  numbers_.push_back({&tangent_[Block::position_q], nullptr});
  add(row += n_, Block::position_q, kQ);
  if (levels_ == 3) {
    add(row += m_, Block::position_q, kV);
    add(row, Block::velocity_q, kQ);
    add(row += m_, Block::position_q, kA);
    add(row, Block::acceleration_v, kV);
    add(row, Block::acceleration_q, kQ);
  }
  row += m_;
  if (!reduced_) {
    const auto add_relation = [&](Kind upper, const std::vector<double>& factor, Kind lower) {
      terms.push_back({&selection_, row, column_[upper]});
      numbers_.push_back({&ones_, &factor});
      terms.push_back({&selection_, row, column_[lower]});
      numbers_.push_back({&ones_, &minus_});
      row += selection_.rows;
    };
    add_relation(kA, relation_a_, kV);
    add_relation(kV, relation_v_, kQ);
  }
  return Composition(size_, std::move(terms), threads);
}

void StepEquations::pack(const StepRelation& relation, const std::vector<double>& lambda, double* x) const {
  std::copy(lambda.begin(), lambda.end(), x);
  parallel_for(is_independent_.size(), threads_, [&](std::size_t i) {
    x[column_[kA][i]] = relation.a[i];
    if (eliminated(i)) return;
    x[column_[kV][i]] = relation.v[i];
    x[column_[kQ][i]] = relation.q[i];
  });
}

void StepEquations::unpack(const double* x, const StepRelation& relation, State& state) const {
  state.t = relation.t;
  state.lambda.assign(x, x + m_);
  const auto n = is_independent_.size();
  for (auto* part : {&state.q, &state.v, &state.a}) part->resize(n);
  parallel_for(n, threads_, [&](std::size_t i) {
    state.a[i] = x[column_[kA][i]];
    const double change = relation.v_by_a * (state.a[i] - relation.a[i]);  // of v, where it is eliminated
    state.v[i] = eliminated(i) ? relation.v[i] + change : x[column_[kV][i]];
    state.q[i] = eliminated(i) ? relation.q[i] + relation.q_by_v * change : x[column_[kQ][i]];
  });
}

void StepEquations::scale_corrections(double ratio, double* scale) const {
  const double of_q = 2.0 / (1.0 + ratio);
  std::fill(scale, scale + m_, 1.0);  // multipliers balance forces, whichever dominate
  parallel_for(is_independent_.size(), threads_, [&](std::size_t i) {
    scale[column_[kA][i]] = ratio * of_q;
    if (eliminated(i)) return;  // the matrix took v and q for a over its own rates
    scale[column_[kV][i]] = std::sqrt(ratio) * of_q;
    scale[column_[kQ][i]] = of_q;
  });
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

void StepEquations::set_factors(const StepRelation& relation) const {
  if (reduced_) {
    parallel_for(independent_.size(), threads_, [&](std::size_t k) {
      factor_v_[independent_[k]] = relation.v_by_a;
      factor_q_[independent_[k]] = relation.q_by_a();
    });
  } else {
    std::fill(relation_a_.begin(), relation_a_.end(), relation.v_by_a);
    std::fill(relation_v_.begin(), relation_v_.end(), relation.q_by_v);
  }
}

void StepEquations::jacobian(const State& state, const StepRelation& relation, double* values) const {
  system_.evaluate(view(state), tangent_, due_);
  due_.erase(constant_);
  set_factors(relation);
  std::vector<Composition::Values> terms;
  for (const Numbers& numbers : numbers_)
    terms.push_back({numbers.block->data(), numbers.factor != nullptr ? numbers.factor->data() : nullptr});
  composition_.compose(terms, values);
}

}  // namespace mfs::dae
