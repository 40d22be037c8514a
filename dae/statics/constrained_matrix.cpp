#include "dae/statics/constrained_matrix.hpp"

#include <utility>

#include <mfs/error.hpp>

#include "dae/statics/block_vectors.hpp"

namespace mfs::dae {
namespace {

Options solver_options(int threads, Backend backend) {
  Options options;
  options.backend = backend;
  options.threads = threads;
  options.solve.row_floor = kRowFloor;
  return options;
}

std::vector<Composition::Term> terms_of(const ConstrainedSystem& system, const TransposedPattern& transposed,
                                        const Augmentation& augmentation) {
  const int n = system.coordinates(), m = system.constraints();
  const TangentPattern& pattern = system.tangent_pattern();
  const std::vector<int> first = consecutive(0, n);
  return {{&pattern[Block::force_a], 0, first},
          {&pattern[Block::force_v], 0, first},
          {&pattern[Block::force_q], 0, first},
          {&augmentation.pattern(), 0, first},
          {&transposed.pattern, 0, consecutive(n, m), transposed.source.data()},
          {&pattern[Block::position_q], n, first}};
}

/// The median of the sizes of the diagonal's entries that are not zero, 1 where there are none.
double typical_diagonal(const Pattern& pattern, const std::vector<double>& values, int rows) {
  const Eigen::VectorXd all = diagonal_sizes(pattern, values);
  std::vector<double> sizes;
  for (int i = 0; i < rows; ++i)
    if (all[i] != 0) sizes.push_back(all[i]);
  return sizes.empty() ? 1.0 : median(std::move(sizes));
}

}  // namespace

ConstrainedMatrix::ConstrainedMatrix(const ConstrainedSystem& system, int threads, Backend backend)
    : system_(system),
      n_(system.coordinates()),
      m_(system.constraints()),
      transposed_(system.tangent_pattern()[Block::position_q]),
      augmentation_(system.tangent_pattern()[Block::position_q], transposed_, threads),
      matrix_(n_ + m_, terms_of(system, transposed_, augmentation_), threads),
      values_(matrix_.pattern().entries()),
      solver_(solver_options(threads, backend)) {}

void ConstrainedMatrix::factor(const Tangent& tangent, const ByAVQ& factors) {
  gradient_ = tangent[Block::position_q];
  augmentation_.compute(gradient_);
  const auto compose = [&](double augmented_by) {
    matrix_.compose({{tangent[Block::force_a].data(), factors[0]},
                     {tangent[Block::force_v].data(), factors[1]},
                     {tangent[Block::force_q].data(), factors[2]},
                     {augmentation_.values().data(), augmented_by},
                     {gradient_.data()},
                     {gradient_.data()}},
                    values_.data());
  };
  compose(0.0);
  augmented_by_ = typical_diagonal(matrix_.pattern(), values_, n_);
  compose(augmented_by_);
  const Pattern& pattern = matrix_.pattern();
  try {
    solver_.factor(
        {pattern.rows, pattern.columns, pattern.row_start.data(), pattern.column.data(), values_.data()});
  } catch (SingularMatrix& e) {
    const auto i = static_cast<int>(e.column());
    if (i >= 0)
      e.append(" (" + (i < n_ ? system_.coordinate_name(i) : system_.constraint_name(i - n_)) + ")");
    throw;
  }
}

/// With s Phi_q^T Phi_q added to A the same x fulfils the equations with mu - s c.
std::vector<double> ConstrainedMatrix::solve(std::vector<double> right_side) {
  const std::vector<double> c(right_side.begin() + n_, right_side.end());
  if (std::all_of(right_side.begin(), right_side.end(), [](double x) { return x == 0; })) return right_side;
  solver_.solve(right_side.data(), right_side.data());
  for (int j = 0; j < m_; ++j) right_side[n_ + j] += augmented_by_ * c[j];
  return right_side;
}

std::vector<double> product(const Pattern& pattern, const std::vector<double>& values,
                            const std::vector<double>& x, bool transposed) {
  std::vector<double> y(static_cast<std::size_t>(transposed ? pattern.columns : pattern.rows), 0.0);
  for (int i = 0; i < pattern.rows; ++i)
    for (int k = pattern.row_start[i]; k < pattern.row_start[i + 1]; ++k) {
      const int from = transposed ? i : pattern.column[k], to = transposed ? pattern.column[k] : i;
      y[to] += values[k] * x[from];
    }
  return y;
}

}  // namespace mfs::dae
