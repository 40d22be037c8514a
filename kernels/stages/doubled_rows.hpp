// Residuals summed in twice the precision of double, on the host: by fused multiply-adds of the processor
// where it has them, which are calls else.
#pragma once

#include <algorithm>

#include "kernels/stages/residual.hpp"

namespace mfs {

/// r = b - A (x + low) for rows [begin, end).
template <class Scalar>
void doubled_rows(const RowAccess<Scalar>& a, Offset begin, Offset end, const Scalar* b, const Scalar* x,
                  const Scalar* low, Scalar* r);

/// r = b - A (x + low).
template <class Exec, class Scalar>
void doubled_residual(const Exec& exec, Vertex n, const RowAccess<Scalar>& a, const Scalar* b,
                      const Scalar* x, const Scalar* low, Scalar* r) {
  constexpr Offset kGroup = 128;
  for_each_index(exec, "mfs::doubled", (n + kGroup - 1) / kGroup, [=](Offset group) {
    doubled_rows(a, group * kGroup, std::min<Offset>(n, (group + 1) * kGroup), b, x, low, r);
  });
}

/// (x, low) += factor (d, d_low), where all are numbers of twice the precision.
template <class Exec, class Scalar>
void add_doubled_multiple(const Exec& exec, Vertex n, const Scalar& factor, const Scalar* d,
                          const Scalar* d_low, Scalar* x, Scalar* low) {
  for_each_index(exec, "mfs::doubled", n, [=, minus = widened(-factor)](Offset i) {
    using Number = decltype(widened(x[i]));
    DoubledTotal<Number> total;
    total.add(widened(x[i]));
    total.add(widened(low[i]));
    total.subtract_product(minus, widened(d[i]));
    total.subtract_product(minus, widened(d_low[i]));
    narrow(total.value(), x[i]);
    total.add(-widened(x[i]));
    narrow(total.value(), low[i]);
  });
}

}  // namespace mfs
