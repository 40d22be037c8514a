#include "ordering/scaling.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <cstring>
#include <functional>

#include "ordering/shared_extremes.hpp"

namespace mfs {
namespace {

constexpr int kSmallest = -1020;     // exponents below count as this
constexpr int kLargestScale = 1020;  // no scale leaves 2^-1020 ... 2^1020
constexpr int kSweeps = 12;          // each halves the deviation: 2^11 covers all doubles

template <class Real>
double magnitude(Real value) {
  return std::abs(static_cast<double>(value));
}
template <class Real>
double magnitude(const std::complex<Real>& value) {
  return std::max(magnitude(value.real()), magnitude(value.imag()));
}

/// Read from the bits: std::ilogb is a call for each entry. Denormal numbers end up at the smallest.
Exponent exponent_of(double magnitude) {
  if (magnitude == 0.0) return kZeroEntry;
  std::uint64_t bits;
  std::memcpy(&bits, &magnitude, sizeof bits);
  return static_cast<Exponent>(std::max(static_cast<int>(bits >> 52) - 1023, kSmallest));
}

/// Takes the mean of the scaled exponents of each row out of `own`, and so by columns; returns the largest
/// change.
double subtract_means(const Pattern& pattern, const RawVector<Exponent>& exponents, bool by_rows,
                      const std::vector<double>& other, std::vector<double>& own) {
  std::vector<double> sum(own.size(), 0.0);
  std::vector<Offset> count(own.size(), 0);
  for (Vertex i = 0; i < pattern.n; ++i) {
    for (Offset k = pattern.offsets[i]; k < pattern.offsets[i + 1]; ++k) {
      if (exponents[k] == kZeroEntry) continue;
      const Vertex j = pattern.columns[k], at = by_rows ? i : j;
      sum[at] += exponents[k] + other[by_rows ? j : i];
      ++count[at];
    }
  }
  double most = 0;
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (count[i] == 0) continue;
    const double scale = -sum[i] / static_cast<double>(count[i]);
    most = std::max(most, std::abs(scale - own[i]));
    own[i] = scale;
  }
  return most;
}

/// Moves a scale against half of the excess; tells whether it changed.
bool shift_half(std::int32_t largest, std::int32_t& scale) {
  if (largest == kZeroEntry) return false;
  const std::int32_t before = scale;
  scale = std::clamp(before - largest / 2, -kLargestScale, kLargestScale);
  return scale != before;
}
bool shift_half(const LargestEntries& largest, int threads, PowerScaling& scaling) {
  const auto n = static_cast<Vertex>(scaling.row.size());
  bool changed = false;
#pragma omp parallel for num_threads(threads) schedule(static) reduction(|| : changed)
  for (Vertex i = 0; i < n; ++i) {
    const bool row = shift_half(largest.row[i], scaling.row[i]);
    const bool column = shift_half(largest.column[i], scaling.column[i]);
    changed = changed || row || column;
  }
  return changed;
}

/// Writes over what `largest` has.
void find_largest_entries(const Pattern& pattern, const RawVector<Exponent>& exponents,
                          const PowerScaling& scaling, int threads, LargestEntries& largest) {
#pragma omp parallel num_threads(threads)
  {
#pragma omp for schedule(static)
    for (Vertex j = 0; j < pattern.n; ++j) largest.column[j] = kZeroEntry;
#pragma omp for schedule(static)
    for (Vertex i = 0; i < pattern.n; ++i) {
      std::int32_t row_largest = kZeroEntry;
      for (Offset k = pattern.offsets[i]; k < pattern.offsets[i + 1]; ++k) {
        if (exponents[k] == kZeroEntry) continue;
        const Vertex j = pattern.columns[k];
        const std::int32_t scaled = exponents[k] + scaling.row[i] + scaling.column[j];
        row_largest = std::max(row_largest, scaled);
        improve(largest.column[j], scaled, std::greater<>());
      }
      largest.row[i] = row_largest;
    }
  }
}

}  // namespace

template <class Scalar>
RawVector<Exponent> exponents_of(const Scalar* values, Offset count, int threads) {
  RawVector<Exponent> exponents(static_cast<std::size_t>(count));
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Offset k = 0; k < count; ++k) exponents[k] = exponent_of(magnitude(values[k]));
  return exponents;
}

std::vector<double> powers_of_two(const std::vector<std::int32_t>& exponents, int threads) {
  std::vector<double> scales(exponents.size());
  const auto count = static_cast<Vertex>(exponents.size());
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Vertex i = 0; i < count; ++i) scales[i] = std::ldexp(1.0, exponents[i]);
  return scales;
}

LargestEntries largest_entries(const Pattern& pattern, const RawVector<Exponent>& exponents,
                               const PowerScaling& scaling, int threads) {
  LargestEntries largest;
  largest.row.resize(static_cast<std::size_t>(pattern.n));
  largest.column.resize(static_cast<std::size_t>(pattern.n));
  find_largest_entries(pattern, exponents, scaling, threads, largest);
  return largest;
}

LargestEntries equilibrate(const Pattern& pattern, const RawVector<Exponent>& exponents, int threads,
                           PowerScaling& scaling) {
  LargestEntries largest = largest_entries(pattern, exponents, scaling, threads);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    if (!shift_half(largest, threads, scaling)) break;
    find_largest_entries(pattern, exponents, scaling, threads, largest);
  }
  return largest;
}

void balance(const Pattern& pattern, const RawVector<Exponent>& exponents, PowerScaling& scaling) {
  constexpr int kMost = 50;       // sweeps
  constexpr double kSettled = 1;  // change of an exponent
  std::vector<double> row(scaling.row.begin(), scaling.row.end());
  std::vector<double> column(scaling.column.begin(), scaling.column.end());
  for (int sweep = 0; sweep < kMost; ++sweep) {
    const double rows = subtract_means(pattern, exponents, true, column, row);
    const double columns = subtract_means(pattern, exponents, false, row, column);
    if (rows <= kSettled && columns <= kSettled) break;
  }
  const auto rounded = [](double scale) {
    return static_cast<std::int32_t>(std::lround(std::clamp<double>(scale, -kLargestScale, kLargestScale)));
  };
  std::transform(row.begin(), row.end(), scaling.row.begin(), rounded);
  std::transform(column.begin(), column.end(), scaling.column.begin(), rounded);
  equilibrate(pattern, exponents, 1, scaling);
}

Offset find_slot(const Pattern& pattern, Vertex row, Vertex column) {
  const auto begin = pattern.columns.begin() + pattern.offsets[row];
  const auto end = pattern.columns.begin() + pattern.offsets[row + 1];
  const auto found = std::lower_bound(begin, end, column);
  return found != end && *found == column ? found - pattern.columns.begin() : -1;
}

std::int32_t scaled_exponent(const Pattern& pattern, const RawVector<Exponent>& exponents,
                             const PowerScaling& scaling, Vertex row, Vertex column) {
  const Offset slot = find_slot(pattern, row, column);
  if (slot < 0 || exponents[slot] == kZeroEntry) return kZeroEntry;
  return exponents[slot] + scaling.row[row] + scaling.column[column];
}

template RawVector<Exponent> exponents_of(const float*, Offset, int);
template RawVector<Exponent> exponents_of(const double*, Offset, int);
template RawVector<Exponent> exponents_of(const std::complex<float>*, Offset, int);
template RawVector<Exponent> exponents_of(const std::complex<double>*, Offset, int);

}  // namespace mfs
