// How a formula's relations and the constraints share the coordinates of a step.
//
// Both say how v and q go on; the constraints must hold, so the formula is asked for along the directions
// that they leave free: U^T (v_by_a (a - a0) - (v - v0)) = 0 with U^T B = 0, or, with an unknown for each
// constraint,
//
//   v = v0 + v_by_a (a - a0) + B kappa,        q = q0 + q_by_v (v - v0) + B mu.
//
// B is where the local error of the formula is given to the constraints. It has to change as smoothly as the
// motion does: with single coordinates as columns, which had to be chosen anew in the course of a motion, the
// differences of BDF met a jump at each choice (docs/experiments/integrator-rotation.md). So a column of B is
//
//   Phi_q^T of the constraint at the prediction: the error is removed by the least change of coordinates
//           (Fuhrer and Leimkuhler 1991; Eich 1993), or
//   e_i     where coordinate i is in this constraint alone and its entry of Phi_q never changes, as that of a
//           node that is tied to a frame: kappa, mu and the relations of i are left out. With Phi_q^T all
//           nodes of a frame would be coupled with each other.
//
// A constraint on velocities takes nothing of q: its mu is zero.
#pragma once

#include <vector>

#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae {

/// By what v and q of a coordinate are determined.
enum class Role : char {
  free,    ///< by the formula alone
  tied,    ///< by a constraint of its own
  shared,  ///< by both
};

struct Projection {
  std::vector<Role> role;  ///< n
  std::vector<int>
      tied_entry;           ///< m: of each constraint, the entry of Phi_q of the coordinate tied to it, or -1
  std::vector<int> rows;    ///< the constraints with columns Phi_q^T, ascending
  Pattern directions;       ///< n x rows.size(): entries of these columns, in rows of shared coordinates
  std::vector<int> source;  ///< the entry of Phi_q for each of them
};

/// Of no constraint: all coordinates are free.
Projection no_projection(int coordinates);

/// Looks at Phi_q at `q` and at a state that is as good as random, at a time up to `t_end`.
Projection find_projection(const ConstrainedSystem& system, double t, const std::vector<double>& q,
                           double t_end);

}  // namespace mfs::dae
