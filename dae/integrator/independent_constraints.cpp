#include "dae/integrator/independent_constraints.hpp"

namespace mfs::dae {
namespace {

bool of_constraints(std::size_t block) {
  return block >= static_cast<std::size_t>(Block::position_q);
}

void take(const std::vector<double>& from, const std::vector<int>& rows, std::vector<double>& to) {
  for (std::size_t k = 0; k < rows.size(); ++k) to[k] = from[rows[k]];
}

}  // namespace

IndependentConstraints::IndependentConstraints(const ConstrainedSystem& system,
                                               const std::vector<int>& redundant)
    : system_(system),
      pattern_(system.tangent_pattern()),
      lambda_(static_cast<std::size_t>(system.constraints()), 0.0),
      residual_(make_residual(system)),
      tangent_(make_tangent(system)) {
  std::vector<char> out(lambda_.size(), 0);
  for (const int row : redundant) out[row] = 1;
  for (int row = 0; row < system.constraints(); ++row)
    if (out[row] == 0) kept_.push_back(row);
  for (std::size_t b = 0; b < kBlocks; ++b) {
    if (!of_constraints(b)) continue;
    const Pattern& all = system.tangent_pattern().block[b];
    Pattern rows{static_cast<int>(kept_.size()), all.columns, {0}, {}};
    for (const int row : kept_) {
      for (int k = all.row_start[row]; k < all.row_start[row + 1]; ++k) {
        rows.column.push_back(all.column[k]);
        source_[b].push_back(k);
      }
      rows.row_start.push_back(static_cast<int>(rows.column.size()));
    }
    pattern_.block[b] = std::move(rows);
  }
}

StateView IndependentConstraints::with_all_multipliers(const StateView& state) const {
  for (std::size_t k = 0; k < kept_.size(); ++k) lambda_[kept_[k]] = state.lambda[k];
  StateView all = state;
  all.lambda = lambda_.data();
  return all;
}

void IndependentConstraints::evaluate(const StateView& state, Residual& residual) const {
  residual_.force.swap(residual.force);
  system_.evaluate(with_all_multipliers(state), residual_);
  residual_.force.swap(residual.force);
  take(residual_.position, kept_, residual.position);
  take(residual_.velocity, kept_, residual.velocity);
  take(residual_.acceleration, kept_, residual.acceleration);
}

void IndependentConstraints::evaluate(const StateView& state, Tangent& tangent, BlockSet blocks) const {
  const auto lend_forces = [&] {
    for (std::size_t b = 0; b < kBlocks; ++b)
      if (!of_constraints(b)) tangent_.values[b].swap(tangent.values[b]);
  };
  lend_forces();
  system_.evaluate(with_all_multipliers(state), tangent_, blocks);
  lend_forces();
  for (std::size_t b = 0; b < kBlocks; ++b)
    if (of_constraints(b) && blocks.has(static_cast<Block>(b)))
      take(tangent_.values[b], source_[b], tangent.values[b]);
}

}  // namespace mfs::dae
