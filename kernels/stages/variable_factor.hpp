// Stage "variable factor": LU of the pivot block of each front, and the triangular solves of its column block
// L and row block U. The pivot block is divided into blocks of at most max_block_size columns:
//
//           k   k+s      p        b
//         +---+---+-----------+------+
//         | U : U             |      |      for each block:  panel    rows [k, p) of columns [k, k+s), pivots
//       k |...+---+-----------+------|                                searched in all of them
//         |   |///| row solve | ---> |               L       rows of the border, times U_kk^-1
//     k+s |   |///+-----------+------|               rows    L_kk^-1 times what is right of the block
//         |   |///| product   | ---> |               product of the two from all that is left of P, L and U
//       p |   +---+-----------+------+
//         |   | L |           |   C  |      C is left to the stage "variable update".
//         +---+---+-----------+------+
#pragma once

#include "kernels/dense/panel_lu.hpp"
#include "kernels/stages/front_store.hpp"
#include "plan/symbolic_plan.hpp"

namespace mfs {

/// What fronts add to the status.
struct FrontTally {
  Vertex perturbed = 0;
  Vertex nonfinite = 0;
  BlockFlops flops{0, 0, 0};
};

/// Place i of the pivot block holds row local_row[i] of the assembled front, once all exchanges are done.
inline void follow_exchanges(Vertex pivots, Vertex width, const Vertex* interchange, Vertex* local_row) {
  for (Vertex i = 0; i < pivots; ++i) local_row[i] = i;
  for (Vertex k = 0; k < pivots; k += width) {
    for (Vertex j = k; j < k + width && j < pivots; ++j) {
      const Vertex other = k + interchange[j], row = local_row[j];
      local_row[j] = local_row[other];
      local_row[other] = row;
    }
  }
}

/// Factors P, L and U of one front with the given block operations (kernels/stages/host_ops.hpp).
/// `interchange`, `shift` and `work` have one place per pivot; `interchange` counts from the begin of each
/// block.
template <class Ops, class Scalar>
void factor_front(const Ops& ops, const Front<Scalar>& front, Vertex width, const PivotRule& rule,
                  Vertex* interchange, Scalar* shift, Scalar* work, FrontTally& tally) {
  const Vertex p = front.pivots, b = front.border;
  const Offset ld = front.lower_ld;
  for (Vertex k = 0; k < p; k += width) {
    const Vertex s = width < p - k ? width : p - k, rest = p - k - s;
    Scalar* block = front.lower + k + k * ld;        // (k, k)
    Scalar* right = block + s * ld;                  // (k, k+s)
    Scalar* border_rows = front.lower + p + k * ld;  // (p, k)
    Scalar* upper = front.upper + k;                 // (k, p)

    const PivotTally pivots = ops.factor_block(BlockColumns<Scalar>{block, ld, p - k, b, work}, p - k, s,
                                               rule, interchange + k, shift + k);
    tally.perturbed += pivots.perturbed;
    tally.nonfinite += pivots.first_nonfinite >= 0;
    ops.all(ops.solve_upper_right(b, s, block, ld, border_rows, ld),
            ops.exchange_and_solve(s, b, block, ld, interchange + k, upper, p),
            ops.exchange_and_solve(s, rest, block, ld, interchange + k, right, ld),
            ops.exchange_rows(k, front.lower + k, ld, interchange + k, s));
    ops.all(ops.gemm_minus(b, rest, s, border_rows, ld, right, ld, border_rows + s * ld, ld),
            ops.gemm_minus(rest, b, s, block + s, ld, upper, p, upper + s, p),
            ops.gemm_minus(rest, rest, s, block + s, ld, right, ld, right + s, ld));

    const BlockFlops done = block_flops(s, rest + b);
    tally.flops.getrf += done.getrf;
    tally.flops.trsm += done.trsm;
    tally.flops.gemm += done.gemm - 2.0 * s * static_cast<double>(b) * b;
  }
}

}  // namespace mfs
