#include "solver/program/backward_error.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

namespace mfs::program {
namespace {

long double wide(double value) {
  return value;
}
std::complex<long double> wide(const std::complex<double>& value) {
  return {value.real(), value.imag()};
}

constexpr long double kLeast = std::numeric_limits<double>::denorm_min();

bool finite(double value) {
  return std::isfinite(value);
}
bool finite(const std::complex<double>& value) {
  return std::isfinite(value.real()) && std::isfinite(value.imag());
}

}  // namespace

template <class Scalar>
double backward_error(const io::CsrMatrix<Scalar>& a, bool transpose, const io::DenseMatrix<Scalar>& x,
                      const io::DenseMatrix<Scalar>& b, std::int64_t j) {
  const std::size_t n = static_cast<std::size_t>(a.rows), first = static_cast<std::size_t>(j) * n;
  std::vector<decltype(wide(Scalar()))> residual(n);
  std::vector<long double> scale(n), free(n, kLeast);
  for (std::size_t i = 0; i < n; ++i) {
    residual[i] = wide(b.values[first + i]);
    scale[i] = std::abs(residual[i]);
  }
  for (std::size_t row = 0; row < n; ++row)
    for (std::int64_t k = a.offsets[row]; k < a.offsets[row + 1]; ++k) {
      const std::size_t entry = static_cast<std::size_t>(k);
      const std::size_t column = static_cast<std::size_t>(a.column_indices[entry]);
      const std::size_t equation = transpose ? column : row, unknown = transpose ? row : column;
      const auto term = wide(a.values[entry]) * wide(x.values[first + unknown]);
      residual[equation] -= term;
      scale[equation] += std::abs(term);
      free[equation] += kLeast * (1 + 8 * std::abs(wide(a.values[entry])));
    }
  long double worst = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (!finite(x.values[first + i])) return std::numeric_limits<double>::infinity();
    const long double off = std::abs(residual[i]) - free[i];
    if (off > 0) worst = std::max(worst, off / scale[i]);
  }
  return static_cast<double>(worst);
}

template <class Scalar>
double backward_error(const io::CsrMatrix<Scalar>& a, bool transpose, const io::DenseMatrix<Scalar>& x,
                      const io::DenseMatrix<Scalar>& b) {
  double worst = 0;
  for (std::int64_t j = 0; j < x.columns; ++j) worst = std::max(worst, backward_error(a, transpose, x, b, j));
  return worst;
}

#define MFS_INSTANTIATE(S)                                                                 \
  template double backward_error(const io::CsrMatrix<S>&, bool, const io::DenseMatrix<S>&, \
                                 const io::DenseMatrix<S>&, std::int64_t);                 \
  template double backward_error(const io::CsrMatrix<S>&, bool, const io::DenseMatrix<S>&, \
                                 const io::DenseMatrix<S>&);
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs::program
