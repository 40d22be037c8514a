#include "dae/statics/block_vectors.hpp"

#include <algorithm>
#include <cmath>

#include "dae/integrator/composition.hpp"
#include "dae/statics/constrained_matrix.hpp"

namespace mfs::dae {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd product(const Pattern& pattern, const std::vector<double>& values, const VectorXd& x,
                 bool transposed) {
  const std::vector<double> y = product(pattern, values, std::vector<double>(x.begin(), x.end()), transposed);
  return Eigen::Map<const VectorXd>(y.data(), static_cast<Index>(y.size()));
}

VectorXd diagonal_sizes(const Pattern& pattern, const std::vector<double>& values) {
  VectorXd sizes = VectorXd::Zero(pattern.rows);
  const std::vector<int> place = find_diagonal(pattern);
  for (int i = 0; i < pattern.rows; ++i)
    if (place[i] >= 0) sizes[i] = std::abs(values[place[i]]);
  return sizes;
}

double median(std::vector<double> numbers) {
  const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return *middle;
}

VectorXd irregular(Index size, int number) {
  VectorXd x(size);
  for (Index i = 0; i < size; ++i) x[i] = std::sin(1.0 + 1.7 * static_cast<double>(i * number));
  return x;
}

}  // namespace mfs::dae
