// What a model does that no step gets past: a constraint or a force that jumps, or is no number.
#pragma once

#include <string>

#include "dae/integrator/integrator.hpp"
#include "dae/integrator/redundancy.hpp"
#include "dae/integrator/step_watch.hpp"
#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae {

/// Says which constraint or force of `state` jumps within `moment` (s) after it, is too fast to be followed
/// (find_too_fast), or what is no number then; empty: nothing. `time_unit`: what times are multiplied by for
/// a message.
std::string find_jump(const ConstrainedSystem& system, const State& state, double moment,
                      const IntegratorOptions& options, double time_unit);
/// Whether any force or constraint of `state` changes within `moment` (s) by more than what is smooth does.
bool jumps_within(const ConstrainedSystem& system, const State& state, double moment);
/// Where nothing jumps in time and accelerations are out of all bounds: which force changes where the motion
/// leads within `moment`, or is the largest; empty: accelerations are not. Positions that are nearly singular
/// make them large as well.
std::string find_pole(const ConstrainedSystem& system, const State& state, double moment,
                      const IntegratorOptions& options);

/// The motion that goes on, while time is rounded, by more than its constraint may be left, as
/// exp(1000 t) of a slide; empty: there is none.
std::string find_too_fast(const ConstrainedSystem& system, double t, const std::vector<double>& q,
                          const IntegratorOptions& options, double time_unit);

/// What the model does that no step gets past, with names, "; ..."; empty: none of this. `redundant`: as
/// Redundancy::dead_point.
std::string find_obstacle(const ConstrainedSystem& system, const State& state, double moment,
                          const IntegratorOptions& options, const Redundancy& redundancy,
                          const std::vector<std::string>& redundant, double time_unit);

/// Says why steps stay short until `state`. `predicted`: its velocities; `weights`: of [q, v].
std::string find_what_keeps_steps_short(const ConstrainedSystem& system, const State& state,
                                        StepWatch::Verdict verdict, const std::vector<double>& predicted,
                                        const std::vector<double>& weights, double time_unit);

}  // namespace mfs::dae
