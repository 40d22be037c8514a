#include "kernels/dense/row_kernels.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <type_traits>

#include "kernels/dense/simd_register.hpp"
#include "kernels/runtime/simd_clones.hpp"

namespace mfs::rows {

namespace {

/// Terms of a sum that are added before it goes to C, so that rows of B stay in the first cache.
constexpr Vertex kTermsAtOnce = 128;

/// The registers for rows of kWidth entries, of at most kBytes.
template <class Scalar, int kBytes, int kWidth>
using RowRegister = small::Register<Scalar, std::min<int>(kBytes, kWidth * sizeof(Scalar))>;

/// The kernels for rows of kWidth entries, where registers of up to kBytes are at hand. Products with complex
/// factors are a b = Re(a) b + Im(a) (i b).
template <class Scalar, int kBytes, int kWidth>
struct Rows : RowRegister<Scalar, kBytes, kWidth> {
  using Base = RowRegister<Scalar, kBytes, kWidth>;
  using Base::kLanes, Base::kParts;
  using typename Base::Real;
  using typename Base::Vector;
  static constexpr int kEntries = kWidth * kParts;  // Real in a row
  /// Registers that a part of a row fills, the columns of A or rows of C that meet it at the same time: these
  /// take half of all registers.
  static constexpr int kWide = std::min(kEntries / kLanes, 2), kPart = kWide * kLanes;
  static constexpr int kHigh = std::clamp((kBytes == 64 ? 16 : 8) / (kWide * kParts), 1, 8);

  static MFS_INLINE void load_part(const Real* from, Vector (&to)[kWide]) {
#pragma GCC unroll 2
    for (int j = 0; j < kWide; ++j) Base::load(from + j * kLanes, to[j]);
  }
  static MFS_INLINE void store_part(const Vector (&from)[kWide], Real* to) {
#pragma GCC unroll 2
    for (int j = 0; j < kWide; ++j) Base::store(from[j], to + j * kLanes);
  }

  // C -= A B for `terms` columns of A, whose rows of B are held.
  template <int terms>
  static MFS_INLINE void subtract_columns(Vertex m, const Real* a, Offset lda, const Real* b, Real* c) {
    Vector held[terms][kParts][kWide];
#pragma GCC unroll 8
    for (int p = 0; p < terms; ++p) {
      load_part(b + p * kEntries, held[p][0]);
      if constexpr (kParts == 2) {
#pragma GCC unroll 2
        for (int j = 0; j < kWide; ++j) Base::turn(held[p][0][j], held[p][1][j]);
      }
    }
    for (Vertex i = 0; i < m; ++i, a += kParts, c += kEntries) {
      Vector sum[kWide];
      load_part(c, sum);
#pragma GCC unroll 8
      for (int p = 0; p < terms; ++p) {
#pragma GCC unroll 2
        for (int part = 0; part < kParts; ++part) {
          const Real factor = a[p * kParts * lda + part];
#pragma GCC unroll 2
          for (int j = 0; j < kWide; ++j) sum[j] -= held[p][part][j] * factor;
        }
      }
      store_part(sum, c);
    }
  }
  template <int terms>
  static MFS_INLINE void product_from(Vertex p, Vertex m, Vertex k, const Real* a, Offset lda, const Real* b,
                                      Real* c) {
    for (; p + terms <= k; p += terms) {
      for (int j = 0; j < kEntries; j += kPart)
        subtract_columns<terms>(m, a + p * kParts * lda, lda, b + p * kEntries + j, c + j);
    }
    if constexpr (terms > 1) product_from<terms / 2>(p, m, k, a, lda, b, c);
  }

