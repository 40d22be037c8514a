// The program's own judgement of a solution: plain loops over the matrix that was read, apart from anything
// the solver computes.
#pragma once

#include <vector>

#include "solver/program/matrix_market.hpp"

namespace mfs::program {

/// Componentwise backward error of column `j` of x as solution of A x = b (A^T x = b with `transpose`):
/// max_i |b - A x|_i / (|A| |x| + |b|)_i, 0/0 = 0 (Oettli and Prager, Numer. Math. 6, 1964). Of a
/// residual 4.9e-324 (1 + 8 |a_ij|) is free for each entry of the row: unknowns have no digits below that,
/// and the solver's products are rounded. Sums are taken in long double, absolute values are moduli (for
/// complex numbers too). Infinite if x is not finite.
template <class Scalar>
double backward_error(const io::CsrMatrix<Scalar>& a, bool transpose, const io::DenseMatrix<Scalar>& x,
                      const io::DenseMatrix<Scalar>& b, std::int64_t j);

/// The worst over all columns.
template <class Scalar>
double backward_error(const io::CsrMatrix<Scalar>& a, bool transpose, const io::DenseMatrix<Scalar>& x,
                      const io::DenseMatrix<Scalar>& b);

}  // namespace mfs::program
