#include "kernels/dense/transposed_kernels.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "kernels/runtime/simd_clones.hpp"

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"  // vectors are passed between inlined functions only
#endif

#define MFS_INLINE inline __attribute__((always_inline))

namespace mfs::small {

namespace {

/// Columns of A that are multiplied at the same time, and rows of a triangle that are solved for.
constexpr int kHigh = 4;
/// Terms of a sum that are added before it goes to C, so that columns of B stay in the first cache.
constexpr Vertex kTerms = 256;

/// kBytes: of a vector register. kWide: columns of B that are multiplied at the same time.
template <class Real, int kBytes, int kWide>
struct Dots {
  static constexpr int kLanes = kBytes / static_cast<int>(sizeof(Real));
  typedef Real Vector __attribute__((vector_size(kBytes)));
  using Index = std::conditional_t<sizeof(Real) == 8, std::int64_t, std::int32_t>;
  typedef Index Places __attribute__((vector_size(kBytes)));

  /// The last entries of a column fill no register. It then ends with them, and those before, which have been
  /// added, count as zero.
  static MFS_INLINE void load(const Real* from, const Places* keep, Vector& to) {
    std::memcpy(&to, from, kBytes);
    if (keep) to = reinterpret_cast<Vector>(reinterpret_cast<Places>(to) & *keep);
  }

  template <int high, int wide>
  static MFS_INLINE void add_terms(const Real* a, Offset lda, const Real* b, Offset ldb, const Places* keep,
                                   Vector (&sum)[high][wide]) {
    Vector of_b[wide];
#pragma GCC unroll 4
    for (int j = 0; j < wide; ++j) load(b + j * ldb, keep, of_b[j]);
#pragma GCC unroll 4
    for (int i = 0; i < high; ++i) {
      Vector of_a;
      load(a + i * lda, keep, of_a);
#pragma GCC unroll 4
      for (int j = 0; j < wide; ++j) sum[i][j] += of_a * of_b[j];
    }
  }

  // c(i, j) -= a(:, i) . b(:, j) for i < high and j < wide.
  template <int high, int wide>
  static MFS_INLINE void subtract_tile(Vertex k, const Real* a, Offset lda, const Real* b, Offset ldb,
                                       Real* c, Offset ldc) {
    if (k < kLanes) {
      for (int j = 0; j < wide; ++j) {
        for (int i = 0; i < high; ++i) {
          Real total = 0;
          for (Vertex p = 0; p < k; ++p) total += a[p + i * lda] * b[p + j * ldb];
          c[i + j * ldc] -= total;
        }
      }
      return;
    }
    Vector sum[high][wide];
#pragma GCC unroll 4
    for (int i = 0; i < high; ++i) {
#pragma GCC unroll 4
      for (int j = 0; j < wide; ++j) sum[i][j] = Vector{};
    }
    Vertex p = 0;
    for (; p + kLanes <= k; p += kLanes) add_terms(a + p, lda, b + p, ldb, nullptr, sum);
    if (p < k) {
      Places keep;
      for (int lane = 0; lane < kLanes; ++lane) keep[lane] = k - kLanes + lane >= p ? -1 : 0;
      add_terms(a + k - kLanes, lda, b + k - kLanes, ldb, &keep, sum);
    }
#pragma GCC unroll 4
    for (int i = 0; i < high; ++i) {
#pragma GCC unroll 4
      for (int j = 0; j < wide; ++j) {
        Real total = 0;
        for (int lane = 0; lane < kLanes; ++lane) total += sum[i][j][lane];
        c[i + j * ldc] -= total;
      }
    }
  }

  template <int high, int wide>
  static MFS_INLINE void subtract_columns(Vertex j, Vertex n, Vertex k, const Real* a, Offset lda,
                                          const Real* b, Offset ldb, Real* c, Offset ldc) {
    for (; j + wide <= n; j += wide) subtract_tile<high, wide>(k, a, lda, b + j * ldb, ldb, c + j * ldc, ldc);
    if constexpr (wide > 1) subtract_columns<high, wide / 2>(j, n, k, a, lda, b, ldb, c, ldc);
  }

  static MFS_INLINE void gemm_minus(Vertex m, Vertex n, Vertex k, const Real* a, Offset lda, const Real* b,
                                    Offset ldb, Real* c, Offset ldc) {
    for (Vertex p = 0; p < k; p += kTerms, a += kTerms, b += kTerms) {
      const Vertex terms = std::min(kTerms, k - p);
      Vertex i = 0;
      for (; i + kHigh <= m; i += kHigh)
        subtract_columns<kHigh, kWide>(0, n, terms, a + i * lda, lda, b, ldb, c + i, ldc);
      for (; i < m; ++i) subtract_columns<1, kWide>(0, n, terms, a + i * lda, lda, b, ldb, c + i, ldc);
    }
  }

