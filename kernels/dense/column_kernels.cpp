#include "kernels/dense/column_kernels.hpp"

#include <algorithm>

#include "kernels/dense/simd_register.hpp"
#include "kernels/runtime/simd_clones.hpp"

namespace mfs::small {

namespace {

/// y -= A x by registers of kBytes, what is left of the rows by smaller ones.
template <class Number, int kBytes>
struct Product : Register<Number, kBytes> {
  using Base = Register<Number, kBytes>;
  using Base::kLanes, Base::load, Base::store;
  using typename Base::Real;
  using typename Base::Vector;

  // kLanes rows; sums of two, of four, of eight.
  template <int kColumns>
  static MFS_INLINE void subtract(const Real* a, Offset ld, const Real* x, Real* y) {
    Vector sum[kColumns], to;
#pragma GCC unroll 8
    for (int j = 0; j < kColumns; ++j) {
      load(a + j * ld, sum[j]);
      sum[j] *= x[j];
    }
#pragma GCC unroll 8
    for (int apart = 1; apart < kColumns; apart *= 2) {
#pragma GCC unroll 8
      for (int j = 0; j < kColumns; j += 2 * apart) sum[j] += sum[j + apart];
    }
    load(y, to);
    to -= sum[0];
    store(to, y);
  }
  template <int kColumns>
  static MFS_INLINE void rows(Vertex m, const Real* a, Offset ld, const Real* x, Real* y) {
    Vertex i = 0;
    for (; i + kLanes <= m; i += kLanes) subtract<kColumns>(a + i, ld, x, y + i);
    if constexpr (kLanes > 1) {
      if (i < m) Product<Number, kBytes / 2>::template rows<kColumns>(m - i, a + i, ld, x, y + i);
    }
  }
  static MFS_INLINE void columns(Vertex m, Vertex k, const Real* a, Offset ld, const Real* x, Real* y) {
    Vertex j = 0;
    for (; j + 8 <= k; j += 8) rows<8>(m, a + j * ld, ld, x + j, y);
    if (k - j >= 4) rows<4>(m, a + j * ld, ld, x + j, y), j += 4;
    if (k - j >= 2) rows<2>(m, a + j * ld, ld, x + j, y), j += 2;
    if (k - j >= 1) rows<1>(m, a + j * ld, ld, x + j, y);
  }
};

// y (m) -= A x for A (m x k).
#define MFS_PRODUCT_FOR(TARGET, S, BYTES)                                                        \
  TARGET void subtract_product_of(Vertex m, Vertex k, const S* a, Offset ld, const S* x, S* y) { \
    Product<S, BYTES>::columns(m, k, a, ld, x, y);                                               \
  }
MFS_FOR_SIMD_REGISTERS(MFS_PRODUCT_FOR, float)
MFS_FOR_SIMD_REGISTERS(MFS_PRODUCT_FOR, double)

/// The registers for blocks of kBlock rows, of at most kBytes.
template <class Number, int kBytes, int kBlock>
using BlockRegister = Register<Number, std::min<int>(kBytes, kBlock * sizeof(Number))>;

/// kBlock rows are solved for together.
template <class Number, int kBytes, int kBlock>
struct Column : BlockRegister<Number, kBytes, kBlock> {
  using Base = BlockRegister<Number, kBytes, kBlock>;
  using Base::kLanes, Base::load, Base::store;
  using typename Base::Places;
  using typename Base::Real;
  using typename Base::Vector;
  static constexpr int kRegisters = kBlock / kLanes;  // of a block

  /// Lanes behind `lane` stay, or those before it; others become zero.
  static MFS_INLINE void keep(bool before, int lane, Vector& x) {
    Places kept;
    for (int i = 0; i < kLanes; ++i) kept[i] = (before ? i < lane : i > lane) ? -1 : 0;
    x = reinterpret_cast<Vector>(reinterpret_cast<Places>(x) & kept);
  }

  /// inverse[j] = 1 / t(j, j), first <= j < last; false where one is not finite.
  static MFS_INLINE bool invert(int first, int last, const Real* t, Offset ldt, Real* inverse) {
    Real diagonal[kBlock];
    for (int j = 0; j < kBlock; ++j) diagonal[j] = j >= first && j < last ? t[j + j * ldt] : Real(1);
    Real none = 0;  // NaN where an inverse is infinite or NaN
    for (int r = 0; r < kBlock; r += kLanes) {
      Vector entries;
      load(diagonal + r, entries);
      entries = 1 / entries;
      store(entries, inverse + r);
    }
    for (int j = 0; j < kBlock; ++j) none += inverse[j] * 0;
    return none == 0;
  }

