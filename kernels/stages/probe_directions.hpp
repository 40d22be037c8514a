// Steps of a probe that know of each other, where the factors lie: those of GCR (Eisenstat, Elman and Schultz
// 1983), each of which leaves the least residual that it and the steps before it can. What accuracy/probe.hpp
// says of the host holds here as well, but that a new direction is made orthogonal to all before it at once,
// and twice (classical Gram-Schmidt with one repetition: Giraud, Langou, Rozloznik and van den Eshof 2005):
// that takes a few kernels however many there are.
#pragma once

#include <algorithm>

#include "kernels/stages/probe_step.hpp"

namespace mfs {

/// a^H b.
KOKKOS_INLINE_FUNCTION double conjugate_times(double a, double b) {
  return a * b;
}
KOKKOS_INLINE_FUNCTION Kokkos::complex<double> conjugate_times(const Kokkos::complex<double>& a,
                                                               const Kokkos::complex<double>& b) {
  return Kokkos::conj(a) * b;
}

/// n each: d and d_low, a number of twice the precision, and A (d + d_low) in scaled rows.
template <class Scalar>
struct ProbeDirection {
  Scalar *d, *low, *product;
};

/// A direction begins as d, and low is zero.
template <class Scalar>
struct BeginDirection {
  RowAccess<Scalar> a;
  const double* row_scale;
  const Scalar* d;
  ProbeDirection<Scalar> to;
  KOKKOS_FUNCTION void operator()(Offset i) const {
    using Number = decltype(widened(d[i]));
    DoubledTotal<Number> total;
    for (Offset k = a.offsets[i]; k < a.offsets[i + 1]; ++k)
      total.subtract_product(widened(a.values[a.slots ? a.slots[k] : k]), widened(d[a.columns[k]]));
    narrow(-total.value() * row_scale[i], to.product[i]);
    to.d[i] = d[i];
    to.low[i] = Scalar(0);
  }
};

/// Sums over vectors in three steps, each of which has work for a device and whose order is always the same:
/// kParts of them by index, kGroups of those, and all.
constexpr Offset kProbeParts = 2048, kProbeGroups = 32;
/// parts[j kProbeParts ...]: of product_j^H v, products beginning every `stride` entries. Where row_scale is
/// not null, v is not in scaled rows yet.
template <class Scalar, class Number>
struct SumParts {
  Offset n, stride;
  const Scalar *products, *v;
  const double* row_scale;
  Number* parts;
  KOKKOS_FUNCTION void operator()(Offset index) const {
    const Scalar* const product = products + index / kProbeParts * stride;
    Number sum(0);
    for (Offset i = index % kProbeParts; i < n; i += kProbeParts) {
      const Number other = widened(v[i]);
      sum += conjugate_times(widened(product[i]), row_scale ? other * row_scale[i] : other);
    }
    parts[index] = sum;
  }
};
template <class Number>
struct SumGroups {
  const Number* parts;
  Number* groups;
  KOKKOS_FUNCTION void operator()(Offset index) const {
    const Number* const part = parts + index / kProbeGroups * kProbeParts + index % kProbeGroups;
    Number sum(0);
    for (Offset k = 0; k < kProbeParts; k += kProbeGroups) sum += part[k];
    groups[index] = sum;
  }
};
/// sums[j], divided by squares[j].
template <class Number>
struct SumAll {
  const Number* groups;
  const double* squares;
  Number* sums;
  KOKKOS_FUNCTION void operator()(Offset j) const {
    Number sum(0);
    for (Offset k = 0; k < kProbeGroups; ++k) sum += groups[j * kProbeGroups + k];
    sums[j] = sum / squares[j];
  }
};
/// The square of a product's length, from product^H product.
template <class Number>
struct SumSquares {
  const Number* groups;
  double* square;
  KOKKOS_FUNCTION void operator()(Offset) const {
    double sum = 0;
    for (Offset k = 0; k < kProbeGroups; ++k) sum += magnitude(groups[k]);
    *square = sum;
  }
};

/// (to, to_low) -= the sum of factor (d, d_low), numbers of twice the precision, over directions that lie
/// `stride` entries apart.
template <class Scalar, class Number>
KOKKOS_INLINE_FUNCTION void subtract_directions(Offset i, Offset count, Offset stride, const Number* factors,
                                                const ProbeDirection<Scalar>& first, Scalar& to,
                                                Scalar& to_low) {
  DoubledTotal<Number> total;
  total.add(widened(to));
  total.add(widened(to_low));
  for (Offset j = 0; j < count; ++j) {
    total.subtract_product(factors[j], widened(first.d[i + j * stride]));
    total.subtract_product(factors[j], widened(first.low[i + j * stride]));
  }
  narrow(total.value(), to);
  total.add(-widened(to));
  narrow(total.value(), to_low);
}
/// The next direction without its parts along those before.
template <class Scalar, class Number>
struct LeaveDirections {
  Offset count, stride;
  const Number* parts;
  ProbeDirection<Scalar> first, next;
  KOKKOS_FUNCTION void operator()(Offset i) const {
    Number product = widened(next.product[i]);
    for (Offset j = 0; j < count; ++j) product -= parts[j] * widened(first.product[i + j * stride]);
    narrow(product, next.product[i]);
    subtract_directions(i, count, stride, parts, first, next.d[i], next.low[i]);
  }
};
/// A step along a direction, as far as leaves the least residual.
template <class Scalar, class Number>
struct StepAlong {
  const Number* part;
  ProbeDirection<Scalar> direction;
  Scalar *x, *low;
  KOKKOS_FUNCTION void operator()(Offset i) const {
    const Number back = -*part;
    subtract_directions(i, 1, 0, &back, direction, x[i], low[i]);
  }
};

/// The directions that steps have taken, in memory of an execution space.
template <class Scalar>
class ProbeDirections {
  using Number = decltype(widened(Scalar()));

