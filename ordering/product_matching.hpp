// The matching of rows to columns that maximises the product of the matched entries: shortest augmenting
// paths with dual variables (Duff and Koster 2001; the assignment method of Jonker and Volgenant 1987 on
// sparse rows).
//
// With costs c_ij = -log2 |a_ij| the largest product is the least sum of costs. Duals u (rows) and v
// (columns) keep
//   c_ij >= u_i + v_j,     with equality where row i is matched to column j,
// which proves the matching optimal and is a scaling as well: |a_ij| 2^(u_i + v_j) is 1 for matched entries
// and at most 1 for all others.
//
// Costs are integers (steps of 2^-20), so equal products are equal, ties do not hang on rounding, and a
// symmetric matrix stays symmetric. Among equals the diagonal is taken. (The usual code, HSL's MC64, is not
// free; Debian's SuperLU comes without it.)
#pragma once

#include <cstdint>
#include <vector>

#include "ordering/scaling.hpp"
#include "ordering/types.hpp"

namespace mfs {

/// Cost of an entry in steps of 2^-20 of a binary exponent; kNoEdge for an entry that must not be matched.
using Cost = std::int32_t;
constexpr Cost kCostOfTwo = 1 << 20;
constexpr Cost kNoEdge = INT32_MAX;

/// -log2 of the scaled entries, by slot; 0 for all of them where only the pattern is known (`values` null).
template <class Scalar>
RawVector<Cost> matching_costs(const Pattern& pattern, const Scalar* values,
                               const RawVector<Exponent>& exponents, const PowerScaling& scaling,
                               int threads);

struct ProductMatching {
  std::vector<Vertex> row_of_column;              // n: -1 where the column is unmatched
  std::vector<Vertex> column_of_row;              // n
  RawVector<std::int64_t> row_dual, column_dual;  // n each, in steps of cost
  Vertex unmatched = 0;                           // rows, and as many columns; 0: a full matching
};

/// `costs` [pattern.nnz()], by slot. Where no full matching exists the result is a largest one (its duals
/// mean nothing then). The same for any number of threads. Time: nearly linear for most matrices; n times the
/// entries at worst.
ProductMatching maximum_product_matching(const Pattern& pattern, const RawVector<Cost>& costs, int threads);

}  // namespace mfs
