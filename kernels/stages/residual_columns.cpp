#include "kernels/stages/residual_columns.hpp"

#include <algorithm>
#include <complex>

#include "kernels/runtime/inlined.hpp"
#include "kernels/runtime/simd_clones.hpp"

namespace mfs {

namespace {

constexpr int kColumns = kResidualColumns;

/// One row's sums; as BlockedSum.
template <class Sum>
struct RowSums {
  Sum block[kColumns], high[kColumns], low[kColumns];
  double size[kColumns];

  MFS_INLINE void close() {
    for (int c = 0; c < kColumns; ++c) {
      const Sum sum = high[c] + block[c], added = sum - high[c];
      low[c] += (high[c] - (sum - added)) + (block[c] - added);
      high[c] = sum;
      block[c] = Sum(0);
    }
  }
};

template <class Scalar>
MFS_INLINE void rows_of_columns(const RowAccess<Scalar>& a, Offset begin, Offset end, Offset n,
                                const Scalar* b, const Scalar* x, Scalar* r, double* error) {
  using Sum = decltype(widened(Scalar()));
  constexpr Offset kBlock = BlockedSum<Sum>::kBlock;
  std::fill_n(error, kColumns, 0.0);
  for (Offset i = begin; i < end; ++i) {
    RowSums<Sum> row;
    for (int c = 0; c < kColumns; ++c) {
      row.block[c] = widened(b[i + c * n]);
      row.size[c] = magnitude(row.block[c]);
      row.high[c] = row.low[c] = Sum(0);
    }
    const Offset last = a.offsets[i + 1];
    for (Offset k = a.offsets[i]; k < last;) {
      const Offset stop = std::min(k + kBlock, last);
      const bool full = stop - k == kBlock;
      for (; k < stop; ++k) {
        const Sum value = widened(a.values[a.slots ? a.slots[k] : k]);
        const Scalar* const unknowns = x + static_cast<Offset>(a.columns[k]) * kColumns;
        for (int c = 0; c < kColumns; ++c) {
          const Sum product = value * widened(unknowns[c]);
          row.block[c] -= product;
          row.size[c] += magnitude(product);
        }
      }
      if (full) row.close();
    }
    for (int c = 0; c < kColumns; ++c) {
      const Sum sum = (row.high[c] + row.block[c]) + row.low[c];
      narrow(sum, r[i + c * n]);
      error[c] = row_error_beyond(error[c], a, i, magnitude(sum), row.size[c]);
    }
  }
}

#define MFS_RESIDUAL_FOR(TARGET, S)                                                                       \
  TARGET void rows_for(const RowAccess<S>& a, Offset begin, Offset end, Offset n, const S* b, const S* x, \
                       S* r, double* error) {                                                             \
    rows_of_columns(a, begin, end, n, b, x, r, error);                                                    \
  }
MFS_FOR_SIMD_TARGETS(MFS_RESIDUAL_FOR, float)
MFS_FOR_SIMD_TARGETS(MFS_RESIDUAL_FOR, double)
MFS_FOR_SIMD_TARGETS(MFS_RESIDUAL_FOR, std::complex<float>)
MFS_FOR_SIMD_TARGETS(MFS_RESIDUAL_FOR, std::complex<double>)

}  // namespace

template <class Scalar>
void residual_rows(const RowAccess<Scalar>& a, Offset begin, Offset end, Offset n, const Scalar* b,
                   const Scalar* x, Scalar* r, double* error) {
  rows_for(a, begin, end, n, b, x, r, error);
}

#define MFS_INSTANTIATE(S)                                                                            \
  template void residual_rows<S>(const RowAccess<S>&, Offset, Offset, Offset, const S*, const S*, S*, \
                                 double*);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs
