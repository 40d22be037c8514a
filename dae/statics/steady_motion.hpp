// Modes about a state that moves, and whether they are any. M, D and K of turning_axes.hpp are made for axes
// in which they may stay what they are. Whether they do is seen a little later: with T what the axes do until
// then,
//
//   y_j^T T^T (s^2 M + s D + K) T y_k  and  Phi_q T y_k       are what they were, of all modes s, y
//
// (or (s A + B) T y_k of constraints on velocities) where the motion is steady. Axes are tried by turns:
// those that turn along where all turns as one body, those of the ground, those that precess. A rotor on
// springs that are stiffer across than up and down has its modes in the ground's axes, though all of it turns
// as one body; in its own the springs turn.
#pragma once

#include <functional>
#include <vector>

#include "dae/statics/modes.hpp"
#include "dae/statics/turning_axes.hpp"

namespace mfs::dae {

struct ModesInMotion {
  std::vector<Mode> modes;
  TurningAxes axes;
  /// Whether matrices are constant in these axes. Else modes are those of this moment.
  bool steady = false;
};

/// Of the motion from the state on, at a later time.
using Later = std::function<State(double t)>;

/// As find_modes(), about `state`, which has accelerations.
ModesInMotion find_modes_in_motion(const ConstrainedSystem& system, const State& state, const Later& later,
                                   int count, int threads, Damping damping = Damping::as_it_is,
                                   const std::function<bool()>& go_on = {},
                                   Backend backend = Backend::openmp);

}  // namespace mfs::dae
