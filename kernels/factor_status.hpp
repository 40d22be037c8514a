// What a factorization says when it is done.
#pragma once

namespace mfs {

/// Zeroed at its begin, read once at its end.
struct FactorStatus {
  unsigned long long perturbed;
  unsigned long long nonfinite;  // pivots that were NaN or infinite
  double getrf, trsm, gemm;      // floating-point operations done, as the plan counts them
};

}  // namespace mfs