  // C -= A^T B for `high` columns of A, whose sums are held.
  template <int high>
  static MFS_INLINE void subtract_sums(Vertex k, const Real* a, Offset lda, const Real* b, Real* c) {
    Vector sum[high][kParts][kWide] = {};
    for (Vertex p = 0; p < k; ++p, a += kParts, b += kEntries) {
      Vector row[kWide];
      load_part(b, row);
#pragma GCC unroll 8
      for (int i = 0; i < high; ++i) {
#pragma GCC unroll 2
        for (int part = 0; part < kParts; ++part) {
          const Real factor = a[i * kParts * lda + part];
#pragma GCC unroll 2
          for (int j = 0; j < kWide; ++j) sum[i][part][j] += row[j] * factor;
        }
      }
    }
#pragma GCC unroll 8
    for (int i = 0; i < high; ++i, c += kEntries) {
      Vector to[kWide];
      load_part(c, to);
#pragma GCC unroll 2
      for (int j = 0; j < kWide; ++j) {
        to[j] -= sum[i][0][j];
        if constexpr (kParts == 2) {
          Vector turned;
          Base::turn(sum[i][1][j], turned);
          to[j] -= turned;
        }
      }
      store_part(to, c);
    }
  }
  template <int high>
  static MFS_INLINE void transposed_from(Vertex i, Vertex m, Vertex k, const Real* a, Offset lda,
                                         const Real* b, Real* c) {
    for (; i + high <= m; i += high) {
      for (int j = 0; j < kEntries; j += kPart)
        subtract_sums<high>(k, a + i * kParts * lda, lda, b + j, c + i * kEntries + j);
    }
    if constexpr (high > 1) transposed_from<high / 2>(i, m, k, a, lda, b, c);
  }

  static MFS_INLINE void gemm_minus(bool transposed, Vertex m, Vertex k, const Real* a, Offset lda,
                                    const Real* b, Real* c) {
    if (!transposed) return product_from<kHigh>(0, m, k, a, lda, b, c);
    for (Vertex p = 0; p < k; p += kTermsAtOnce)
      transposed_from<kHigh>(0, m, std::min(kTermsAtOnce, k - p), a + p * kParts, lda, b + p * kEntries, c);
  }
};

/// Function<4>, <8> or <16>. No lambda stands between these and the functions that they are inlined into: GCC
/// compiles a lambda for the processor that the file is compiled for.
#define MFS_FOR_WIDTH(width, Kernels, Function, arguments)               \
  if (width == 4) return Kernels<Scalar, kBytes, 4>::Function arguments; \
  if (width == 8) return Kernels<Scalar, kBytes, 8>::Function arguments; \
  Kernels<Scalar, kBytes, 16>::Function arguments
template <class Scalar, int kBytes, class Real>
MFS_INLINE void gemm_minus_by(bool transposed, Vertex m, Vertex width, Vertex k, const Real* a, Offset lda,
                              const Real* b, Real* c) {
  MFS_FOR_WIDTH(width, Rows, gemm_minus, (transposed, m, k, a, lda, b, c));
}

#define MFS_PRODUCTS_FOR(TARGET, S, BYTES)                                                             \
  TARGET void gemm_minus_of(bool transposed, Vertex m, Vertex width, Vertex k, const S* a, Offset lda, \
                            const S* b, S* c) {                                                        \
    using R = typename NumberParts<S>::type;                                                           \
    gemm_minus_by<S, BYTES>(transposed, m, width, k, reinterpret_cast<const R*>(a), lda,               \
                            reinterpret_cast<const R*>(b), reinterpret_cast<R*>(c));                   \
  }
MFS_FOR_SIMD_REGISTERS(MFS_PRODUCTS_FOR, float)
MFS_FOR_SIMD_REGISTERS(MFS_PRODUCTS_FOR, double)
MFS_FOR_SIMD_REGISTERS(MFS_PRODUCTS_FOR, std::complex<float>)
MFS_FOR_SIMD_REGISTERS(MFS_PRODUCTS_FOR, std::complex<double>)

/// B := op(U)^-1 B for a block of U with pivots whose inverses are not finite.
template <class Scalar>
__attribute__((noinline)) void divide_block(bool transposed, int count, int width, const Scalar* t,
                                            Offset ldt, Scalar* b) {
  for (int turn = 0; turn < count; ++turn) {
    const int row = transposed ? turn : count - 1 - turn;
    for (int j = 0; j < width; ++j) b[row * width + j] /= t[row + row * ldt];
    for (int next = turn + 1; next < count; ++next) {
      const int i = transposed ? next : count - 1 - next;
      const Scalar factor = transposed ? t[row + i * ldt] : t[i + row * ldt];
      for (int j = 0; j < width; ++j) b[i * width + j] -= factor * b[row * width + j];
    }
  }
}

/// Solves with triangles, diagonal block by diagonal block.
template <class Scalar, int kBytes, int kWidth>
struct Triangles : Rows<Scalar, kBytes, kWidth> {
  using Products = Rows<Scalar, kBytes, kWidth>;
  using Base = typename Products::Base;
  using Base::kLanes, Base::kParts;
  using Products::kEntries, Products::kHigh, Products::kPart, Products::kWide, Products::load_part,
      Products::store_part;
  using typename Base::Real;
  using typename Base::Vector;

