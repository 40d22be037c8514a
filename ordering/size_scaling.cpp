#include "ordering/size_scaling.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

namespace mfs {
namespace {

constexpr std::int32_t kLimit = 1020;  // no scale leaves 2^-1020 ... 2^1020

/// |A| |x| + |b|, or |A^T| |x| + |b|.
template <class Scalar>
std::vector<double> sizes(const Pattern& pattern, const Scalar* values, const Scalar* b, const Scalar* x,
                          bool transposed) {
  std::vector<double> size(static_cast<std::size_t>(pattern.n));
  for (Vertex i = 0; i < pattern.n; ++i) size[i] = std::abs(b[i]);
  for (Vertex i = 0; i < pattern.n; ++i) {
    for (Offset k = pattern.offsets[i]; k < pattern.offsets[i + 1]; ++k) {
      const Vertex j = pattern.columns[k];
      const double entry = std::abs(values[k]);
      if (transposed) {
        size[j] += entry * static_cast<double>(std::abs(x[i]));
      } else {
        size[i] += entry * static_cast<double>(std::abs(x[j]));
      }
    }
  }
  return size;
}

std::int32_t bringing_to_one(std::int32_t exponent) {
  return exponent == kZeroEntry ? 0 : std::clamp(-exponent, -kLimit, kLimit);
}

}  // namespace

template <class Scalar>
PowerScaling scaling_by_size(const Pattern& pattern, const Scalar* values, const Scalar* b, const Scalar* x,
                             bool transposed, int threads) {
  const std::vector<double> size = sizes(pattern, values, b, x, transposed);
  const auto has_size = [&](Vertex i) {
    return size[i] >= std::numeric_limits<double>::min() && std::isfinite(size[i]);
  };
  const std::vector<Exponent> exponents = exponents_of(values, pattern.nnz(), threads);
  PowerScaling scaling(pattern.n);
  std::vector<std::int32_t>&by_size = transposed ? scaling.column : scaling.row,
  &by_entry = transposed ? scaling.row : scaling.column;
  for (Vertex i = 0; i < pattern.n; ++i)
    by_size[i] = has_size(i) ? bringing_to_one(std::ilogb(size[i])) : -kLimit;  // as good as absent
  const LargestEntries beside = largest_entries(pattern, exponents, scaling, threads);
  for (Vertex i = 0; i < pattern.n; ++i)
    by_entry[i] = bringing_to_one((transposed ? beside.row : beside.column)[i]);
  const LargestEntries reached = largest_entries(pattern, exponents, scaling, threads);
  for (Vertex i = 0; i < pattern.n; ++i) {
    if (has_size(i)) continue;
    const std::int32_t largest = (transposed ? reached.column : reached.row)[i];
    if (largest != kZeroEntry) by_size[i] = std::clamp(by_size[i] - largest, -kLimit, kLimit);
  }
  return scaling;
}

#define MFS_INSTANTIATE(Scalar)                                                                            \
  template PowerScaling scaling_by_size(const Pattern&, const Scalar*, const Scalar*, const Scalar*, bool, \
                                        int);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs
