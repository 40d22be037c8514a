#include "ordering/matrix_check.hpp"

#include <algorithm>
#include <complex>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include <mfs/error.hpp>

#include "ordering/first_error.hpp"
#include "ordering/mixed_bits.hpp"
#include "ordering/number_parts.hpp"

namespace mfs {
namespace {

constexpr Offset kNone = std::numeric_limits<Offset>::max();

/// Calls `body` with the span's array in its own width, so that inner loops carry no branch.
template <class Body>
auto with_index(const IndexSpan& span, Body&& body) {
  return span.wide() ? body(static_cast<const std::int64_t*>(span.data()))
                     : body(static_cast<const std::int32_t*>(span.data()));
}

template <class Scalar>
Vertex check_shape(const CsrView<Scalar>& matrix) {
  if (matrix.rows < 0) throw InvalidInput("rows", "negative");
  if (matrix.columns < 0) throw InvalidInput("columns", "negative");
  if (matrix.rows != matrix.columns) {
    throw InvalidInput("columns", "the matrix is not square: " + std::to_string(matrix.rows) + " rows, " +
                                      std::to_string(matrix.columns) + " columns");
  }
  if (matrix.rows == 0) throw InvalidInput("rows", "the matrix is empty");
  if (matrix.rows > std::numeric_limits<Vertex>::max() - 1) throw InvalidInput("rows", "more than 2^31 - 2");
  return static_cast<Vertex>(matrix.rows);
}

template <class Scalar>
void check_arrays(const CsrView<Scalar>& matrix) {
  if (matrix.row_offsets.data() == nullptr) throw InvalidInput("row_offsets", "null pointer");
  if (matrix.column_indices.data() == nullptr && matrix.row_offsets[matrix.rows] > 0) {
    throw InvalidInput("column_indices", "null pointer");
  }
}

template <class Index>
void check_offsets(Vertex n, const Index* offsets) {
  if (offsets[0] != 0) throw InvalidInput("row_offsets", "the first offset is not 0", 0);
  for (Vertex i = 0; i < n; ++i) {
    if (offsets[i + 1] < offsets[i]) {
      throw InvalidInput("row_offsets", "offsets decrease (an overflow of 32 bits looks like this)", i);
    }
  }
}

/// The first row with a column outside [0, n) (kNone: there is none), and whether all rows ascend strictly.
struct RowScan {
  Offset bad_row = kNone;
  bool strictly_ascending = true;
};

template <class OffsetInt, class ColumnInt>
RowScan scan_rows(Vertex n, const OffsetInt* offsets, const ColumnInt* columns, int threads) {
  Offset bad_row = kNone;
  bool ascending = true;
#pragma omp parallel for num_threads(threads) schedule(static) reduction(min : bad_row) reduction(&& : ascending)
  for (Vertex i = 0; i < n; ++i) {
    bool outside = false, sorted = true;
    ColumnInt last = -1;
    for (OffsetInt k = offsets[i]; k < offsets[i + 1]; ++k) {
      const ColumnInt j = columns[k];
      outside |= j < 0 || j >= n;
      sorted &= j > last;
      last = j;
    }
    if (outside) bad_row = std::min<Offset>(bad_row, i);
    ascending = ascending && sorted;
  }
  return {bad_row, ascending};
}

template <class OffsetInt, class ColumnInt>
[[noreturn]] void throw_bad_column(Vertex n, const OffsetInt* offsets, const ColumnInt* columns, Offset row) {
  OffsetInt k = offsets[row];
  while (columns[k] >= 0 && columns[k] < n) ++k;
  throw InvalidInput("column_indices", "outside of the matrix (of order " + std::to_string(n) + ")", row,
                     columns[k]);
}

template <class OffsetInt, class ColumnInt>
void copy_pattern(const OffsetInt* offsets, const ColumnInt* columns, Pattern& pattern, int threads) {
  pattern.offsets.assign(offsets, offsets + pattern.n + 1);
  const Offset entries = offsets[pattern.n];
  pattern.columns.resize(static_cast<std::size_t>(entries));
#pragma omp parallel for num_threads(threads) schedule(static)
  for (Offset k = 0; k < entries; ++k) pattern.columns[k] = static_cast<Vertex>(columns[k]);
}

/// Sorts each row by (column, entry) and gives equal columns one slot, counted within the row for now.
/// Returns the number of slots of each row, shifted by one for the sum that follows.
template <class OffsetInt, class ColumnInt>
std::vector<Offset> sort_rows(const OffsetInt* offsets, const ColumnInt* columns, Pattern& pattern,
                              int threads) {
  const Vertex n = pattern.n;
  std::vector<Offset> slots(static_cast<std::size_t>(n) + 1, 0);
  FirstError error;
#pragma omp parallel num_threads(threads)
  {
    std::vector<std::pair<Vertex, Offset>> row;
#pragma omp for schedule(dynamic, 256)
    for (Vertex i = 0; i < n; ++i) {
      error.attempt([&] {
        row.clear();
        for (Offset k = offsets[i]; k < offsets[i + 1]; ++k)
          row.emplace_back(static_cast<Vertex>(columns[k]), k);
        std::sort(row.begin(), row.end());
        Offset last = -1;
        for (std::size_t r = 0; r < row.size(); ++r) {
          if (r == 0 || row[r].first != row[r - 1].first) pattern.columns[offsets[i] + ++last] = row[r].first;
          pattern.slot_of_entry[row[r].second] = last;
        }
        slots[i + 1] = last + 1;
      });
    }
  }
  error.rethrow();
  return slots;
}

/// Sorts the rows and closes the gaps that duplicates leave.
template <class OffsetInt, class ColumnInt>
void sort_pattern(const OffsetInt* offsets, const ColumnInt* columns, Pattern& pattern, int threads) {
  const Vertex n = pattern.n;
  pattern.columns.resize(static_cast<std::size_t>(offsets[n]));
  pattern.slot_of_entry.resize(static_cast<std::size_t>(offsets[n]));
  pattern.offsets = sort_rows(offsets, columns, pattern, threads);
  for (Vertex i = 0; i < n; ++i) {
    const Offset begin = pattern.offsets[i], slots = pattern.offsets[i + 1];
    std::copy_n(pattern.columns.begin() + offsets[i], slots, pattern.columns.begin() + begin);
    for (Offset k = offsets[i]; k < offsets[i + 1]; ++k) pattern.slot_of_entry[k] += begin;
    pattern.offsets[i + 1] = begin + slots;
  }
  pattern.columns.resize(static_cast<std::size_t>(pattern.nnz()));
}

/// Whether rows [first, last) have the entries that `pattern` was made from (sorted and unique then).
template <class OffsetInt, class ColumnInt>
bool same_rows(const Pattern& pattern, const OffsetInt* offsets, const ColumnInt* columns, Offset first,
               Offset last) {
  bool same = true;
  for (Offset i = first; i <= last; ++i) same &= offsets[i] == pattern.offsets[i];
  if (!same) return false;
  for (Offset k = pattern.offsets[first]; k < pattern.offsets[last]; ++k)
    same &= columns[k] == pattern.columns[k];
  return same;
}

/// First row that has changed; kNone for none.
template <class OffsetInt, class ColumnInt>
Offset first_changed_row(const Pattern& pattern, const OffsetInt* offsets, const ColumnInt* columns,
                         int threads) {
  constexpr Offset kBlock = 1024;
  const Offset n = pattern.n, blocks = (n + kBlock - 1) / kBlock;
  Offset changed = kNone;
#pragma omp parallel for num_threads(threads) schedule(static) reduction(min : changed)
  for (Offset block = 0; block < blocks; ++block) {
    const Offset first = block * kBlock, last = std::min(first + kBlock, n);
    if (same_rows(pattern, offsets, columns, first, last)) continue;
    Offset row = first;
    while (same_rows(pattern, offsets, columns, row, row + 1)) ++row;
    changed = std::min(changed, row);
  }
  return changed;
}

/// The same where entries were sorted or summed: entry k must still lie in its row and in the column of its
/// slot.
template <class OffsetInt, class ColumnInt>
Offset first_changed_row_by_slot(const Pattern& pattern, const OffsetInt* offsets, const ColumnInt* columns,
                                 int threads) {
  Offset changed = kNone;
#pragma omp parallel for num_threads(threads) schedule(static) reduction(min : changed)
  for (Vertex i = 0; i < pattern.n; ++i) {
    const Offset begin = offsets[i], end = offsets[i + 1];
    bool same = begin >= 0 && begin <= end && end <= pattern.num_entries;
    // Every entry of row i must have a slot of row i. With equal totals this also fixes where rows begin.
    for (Offset k = begin; same && k < end; ++k) {
      const Offset slot = pattern.slot_of_entry[k];
      same =
          slot >= pattern.offsets[i] && slot < pattern.offsets[i + 1] && columns[k] == pattern.columns[slot];
    }
    // An entry of row i that slid into another row: the entries just outside must not have slots of row i.
    if (same && begin > 0) same = pattern.slot_of_entry[begin - 1] < pattern.offsets[i];
    if (same && end < pattern.num_entries) same = pattern.slot_of_entry[end] >= pattern.offsets[i + 1];
    if (!same) changed = std::min<Offset>(changed, i);
  }
  return changed;
}

/// True where every number of values[0, count) is finite. x - x is 0 for finite x and NaN otherwise; the sum
/// over a block keeps a NaN, and the loop runs at memory speed.
template <class Real>
bool all_finite(const Real* values, Offset count) {
  Real sum = 0;
#pragma omp simd reduction(+ : sum)
  for (Offset k = 0; k < count; ++k) sum += values[k] - values[k];
  return sum == 0;
}

/// Of numbers that are the first-th ones and the following.
template <class Real>
std::uint64_t fingerprint_of(const Real* values, Offset count, Offset first) {
  constexpr std::uint64_t kStep = 0xd1342543de82ef95u;  // odd
  std::uint64_t sum = 0;
  for (Offset k = 0; k < count; ++k) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, values + k, sizeof(Real));
    sum += mixed(bits + static_cast<std::uint64_t>(first + k) * kStep);
  }
  return sum;
}

}  // namespace

template <class Scalar>
Pattern check_pattern(const CsrView<Scalar>& matrix, int threads) {
  Pattern pattern;
  pattern.n = check_shape(matrix);
  check_arrays(matrix);
  with_index(matrix.row_offsets, [&](const auto* offsets) {
    check_offsets(pattern.n, offsets);
    pattern.num_entries = offsets[pattern.n];
    with_index(matrix.column_indices, [&](const auto* columns) {
      const RowScan scan = scan_rows(pattern.n, offsets, columns, threads);
      if (scan.bad_row != kNone) throw_bad_column(pattern.n, offsets, columns, scan.bad_row);
      if (scan.strictly_ascending) {
        copy_pattern(offsets, columns, pattern, threads);
      } else {
        sort_pattern(offsets, columns, pattern, threads);
      }
    });
  });
  return pattern;
}

template <class Scalar>
void check_same_pattern(const Pattern& pattern, const CsrView<Scalar>& matrix, int threads) {
  if (matrix.rows != pattern.n || matrix.columns != pattern.n) {
    throw PatternChanged("the matrix is " + std::to_string(matrix.rows) + " x " +
                             std::to_string(matrix.columns) + ", the analysed one has order " +
                             std::to_string(pattern.n),
                         std::max<std::int64_t>(0, std::min<std::int64_t>(matrix.rows, pattern.n)));
  }
  if (matrix.row_offsets.data() == nullptr) throw InvalidInput("row_offsets", "null pointer");
  if (matrix.column_indices.data() == nullptr && pattern.num_entries > 0) {
    throw InvalidInput("column_indices", "null pointer");
  }
  const Offset row = with_index(matrix.row_offsets, [&](const auto* offsets) {
    return with_index(matrix.column_indices, [&](const auto* columns) {
      return pattern.slot_of_entry.empty() ? first_changed_row(pattern, offsets, columns, threads)
                                           : first_changed_row_by_slot(pattern, offsets, columns, threads);
    });
  });
  if (row != kNone) throw PatternChanged("its entries are not those that were analysed, in the same order", row);
}

template <class Scalar>
void check_values(const CsrView<Scalar>& matrix, int threads, std::uint64_t* fingerprint) {
  const Offset entries = matrix.row_offsets[matrix.rows];
  if (fingerprint) *fingerprint = 0;
  if (entries == 0) return;
  if (matrix.values == nullptr) throw InvalidInput("values", "null pointer");
  using Real = typename NumberParts<Scalar>::type;
  constexpr Offset block = 4096, parts = NumberParts<Scalar>::count;
  const auto* numbers = reinterpret_cast<const Real*>(matrix.values);
  Offset bad = kNone;
  std::uint64_t sum = 0;
#pragma omp parallel for num_threads(threads) schedule(static) reduction(min : bad) reduction(+ : sum)
  for (Offset begin = 0; begin < entries; begin += block) {
    const Offset count = std::min(block, entries - begin);
    if (fingerprint) sum += fingerprint_of(numbers + parts * begin, parts * count, parts * begin);
    if (all_finite(numbers + parts * begin, parts * count)) continue;
    for (Offset k = begin; k < begin + count; ++k) {
      if (!all_finite(numbers + parts * k, parts)) {
        bad = std::min(bad, k);
        break;
      }
    }
  }
  if (fingerprint) *fingerprint = sum;
  if (bad == kNone) return;
  std::int64_t low = 0, high = matrix.rows;  // the row of entry `bad`: offsets[low] <= bad < offsets[high]
  while (high - low > 1) {
    const std::int64_t middle = low + (high - low) / 2;
    (matrix.row_offsets[middle] <= bad ? low : high) = middle;
  }
  throw InvalidInput("values", "not a finite number", low, matrix.column_indices[bad]);
}