  /// The rows of B by blocks, from the first on for the upper triangle and from the last on for the lower
  /// one.
  template <bool upper>
  static MFS_INLINE void solve(Vertex n, Vertex columns, const Real* t, Offset ldt, Real* b, Offset ldb) {
    for (Vertex done = 0; done < n; done += kHigh) {
      const Vertex count = std::min<Vertex>(kHigh, n - done);
      const Vertex begin = upper ? done : n - done - count, solved = upper ? 0 : n - done;
      const Real* const diagonal = t + begin + begin * ldt;
      gemm_minus(count, columns, done, t + solved + begin * ldt, ldt, b + solved, ldb, b + begin, ldb);
      for (Vertex j = 0; j < columns; ++j) solve_block<upper>(count, diagonal, ldt, b + begin + j * ldb);
    }
  }
  template <bool upper>
  static MFS_INLINE void solve_block(Vertex count, const Real* t, Offset ldt, Real* x) {
    if constexpr (upper) {
      for (Vertex i = 0; i < count; ++i) {
        for (Vertex p = 0; p < i; ++p) x[i] -= t[p + i * ldt] * x[p];
        x[i] /= t[i + i * ldt];
      }
    } else {
      for (Vertex i = count - 1; i >= 0; --i) {
        for (Vertex p = i + 1; p < count; ++p) x[i] -= t[p + i * ldt] * x[p];
      }
    }
  }
};

// A tile has sixteen sums where there are 32 registers, else eight.
#define MFS_KERNELS_FOR(TARGET, S, BYTES, WIDE)                                                           \
  TARGET void gemm_minus_of(Vertex m, Vertex n, Vertex k, const S* a, Offset lda, const S* b, Offset ldb, \
                            S* c, Offset ldc) {                                                           \
    Dots<S, BYTES, WIDE>::gemm_minus(m, n, k, a, lda, b, ldb, c, ldc);                                    \
  }                                                                                                       \
  TARGET void solve_upper_of(Vertex n, Vertex columns, const S* t, Offset ldt, S* b, Offset ldb) {        \
    Dots<S, BYTES, WIDE>::template solve<true>(n, columns, t, ldt, b, ldb);                               \
  }                                                                                                       \
  TARGET void solve_unit_lower_of(Vertex n, Vertex columns, const S* t, Offset ldt, S* b, Offset ldb) {   \
    Dots<S, BYTES, WIDE>::template solve<false>(n, columns, t, ldt, b, ldb);                              \
  }
#ifdef MFS_SIMD_TARGETS
#define MFS_KERNELS(S)                                                 \
  MFS_KERNELS_FOR(__attribute__((target("arch=x86-64-v4"))), S, 64, 4) \
  MFS_KERNELS_FOR(__attribute__((target("arch=x86-64-v3"))), S, 32, 2) \
  MFS_KERNELS_FOR(__attribute__((target("default"))), S, 16, 2)
#else
#define MFS_KERNELS(S) MFS_KERNELS_FOR(, S, 16, 2)
#endif
MFS_KERNELS(float)
MFS_KERNELS(double)

}  // namespace

template <class Real>
void gemm_minus_transposed(Vertex m, Vertex n, Vertex k, const Real* a, Offset lda, const Real* b, Offset ldb,
                           Real* c, Offset ldc) {
  gemm_minus_of(m, n, k, a, lda, b, ldb, c, ldc);
}

template <class Real>
void solve_unit_lower_transposed(Vertex n, Vertex columns, const Real* t, Offset ldt, Real* b, Offset ldb) {
  solve_unit_lower_of(n, columns, t, ldt, b, ldb);
}

template <class Real>
void solve_upper_transposed(Vertex n, Vertex columns, const Real* t, Offset ldt, Real* b, Offset ldb) {
  solve_upper_of(n, columns, t, ldt, b, ldb);
}

#define MFS_INSTANTIATE(S)                                                                               \
  template void gemm_minus_transposed<S>(Vertex, Vertex, Vertex, const S*, Offset, const S*, Offset, S*, \
                                         Offset);                                                        \
  template void solve_unit_lower_transposed<S>(Vertex, Vertex, const S*, Offset, S*, Offset);            \
  template void solve_upper_transposed<S>(Vertex, Vertex, const S*, Offset, S*, Offset);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)

}  // namespace mfs::small
