#include "dae/integrator/augmentation.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>

#include "dae/vectors/host_loops.hpp"

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
  const auto n = static_cast<std::size_t>(gradient.columns);
  pattern_.rows = pattern_.columns = gradient.columns;
  pattern_.row_start.assign(n + 1, 0);
  for (int row = 0; row < gradient.columns; ++row)
    if (transposed.pattern.row_start[row] < transposed.pattern.row_start[row + 1]) rows_.push_back(row);
  product_start_.assign(rows_.size() + 1, 0);
  for_rows([&](std::size_t r, const std::vector<int>& columns, const std::vector<int>& distinct) {
    pattern_.row_start[rows_[r] + 1] = static_cast<int>(distinct.size());
    product_start_[r + 1] = columns.size();
  });
  std::partial_sum(pattern_.row_start.begin(), pattern_.row_start.end(), pattern_.row_start.begin());
  std::partial_sum(product_start_.begin(), product_start_.end(), product_start_.begin());
  pattern_.column.resize(static_cast<std::size_t>(pattern_.row_start.back()));
  place_.resize(product_start_.back());
  for_rows([&](std::size_t r, const std::vector<int>& columns, const std::vector<int>& distinct) {
    const int start = pattern_.row_start[rows_[r]];
    std::copy(distinct.begin(), distinct.end(), pattern_.column.begin() + start);
    std::transform(columns.begin(), columns.end(),
                   place_.begin() + static_cast<std::ptrdiff_t>(product_start_[r]), [&](int column) {
                     const auto found = std::lower_bound(distinct.begin(), distinct.end(), column);
                     return start + static_cast<int>(found - distinct.begin());
                   });
  });
  values_.resize(pattern_.entries());
}

/// visit(r, columns of the products of row rows_[r], those that differ in ascending order), by all threads.
template <class Visit>
void Augmentation::for_rows(const Visit& visit) const {
  const auto count = static_cast<std::int64_t>(rows_.size());
#pragma omp parallel num_threads(threads_)
  {
    std::vector<int> columns, distinct;
#pragma omp for schedule(dynamic, 16)
    for (std::int64_t r = 0; r < count; ++r) {
      columns.clear();
      for_each_product(rows_[r], [&](int, int k) { columns.push_back(gradient_.column[k]); });
      distinct = columns;
      std::sort(distinct.begin(), distinct.end());
      distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
      visit(static_cast<std::size_t>(r), columns, distinct);
    }
  }
}

void Augmentation::compute(const std::vector<double>& gradient) {
  // The rows of frames, side by side, have many times more products than the others.
  parallel_for_shares(product_start_, threads_, [&](std::size_t r) {
    const int row = rows_[r];
    std::fill(values_.begin() + pattern_.row_start[row], values_.begin() + pattern_.row_start[row + 1], 0.0);
    const int* place = place_.data() + product_start_[r];
    for_each_product(row, [&](int t, int k) { values_[*place++] += gradient[t] * gradient[k]; });
  });
}

}  // namespace mfs::dae
