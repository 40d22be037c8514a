// Residual and componentwise backward error of A X = B (or A^T X = B), in the caller's numbering, by plain
// loops over the rows of the original matrix, summed in double precision (Oettli and Prager 1964):
//
//   error = max_i |b - A x|_i / (|A| |x| + |b| + f)_i    0/0 counts as 0; anything not finite as infinity
//
// f is zero but where the caller asked for a floor under rows that hold rounding only. A residual of some
// least numbers for each unknown, kFree |A| 1, counts as zero: where a solution decays until
// nothing is left, unknowns have no digits that could make it smaller (Demmel 1984, Underflow and the
// reliability of numerical software).
#pragma once

#include <cmath>
#include <limits>

#include "kernels/runtime/dispatch.hpp"
#include "kernels/stages/front_store.hpp"
#include "kernels/stages/vector_ops.hpp"

namespace mfs {

/// Rows of the matrix whose residual is taken: of A itself, or of A^T, whose entry k then is
/// values[slots[k]] (slots is null for A).
template <class Scalar>
struct RowAccess {
  const Offset* offsets;
  const Vertex* columns;
  const Offset* slots;
  const Scalar* values;
};

/// f_i = part * *largest / scale[i]; none where part is 0. The largest unknown lies where the vectors do.
struct RowFloor {
  double part = 0;
  const double *largest = nullptr, *scale = nullptr;

  KOKKOS_INLINE_FUNCTION double of_row(Offset i) const {
    const double amount = part > 0 ? part * *largest : 0;
    return amount > 0 ? amount / scale[i] : 0;
  }
};

// Not in the function: device code may use such constants, but not call what they are made by.
constexpr double kMostFinite = std::numeric_limits<double>::max();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
template <class Real>
constexpr double kFree = 8 * static_cast<double>(std::numeric_limits<Real>::denorm_min());

/// Backward error of a row with the residual `off` and terms of the size `size`. A size beyond the range
/// would make any residual look small: it counts as infinite, too. NaN compares false: written so that it
/// counts as infinite.
KOKKOS_INLINE_FUNCTION double row_error(double off, double size) {
  const double ratio = off == 0 ? 0 : size <= kMostFinite ? off / size : kInfinity;
  return ratio <= 1e300 ? ratio : kInfinity;
}

/// That of row i of A, less what is free, if it is more than `most`, which is returned else.
template <class Scalar>
KOKKOS_INLINE_FUNCTION double row_error_beyond(double most, const RowAccess<Scalar>& a, Offset i, double off,
                                               double size) {
  if (!(row_error(off, size) > most)) return most;
  const double part = kFree<RealOf<Scalar>>;
  double free = 0;  // the sum of the entries may be beyond the range, and the modulus of a complex one
  for (Offset k = a.offsets[i]; k < a.offsets[i + 1]; ++k)
    free += magnitude(part * widened(a.values[a.slots ? a.slots[k] : k]));
  const double error = row_error(off <= free ? 0 : off - free, size);  // NaN stays
  return error > most ? error : most;
}

/// A sum in blocks of kBlock terms, whose totals are added with what rounding takes from them (Knuth's
/// TwoSum). In a row of 1e5 equal terms a plain sum loses up to 1e5 eps, more than solutions may be wrong by.
template <class Number>
class BlockedSum {
 public:
  static constexpr Offset kBlock = 256;
  KOKKOS_INLINE_FUNCTION explicit BlockedSum(const Number& first) : block_(first) {}
  KOKKOS_INLINE_FUNCTION void subtract(const Number& term) { block_ -= term; }
  KOKKOS_INLINE_FUNCTION Number value() const { return (high_ + block_) + low_; }
  /// After each kBlock terms.
  KOKKOS_INLINE_FUNCTION void close() {
    const Number sum = high_ + block_, added = sum - high_;
    low_ += (high_ - (sum - added)) + (block_ - added);
    high_ = sum;
    block_ = Number(0);
  }

 private:
  Number block_, high_ = Number(0), low_ = Number(0);
};

/// r = b - A x for one column (b null: r = -A x); *worst = its backward error, a place in the memory of Exec.
/// Where `size_of_row` is not null, size_of_row[i] = (|A| |x| + |b| + f)_i, or 1 where that is no divisor
/// (zero, subnormal, infinite).
template <class Scalar>
struct RowResidual {
  using Limits = std::numeric_limits<RealOf<Scalar>>;
  static constexpr double kSmallest = Limits::min(), kLargest = Limits::max();