template <class Scalar>
void sum_into_slots(const Pattern& pattern, const CsrView<Scalar>& matrix, Scalar* slot_values, int threads) {
  if (pattern.slot_of_entry.empty()) {
    const Offset entries = pattern.num_entries;
#pragma omp parallel for num_threads(threads) schedule(static)
    for (Offset k = 0; k < entries; ++k) slot_values[k] = matrix.values[k];
    return;
  }
  using Real = typename NumberParts<Scalar>::type;
  constexpr Offset parts = NumberParts<Scalar>::count;
  Offset overflowed = kNone;
#pragma omp parallel for num_threads(threads) schedule(static) reduction(min : overflowed)
  for (Vertex i = 0; i < pattern.n; ++i) {
    const Offset begin = pattern.offsets[i], slots = pattern.offsets[i + 1] - begin;
    std::fill_n(slot_values + begin, slots, Scalar(0));
    for (Offset k = matrix.row_offsets[i]; k < matrix.row_offsets[i + 1]; ++k) {
      slot_values[pattern.slot_of_entry[k]] += matrix.values[k];
    }
    if (!all_finite(reinterpret_cast<const Real*>(slot_values + begin), parts * slots)) {
      overflowed = std::min<Offset>(overflowed, i);
    }
  }
  if (overflowed != kNone) throw InvalidInput("values", "the sum of repeated entries overflows", overflowed);
}

#define MFS_INSTANTIATE(Scalar)                                                  \
  template Pattern check_pattern(const CsrView<Scalar>&, int);                   \
  template void check_same_pattern(const Pattern&, const CsrView<Scalar>&, int); \
  template void check_values(const CsrView<Scalar>&, int, std::uint64_t*);       \
  template void sum_into_slots(const Pattern&, const CsrView<Scalar>&, Scalar*, int);
MFS_INSTANTIATE(float)
MFS_INSTANTIATE(double)
MFS_INSTANTIATE(std::complex<float>)
MFS_INSTANTIATE(std::complex<double>)
#undef MFS_INSTANTIATE

}  // namespace mfs