  // A call: code of products in each of the triangles would be a megabyte.
  static MFS_INLINE void subtract_product(bool transposed, Vertex m, Vertex k, const Real* a, Offset lda,
                                          const Real* b, Real* c) {
    gemm_minus_of(transposed, m, kWidth, k, reinterpret_cast<const Scalar*>(a), lda,
                  reinterpret_cast<const Scalar*>(b), reinterpret_cast<Scalar*>(c));
  }

  /// The inverses of `count` pivots; false where one is not finite.
  static MFS_INLINE bool invert(int count, const Real* t, Offset ldt, Scalar* inverse) {
    bool finite = true;
    for (int i = 0; i < count; ++i) {
      inverse[i] = Scalar(1) / *reinterpret_cast<const Scalar*>(t + (i + i * ldt) * kParts);
      finite = finite && std::isfinite(std::abs(inverse[i]));
    }
    return finite;
  }

  // The rows of a diagonal block, all of which are held.
  template <bool upper, bool transposed, int count>
  static MFS_INLINE void solve_block(const Real* t, Offset ldt, Real* b) {
    constexpr bool downwards = upper == transposed;
    Scalar inverse[count];
    if (upper && !invert(count, t, ldt, inverse))
      return divide_block(transposed, count, kWidth, reinterpret_cast<const Scalar*>(t), ldt,
                          reinterpret_cast<Scalar*>(b));
    for (int first = 0; first < kEntries; first += kPart) {
      Vector x[count][kWide];
#pragma GCC unroll 8
      for (int i = 0; i < count; ++i) load_part(b + i * kEntries + first, x[i]);
#pragma GCC unroll 8
      for (int turn = 0; turn < count; ++turn) {
        const int row = downwards ? turn : count - 1 - turn;
        if constexpr (upper) {
#pragma GCC unroll 2
          for (int j = 0; j < kWide; ++j)
            Base::multiply(reinterpret_cast<const Real*>(inverse + row), x[row][j]);
        }
#pragma GCC unroll 8
        for (int next = turn + 1; next < count; ++next) {
          const int i = downwards ? next : count - 1 - next;
          const Real* const factor = t + (transposed ? row + i * ldt : i + row * ldt) * kParts;
#pragma GCC unroll 2
          for (int j = 0; j < kWide; ++j) Base::subtract(x[row][j], factor, x[i][j]);
        }
      }
#pragma GCC unroll 8
      for (int i = 0; i < count; ++i) store_part(x[i], b + i * kEntries + first);
    }
  }

