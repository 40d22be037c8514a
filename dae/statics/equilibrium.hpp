// Static equilibrium: positions q and multipliers lambda with
//
//   F(t, q, 0, 0, lambda) = 0,   Phi(t, q) = 0,
//
// near given ones, for the time t. Newton's method alone goes to whatever equilibrium is near, also an
// unstable one, and fails where the stiffness is singular, as of a pendulum that is held horizontally. So the
// path is that of a motion that is stopped again and again (pseudo-transient continuation, Kelley and Keyes,
// SIAM J. Numer. Anal. 35, 1998):
//
//   [ F_q + s M   Phi_q^T ] [ dq      ]   [ -F   ]
//   [ Phi_q          0    ] [ dlambda ] = [ -Phi ]
//
// With a large s, dq is a short way along the acceleration that the forces give; as steps succeed s falls to
// next to nothing, and they are Newton's. A step succeeds when it is not too long and goes where the forces
// push; lengths may change by a part of what the whole mechanism measures, as the end of a chain goes as far.
// What happens at its end is not looked at: nodes of a beam that turns leave their arc on straight lines,
// which stretches it a great deal, and bodies that turn leave their joints; the next step mends that. Brought
// back to the constraints alone, without the forces, a chain of 250 links was pushed about by its own
// mending.
//
// What follows from other constraints is left out, as the matrix would be singular. That is looked at anew
// where the search ends without success next to a singular position, as of a linkage that comes to hang
// straight down, and where it has begun in one and what was left out does not hold at its end.
//
// An equilibrium that is reached may be unstable all the same, as a step goes where forces push as a whole.
// So each is examined (instability.hpp). Where a motion grows the search takes a short step along it and goes
// on; one that begins in an unstable equilibrium stays there, and the report tells. Where forces have no
// potential it looks among the slowest modes, too: what swings and grows leads to no other equilibrium.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae {

struct EquilibriumReport {
  int iterations = 0;         ///< steps, rejected ones included
  double last_step = 0.0;     ///< largest change of a coordinate in the last one, in its scale
  double force = 0.0;         ///< largest |F_i| that is left
  bool stopped = false;       ///< on the way, by go_on
  std::vector<double> begin;  ///< q (n) of the first step: as given, corrected to fulfil the constraints
  int escapes = 0;            ///< unstable equilibria that the search has left
  /// 1/time: of what is returned, how fast a small motion grows where nothing damps it (instability.hpp), and
  /// the coordinate that moves most in it; 0 and empty: none has been found.
  double growth = 0.0;
  std::string grows_most;
  /// That motion is a mode, with dampers as they are: forces have no potential.
  bool is_mode = false;
  double swings = 0.0;    ///< 1/time: angular frequency of that mode
  bool as_given = false;  ///< growth > 0, and the given state was in that equilibrium
};

/// `state`: t and q (v is left as it is, a and lambda are not looked at). Returns the equilibrium with v and
/// a zero. Of the options threads and constraint_position are used. `report`: null or overwritten, also where
/// this throws. `go_on` is asked before each step; false ends the search where it is. Throws InvalidInput
/// where constraints cannot be fulfilled, mfs::Error where no equilibrium is found, with the coordinate that
/// moves most, and what mfs::Solver throws.
State find_equilibrium(const ConstrainedSystem& system, const IntegratorOptions& options, State state,
                       EquilibriumReport* report = nullptr, const std::function<bool()>& go_on = {});

}  // namespace mfs::dae
