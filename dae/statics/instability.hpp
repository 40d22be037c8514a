// Whether an equilibrium is unstable. Where forces have a potential, a motion x that constraints allow and
// along which the stiffness is negative proves it:
//
//   x^T K x < 0,   Phi_q x = 0,        K = F_q, which has the change of the multipliers' forces in it.
//
// The motion is looked for in Krylov spaces of the response to inertia (spectral transformation, Ericsson and
// Ruhe, Math. Comp. 35, 1980; Nour-Omid, Parlett, Ericsson and Jensen, Math. Comp. 48, 1987),
//
//   (K + s M) z + Phi_q^T mu = M x,   Phi_q z = 0,        M = F_a,
//
// in which each kappa of K x = kappa M x counts by 1 / (s + kappa). One space of 40 vectors shows a negative
// kappa that is between a hundredth and a thousand times of s in size. So s falls from what the stiffest part
// has, by ten thousands, until the space shows the smallest kappa of all; free motions, whose kappa is 0,
// take three factorizations. Where several motions grow, the one that is returned need not be the fastest.
//
// Where forces have no potential, as those that follow a body, or dampers feed a motion, one may grow
// although K is positive: two rods under a follower flutter (Ziegler, Ingenieur-Archiv 20, 1952). In the last
// of these spaces K is not symmetric then, or x^T D x negative, D = F_v. Only modes (modes.hpp) tell more.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "dae/mechanics/constrained_system.hpp"
#include "dae/statics/constrained_matrix.hpp"

namespace mfs::dae {

struct UnstableMotion {
  std::vector<double> x;  ///< n; x^T M x = 1
  double rate;            ///< sqrt(-kappa), 1/time: it grows by exp(rate t) where nothing damps it
};

struct Stability {
  std::optional<UnstableMotion> growing;  ///< none: nothing has been found
  bool may_swing = false;                 ///< nothing has been found, and forces have no potential
  double rounding = 0.0;                  ///< 1/time^2: the kappa of a motion that may be free
};

/// An equilibrium. The lengths of coordinates have to be of about 1 there (scaled_system.hpp).
struct RestingSystem {
  const ConstrainedSystem& system;   ///< with independent constraints
  const Tangent& tangent;            ///< has force_a, force_v, force_q and position_q
  const std::vector<double>& force;  ///< n: what is left of F
  double rounding;                   ///< 1/time^2: a kappa of this size is 0
};

/// `matrix`: of the system; it is left with other factors. `go_on` is asked before each factorization; false
/// ends the search with nothing. Finds a motion that grows, or nothing. Where K
/// is not symmetric, as of forces that follow a body, the sign of x^T K x proves nothing; then only an
/// eigenvector is returned. Nothing is found where a constraint is on velocities. Matrices that are singular
/// are passed over; other errors are those of mfs::Solver.
Stability examine_rest(const RestingSystem& rest, ConstrainedMatrix& matrix,
                       const std::function<bool()>& go_on = {});

}  // namespace mfs::dae
