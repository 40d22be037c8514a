// Check of the input: the caller's matrix is checked here once, and nowhere else.
//
// What comes in: compressed rows with 32-bit or 64-bit indices, rows sorted or not, entries repeated or not,
// explicit zeros or not. What goes out: a Pattern, sorted and unique, in which every entry of the caller has
// one slot. Nothing is allocated before the numbers that ask for it were seen to be true: memory for the
// pattern is taken only after all offsets and columns were checked.
//
//   caller's entries   0   1   2   3   4   5        row 0: columns 3 1 3     row 1: columns 0 2 1
//   columns            3   1   3 | 0   2   1
//   slot_of_entry      1   0   1   2   4   3
//   slots              0   1 | 2   3   4            row 0: columns 1 3       row 1: columns 0 1 2
#pragma once

#include <cstdint>

#include <mfs/csr_view.hpp>

#include "ordering/types.hpp"

namespace mfs {

/// Checks `matrix` (its values are not read) and returns its pattern. Linear time but for the sorting of
/// unsorted rows; a matrix whose rows are sorted and unique already is only copied. Throws InvalidInput with
/// argument "rows", "columns", "row_offsets" or "column_indices" and the first place.
template <class Scalar>
Pattern check_pattern(const CsrView<Scalar>& matrix, int threads);

/// Throws PatternChanged with the first row that differs unless `matrix` has, entry by entry, the pattern
/// that `pattern` was made from; InvalidInput where an array is missing. Allocates nothing.
template <class Scalar>
void check_same_pattern(const Pattern& pattern, const CsrView<Scalar>& matrix, int threads);

/// Throws InvalidInput("values") with the row and column of the first NaN or infinity, or where there are no
/// values. `matrix` must have passed check_pattern or check_same_pattern. Allocates nothing. `fingerprint`,
/// where it is asked for: a number that other values (bit for bit, in the caller's order) have with a
/// probability of 2^-64, the same for any number of threads.
template <class Scalar>
void check_values(const CsrView<Scalar>& matrix, int threads, std::uint64_t* fingerprint = nullptr);

/// slot_values[pattern.nnz()] = the values of `matrix`, duplicates summed in the caller's order. Allocates
/// nothing. Throws InvalidInput("values") with the first row in which such a sum is no longer finite.
template <class Scalar>
void sum_into_slots(const Pattern& pattern, const CsrView<Scalar>& matrix, Scalar* slot_values, int threads);

}  // namespace mfs
