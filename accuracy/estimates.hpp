// What the condition estimate and the determinant need besides solves.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>
#include <vector>

#include "accuracy/null_vectors.hpp"
#include "kernels/stages/probe_step.hpp"
#include "ordering/types.hpp"

namespace mfs {

/// 1 or -1 for the permutation i -> at[i] of 0 ... n-1.
inline double permutation_sign(std::vector<Vertex> at) {
  double sign = 1;
  for (Vertex i = 0; i < static_cast<Vertex>(at.size()); ++i) {
    while (at[i] != i) {
      std::swap(at[i], at[at[i]]);
      sign = -sign;
    }
  }
  return sign;
}

/// floor(log2) of the largest real or imaginary part of `count` values; 0 where all are zero.
template <class Value>
int largest_exponent(Offset count, const Value* values) {
  double largest = 0;
  for (Offset k = 0; k < count; ++k) {
    const std::complex<double> value(values[k]);
    largest = std::max({largest, std::abs(value.real()), std::abs(value.imag())});
  }
  return largest > 0 ? std::ilogb(largest) : 0;
}

/// |A|_1 / 2^unit, A being n x n.
template <class Value>
double norm_in_units(const TransposedPattern& transposed, Vertex n, const Value* values, int unit) {
  double norm = 0;
  for (Vertex j = 0; j < n; ++j) {
    double sum = 0;
    for (Offset k = transposed.offsets[j]; k < transposed.offsets[j + 1]; ++k) {
      const std::complex<double> value(values[transposed.slots[k]]);
      sum += std::hypot(std::ldexp(value.real(), -unit), std::ldexp(value.imag(), -unit));
    }
    norm = std::max(norm, sum);
  }
  return norm;
}

/// How far the determinant of a matrix is off, relative to it, whose inverse inverse(x), x := B x, applies
/// instead of that of A. It is the trace of F = B A - I, if F is small. |F z| shows the size of F for a z
/// that is as good as random (Hutchinson 1990), here in scaled unknowns.
template <class Exec, class Value, class Inverse>
double inverse_error(const Exec& exec, Vertex n, const ScaledRows<Value>& a, const Inverse& inverse) {
  // Rows of A z are as large as their scales are small. z takes half of that, so that both are in range.
  const double unit = std::ldexp(1.0, std::ilogb(*std::min_element(a.row_scale, a.row_scale + n)) / 2);
  std::vector<Value> z(static_cast<std::size_t>(n)), r(z.size());
  for (std::size_t i = 0; i < z.size(); ++i)
    z[i] = static_cast<RealOf<Value>>(unit * probing_entry(static_cast<Offset>(i)));
  scaled_residual(exec, a, std::vector<Value>(), z, r);  // -A z
  inverse(r.data());
  double error = 0, size = 0;
  for (std::size_t i = 0; i < z.size(); ++i) {
    const std::complex<double> was(z[i]), back(r[i]);
    error += std::norm((back / a.scale[i] + was) / unit);
    size += std::norm(was / unit);
  }
  return std::sqrt(error / size * static_cast<double>(n));
}

}  // namespace mfs
