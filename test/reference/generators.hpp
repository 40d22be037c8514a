// Matrices for tests: plain families, and adversarial ones that a seed makes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "test/reference/random.hpp"
#include "test/reference/sparse.hpp"

namespace mfs::test {

/// Convection-diffusion on rows x columns points: symmetric pattern, unsymmetric values.
SparseMatrix grid_2d(std::int64_t rows, std::int64_t columns);
/// The same on points x points x points.
SparseMatrix grid_3d(std::int64_t points);
SparseMatrix tridiagonal(std::int64_t n);
/// A diagonal, and `width` full last rows and columns.
SparseMatrix arrow(std::int64_t n, std::int64_t width);
/// One irreducible block for each of `sizes`, entries between each and blocks before it, rows and columns in
/// random orders. Each row has an entry as
/// large as all others together.
SparseMatrix permuted_blocks(const std::vector<std::int64_t>& sizes, std::uint64_t seed);
/// Unsymmetric pattern with about `per_row` entries beside the dominant diagonal.
SparseMatrix random_diagonally_dominant(std::int64_t n, std::int64_t per_row, std::uint64_t seed);
/// Of resistors in a tree, each node with one to a node shortly before it, and earthed by a large one: a
/// dominant diagonal. Conductances go over six orders of magnitude.
SparseMatrix resistors(std::int64_t nodes, std::uint64_t seed);
/// Chains of unknowns without a boundary, so each all but singular: `spring` or so is added to its diagonal.
/// 1e-8 is nothing to factors of single precision, and one pivot of each chain gets perturbed. Springs of
/// 1e-7 they still see, too coarsely for two steps of refinement. Chains that are alike are cured together.
SparseMatrix floating_chains(std::int64_t chains, std::int64_t length, bool alike, double spring = 1e-8);
/// `a`, and `count` pairs of unknowns beside it, the second of which the first leaves with a pivot of zero.
SparseMatrix with_cancelling_pivots(const SparseMatrix& a, std::int64_t count);
/// Rows and columns in one random order.
SparseMatrix renumbered(const SparseMatrix& a, Random& random);
/// Of adversarial_matrices(seed), below, that of the family.
SparseMatrix adversarial_matrix(const std::string& family, std::uint64_t seed);

/// One matrix of a family. Where rows and columns are graded, a solution must be as well, or some of its
/// entries cannot be seen in b: sizes that suit A x = b and A^T x = b (empty: 1).
struct NamedMatrix {
  std::string name;  // family and seed
  SparseMatrix matrix;
  std::vector<double> solution_sizes = {}, transposed_solution_sizes = {};
};

/// Regular matrices of every awkward kind: zero diagonals, saddle points, badly graded, explicit zeros, block
/// triangular, arrows, dense rows, disconnected, permuted identities, one unknown. All are solvable to full
/// accuracy by a direct method with partial pivoting.
std::vector<NamedMatrix> adversarial_matrices(std::uint64_t seed);

}  // namespace mfs::test
