// The systems that mfs_distributed solves, assembled in parallel: each rank computes the elements that touch
// its own nodes, so that no matrix entry has to be sent.
//
// A body of nx * ny * nz nodes, trilinear hexahedra, clamped at x = 0, with weight; the ranks own bricks of
// nodes:
//
//        +-------+-------+
//        | rank 2| rank 3|      z
//        +-------+-------+      |
//        | rank 0| rank 1|      +-- y
//        +-------+-------+
//
// elasticity   3 unknowns per node, displacements; Poisson's ratio 0.3
// stokes       4 unknowns per node, velocity and pressure of an incompressible medium: a saddle point. Equal
//              order is stabilised by the part of the pressure that is not constant in an element (Dohrmann,
//              Bochev, Int. J. Numer. Meth. Fluids 46, 2004)
#pragma once

#include <array>
#include <functional>
#include <string>

#include "types.hpp"

namespace distributed {

/// One vector per column, all of them on the rows' map but the coordinates.
struct Problem {
  std::string name;
  int unknowns_per_node = 1;
  RCP<Matrix> a;
  RCP<Vector> b;
  RCP<Vector> coordinates;  ///< three columns, one row per node; null where nothing is known
  RCP<Vector> null_space;   ///< of the operator without supports; null where nothing is known
  /// Fills `a` with the values of a step, on the same pattern. Step 0 is what the problem was made with.
  std::function<void(int step)> set_values;
};

using Counts = std::array<GlobalOrdinal, 3>;  ///< in x, y, z

/// Ranks in x, y, z: as near to a cube as possible, the most in z.
Counts divide_ranks(int ranks);

/// Throws std::invalid_argument where a direction has fewer nodes than ranks, or fewer than 2.
Problem elasticity(const RCP<const Comm>& comm, const Counts& nodes);
Problem stokes(const RCP<const Comm>& comm, const Counts& nodes);

/// A square Matrix Market file, its rows in equal pieces; the right-hand side is all ones. Step k multiplies
/// the diagonal by 1 + k / 10. Throws std::runtime_error for a file that cannot be read.
Problem from_file(const RCP<const Comm>& comm, const std::string& path);

}  // namespace distributed
