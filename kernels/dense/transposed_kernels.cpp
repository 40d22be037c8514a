#include "kernels/dense/transposed_kernels.hpp"

#include <algorithm>
#include <complex>

#include "kernels/dense/simd_register.hpp"
#include "kernels/runtime/simd_clones.hpp"

namespace mfs::small {

namespace {

/// Columns of A that are multiplied at the same time, and rows of a triangle that are solved for.
constexpr int kHigh = 4;
/// Terms of a sum that are added before it goes to C, so that columns of B stay in the first cache.
constexpr Vertex kTerms = 256;

/// kSums: registers that hold sums at the same time, half of all. Complex numbers are pairs of real ones
/// here, and a sum of their products has two registers: a b = (Re a Re b - Im a Im b) + i (Re a Im b + Im a
/// Re b) are the entries of a times those of b, and times those of b with each pair exchanged.
template <class Scalar, int kBytes>
struct Dots : Register<Scalar, kBytes> {
  using Base = Register<Scalar, kBytes>;
  using Base::kLanes, Base::kParts, Base::kRows, Base::exchange_pairs;
  using typename Base::Places;
  using typename Base::Real;
  using typename Base::Vector;
  static constexpr int kSums = kBytes == 64 ? 16 : 8;
  static constexpr int kWide = kSums / kHigh / kParts > 0 ? kSums / kHigh / kParts : 1;

  /// The last entries of a column fill no register. It then ends with them, and those before, which have been
  /// added, count as zero.
  static MFS_INLINE void load(const Real* from, const Places* keep, Vector& to) {
    Base::load(from, to);
    if (keep) to = reinterpret_cast<Vector>(reinterpret_cast<Places>(to) & *keep);
  }

  template <int high, int wide>
  struct Sums {
    Vector of[high][wide][kParts];
  };
  template <int high, int wide>
  static MFS_INLINE void add_terms(const Real* a, Offset lda, const Real* b, Offset ldb, const Places* keep,
                                   Sums<high, wide>& sums) {
    Vector of_b[wide][kParts];
#pragma GCC unroll 4
    for (int j = 0; j < wide; ++j) {
      load(b + j * kParts * ldb, keep, of_b[j][0]);
      if constexpr (kParts == 2) exchange_pairs(of_b[j][0], of_b[j][1]);
    }
#pragma GCC unroll 4
    for (int i = 0; i < high; ++i) {
      Vector of_a;
      load(a + i * kParts * lda, keep, of_a);
#pragma GCC unroll 4
      for (int j = 0; j < wide; ++j) {
#pragma GCC unroll 2
        for (int part = 0; part < kParts; ++part) sums.of[i][j][part] += of_a * of_b[j][part];
      }
    }
  }
  /// to -= the sum of all products.
  static MFS_INLINE void subtract_sum(const Vector (&sum)[kParts], Real* to) {
    Real total[kParts] = {};
    for (int lane = 0; lane < kLanes; ++lane) {
      total[0] += kParts == 2 && lane % 2 == 1 ? -sum[0][lane] : sum[0][lane];
      if constexpr (kParts == 2) total[1] += sum[1][lane];
    }
    for (int part = 0; part < kParts; ++part) to[part] -= total[part];
  }
  /// to -= a b.
  static MFS_INLINE void subtract_product(const Real* a, const Real* b, Real* to) {
    if constexpr (kParts == 1) {
      to[0] -= a[0] * b[0];
    } else {
      to[0] -= a[0] * b[0] - a[1] * b[1];
      to[1] -= a[0] * b[1] + a[1] * b[0];
    }
  }

  // c(i, j) -= a(:, i) . b(:, j) for i < high and j < wide.
  template <int high, int wide>
  static MFS_INLINE void subtract_tile(Vertex k, const Real* a, Offset lda, const Real* b, Offset ldb,
                                       Real* c, Offset ldc) {
    if (k < kRows) {
      for (int j = 0; j < wide; ++j) {
        for (int i = 0; i < high; ++i) {
          Real total[kParts] = {};
          for (Vertex p = 0; p < k; ++p)
            subtract_product(a + (p + i * lda) * kParts, b + (p + j * ldb) * kParts, total);
          for (int part = 0; part < kParts; ++part) c[(i + j * ldc) * kParts + part] += total[part];
        }
      }
      return;
    }
    Sums<high, wide> sums = {};
    Vertex p = 0;
    for (; p + kRows <= k; p += kRows)
      add_terms<high, wide>(a + p * kParts, lda, b + p * kParts, ldb, nullptr, sums);
    if (p < k) {
      const Vertex begin = k - kRows;
      Places keep;
      for (int lane = 0; lane < kLanes; ++lane) keep[lane] = begin + lane / kParts >= p ? -1 : 0;
      add_terms<high, wide>(a + begin * kParts, lda, b + begin * kParts, ldb, &keep, sums);
    }
#pragma GCC unroll 4
    for (int i = 0; i < high; ++i) {
#pragma GCC unroll 4
      for (int j = 0; j < wide; ++j) subtract_sum(sums.of[i][j], c + (i + j * ldc) * kParts);
    }
  }

  template <int high, int wide>
  static MFS_INLINE void subtract_columns(Vertex j, Vertex n, Vertex k, const Real* a, Offset lda,
                                          const Real* b, Offset ldb, Real* c, Offset ldc) {
    for (; j + wide <= n; j += wide)
      subtract_tile<high, wide>(k, a, lda, b + j * kParts * ldb, ldb, c + j * kParts * ldc, ldc);
    if constexpr (wide > 1) subtract_columns<high, wide / 2>(j, n, k, a, lda, b, ldb, c, ldc);
  }

