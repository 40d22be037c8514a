#include "kernels/dense/host_dense.hpp"

#include <complex>

#include <Kokkos_Core.hpp>

#include "kernels/runtime/scalars.hpp"

namespace mfs {

namespace {

/// The calls for numbers that the host calls Scalar and device code S, which have one layout.
template <class Scalar, class S = DeviceScalar<Scalar>>
struct Calls {
  static const Scalar* host(const S* numbers) { return reinterpret_cast<const Scalar*>(numbers); }
  static Scalar* host(S* numbers) { return reinterpret_cast<Scalar*>(numbers); }

  static void gemm_minus(blas::Transpose transpose, Vertex m, Vertex n, Vertex k, const S* a, Offset lda,
                         const S* b, Offset ldb, S* c, Offset ldc) {
    blas::gemm_minus(transpose, m, n, k, host(a), lda, host(b), ldb, host(c), ldc);
  }
  static void solve_unit_lower(blas::Transpose transpose, Vertex n, Vertex columns, const S* t, Offset ldt,
                               S* b, Offset ldb) {
    blas::solve_unit_lower(transpose, n, columns, host(t), ldt, host(b), ldb);
  }
  static void solve_upper(blas::Transpose transpose, Vertex n, Vertex columns, const S* t, Offset ldt, S* b,
                          Offset ldb) {
    blas::solve_upper(transpose, n, columns, host(t), ldt, host(b), ldb);
  }
  static void solve_upper_right(Vertex rows, Vertex n, const S* u, Offset ldu, S* b, Offset ldb) {
    blas::solve_upper_right(rows, n, host(u), ldu, host(b), ldb);
  }
  static PivotTally factor_panel(const BlockColumns<S>& block, Vertex m, Vertex n, const PivotRule& rule,
                                 Vertex* interchange, S* shift) {
    const BlockColumns<Scalar> columns{host(block.a), block.lda, block.border_begin, block.border_rows,
                                       host(block.work)};
    return mfs::factor_panel(columns, 0, m, n, rule, interchange, host(shift));
  }
  static HostDense<S> all() {
    return {&gemm_minus, &solve_unit_lower, &solve_upper, &solve_upper_right, &factor_panel};
  }
};

}  // namespace

template <>
HostDense<float> host_dense<float>() {
  return Calls<float>::all();
}
template <>
HostDense<double> host_dense<double>() {
  return Calls<double>::all();
}
template <>
HostDense<Kokkos::complex<float>> host_dense<Kokkos::complex<float>>() {
  return Calls<std::complex<float>>::all();
}
template <>
HostDense<Kokkos::complex<double>> host_dense<Kokkos::complex<double>>() {
  return Calls<std::complex<double>>::all();
}

}  // namespace mfs
