// Vectors that may be null vectors of A, in scaled unknowns (x[u] / scale[u]), and how they are measured:
// by |A x| / | |A| |x| | in scaled rows, maximum norms. The scales of the factors leave open how rows are
// scaled that only small entries link, so what is small there is measured in balanced rows, too.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <type_traits>
#include <vector>

#include "kernels/stages/residual.hpp"
#include "kernels/stages/vector_ops.hpp"

namespace mfs {

/// What a residual is summed in where cancellation must leave digits.
template <class Scalar>
using Extended =
    std::conditional_t<std::is_same_v<Scalar, RealOf<Scalar>>, long double, std::complex<long double>>;

/// Rows of A with the scales of its rows and unknowns. `balanced_row_scale` makes those of `balance`
/// (ordering/scaling.hpp) when it is first called.
template <class Scalar>
struct ScaledRows {
  RowAccess<Scalar> rows;
  const double* row_scale;
  const double* scale;
  std::function<const double*()> balanced_row_scale;
};

/// Double: 1e-14. |A x| of at most so much of | |A| |x| | proves A singular to working precision.
template <class Scalar>
constexpr double singular_below() {
  return 45.0 * std::numeric_limits<RealOf<Scalar>>::epsilon();
}

/// r = b - A x for scaled unknowns x and unscaled rows (b empty: zero), and |A x| / | |A| |x| |.
template <class Exec, class Scalar>
double scaled_residual(const Exec& exec, const ScaledRows<Scalar>& a, const std::vector<Scalar>& b,
                       const std::vector<Scalar>& x, std::vector<Scalar>& r) {
  std::vector<double> products(x.size()), sizes(x.size());
  for_each_index(exec, "null vector", static_cast<Offset>(x.size()), [&](Offset i) {
    Extended<Scalar> sum = 0;
    double size = 0;
    for (Offset k = a.rows.offsets[i]; k < a.rows.offsets[i + 1]; ++k) {
      const Vertex column = a.rows.columns[k];
      const Extended<Scalar> term = Extended<Scalar>(a.rows.values[a.rows.slots ? a.rows.slots[k] : k]) *
                                    static_cast<long double>(a.scale[column]) * Extended<Scalar>(x[column]);
      sum += term;
      size += static_cast<double>(std::abs(term));
    }
    r[i] = static_cast<Scalar>(b.empty() ? -sum : Extended<Scalar>(b[i]) - sum);
    products[i] = static_cast<double>(std::abs(sum)) * a.row_scale[i];
    sizes[i] = size * a.row_scale[i];
  });
  double product = 0, size = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    product = std::max(product, products[i]);
    size = std::max(size, sizes[i]);
  }
  return product / size;
}

/// |A x| / | |A| |x| | for scaled unknowns x, where that is at most `bound` the larger of it and of the same
/// in balanced rows. r = -A x in unscaled rows.
template <class Exec, class Scalar>
double null_measure(const Exec& exec, const ScaledRows<Scalar>& a, double bound, const std::vector<Scalar>& x,
                    std::vector<Scalar>& r) {
  const double smallness = scaled_residual(exec, a, {}, x, r);
  if (!(smallness <= bound)) return smallness;
  ScaledRows<Scalar> balanced = a;
  balanced.row_scale = a.balanced_row_scale();
  return std::max(smallness, scaled_residual(exec, balanced, {}, x, r));
}

template <class Scalar>
double largest_size(const std::vector<Scalar>& x) {
  double largest = 0;
  for (const Scalar& entry : x) largest = std::max<double>(largest, std::abs(entry));
  return largest;
}

/// Makes x as long as 1; returns its length.
template <class Scalar>
double normalize(std::vector<Scalar>& x) {
  const double largest = largest_size(x);
  double sum = 0;
  for (const Scalar& entry : x) sum += std::norm(std::complex<double>(entry) / largest);
  const double length = largest * std::sqrt(sum);
  for (Scalar& entry : x) entry /= static_cast<RealOf<Scalar>>(length);
  return length;
}

/// Takes from x its part along a vector of the length 1.
template <class Scalar>
void subtract_projection(const std::vector<Scalar>& unit, std::vector<Scalar>& x) {
  Wide<Scalar> part = 0;
  for (std::size_t i = 0; i < x.size(); ++i) part += Wide<Scalar>(conjugated(unit[i])) * Wide<Scalar>(x[i]);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] -= static_cast<Scalar>(part) * unit[i];
}

}  // namespace mfs