  static MFS_INLINE void gemm_minus(Vertex m, Vertex n, Vertex k, const Real* a, Offset lda, const Real* b,
                                    Offset ldb, Real* c, Offset ldc) {
    for (Vertex p = 0; p < k; p += kTerms, a += kTerms * kParts, b += kTerms * kParts) {
      const Vertex terms = std::min(kTerms, k - p);
      Vertex i = 0;
      for (; i + kHigh <= m; i += kHigh)
        subtract_columns<kHigh, kWide>(0, n, terms, a + i * kParts * lda, lda, b, ldb, c + i * kParts, ldc);
      for (; i < m; ++i)
        subtract_columns<1, kWide>(0, n, terms, a + i * kParts * lda, lda, b, ldb, c + i * kParts, ldc);
    }
  }

  /// The rows of B by blocks, from the first on for the upper triangle and from the last on for the lower
  /// one.
  template <bool upper>
  static MFS_INLINE void solve(Vertex n, Vertex columns, const Real* t, Offset ldt, Real* b, Offset ldb) {
    for (Vertex done = 0; done < n; done += kHigh) {
      const Vertex count = std::min<Vertex>(kHigh, n - done);
      const Vertex begin = upper ? done : n - done - count, solved = upper ? 0 : n - done;
      gemm_minus(count, columns, done, t + (solved + begin * ldt) * kParts, ldt, b + solved * kParts, ldb,
                 b + begin * kParts, ldb);
      for (Vertex j = 0; j < columns; ++j)
        solve_block<upper>(count, t + (begin + begin * ldt) * kParts, ldt, b + (begin + j * ldb) * kParts);
    }
  }
  template <bool upper>
  static MFS_INLINE void solve_block(Vertex count, const Real* t, Offset ldt, Real* x) {
    for (Vertex turn = 0; turn < count; ++turn) {
      const Vertex i = upper ? turn : count - 1 - turn;
      const Vertex first = upper ? 0 : i + 1, last = upper ? i : count;
      for (Vertex p = first; p < last; ++p)
        subtract_product(t + (p + i * ldt) * kParts, x + p * kParts, x + i * kParts);
      if constexpr (upper)
        *reinterpret_cast<Scalar*>(x + i * kParts) /=
            *reinterpret_cast<const Scalar*>(t + (i + i * ldt) * kParts);
    }
  }
};

#define MFS_KERNELS_FOR(TARGET, S, BYTES)                                                                   \
  TARGET void gemm_minus_of(Vertex m, Vertex n, Vertex k, const S* a, Offset lda, const S* b, Offset ldb,   \
                            S* c, Offset ldc) {                                                             \
    using D = Dots<S, BYTES>;                                                                               \
    using R = typename D::Real;                                                                             \
    D::gemm_minus(m, n, k, reinterpret_cast<const R*>(a), lda, reinterpret_cast<const R*>(b), ldb,          \
                  reinterpret_cast<R*>(c), ldc);                                                            \
  }                                                                                                         \
  TARGET void solve_upper_of(Vertex n, Vertex columns, const S* t, Offset ldt, S* b, Offset ldb) {          \
    using D = Dots<S, BYTES>;                                                                               \
    using R = typename D::Real;                                                                             \
    D::template solve<true>(n, columns, reinterpret_cast<const R*>(t), ldt, reinterpret_cast<R*>(b), ldb);  \
  }                                                                                                         \
  TARGET void solve_unit_lower_of(Vertex n, Vertex columns, const S* t, Offset ldt, S* b, Offset ldb) {     \
    using D = Dots<S, BYTES>;                                                                               \
    using R = typename D::Real;                                                                             \
    D::template solve<false>(n, columns, reinterpret_cast<const R*>(t), ldt, reinterpret_cast<R*>(b), ldb); \
  }
MFS_FOR_SIMD_REGISTERS(MFS_KERNELS_FOR, float)
MFS_FOR_SIMD_REGISTERS(MFS_KERNELS_FOR, double)
MFS_FOR_SIMD_REGISTERS(MFS_KERNELS_FOR, std::complex<float>)
MFS_FOR_SIMD_REGISTERS(MFS_KERNELS_FOR, std::complex<double>)

}  // namespace

template <class Scalar>
void gemm_minus_transposed(Vertex m, Vertex n, Vertex k, const Scalar* a, Offset lda, const Scalar* b,
                           Offset ldb, Scalar* c, Offset ldc) {
  gemm_minus_of(m, n, k, a, lda, b, ldb, c, ldc);
}

template <class Scalar>
void solve_unit_lower_transposed(Vertex n, Vertex columns, const Scalar* t, Offset ldt, Scalar* b,
                                 Offset ldb) {
  solve_unit_lower_of(n, columns, t, ldt, b, ldb);
}

template <class Scalar>
void solve_upper_transposed(Vertex n, Vertex columns, const Scalar* t, Offset ldt, Scalar* b, Offset ldb) {
  solve_upper_of(n, columns, t, ldt, b, ldb);
}

#define MFS_INSTANTIATE(S)                                                                               \
  template void gemm_minus_transposed<S>(Vertex, Vertex, Vertex, const S*, Offset, const S*, Offset, S*, \
                                         Offset);                                                        \
  template void solve_unit_lower_transposed<S>(Vertex, Vertex, const S*, Offset, S*, Offset);            \
  template void solve_upper_transposed<S>(Vertex, Vertex, const S*, Offset, S*, Offset);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs::small
