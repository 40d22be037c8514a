// The right-hand side that is as good as random, by which a probe finds out whether A is singular
// (accuracy/probe.hpp), and a step towards its solution where the factors lie: x and the residual have twice
// the precision.
#pragma once

#include <cstdint>

#include "kernels/factors.hpp"
#include "kernels/stages/residual.hpp"
#include "kernels/stages/vector_ops.hpp"

namespace mfs {

/// Row i of that right-hand side, scaled: of size 1/2 to 1 with a random sign, the same in every run and
/// everywhere (SplitMix64: Steele, Lea and Flood 2014).
KOKKOS_INLINE_FUNCTION double probing_entry(Offset i) {
  std::uint64_t state = (static_cast<std::uint64_t>(i) + 1) * 0x9E3779B97F4A7C15u;
  state = (state ^ (state >> 30)) * 0xBF58476D1CE4E5B9u;
  state = (state ^ (state >> 27)) * 0x94D049BB133111EBu;
  state ^= state >> 31;
  const double size = 0.5 + 0.5 * static_cast<double>(state >> 40) * 0x1p-24;
  return state & 1 ? size : -size;
}

/// The same as a number of the matrix, unscaled.
template <class Scalar>
KOKKOS_INLINE_FUNCTION void take_probing_entry(Offset i, const double* row_scale, Scalar& b) {
  narrow(decltype(widened(b))(probing_entry(i) / row_scale[i]), b);
}

/// n each, in the memory of an execution space: the solution x + low, the last correction d, and what it has
/// left, r.
template <class Scalar>
struct ProbeVectors {
  Scalar *x, *low, *d, *r;
};

template <class Scalar>
struct BeginProbe {
  const double* row_scale;
  ProbeVectors<Scalar> at;
  KOKKOS_FUNCTION void operator()(Offset i) const {
    at.x[i] = at.low[i] = Scalar(0);
    take_probing_entry(i, row_scale, at.r[i]);
  }
};

/// Leaves r = b - A (x + low), and the largest entry of it in scaled rows.
template <class Scalar>
struct ProbeResidual {
  RowAccess<Scalar> a;
  const double* row_scale;
  ProbeVectors<Scalar> at;
  KOKKOS_FUNCTION void operator()(Offset i, double& most) const {
    Scalar b;
    take_probing_entry(i, row_scale, b);
    narrow(doubled_row(a, i, widened(b), at.x, at.low), at.r[i]);
    const double size = magnitude(at.r[i]) * row_scale[i];
    if (!(size <= most)) most = size <= kMostFinite ? size : kInfinity;  // maxima of parts lose NaN
  }
};

/// The largest entry of A d, in scaled rows, or of |A| |d|.
template <class Scalar, bool kOfSizes>
struct ProbeProduct {
  RowAccess<Scalar> a;
  const double* row_scale;
  const Scalar* d;
  KOKKOS_FUNCTION void operator()(Offset i, double& most) const {
    DoubledTotal<decltype(widened(d[i]))> total;
    double size = 0;
    for (Offset k = a.offsets[i]; k < a.offsets[i + 1]; ++k) {
      const auto entry = widened(a.values[a.slots ? a.slots[k] : k]), unknown = widened(d[a.columns[k]]);
      if (kOfSizes) {
        size += magnitude(entry) * magnitude(unknown);
      } else {
        total.subtract_product(entry, unknown);
      }
    }
    const double found = (kOfSizes ? size : magnitude(total.value())) * row_scale[i];
    if (found > most) most = found;
  }
};

template <class Exec, class Scalar>
void begin_probe(const Exec& exec, Vertex n, const double* row_scale, const ProbeVectors<Scalar>& at) {
  for_each_index(exec, "mfs::probe", n, BeginProbe<Scalar>{row_scale, at});
}

/// All but found->left, of the correction d. `found` is in the memory of Exec.
template <class Exec, class Scalar>
void measure_correction(const Exec& exec, Vertex n, const RowAccess<Scalar>& a, const double* row_scale,
                        const double* column_scale, const Scalar* d, ProbeStep* found) {
  largest_unscaled(exec, n, column_scale, d, &found->length);
  find_maximum(exec, "mfs::probe", n, ProbeProduct<Scalar, false>{a, row_scale, d}, &found->product);
  find_maximum(exec, "mfs::probe", n, ProbeProduct<Scalar, true>{a, row_scale, d}, &found->size);
}
/// found->left, and r.
template <class Exec, class Scalar>
void find_left(const Exec& exec, Vertex n, const RowAccess<Scalar>& a, const double* row_scale,
               const ProbeVectors<Scalar>& at, ProbeStep* found) {
  find_maximum(exec, "mfs::probe", n, ProbeResidual<Scalar>{a, row_scale, at}, &found->left);
}

/// Once d is about A^-1 r.
template <class Exec, class Scalar>
void take_probe_step(const Exec& exec, Vertex n, const RowAccess<Scalar>& a, const double* row_scale,
                     const double* column_scale, const ProbeVectors<Scalar>& at, ProbeStep* found) {
  const Scalar* const d = at.d;
  measure_correction(exec, n, a, row_scale, column_scale, d, found);
  add_doubled(exec, n, d, at.x, at.low);
  find_left(exec, n, a, row_scale, at, found);
}

}  // namespace mfs
