// Vector operations of the solve phase. Free functions: nvcc takes no extended lambda of a private member.
// What files for several pairs of scalars have in common on a device is a function object: nvcc reaches the
// host code of an extended lambda by a pointer of its file, which is null where the linker takes the launch
// from another.
#pragma once

#include <complex>

#include "kernels/runtime/dispatch.hpp"
#include "kernels/stages/front_store.hpp"

namespace mfs {

/// to = from
template <class Exec, class Scalar>
void copy_vector(const Exec& exec, Vertex n, const Scalar* from, Scalar* to) {
  for_each_index(
      exec, "mfs::copy", n, KOKKOS_LAMBDA(Offset i) { to[i] = from[i]; });
}

/// to += factor * from
template <class Exec, class Scalar>
void add_vector(const Exec& exec, Offset n, Scalar factor, const Scalar* from, Scalar* to) {
  for_each_index(
      exec, "mfs::add", n, KOKKOS_LAMBDA(Offset i) { to[i] += factor * from[i]; });
}

/// What is left of an entry, as a part of it, where a correction takes it away and only rounding remains.
constexpr double kRemainder = 1e-6;

/// Entries of x that were larger by 1 / kRemainder in `before` become zero.
template <class Exec, class Scalar>
void drop_remainders(const Exec& exec, Vertex n, const Scalar* before, Scalar* x) {
  for_each_index(exec, "mfs::drop_remainders", n, [=](Offset i) {
    if (magnitude(x[i]) <= kRemainder * magnitude(before[i])) x[i] = Scalar(0);
  });
}

/// What a correction changes an entry by, as a part of it, where the entry is taken for rounding.
constexpr double kNoise = 1e-3;

/// Entries of x become zero that d, the last of corrections which do not get smaller, still changes.
template <class Exec, class Scalar>
void drop_noise(const Exec& exec, Vertex n, const Scalar* d, Scalar* x) {
  for_each_index(exec, "mfs::drop_noise", n, [=](Offset i) {
    if (magnitude(d[i]) >= kNoise * magnitude(x[i])) x[i] = Scalar(0);
  });
}

/// Entries of x become zero where `kept` is false.
template <class Exec, class Scalar>
void keep_entries(const Exec& exec, Vertex n, const char* kept, Scalar* x) {
  for_each_index(exec, "mfs::keep_entries", n, [=](Offset i) {
    if (!kept[i]) x[i] = Scalar(0);
  });
}

/// (x, low) += d, where x + low is a number of twice the precision and x that number rounded (Knuth's
/// TwoSum).
template <class Scalar>
struct AddDoubled {
  const Scalar* d;
  Scalar *x, *low;
  KOKKOS_FUNCTION void operator()(Offset i) const {
    const Scalar sum = x[i] + d[i], added = sum - x[i];
    const Scalar rest = low[i] + ((x[i] - (sum - added)) + (d[i] - added));
    x[i] = sum + rest;
    low[i] = rest - (x[i] - sum);
  }
};
template <class Exec, class Scalar>
void add_doubled(const Exec& exec, Vertex n, const Scalar* d, Scalar* x, Scalar* low) {
  using Number = DeviceScalar<Scalar>;
  const auto* const of_d = reinterpret_cast<const Number*>(d);
  auto *const of_x = reinterpret_cast<Number*>(x), *const of_low = reinterpret_cast<Number*>(low);
  for_each_index(exec, "mfs::add_doubled", n, AddDoubled<Number>{of_d, of_x, of_low});
}

/// x *= factor
template <class Exec, class Scalar>
void scale_vector(const Exec& exec, Vertex n, Scalar factor, Scalar* x) {
  for_each_index(
      exec, "mfs::scale", n, KOKKOS_LAMBDA(Offset i) { x[i] *= factor; });
}

/// to = from * weight, entry by entry, or from / weight.
template <class Exec, class Scalar>
void weigh_vector(const Exec& exec, Vertex n, const double* weight, bool divide, const Scalar* from,
                  Scalar* to) {
  for_each_index(
      exec, "mfs::weight", n, KOKKOS_LAMBDA(Offset i) {
        const auto factor = static_cast<RealOf<Scalar>>(weight[i]);
        to[i] = divide ? from[i] / factor : from[i] * factor;
      });
}

/// conj(a) b in the precision of a and b, as a complex number.
template <class Real>
KOKKOS_INLINE_FUNCTION std::enable_if_t<std::is_floating_point_v<Real>, Kokkos::complex<double>>
conjugate_product(Real a, Real b) {
  return {a * b, 0};
}
template <class Real>
KOKKOS_INLINE_FUNCTION Kokkos::complex<double> conjugate_product(const std::complex<Real>& a,
                                                                 const std::complex<Real>& b) {
  const Real *x = reinterpret_cast<const Real*>(&a), *y = reinterpret_cast<const Real*>(&b);
  return {x[0] * y[0] + x[1] * y[1], x[0] * y[1] - x[1] * y[0]};
}

/// a^H b, summed in double precision.
template <class Exec, class Scalar>
Scalar dot_product(const Exec& exec, Vertex n, const Scalar* a, const Scalar* b) {
  const auto sum = find_sum<Kokkos::complex<double>>(
      exec, "mfs::dot", n,
      KOKKOS_LAMBDA(Offset i, Kokkos::complex<double> & part) { part += conjugate_product(a[i], b[i]); });
  return from_parts<Scalar>(sum.real(), sum.imag());
}

/// Between the caller's order and the order of elimination, whose position p holds number index[p]: scaled by
/// that number's scale on the way, for columns with leading dimensions of their own, and computed as Value.
/// `add`: to what is there already.
template <class Value, bool kIntoElimination, class From, class To>
struct PermuteScaled {
  Vertex columns;
  const Vertex* index;
  const double* scale;
  const From* from;
  Offset from_ld;
  To* to;
  Offset to_ld;
  bool add;

