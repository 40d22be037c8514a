// Stage "variable update": what the pivots of a front do to its border, C -= L U.
#pragma once

#include "kernels/stages/front_store.hpp"

namespace mfs {

/// Returns the floating-point operations done.
template <class Ops, class Scalar>
double update_front(const Ops& ops, const Front<Scalar>& front) {
  const Vertex p = front.pivots, b = front.border;
  ops.all(ops.gemm_minus(b, b, p, front.lower + p, front.lower_ld, front.upper, p, front.contribution,
                         front.contribution_ld));
  return 2.0 * p * static_cast<double>(b) * b;
}

}  // namespace mfs