  /// With L and U^T from the first row on, with U and L^T from the last: blocks of `count` rows, then of half
  /// as many.
  template <bool upper, bool transposed, int count>
  static MFS_INLINE void solve_from(Vertex done, Vertex n, const Real* t, Offset ldt, Real* b) {
    constexpr bool downwards = upper == transposed;
    const auto at = [=](Vertex i, Vertex j) { return t + (i + j * ldt) * kParts; };
    for (; done + count <= n; done += count) {
      const Vertex begin = downwards ? done : n - done - count, end = begin + count;
      const Vertex solved = downwards ? 0 : end, left = downwards ? end : 0;
      if constexpr (transposed)
        subtract_product(true, count, done, at(solved, begin), ldt, b + solved * kEntries,
                         b + begin * kEntries);
      solve_block<upper, transposed, count>(at(begin, begin), ldt, b + begin * kEntries);
      if constexpr (!transposed)
        subtract_product(false, n - done - count, count, at(left, begin), ldt, b + begin * kEntries,
                         b + left * kEntries);
    }
    if constexpr (count > 1) solve_from<upper, transposed, count / 2>(done, n, t, ldt, b);
  }
  static MFS_INLINE void solve(bool upper, bool transposed, Vertex n, const Real* t, Offset ldt, Real* b) {
    if (upper && transposed) solve_from<true, true, kHigh>(0, n, t, ldt, b);
    if (upper && !transposed) solve_from<true, false, kHigh>(0, n, t, ldt, b);
    if (!upper && transposed) solve_from<false, true, kHigh>(0, n, t, ldt, b);
    if (!upper && !transposed) solve_from<false, false, kHigh>(0, n, t, ldt, b);
  }
};

template <class Scalar, int kBytes, class Real>
MFS_INLINE void solve_by(bool upper, bool transposed, Vertex n, Vertex width, const Real* t, Offset ldt,
                         Real* b) {
  MFS_FOR_WIDTH(width, Triangles, solve, (upper, transposed, n, t, ldt, b));
}

#define MFS_TRIANGLES_FOR(TARGET, S, BYTES)                                                                 \
  TARGET void solve_of(bool upper, bool transposed, Vertex n, Vertex width, const S* t, Offset ldt, S* b) { \
    using R = typename NumberParts<S>::type;                                                                \
    solve_by<S, BYTES>(upper, transposed, n, width, reinterpret_cast<const R*>(t), ldt,                     \
                       reinterpret_cast<R*>(b));                                                            \
  }
MFS_FOR_SIMD_REGISTERS(MFS_TRIANGLES_FOR, float)
MFS_FOR_SIMD_REGISTERS(MFS_TRIANGLES_FOR, double)
MFS_FOR_SIMD_REGISTERS(MFS_TRIANGLES_FOR, std::complex<float>)
MFS_FOR_SIMD_REGISTERS(MFS_TRIANGLES_FOR, std::complex<double>)

template <int kWidth>
using Width = std::integral_constant<int, kWidth>;

/// move(i, entries of a row) for i < count, with loops whose length the compiler knows.
template <class Move>
void for_each_row(Vertex count, Vertex width, const Move& move) {
  const auto all = [&](auto w) {
    for (Vertex i = 0; i < count; ++i) move(i, w);
  };
  if (width == 1) return all(Width<1>());
  if (width == 4) return all(Width<4>());
  if (width == 8) return all(Width<8>());
  all(Width<16>());
}

}  // namespace

template <class Scalar>
void gemm_minus(bool transposed, Vertex m, Vertex width, Vertex k, const Scalar* a, Offset lda,
                const Scalar* b, Scalar* c) {
  gemm_minus_of(transposed, m, width, k, a, lda, b, c);
}

template <class Scalar>
void solve_triangle(bool upper, bool transposed, Vertex n, Vertex width, const Scalar* t, Offset ldt,
                    Scalar* b) {
  solve_of(upper, transposed, n, width, t, ldt, b);
}

template <class Scalar>
void gather(Vertex count, Vertex width, const Vertex* row, const Scalar* from, Scalar* to) {
  for_each_row(count, width, [=](Vertex i, auto w) {
    std::copy_n(from + static_cast<Offset>(row[i]) * w, w, to + static_cast<Offset>(i) * w);
  });
}

template <class Scalar>
void scatter(Vertex count, Vertex width, const Vertex* row, const Scalar* from, Scalar* to) {
  for_each_row(count, width, [=](Vertex i, auto w) {
    std::copy_n(from + static_cast<Offset>(i) * w, w, to + static_cast<Offset>(row[i]) * w);
  });
}

template <class Scalar>
void scatter_add(Vertex count, Vertex width, const Vertex* row, Vertex first, const Scalar* from,
                 Scalar* to) {
  for_each_row(count, width, [=](Vertex i, auto w) {
    const Scalar* const term = from + static_cast<Offset>(i) * w;
    Scalar* const sum = to + static_cast<Offset>(row[i] - first) * w;
    for (int j = 0; j < w; ++j) sum[j] += term[j];
  });
}

#define MFS_INSTANTIATE(S)                                                                   \
  template void gemm_minus<S>(bool, Vertex, Vertex, Vertex, const S*, Offset, const S*, S*); \
  template void solve_triangle<S>(bool, bool, Vertex, Vertex, const S*, Offset, S*);         \
  template void gather<S>(Vertex, Vertex, const Vertex*, const S*, S*);                      \
  template void scatter<S>(Vertex, Vertex, const Vertex*, const S*, S*);                     \
  template void scatter_add<S>(Vertex, Vertex, const Vertex*, Vertex, const S*, S*);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs::rows
