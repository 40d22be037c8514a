#include "kernels/dense/small_kernels.hpp"

#include <cmath>

#include "kernels/dense/small_tiles.hpp"
#include "kernels/runtime/simd_clones.hpp"

namespace mfs::small {

namespace {

// Each kernel for registers of one kind.
#define MFS_KERNELS_FOR(TARGET, S, BYTES)                                                                  \
  TARGET void subtract_product_of(Vertex m, Vertex n, Vertex k, const S* a, Offset lda, const S* b,        \
                                  Offset ldb, S* c, Offset ldc) {                                          \
    using T = Tiles<S, BYTES>;                                                                             \
    using R = typename T::Real;                                                                            \
    T::gemm_minus(m, n, k, reinterpret_cast<const R*>(a), lda, reinterpret_cast<const R*>(b), ldb,         \
                  reinterpret_cast<R*>(c), ldc);                                                           \
  }                                                                                                        \
  TARGET void solve_left_of(Vertex n, Vertex columns, const S* t, Offset ldt, const S* inverse, S* b,      \
                            Offset ldb) {                                                                  \
    using T = Tiles<S, BYTES>;                                                                             \
    using R = typename T::Real;                                                                            \
    const R* const triangle = reinterpret_cast<const R*>(t);                                               \
    const R* const by = reinterpret_cast<const R*>(inverse);                                               \
    R* const to = reinterpret_cast<R*>(b);                                                                 \
    if (inverse) {                                                                                         \
      T::template solve_left<true>(n, columns, triangle, ldt, by, to, ldb);                                \
    } else {                                                                                               \
      T::template solve_left<false>(n, columns, triangle, ldt, by, to, ldb);                               \
    }                                                                                                      \
  }                                                                                                        \
  TARGET void solve_right_of(Vertex rows, Vertex n, const S* u, Offset ldu, const S* inverse, S* b,        \
                             Offset ldb) {                                                                 \
    using T = Tiles<S, BYTES>;                                                                             \
    using R = typename T::Real;                                                                            \
    T::solve_upper_right(rows, n, reinterpret_cast<const R*>(u), ldu, reinterpret_cast<const R*>(inverse), \
                         reinterpret_cast<R*>(b), ldb);                                                    \
  }

MFS_FOR_SIMD_REGISTERS(MFS_KERNELS_FOR, float)
MFS_FOR_SIMD_REGISTERS(MFS_KERNELS_FOR, double)
MFS_FOR_SIMD_REGISTERS(MFS_KERNELS_FOR, std::complex<float>)
MFS_FOR_SIMD_REGISTERS(MFS_KERNELS_FOR, std::complex<double>)

}  // namespace

template <class Scalar>
void gemm_minus(Vertex m, Vertex n, Vertex k, const Scalar* a, Offset lda, const Scalar* b, Offset ldb,
                Scalar* c, Offset ldc) {
  subtract_product_of(m, n, k, a, lda, b, ldb, c, ldc);
}

template <class Scalar>
void solve_unit_lower(Vertex n, Vertex columns, const Scalar* t, Offset ldt, Scalar* b, Offset ldb) {
  solve_left_of(n, columns, t, ldt, static_cast<const Scalar*>(nullptr), b, ldb);
}

namespace {

/// inverse[j] = 1 / u(j, j), j < n <= kMost; false where one is not finite.
template <class Scalar>
bool invert_diagonal(Vertex n, const Scalar* u, Offset ldu, Scalar* inverse) {
  for (Vertex j = 0; j < n; ++j) {
    inverse[j] = Scalar(1) / u[j + j * ldu];
    if (!std::isfinite(std::abs(inverse[j]))) return false;
  }
  return true;
}

}  // namespace

template <class Scalar>
bool solve_upper(Vertex n, Vertex columns, const Scalar* t, Offset ldt, Scalar* b, Offset ldb) {
  Scalar inverse[kMost];
  if (!invert_diagonal(n, t, ldt, inverse)) return false;
  solve_left_of(n, columns, t, ldt, static_cast<const Scalar*>(inverse), b, ldb);
  return true;
}

template <class Scalar>
bool solve_upper_right(Vertex rows, Vertex n, const Scalar* u, Offset ldu, Scalar* b, Offset ldb) {
  Scalar inverse[kMost];
  if (!invert_diagonal(n, u, ldu, inverse)) return false;
  solve_right_of(rows, n, u, ldu, inverse, b, ldb);
  return true;
}

#define MFS_INSTANTIATE(S)                                                                             \
  template void gemm_minus<S>(Vertex, Vertex, Vertex, const S*, Offset, const S*, Offset, S*, Offset); \
  template void solve_unit_lower<S>(Vertex, Vertex, const S*, Offset, S*, Offset);                     \
  template bool solve_upper<S>(Vertex, Vertex, const S*, Offset, S*, Offset);                          \
  template bool solve_upper_right<S>(Vertex, Vertex, const S*, Offset, S*, Offset);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs::small
