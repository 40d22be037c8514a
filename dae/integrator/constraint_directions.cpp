#include "dae/integrator/constraint_directions.hpp"

#include <algorithm>
#include <tuple>

#include <mfs/error.hpp>

namespace mfs::dae {

ConstraintDirections::ConstraintDirections(const Pattern& gradient, const Projection& projection)
    : gradient_(gradient),
      shared_(projection.rows),
      rows_(take_rows(gradient, shared_)),
      transposed_(rows_.first),
      again_(transposed_.pattern),
      square_(transposed_.pattern, again_, 1),
      values_(rows_.second.size()) {
  for (int row = 0; row < gradient.rows; ++row)
    if (const int k = projection.tied_entry[row]; k >= 0) tied_.push_back({row, k, gradient.column[k]});
  const Pattern& pattern = square_.pattern();
  matrix_.resize(pattern.rows, pattern.rows);
  matrix_.resizeNonZeros(static_cast<Eigen::Index>(pattern.entries()));
  std::copy(pattern.row_start.begin(), pattern.row_start.end(), matrix_.outerIndexPtr());
  std::copy(pattern.column.begin(), pattern.column.end(), matrix_.innerIndexPtr());
  right_side_.resize(pattern.rows);
  factors_.analyzePattern(matrix_);
}

void ConstraintDirections::factor(const std::vector<double>& gradient) {
  for (std::size_t k = 0; k < values_.size(); ++k) values_[k] = gradient[rows_.second[transposed_.source[k]]];
  square_.compute(values_);
  std::copy(square_.values().begin(), square_.values().end(), matrix_.valuePtr());
  factors_.factorize(matrix_);
  if (factors_.info() != Eigen::Success)
    throw SingularMatrix(SingularMatrix::Kind::numerical, -1, -1, 1, "constraints depend on each other");
}

double ConstraintDirections::product(int row, const double* change) const {
  double sum = 0.0;
  for (int k = gradient_.row_start[row]; k < gradient_.row_start[row + 1]; ++k)
    sum += now_[k] * change[gradient_.column[k]];
  return sum;
}

void ConstraintDirections::add_row(int row, double x, double* change) const {
  for (int k = gradient_.row_start[row]; k < gradient_.row_start[row + 1]; ++k)
    change[gradient_.column[k]] += now_[k] * x;
}

void ConstraintDirections::add(const std::vector<double>& x, double* change) const {
  for (const int row : shared_) add_row(row, x[row], change);
  for (const Tied& tied : tied_) change[tied.coordinate] += x[tied.row];
}

void ConstraintDirections::solve(const std::vector<double>& b, std::vector<double>& change,
                                 std::vector<double>& x) {
  for (std::size_t j = 0; j < shared_.size(); ++j)
    right_side_[static_cast<Eigen::Index>(j)] = b[shared_[j]] - product(shared_[j], change.data());
  if (!shared_.empty()) solution_ = factors_.solve(right_side_);
  for (std::size_t j = 0; j < shared_.size(); ++j) {
    const int row = shared_[j];
    x[row] = solution_[static_cast<Eigen::Index>(j)];
    add_row(row, x[row], change.data());
  }
  for (const Tied& tied : tied_) {
    x[tied.row] = (b[tied.row] - product(tied.row, change.data())) / now_[tied.entry];
    change[tied.coordinate] += x[tied.row];
  }
}

}  // namespace mfs::dae
