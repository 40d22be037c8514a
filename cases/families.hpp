// The benchmark families: matrices of any size, made from nothing but their name, to which every measured
// figure of this project refers. Their numbers never change, to the last bit (test/program keeps checksums).
//
//   elas3d:m      3D linear elasticity, m x m x m nodes of trilinear hexahedra (E = 1, nu = 0.3), 3 unknowns
//                 each; symmetric positive definite
//   beam3d:m      the same on 8m x m x m nodes
//   kkt:m         saddle point of constrained multibody dynamics: elas3d:m with an unsymmetric (gyroscopic)
//                 part and 3m^2 constraints of 12 unknowns each; their diagonal block is explicit zeros
//   convdiff3d:m  convection-diffusion on m x m x m points, 7 points, upwind; unsymmetric values
//   poisson2d:m   Laplacian on m x m points, 5 points
//   circuit:n     n unknowns of a power-law network; unsymmetric pattern, missing diagonals
//
// Each row is made as a list of contributions that is sorted by column and summed. std::sort leaves the order
// of equal columns open, and with it the last bits of the sums; so rows are summed from the same
// contributions in the same order as in the family's definition. In a regular grid all rows of nodes that lie
// alike (inside, on a face, an edge, a corner) are shifted copies of one: it is made once.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace mfs::cases {

/// Compressed rows, zero-based, both triangles, columns sorted and unique.
struct FamilyMatrix {
  std::int64_t n = 0;
  std::vector<std::int64_t> offsets;         ///< n + 1
  std::vector<std::int32_t> column_indices;  ///< offsets[n]
  std::vector<double> values;                ///< offsets[n]
};

/// The names above, in that order.
const std::vector<std::string>& family_names();

/// Throws InvalidInput for an unknown name and for a size below 1 or with more than 2^31 - 1 unknowns.
FamilyMatrix make_family(const std::string& name, std::int64_t size);

}  // namespace mfs::cases
