#include "solver/program/backward_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mfs::program {

double backward_error(const io::CsrMatrix<double>& a, bool transpose, const io::DenseMatrix<double>& x,
                      const io::DenseMatrix<double>& b, std::int64_t j) {
  const std::size_t n = static_cast<std::size_t>(a.rows), first = static_cast<std::size_t>(j) * n;
  std::vector<long double> residual(n), scale(n);
  for (std::size_t i = 0; i < n; ++i) {
    residual[i] = b.values[first + i];
    scale[i] = std::fabs(b.values[first + i]);
  }
  for (std::size_t row = 0; row < n; ++row)
    for (std::int64_t k = a.offsets[row]; k < a.offsets[row + 1]; ++k) {
      const std::size_t entry = static_cast<std::size_t>(k);
      const std::size_t column = static_cast<std::size_t>(a.column_indices[entry]);
      const std::size_t equation = transpose ? column : row, unknown = transpose ? row : column;
      const long double term = static_cast<long double>(a.values[entry]) * x.values[first + unknown];
      residual[equation] -= term;
      scale[equation] += std::fabs(term);
    }
  long double worst = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (!std::isfinite(x.values[first + i])) return std::numeric_limits<double>::infinity();
    if (scale[i] > 0) worst = std::max(worst, std::fabs(residual[i]) / scale[i]);
  }
  return static_cast<double>(worst);
}

double backward_error(const io::CsrMatrix<double>& a, bool transpose, const io::DenseMatrix<double>& x,
                      const io::DenseMatrix<double>& b) {
  double worst = 0;
  for (std::int64_t j = 0; j < x.columns; ++j) worst = std::max(worst, backward_error(a, transpose, x, b, j));
  return worst;
}

}  // namespace mfs::program
