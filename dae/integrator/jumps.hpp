// What a model does that no step gets past: a constraint or a force that jumps, or is no number.
#pragma once

#include <string>

#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae {

/// Says which constraint or force of `state` jumps within `moment` (s) after it, is too fast to be followed
/// (find_too_fast), or what is no number then; empty: nothing. `time_unit`: what times are multiplied by for
/// a message.
std::string find_jump(const ConstrainedSystem& system, const State& state, double moment,
                      const IntegratorOptions& options, double time_unit);
/// Where nothing jumps in time and accelerations are out of all bounds: which force changes where the motion
/// leads within `moment`, or is the largest; empty: accelerations are not. Positions that are nearly singular
/// make them large as well.
std::string find_pole(const ConstrainedSystem& system, const State& state, double moment,
                      const IntegratorOptions& options);

/// What is fastest in `state`, and how fast: the motion that prescribes the largest rate, or, without any, a
/// coordinate.
std::string find_fastest(const ConstrainedSystem& system, const State& state, double time_unit);
/// The same of a motion that goes on, while time is rounded, by more than its constraint may be left, as
/// exp(1000 t) of a slide; empty: there is none.
std::string find_too_fast(const ConstrainedSystem& system, double t, const std::vector<double>& q,
                          const IntegratorOptions& options, double time_unit);

/// The coordinate whose velocity is farthest from what was predicted, in the weights of [q, v].
std::string least_foreseen(const ConstrainedSystem& system, const std::vector<double>& v,
                           const std::vector<double>& predicted, const std::vector<double>& weights);

}  // namespace mfs::dae
