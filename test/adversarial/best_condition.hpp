// How close a small matrix is to singular, whatever its scaling: the reciprocal of the least condition number
// in the maximum norm that scaling of rows and columns can give it (Bauer 1963):
//
//   min over D1, D2 of cond(D1 A D2)  =  spectral radius of P,    P = |A^-1| |A|
//
// For any x > 0 the scaling D2 = diag(x), D1 = diag(1 / (|A| x)) has the condition number max_i (P x)_i /
// x_i; power iteration makes it small. In quadruple precision (34 digits, exponents to 4932), by plain loops.
#pragma once

#include <vector>

#include "test/reference/sparse.hpp"

namespace mfs::test {

struct BestCondition {
  /// Reciprocal condition number of the best scaling found; 0 for a singular matrix.
  double reciprocal = 0;
  /// False where no inverse could be found, or the one found is not proved to be one.
  bool proved = false;
  /// Double precision has no range for it: not for the scaling, or not for the products of entries with the
  /// solution of A x = b, so that nobody can tell there that x is a solution.
  bool beyond_range = false;
};

BestCondition best_condition(const SparseMatrix& a, const std::vector<double>& b);

}  // namespace mfs::test
