// Which unknowns of A x = b may differ from zero, by where A and b have entries alone. With one entry of each
// row matched to one of each column, equation i gives the unknown that it is matched to, and x_j may differ
// from zero where a path of such steps leads to it from an entry of b (Gilbert, Predicting structure in
// sparse matrix computations, SIAM J. Matrix Anal. Appl. 15, 1994). All others are zero whatever the values
// are. Factors of blocks on the diagonal (ordering/diagonal_blocks.hpp) leave them so. Those of the whole
// matrix leave rounding there, in rows that may meet nothing else, where it is an error of 1.
#pragma once

#include <optional>
#include <vector>

#include "ordering/product_matching.hpp"
#include "ordering/transpose.hpp"

namespace mfs {

class SolutionSupport {
 public:
  /// `costs` by slot of A: kNoEdge where the entry is zero, else 0. The pattern stays the caller's.
  SolutionSupport(const Pattern& pattern, RawVector<Cost> costs);

  /// By unknown of A, or of A^T, for b that has entries where `right_side` is true: whether it may differ
  /// from zero. Empty where all may, or the matrix is singular by its pattern. Linear time.
  std::vector<char> of(const std::vector<char>& right_side, bool transposed);

  std::size_t bytes() const;

 private:
  const Pattern& pattern_;
  RawVector<Cost> costs_;
  ProductMatching matching_;
  std::optional<TransposedPattern> columns_;  // made when first needed
};

}  // namespace mfs