  // Rows [first, last) of a block whose others have been solved for.
  template <bool upper>
  static MFS_INLINE void solve_block(int first, int last, const Real* t, Offset ldt, Real* x) {
    Real inverse[kBlock];
    if (upper && !invert(first, last, t, ldt, inverse)) return solve_few<upper>(first, last, t, ldt, x);
    Vector held[kRegisters];
#pragma GCC unroll 8
    for (int r = 0; r < kRegisters; ++r) load(x + r * kLanes, held[r]);
#pragma GCC unroll 8
    for (int turn = 0; turn < kBlock; ++turn) {
      const int j = upper ? kBlock - 1 - turn : turn, own = j / kLanes;
      if (j < first || j >= last) continue;
      Real found = held[own][j % kLanes];
      if constexpr (upper) found *= inverse[j];
      x[j] = found;
#pragma GCC unroll 8
      for (int r = 0; r < kRegisters; ++r) {
        if (upper ? r > own : r < own) continue;
        Vector column;
        load(t + j * ldt + r * kLanes, column);
        if (r == own) keep(upper, j % kLanes, column);
        held[r] -= column * found;
      }
    }
  }
  /// The same by divisions, entry by entry.
  template <bool upper>
  static MFS_INLINE void solve_few(int first, int last, const Real* t, Offset ldt, Real* x) {
    for (int turn = 0; turn < last - first; ++turn) {
      const int j = upper ? last - 1 - turn : first + turn;
      if constexpr (upper) x[j] /= t[j + j * ldt];
      for (int i = upper ? first : j + 1; i < (upper ? j : last); ++i) x[i] -= t[i + j * ldt] * x[j];
    }
  }

  // Blocks from the first row on for L, from the last for U; what is left of a block lies in one with rows
  // before it.
  template <bool upper>
  static MFS_INLINE void solve(Vertex n, const Real* t, Offset ldt, Real* x) {
    if (n < kBlock) {
      if constexpr (kBlock > 4)
        return Column<Number, kBytes, kBlock / 2>::template solve<upper>(n, t, ldt, x);
      return solve_few<upper>(0, n, t, ldt, x);
    }
    Vertex done = 0;
    for (; done + kBlock <= n; done += kBlock) {
      const Vertex begin = upper ? n - done - kBlock : done, rest = upper ? 0 : done + kBlock;
      solve_block<upper>(0, kBlock, t + begin + begin * ldt, ldt, x + begin);
      subtract_product_of(n - done - kBlock, kBlock, t + rest + begin * ldt, ldt, x + begin, x + rest);
    }
    if (done == n) return;
    const Vertex left = n - done, begin = upper ? 0 : n - kBlock;
    solve_block<upper>(upper ? 0 : kBlock - left, upper ? left : kBlock, t + begin + begin * ldt, ldt,
                       x + begin);
  }
};

#define MFS_COLUMN_FOR(TARGET, S, BYTES)                                     \
  TARGET void solve_of(bool upper, Vertex n, const S* t, Offset ldt, S* x) { \
    if (upper) {                                                             \
      Column<S, BYTES, 8>::template solve<true>(n, t, ldt, x);               \
    } else {                                                                 \
      Column<S, BYTES, 8>::template solve<false>(n, t, ldt, x);              \
    }                                                                        \
  }
MFS_FOR_SIMD_REGISTERS(MFS_COLUMN_FOR, float)
MFS_FOR_SIMD_REGISTERS(MFS_COLUMN_FOR, double)

}  // namespace

template <class Real>
void solve_column(bool upper, Vertex n, const Real* t, Offset ldt, Real* x) {
  solve_of(upper, n, t, ldt, x);
}

template <class Real>
void subtract_product(Vertex m, Vertex k, const Real* a, Offset lda, const Real* x, Real* y) {
  subtract_product_of(m, k, a, lda, x, y);
}

template void subtract_product<float>(Vertex, Vertex, const float*, Offset, const float*, float*);
template void subtract_product<double>(Vertex, Vertex, const double*, Offset, const double*, double*);
template void solve_column<float>(bool, Vertex, const float*, Offset, float*);
template void solve_column<double>(bool, Vertex, const double*, Offset, double*);

}  // namespace mfs::small