  RowAccess<Scalar> a;
  const Scalar *b, *x;
  Scalar* r;
  double* size_of_row;
  RowFloor floor;

  KOKKOS_FUNCTION void operator()(Offset i, double& most) const {
    using Sum = decltype(widened(x[i]));
    const Sum first = b ? widened(b[i]) : Sum(0);
    BlockedSum<Sum> terms(first);
    double size = magnitude(first) + floor.of_row(i);
    const Offset last = a.offsets[i + 1];
    for (Offset k = a.offsets[i]; k < last;) {
      const Offset full = k + BlockedSum<Sum>::kBlock, stop = full < last ? full : last;
      for (; k < stop; ++k) {
        const auto product = widened(a.values[a.slots ? a.slots[k] : k]) * widened(x[a.columns[k]]);
        terms.subtract(product);
        size += magnitude(product);
      }
      if (k == full) terms.close();
    }
    const Sum sum = terms.value();
    narrow(sum, r[i]);
    if (size_of_row) size_of_row[i] = size >= kSmallest && size <= kLargest ? size : 1;
    const double off = magnitude(sum);
    if (size <= kMostFinite && off < most * size) return;  // a division takes as long as a short row
    most = row_error_beyond(most, a, i, off, size);
  }
};
template <class Exec, class Scalar>
void residual(const Exec& exec, Vertex n, const RowAccess<Scalar>& a, const Scalar* b, const Scalar* x,
              Scalar* r, double* worst, double* size_of_row = nullptr, const RowFloor& floor = {}) {
  find_maximum(exec, "mfs::residual", n, RowResidual<Scalar>{a, b, x, r, size_of_row, floor}, worst);
}

/// A sum of doubles and of products of doubles, as if in twice the precision (Ogita, Rump and Oishi 2005).
class DoubledSum {
 public:
  KOKKOS_FORCEINLINE_FUNCTION void add(double term) {
    const double sum = high_ + term, added = sum - high_;
    low_ += (high_ - (sum - added)) + (term - added);
    high_ = sum;
  }
  KOKKOS_FORCEINLINE_FUNCTION void add_product(double a, double b) {
    const double product = rounded_product(a, b);
    add(product);
    low_ += std::fma(a, b, -product);
  }
  KOKKOS_FORCEINLINE_FUNCTION double value() const { return high_ + low_; }

 private:
  double high_ = 0, low_ = 0;
};

/// The same of real or of complex numbers.
template <class Number>
class DoubledTotal {
 public:
  KOKKOS_FORCEINLINE_FUNCTION void add(double term) { sum_.add(term); }
  KOKKOS_FORCEINLINE_FUNCTION void subtract_product(double a, double b) { sum_.add_product(-a, b); }
  KOKKOS_FORCEINLINE_FUNCTION double value() const { return sum_.value(); }

 private:
  DoubledSum sum_;
};
template <>
class DoubledTotal<Kokkos::complex<double>> {
 public:
  using Number = Kokkos::complex<double>;
  KOKKOS_FORCEINLINE_FUNCTION void add(const Number& term) {
    real_.add(term.real());
    imag_.add(term.imag());
  }
  KOKKOS_FORCEINLINE_FUNCTION void subtract_product(const Number& a, const Number& b) {
    real_.add_product(-a.real(), b.real());
    real_.add_product(a.imag(), b.imag());
    imag_.add_product(-a.real(), b.imag());
    imag_.add_product(-a.imag(), b.real());
  }
  KOKKOS_FORCEINLINE_FUNCTION Number value() const { return {real_.value(), imag_.value()}; }

 private:
  DoubledSum real_, imag_;
};

/// Row i of b - A (x + low), of which `b` is that of b, summed in twice the precision of double.
template <class Number, class Scalar>
KOKKOS_FORCEINLINE_FUNCTION Number doubled_row(const RowAccess<Scalar>& a, Offset i, const Number& b,
                                               const Scalar* x, const Scalar* low) {
  DoubledTotal<Number> total;
  total.add(b);
  for (Offset k = a.offsets[i]; k < a.offsets[i + 1]; ++k) {
    const Number entry = widened(a.values[a.slots ? a.slots[k] : k]);
    total.subtract_product(entry, widened(x[a.columns[k]]));
    total.subtract_product(entry, widened(low[a.columns[k]]));
  }
  return total.value();
}

}  // namespace mfs
