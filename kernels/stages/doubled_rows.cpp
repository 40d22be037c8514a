#include "kernels/stages/doubled_rows.hpp"

#include <complex>

#include "kernels/runtime/simd_clones.hpp"

namespace mfs {

namespace {

#define MFS_ROWS_FOR(TARGET, S)                                                                  \
  TARGET void rows_for(const RowAccess<S>& a, Offset begin, Offset end, const S* b, const S* x,  \
                       const S* low, S* r) {                                                     \
    for (Offset i = begin; i < end; ++i) narrow(doubled_row(a, i, widened(b[i]), x, low), r[i]); \
  }
MFS_FOR_SIMD_TARGETS(MFS_ROWS_FOR, float)
MFS_FOR_SIMD_TARGETS(MFS_ROWS_FOR, double)
MFS_FOR_SIMD_TARGETS(MFS_ROWS_FOR, std::complex<float>)
MFS_FOR_SIMD_TARGETS(MFS_ROWS_FOR, std::complex<double>)

}  // namespace

template <class Scalar>
void doubled_rows(const RowAccess<Scalar>& a, Offset begin, Offset end, const Scalar* b, const Scalar* x,
                  const Scalar* low, Scalar* r) {
  rows_for(a, begin, end, b, x, low, r);
}

#define MFS_INSTANTIATE(S) \
  template void doubled_rows<S>(const RowAccess<S>&, Offset, Offset, const S*, const S*, const S*, S*);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs
