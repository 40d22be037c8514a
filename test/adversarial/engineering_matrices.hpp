// Matrices as programs of engineers make them whose pivots are small because the matrix is: hundreds of them,
// so that the exact correction of perturbed pivots (accuracy/correction.hpp) does not reach them all.
#pragma once

#include "test/adversarial/hard_matrices.hpp"

namespace mfs::test {

/// Shells with turned node blocks, nearly incompressible solids, curl-curl, mixed Darcy flow with contrast,
/// interior point methods, penalties, gradings beyond 1e+-150, Oseen flow, lattices of rigid bodies with
/// multipliers; singular ones among curl-curl and lattices.
HardMatrix engineering_matrix(std::uint64_t seed);

}  // namespace mfs::test