 public:
  /// The most steps for n unknowns: so many that they take at most kMostBytes.
  static Offset most(Offset n) {
    constexpr Offset kMost = 40, kMostBytes = Offset(1) << 28;
    return std::min(kMost, kMostBytes / (3 * static_cast<Offset>(sizeof(Scalar)) * std::max<Offset>(n, 1)));
  }
  static Offset bytes(Offset n) { return Layout(n).arena.total(); }

  ProbeDirections() = default;
  /// `memory` has bytes(n) and is aligned as arenas are.
  ProbeDirections(Offset n, char* memory) : n_(n) {
    const Layout layout(n);
    auto* const vectors = reinterpret_cast<Scalar*>(memory + layout.vectors);
    first_ = {vectors, vectors + n, vectors + 2 * n};
    squares_ = reinterpret_cast<double*>(memory + layout.squares);
    sums_ = reinterpret_cast<Number*>(memory + layout.sums);
    groups_ = reinterpret_cast<Number*>(memory + layout.groups);
    parts_ = reinterpret_cast<Number*>(memory + layout.parts);
  }

  void forget() { count_ = 0; }
  bool full() const { return count_ == most(n_); }

  /// Once at.d is about A^-1 r and unless full(): a step for x and low. `found` is in the memory of Exec.
  template <class Exec>
  void take_step(const Exec& exec, const RowAccess<Scalar>& a, const double* row_scale,
                 const double* column_scale, const ProbeVectors<Scalar>& at, ProbeStep* found) {
    const ProbeDirection<Scalar> next = direction(count_);
    for_each_index(exec, "mfs::probe", n_, BeginDirection<Scalar>{a, row_scale, at.d, next});
    for (int pass = 0; pass < 2 && count_ > 0; ++pass) {
      sum_products(exec, first_, count_, next.product, nullptr);
      for_each_index(exec, "mfs::probe", count_, SumAll<Number>{groups_, squares_, sums_});
      for_each_index(exec, "mfs::probe", n_,
                     LeaveDirections<Scalar, Number>{count_, kVectors * n_, sums_, first_, next});
    }
    double* const square = squares_ + count_;
    sum_products(exec, next, 1, next.product, nullptr);
    for_each_index(exec, "mfs::probe", 1, SumSquares<Number>{groups_, square});
    sum_products(exec, next, 1, at.r, row_scale);
    for_each_index(exec, "mfs::probe", 1, SumAll<Number>{groups_, square, sums_});
    for_each_index(exec, "mfs::probe", n_, StepAlong<Scalar, Number>{sums_, next, at.x, at.low});
    measure_correction(exec, static_cast<Vertex>(n_), a, row_scale, column_scale,
                       static_cast<const Scalar*>(next.d), found);
    find_left(exec, static_cast<Vertex>(n_), a, row_scale, at, found);
    ++count_;
  }

 private:
  static constexpr Offset kVectors = 3;  // of a direction
  struct Layout {
    explicit Layout(Offset n) {
      const Offset count = most(n), number = static_cast<Offset>(sizeof(Number));
      vectors = arena.add(count * kVectors * n * static_cast<Offset>(sizeof(Scalar)));
      squares = arena.add(count * static_cast<Offset>(sizeof(double)));
      sums = arena.add(count * number);
      groups = arena.add(count * kProbeGroups * number);
      parts = arena.add(count * kProbeParts * number);
    }
    ArenaLayout arena;
    Offset vectors, squares, sums, groups, parts;
  };

  ProbeDirection<Scalar> direction(Offset k) const {
    const Offset begin = k * kVectors * n_;
    return {first_.d + begin, first_.low + begin, first_.product + begin};
  }
  // groups_: of product_j^H v for `count` directions.
  template <class Exec>
  void sum_products(const Exec& exec, const ProbeDirection<Scalar>& of, Offset count, const Scalar* v,
                    const double* row_scale) {
    for_each_index(exec, "mfs::probe", count * kProbeParts,
                   SumParts<Scalar, Number>{n_, kVectors * n_, of.product, v, row_scale, parts_});
    for_each_index(exec, "mfs::probe", count * kProbeGroups, SumGroups<Number>{parts_, groups_});
  }

  Offset n_ = 0, count_ = 0;
  ProbeDirection<Scalar> first_{};
  double* squares_ = nullptr;
  Number *sums_ = nullptr, *groups_ = nullptr, *parts_ = nullptr;
};

}  // namespace mfs