  KOKKOS_FUNCTION void operator()(Offset position) const {
    const Offset i = index[position];
    const Offset source = kIntoElimination ? i : position, target = kIntoElimination ? position : i;
    const auto factor = static_cast<RealOf<Value>>(scale[i]);
    for (Offset j = 0; j < columns; ++j) {
      To& place = to[target + j * to_ld];
      const To scaled = static_cast<To>(Value(from[source + j * from_ld]) * factor);
      place = add ? place + scaled : scaled;
    }
  }
};

/// to[position] = scale * from[index[position]], for `columns` columns.
template <class Value, class Exec, class From, class To>
void gather_scaled(const Exec& exec, Vertex n, Vertex columns, const Vertex* index, const double* scale,
                   const From* from, Offset from_ld, To* to) {
  for_each_index(exec, "mfs::permute", n,
                 PermuteScaled<Value, true, From, To>{columns, index, scale, from, from_ld, to, n, false});
}

/// And back: to[index[position]] = scale * from[position], or += that.
template <class Value, class Exec, class From, class To>
void scatter_scaled(const Exec& exec, Vertex n, Vertex columns, const Vertex* index, const double* scale,
                    const From* from, To* to, bool add = false) {
  for_each_index(exec, "mfs::permute", n,
                 PermuteScaled<Value, false, From, To>{columns, index, scale, from, n, to, n, add});
}

/// The same for many columns, whose entries of a row then lie beside each other, `width` apart: number i has
/// row position[i]. Columns are read in their own order, as whole rows fill lines of cache; those behind
/// `columns` are zero.
template <class Value, class Exec, class From, class To>
void columns_to_rows(const Exec& exec, Vertex n, Vertex columns, Vertex width, const Vertex* position,
                     const double* scale, const From* from, To* to) {
  for_each_index(exec, "mfs::permute", n, [=](Offset i) {
    To* const row = to + static_cast<Offset>(position[i]) * width;
    const auto factor = static_cast<RealOf<Value>>(scale[i]);
    for (Offset j = 0; j < columns; ++j) row[j] = static_cast<To>(Value(from[i + j * n]) * factor);
    for (Offset j = columns; j < width; ++j) row[j] = To(0);
  });
}

/// And back.
template <class Value, class Exec, class From, class To>
void rows_to_columns(const Exec& exec, Vertex n, Vertex columns, Vertex width, const Vertex* position,
                     const double* scale, const From* from, To* to) {
  for_each_index(exec, "mfs::permute", n, [=](Offset i) {
    const From* const row = from + static_cast<Offset>(position[i]) * width;
    const auto factor = static_cast<RealOf<Value>>(scale[i]);
    for (Offset j = 0; j < columns; ++j) to[i + j * n] = static_cast<To>(Value(row[j]) * factor);
  });
}

/// *largest = largest |x_i| / scale[i].
template <class Scalar>
struct LargestUnscaled {
  const double* scale;
  const Scalar* x;
  KOKKOS_FUNCTION void operator()(Offset i, double& most) const {
    const double size = magnitude(x[i]) / scale[i];
    if (size > most) most = size;
  }
};
template <class Exec, class Scalar>
void largest_unscaled(const Exec& exec, Vertex n, const double* scale, const Scalar* x, double* largest) {
  find_maximum(exec, "mfs::unscaled", n, LargestUnscaled<Scalar>{scale, x}, largest);
}

/// *found = 1 if an entry is NaN or infinite, else 0 or less.
template <class Scalar>
struct FindNonfinite {
  const Scalar* x;
  KOKKOS_FUNCTION void operator()(Offset i, double& most) const {
    if (!(magnitude(x[i]) <= 1.7976931348623157e308)) most = 1;
  }
};
template <class Exec, class Scalar>
void find_nonfinite(const Exec& exec, Offset count, const Scalar* x, double* found) {
  find_maximum(exec, "mfs::finite", count, FindNonfinite<Scalar>{x}, found);
}

/// *largest = largest |a_ij| row_scale[i] column_scale[j].
template <class Scalar, class Value>
struct LargestScaledEntry {
  FrontStore<Scalar, Value> store;
  KOKKOS_FUNCTION void operator()(Offset row, double& most) const {
    for (Offset k = store.matrix_offsets[row]; k < store.matrix_offsets[row + 1]; ++k) {
      const double scale = store.row_scale[row] * store.column_scale[store.matrix_columns[k]];
      const double size = magnitude(store.matrix_values[k]) * scale;
      if (size > most) most = size;
    }
  }
};
template <class Exec, class Scalar, class Value>
void largest_scaled_entry(const Exec& exec, const FrontStore<Scalar, Value>& store, double* largest) {
  find_maximum(exec, "mfs::largest", store.n, LargestScaledEntry<Scalar, Value>{store}, largest);
}

}  // namespace mfs
