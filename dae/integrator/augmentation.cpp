#include "dae/integrator/augmentation.hpp"

#include <algorithm>

#include "dae/integrator/vector_loops.hpp"

namespace mfs::dae {

/// visit(t, k) for the products of entries t and k of Phi_q that row `row` of Phi_q^T Phi_q is the sum of.
template <class Visit>
void Augmentation::for_each_product(int row, const Visit& visit) const {
  for (int t = transposed_.pattern.row_start[row]; t < transposed_.pattern.row_start[row + 1]; ++t) {
    const int constraint = transposed_.pattern.column[t];
    for (int k = gradient_.row_start[constraint]; k < gradient_.row_start[constraint + 1]; ++k)
      visit(transposed_.source[t], k);
  }
}

Augmentation::Augmentation(const Pattern& gradient, const TransposedPattern& transposed, int threads)
    : gradient_(gradient), transposed_(transposed), threads_(team_size(threads)) {
  pattern_.rows = pattern_.columns = gradient.columns;
  pattern_.row_start.assign(1, 0);
  std::vector<int> columns;
  for (int row = 0; row < pattern_.rows; ++row) {
    columns.clear();
    for_each_product(row, [&](int, int k) { columns.push_back(gradient_.column[k]); });
    if (!columns.empty()) {
      rows_.push_back(row);
      product_start_.push_back(place_.size());
    }
    std::vector<int> distinct = columns;
    std::sort(distinct.begin(), distinct.end());
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    for (const int column : columns)
      place_.push_back(
          pattern_.row_start.back() +
          static_cast<int>(std::lower_bound(distinct.begin(), distinct.end(), column) - distinct.begin()));
    pattern_.column.insert(pattern_.column.end(), distinct.begin(), distinct.end());
    pattern_.row_start.push_back(static_cast<int>(pattern_.column.size()));
  }
  values_.resize(pattern_.entries());
}

void Augmentation::compute(const std::vector<double>& gradient) {
  const int count = static_cast<int>(rows_.size());
  // The rows of frames, side by side, have many times more products than the others.
#pragma omp parallel for num_threads(threads_) schedule(dynamic, 16)
  for (int r = 0; r < count; ++r) {
    const int row = rows_[r];
    std::fill(values_.begin() + pattern_.row_start[row], values_.begin() + pattern_.row_start[row + 1], 0.0);
    const int* place = place_.data() + product_start_[r];
    for_each_product(row, [&](int t, int k) { values_[*place++] += gradient[t] * gradient[k]; });
  }
}

}  // namespace mfs::dae
