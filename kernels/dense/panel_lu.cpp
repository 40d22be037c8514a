#include "kernels/dense/panel_lu.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "kernels/dense/blas.hpp"
#include "kernels/runtime/simd_clones.hpp"

namespace mfs {

namespace {

// Up to this width a panel of m rows is factored column by column: fewer columns where 16 of them are more
// than a first-level cache holds, as each step passes over all of them. 2-core EPYC, 2026-11: 8 instead of 16
// columns take a third off panels of 800 rows and 64 columns; 32 for small fronts gain nothing with OpenBLAS.
Vertex base_columns(Vertex m) {
  return m > 384 ? 8 : 16;
}

// A (m x n) -= x y^T, y strided: one step of the column-by-column factorization.
#define MFS_RANK_ONE_UPDATE(S)                                                                        \
  MFS_SIMD_CLONES void rank_one_update(Vertex m, Vertex n, const S* x, const S* y, S* a, Offset ld) { \
    for (Vertex j = 0; j < n; ++j) {                                                                  \
      const S factor = y[j * ld];                                                                     \
      S* column = a + j * ld;                                                                         \
      for (Vertex i = 0; i < m; ++i) column[i] -= x[i] * factor;                                      \
    }                                                                                                 \
  }                                                                                                   \
  MFS_SIMD_CLONES void scale(Vertex m, S factor, S* x) {                                              \
    for (Vertex i = 0; i < m; ++i) x[i] *= factor;                                                    \
  }
MFS_RANK_ONE_UPDATE(float)
MFS_RANK_ONE_UPDATE(double)
MFS_RANK_ONE_UPDATE(std::complex<float>)
MFS_RANK_ONE_UPDATE(std::complex<double>)

// The first row counts `preference` times.
template <class Scalar>
Vertex pivot_row(Vertex begin, Vertex end, const Scalar* column, double preference) {
  Vertex best = begin;
  auto most = std::abs(column[begin]);
  most *= static_cast<decltype(most)>(preference);
  for (Vertex i = begin + 1; i < end; ++i) {
    const auto size = std::abs(column[i]);
    if (size > most) {
      most = size;
      best = i;
    }
  }
  return best;
}

template <class Scalar>
Scalar perturbed(Scalar pivot, double size_wanted) {
  using Real = decltype(std::abs(pivot));
  const Real size = std::abs(pivot);
  return size > Real(0) ? pivot / size * static_cast<Real>(size_wanted)
                        : Scalar(static_cast<Real>(size_wanted));
}

// Largest entry that column c of the block has in the border rows once the columns left of it are eliminated.
template <class Scalar>
double largest_in_border(const BlockColumns<Scalar>& block, Vertex c) {
  const Scalar* column = block.a + c * block.lda;
  std::copy(column, column + c, block.work);
  blas::solve_upper(blas::Transpose::no, c, 1, block.a, block.lda, block.work, c);
  double most = 0;
  constexpr Vertex kRows = 64;
  for (Vertex i = 0; i < block.border_rows; i += kRows) {
    const Vertex rows = std::min(kRows, block.border_rows - i);
    Scalar entries[kRows];
    std::copy(column + block.border_begin + i, column + block.border_begin + i + rows, entries);
    blas::gemm_minus(blas::Transpose::no, rows, 1, c, block.a + block.border_begin + i, block.lda, block.work,
                     c, entries, rows);
    for (Vertex k = 0; k < rows; ++k) most = std::max(most, static_cast<double>(std::abs(entries[k])));
  }
  return most;
}

// Replaces the pivot where it is too small; notes what was done.
template <class Scalar>
void accept_pivot(const BlockColumns<Scalar>& block, Vertex c, const PivotRule& rule, Scalar& pivot,
                  Scalar& shift, PivotTally& tally) {
  shift = Scalar(0);
  const double size = std::abs(pivot);
  if (!std::isfinite(size)) {
    if (tally.first_nonfinite < 0) tally.first_nonfinite = c;
  } else if (size < rule.bound) {
    const double border = largest_in_border(block, c);
    if (is_accepted(size, border, rule)) return;
    const Scalar replacement = perturbed(pivot, size_instead(size, border, rule));
    shift = replacement - pivot;
    pivot = replacement;
    ++tally.perturbed;
  }
}

// Division by a tiny pivot would overflow its reciprocal.
template <class Scalar>
void divide_column(Vertex m, Scalar pivot, Scalar* x) {
  const Scalar inverse = Scalar(1) / pivot;
  if (std::isfinite(std::abs(inverse))) {
    scale(m, inverse, x);
  } else {
    for (Vertex i = 0; i < m; ++i) x[i] /= pivot;
  }
}

// The panel's rows and columns count from `first` of the block.
template <class Scalar>
void factor_columns(const BlockColumns<Scalar>& block, Vertex first, Vertex m, Vertex n,
                    const PivotRule& rule, Vertex* interchange, Scalar* shift, PivotTally& tally) {
  const Offset lda = block.lda;
  Scalar* a = block.a + first + first * lda;
  for (Vertex j = 0; j < n; ++j) {
    Scalar* column = a + j * lda;
    interchange[j] = pivot_row(j, m, column, rule.preference);
    if (interchange[j] != j) {
      for (Vertex k = 0; k < n; ++k) std::swap(a[j + k * lda], a[interchange[j] + k * lda]);
    }
    accept_pivot(block, first + j, rule, column[j], shift[j], tally);
    divide_column(m - j - 1, column[j], column + j + 1);
    rank_one_update(m - j - 1, n - j - 1, column + j + 1, column + lda + j, column + lda + j + 1, lda);
  }
}

template <class Scalar>
void factor_recursive(const BlockColumns<Scalar>& block, Vertex first, Vertex m, Vertex n,
                      const PivotRule& rule, Vertex* interchange, Scalar* shift, PivotTally& tally) {
  const Vertex base = base_columns(m);
  if (n <= base) {
    factor_columns(block, first, m, n, rule, interchange, shift, tally);
    return;
  }
  const Vertex left = std::max(n / 2 / base, 1) * base, right = n - left;
  const Offset lda = block.lda;
  Scalar* a = block.a + first + first * lda;
  Scalar* top_right = a + left * lda;
  Scalar* bottom_right = top_right + left;
  factor_recursive(block, first, m, left, rule, interchange, shift, tally);
  exchange_rows(right, top_right, lda, interchange, left);
  blas::solve_unit_lower(blas::Transpose::no, left, right, a, lda, top_right, lda);
  blas::gemm_minus(blas::Transpose::no, m - left, right, left, a + left, lda, top_right, lda, bottom_right,
                   lda);
  factor_recursive(block, first + left, m - left, right, rule, interchange + left, shift + left, tally);
  exchange_rows(left, a + left, lda, interchange + left, right);
  for (Vertex k = left; k < n; ++k) interchange[k] += left;
}

}  // namespace

template <class Scalar>
PivotTally factor_panel(const BlockColumns<Scalar>& block, Vertex first, Vertex m, Vertex n,
                        const PivotRule& rule, Vertex* interchange, Scalar* shift) {
  PivotTally tally;
  factor_recursive(block, first, m, n, rule, interchange, shift, tally);
  return tally;
}

template <class Scalar>
void exchange_rows(Vertex columns, Scalar* a, Offset lda, const Vertex* interchange, Vertex count) {
  constexpr Vertex kAtOnce = 128;
  struct Exchange {
    Vertex row, other;
  } exchanges[kAtOnce];
  // Most rows stay where they are: only the others are looked at in each column.
  for (Vertex k = 0; k < count;) {
    Vertex found = 0;
    for (; k < count && found < kAtOnce; ++k) {
      if (interchange[k] != k) exchanges[found++] = {k, interchange[k]};
    }
    if (found == 0) return;
    Scalar* column = a;
    for (Vertex j = 0; j < columns; ++j, column += lda) {
      for (Vertex e = 0; e < found; ++e) std::swap(column[exchanges[e].row], column[exchanges[e].other]);
    }
  }
}

#define MFS_INSTANTIATE(S)                                                                              \
  template PivotTally factor_panel<S>(const BlockColumns<S>&, Vertex, Vertex, Vertex, const PivotRule&, \
                                      Vertex*, S*);                                                     \
  template void exchange_rows<S>(Vertex, S*, Offset, const Vertex*, Vertex);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)

}  // namespace mfs
