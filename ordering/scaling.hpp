// Sizes of entries as binary exponents, and scaling by powers of two.
//
// Everything that only asks "how large is this entry beside that one" works on exponents: two bytes per entry
// instead of eight or sixteen, one code for all scalar types, and no overflow at 1e-300 or 1e300.
#pragma once

#include <cstdint>
#include <vector>

#include "ordering/raw_vector.hpp"
#include "ordering/types.hpp"

namespace mfs {

/// e with 2^e <= |a| < 2^(e+1), for complex numbers of the larger part. Not below -1020: a smaller entry
/// counts as that, so that no scale needs to leave the range of doubles.
using Exponent = std::int16_t;
constexpr Exponent kZeroEntry = INT16_MIN;  // of an explicit zero

template <class Scalar>
RawVector<Exponent> exponents_of(const Scalar* values, Offset count, int threads);

/// Row i is multiplied by 2^row[i], column j by 2^column[j].
struct PowerScaling {
  std::vector<std::int32_t> row, column;
  explicit PowerScaling(Vertex n) : row(n, 0), column(n, 0) {}
};

/// 2^exponents[i]
std::vector<double> powers_of_two(const std::vector<std::int32_t>& exponents, int threads);

/// Exponent of the largest scaled entry of each row and column; kZeroEntry where there is no nonzero.
struct LargestEntries {
  RawVector<std::int32_t> row, column;
};
LargestEntries largest_entries(const Pattern& pattern, const RawVector<Exponent>& exponents,
                               const PowerScaling& scaling, int threads);

/// Improves `scaling` until the largest entry of every row and column lies in [1/2, 4), as far as a few
/// sweeps go (Ruiz 2001 in the maximum norm). Rows and columns without a nonzero keep their scale. Returns
/// the largest entries that are reached.
LargestEntries equilibrate(const Pattern& pattern, const RawVector<Exponent>& exponents, int threads,
                           PowerScaling& scaling);

/// Improves `scaling` until the exponents of the entries in each row and in each column are 0 in the mean,
/// least squares (Curtis and Reid 1972), as far as some sweeps go, and equilibrates from there. The largest
/// entries alone leave open how blocks that only small entries link are scaled beside each other; here these
/// entries tell.
void balance(const Pattern& pattern, const RawVector<Exponent>& exponents, PowerScaling& scaling);

/// The slot of entry (row, column); -1 where the pattern has none.
Offset find_slot(const Pattern& pattern, Vertex row, Vertex column);

/// Exponent of the scaled entry (row, column); kZeroEntry where it is zero or not there.
std::int32_t scaled_exponent(const Pattern& pattern, const RawVector<Exponent>& exponents,
                             const PowerScaling& scaling, Vertex row, Vertex column);

}  // namespace mfs
