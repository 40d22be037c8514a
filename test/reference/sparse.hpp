// A sparse matrix for tests, and what is asked of a solution, by plain loops over its entries. Shares no code
// with the solver: sums are taken in long double and ratios are formed so that nothing overflows.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <mfs/csr_view.hpp>

namespace mfs::test {

struct Entry {
  std::int64_t row, column;
  double value;
};

/// Compressed rows, zero-based.
struct SparseMatrix {
  std::int64_t n = 0;
  std::vector<std::int64_t> offsets;  // n + 1
  std::vector<std::int32_t> columns;
  std::vector<double> values;

  CsrView<double> view() const { return {n, n, offsets.data(), columns.data(), values.data()}; }
  std::int64_t entries() const { return static_cast<std::int64_t>(values.size()); }
};

/// The entries in the order given within each row; equal places are kept side by side, not summed.
inline SparseMatrix from_entries(std::int64_t n, const std::vector<Entry>& entries) {
  SparseMatrix a;
  a.n = n;
  a.offsets.assign(static_cast<std::size_t>(n) + 1, 0);
  for (const Entry& e : entries) ++a.offsets[e.row + 1];
  for (std::int64_t i = 0; i < n; ++i) a.offsets[i + 1] += a.offsets[i];
  a.columns.resize(entries.size());
  a.values.resize(entries.size());
  std::vector<std::int64_t> next(a.offsets.begin(), a.offsets.end() - 1);
  for (const Entry& e : entries) {
    const std::int64_t k = next[e.row]++;
    a.columns[k] = static_cast<std::int32_t>(e.column);
    a.values[k] = e.value;
  }
  return a;
}

/// Rows sorted by column, equal places summed.
inline SparseMatrix from_entries_summed(std::int64_t n, std::vector<Entry> entries) {
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.row != b.row ? a.row < b.row : a.column < b.column;
  });
  std::vector<Entry> unique;
  for (const Entry& e : entries) {
    if (!unique.empty() && unique.back().row == e.row && unique.back().column == e.column) {
      unique.back().value += e.value;
    } else {
      unique.push_back(e);
    }
  }
  return from_entries(n, unique);
}

inline std::vector<Entry> entries_of(const SparseMatrix& a) {
  std::vector<Entry> entries;
  for (std::int64_t i = 0; i < a.n; ++i) {
    for (std::int64_t k = a.offsets[i]; k < a.offsets[i + 1]; ++k)
      entries.push_back({i, a.columns[k], a.values[k]});
  }
  return entries;
}

inline SparseMatrix transposed(const SparseMatrix& a) {
  std::vector<Entry> entries = entries_of(a);
  for (Entry& e : entries) std::swap(e.row, e.column);
  return from_entries(a.n, entries);
}

/// A x
inline std::vector<double> multiply(const SparseMatrix& a, const std::vector<double>& x) {
  std::vector<double> b(static_cast<std::size_t>(a.n));
  for (std::int64_t i = 0; i < a.n; ++i) {
    long double sum = 0;
    for (std::int64_t k = a.offsets[i]; k < a.offsets[i + 1]; ++k) {
      sum += static_cast<long double>(a.values[k]) * x[a.columns[k]];
    }
    b[i] = static_cast<double>(sum);
  }
  return b;
}

/// max_i |b - A x|_i / (|A| |x| + |b|)_i, 0/0 taken as 0, anything that is not a number as infinity.
inline double backward_error(const SparseMatrix& a, const double* b, const double* x) {
  double worst = 0;
  for (std::int64_t i = 0; i < a.n; ++i) {
    long double residual = b[i], size = std::fabs(static_cast<long double>(b[i]));
    for (std::int64_t k = a.offsets[i]; k < a.offsets[i + 1]; ++k) {
      const long double product = static_cast<long double>(a.values[k]) * x[a.columns[k]];
      residual -= product;
      size += std::fabs(product);
    }
    const long double ratio = residual == 0 ? 0 : std::fabs(residual) / size;
    if (!(ratio <= worst))
      worst = std::isnan(ratio) ? std::numeric_limits<double>::infinity() : static_cast<double>(ratio);
  }
  return worst;
}
inline double backward_error(const SparseMatrix& a, const std::vector<double>& b,
                             const std::vector<double>& x) {
  return backward_error(a, b.data(), x.data());
}

}  // namespace mfs::test
