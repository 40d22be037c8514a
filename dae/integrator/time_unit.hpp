// The unit of time that a run is integrated in, and an equilibrium is searched in.
//
// Errors of velocities are allowed to be atol_velocity, and constraints may leave as much of their rates,
// in units of length over the unit of time. That is of use where velocities are ordinary numbers: in
// microseconds 1e-4 allows 100 m/s, in hours no rounding is that small. So where the model moves by less
// than 1/4 or more than 1024 units of length in one of time, time has another unit: four times what it
// takes to move by one in the mean. (In seconds nearly all machines are within. With sixteen errors were 1
// to 3 times those in s instead of 1 to 7, but four_bars_40 in hours, at one tolerance, came to a flat
// position that it did not pass.) How fast a model moves is told by its kinetic energy, by the
// accelerations that forces give it from rest, and by what motions prescribe, where time begins and, if
// that is slow, at some times until its end.
#pragma once

#include <vector>

#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae {

/// For a run from `start`, whose accelerations and multipliers do not matter, to `t_end`: a power of two, in
/// the system's own unit.
double time_unit(const ConstrainedSystem& system, const State& start, double t_end);

/// The same of a system that is at rest in `q` (n) at `t`, by its forces there alone.
double time_unit_at_rest(const ConstrainedSystem& system, double t, const std::vector<double>& q);

/// How fast these forces would move all masses alike, 1/time: the root of an acceleration in scales of
/// coordinates, as it is, no power of two; 0: there are no forces.
double rate_at_rest(const ConstrainedSystem& system, double t, const std::vector<double>& q);

}  // namespace mfs::dae
