// A sparse matrix for tests, and what is asked of a solution, by plain loops over its entries. Shares no code
// with the solver: sums are taken in long double and ratios are formed so that nothing overflows.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>
#include <vector>

#include <mfs/csr_view.hpp>

namespace mfs::test {

template <class Scalar>
struct BasicEntry {
  std::int64_t row, column;
  Scalar value;
};
using Entry = BasicEntry<double>;

/// Compressed rows, zero-based.
template <class Scalar>
struct BasicSparseMatrix {
  std::int64_t n = 0;
  std::vector<std::int64_t> offsets;  // n + 1
  std::vector<std::int32_t> columns;
  std::vector<Scalar> values;

  CsrView<Scalar> view() const { return {n, n, offsets.data(), columns.data(), values.data()}; }
  std::int64_t entries() const { return static_cast<std::int64_t>(values.size()); }
};
using SparseMatrix = BasicSparseMatrix<double>;

/// long double, or complex of it.
template <class Scalar>
struct WideOf {
  using Type = long double;
};
template <class Real>
struct WideOf<std::complex<Real>> {
  using Type = std::complex<long double>;
};
template <class Scalar>
using Wide = typename WideOf<Scalar>::Type;

/// The entries in the order given within each row; equal places are kept side by side, not summed.
template <class Scalar = double>
BasicSparseMatrix<Scalar> from_entries(std::int64_t n, const std::vector<BasicEntry<Scalar>>& entries) {
  BasicSparseMatrix<Scalar> a;
  a.n = n;
  a.offsets.assign(static_cast<std::size_t>(n) + 1, 0);
  for (const BasicEntry<Scalar>& e : entries) ++a.offsets[e.row + 1];
  for (std::int64_t i = 0; i < n; ++i) a.offsets[i + 1] += a.offsets[i];
  a.columns.resize(entries.size());
  a.values.resize(entries.size());
  std::vector<std::int64_t> next(a.offsets.begin(), a.offsets.end() - 1);
  for (const BasicEntry<Scalar>& e : entries) {
    const std::int64_t k = next[e.row]++;
    a.columns[k] = static_cast<std::int32_t>(e.column);
    a.values[k] = e.value;
  }
  return a;
}

/// Rows sorted by column, equal places summed.
template <class Scalar = double>
BasicSparseMatrix<Scalar> from_entries_summed(std::int64_t n, std::vector<BasicEntry<Scalar>> entries) {
  using Item = BasicEntry<Scalar>;
  std::stable_sort(entries.begin(), entries.end(), [](const Item& a, const Item& b) {
    return a.row != b.row ? a.row < b.row : a.column < b.column;
  });
  std::vector<Item> unique;
  for (const Item& e : entries) {
    if (!unique.empty() && unique.back().row == e.row && unique.back().column == e.column) {
      unique.back().value += e.value;
    } else {
      unique.push_back(e);
    }
  }
  return from_entries(n, unique);
}

template <class Scalar>
std::vector<BasicEntry<Scalar>> entries_of(const BasicSparseMatrix<Scalar>& a) {
  std::vector<BasicEntry<Scalar>> entries;
  for (std::int64_t i = 0; i < a.n; ++i) {
    for (std::int64_t k = a.offsets[i]; k < a.offsets[i + 1]; ++k)
      entries.push_back({i, a.columns[k], a.values[k]});
  }
  return entries;
}

template <class Scalar>
BasicSparseMatrix<Scalar> transposed(const BasicSparseMatrix<Scalar>& a) {
  std::vector<BasicEntry<Scalar>> entries = entries_of(a);
  for (BasicEntry<Scalar>& e : entries) std::swap(e.row, e.column);
  return from_entries(a.n, entries);
}

/// A x
template <class Scalar>
std::vector<Scalar> multiply(const BasicSparseMatrix<Scalar>& a, const std::vector<Scalar>& x) {
  std::vector<Scalar> b(static_cast<std::size_t>(a.n));
  for (std::int64_t i = 0; i < a.n; ++i) {
    Wide<Scalar> sum = 0;
    for (std::int64_t k = a.offsets[i]; k < a.offsets[i + 1]; ++k) {
      sum += Wide<Scalar>(a.values[k]) * Wide<Scalar>(x[a.columns[k]]);
    }
    b[i] = static_cast<Scalar>(sum);
  }
  return b;
}

/// max_i |b - A x|_i / ((|A| |x| + |b|)_i + floor), 0/0 taken as 0, anything that is not a number as
/// infinity.
template <class Scalar>
double backward_error(const BasicSparseMatrix<Scalar>& a, const Scalar* b, const Scalar* x,
                      double floor = 0) {
  double worst = 0;
  for (std::int64_t i = 0; i < a.n; ++i) {
    Wide<Scalar> residual = b[i];
    long double size = std::abs(residual) + floor;
    for (std::int64_t k = a.offsets[i]; k < a.offsets[i + 1]; ++k) {
      const Wide<Scalar> product = Wide<Scalar>(a.values[k]) * Wide<Scalar>(x[a.columns[k]]);
      residual -= product;
      size += std::abs(product);
    }
    const long double ratio = residual == Wide<Scalar>(0) ? 0 : std::abs(residual) / size;
    if (!(ratio <= worst))
      worst = std::isnan(ratio) ? std::numeric_limits<double>::infinity() : static_cast<double>(ratio);
  }
  return worst;
}
template <class Scalar>
double backward_error(const BasicSparseMatrix<Scalar>& a, const std::vector<Scalar>& b,
                      const std::vector<Scalar>& x) {
  return backward_error(a, b.data(), x.data());
}

}  // namespace mfs::test
