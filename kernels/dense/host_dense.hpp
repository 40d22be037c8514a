// BLAS and LU of a panel for kernels that one source writes for every execution space: as pointers, because a
// compiler for a device takes no direct call of a function of the host in code that it compiles for both.
#pragma once

#include "kernels/dense/blas.hpp"
#include "kernels/dense/panel_lu.hpp"

namespace mfs {

/// As the functions of these names in namespace blas and factor_panel; S as device code calls it.
template <class S>
struct HostDense {
  void (*gemm_minus)(blas::Transpose, Vertex m, Vertex n, Vertex k, const S* a, Offset lda, const S* b,
                     Offset ldb, S* c, Offset ldc);
  void (*solve_unit_lower)(blas::Transpose, Vertex n, Vertex columns, const S* t, Offset ldt, S* b,
                           Offset ldb);
  void (*solve_upper)(blas::Transpose, Vertex n, Vertex columns, const S* t, Offset ldt, S* b, Offset ldb);
  void (*solve_upper_right)(Vertex rows, Vertex n, const S* u, Offset ldu, S* b, Offset ldb);
  PivotTally (*factor_panel)(const BlockColumns<S>&, Vertex m, Vertex n, const PivotRule&,
                             Vertex* interchange, S* shift);
};

template <class S>
HostDense<S> host_dense();

}  // namespace mfs
