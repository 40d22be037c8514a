// Matrices as programs of engineers make them whose pivots are small because the matrix is: hundreds of them,
// so that the exact correction of perturbed pivots (accuracy/correction.hpp) does not reach them all.
#pragma once

#include "test/adversarial/hard_matrices.hpp"
#include "test/reference/random.hpp"

namespace mfs::test {

/// Shells with turned node blocks, nearly incompressible solids, curl-curl, mixed Darcy flow with contrast,
/// interior point methods, penalties, gradings beyond 1e+-150, Oseen flow, lattices of rigid bodies with
/// multipliers, multiple shooting; singular ones among curl-curl and lattices.
HardMatrix engineering_matrix(std::uint64_t seed);

/// The name with which multiple shooting begins: no factorization with exchanges of rows does there.
constexpr char kGrowing[] = "multiple shooting";

/// The Laplacian of side^2 points, and side^2 / 4 constraints between three of them as penalties.
SparseMatrix penalties(std::int64_t side, double penalty, Random& random);

/// C^T C + mass I for the curl C from the edges of a grid of side^3 cubes to their faces, all of them. As
/// many pivots as there are nodes are of the size of the mass, but one; without a mass it is singular.
SparseMatrix curl_curl(std::int64_t side, double mass);

}  // namespace mfs::test
