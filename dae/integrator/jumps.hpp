// What a model does that no step gets past: a constraint or a force that jumps, or is no number.
#pragma once

#include <string>

#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/constrained_system.hpp"

namespace mfs::dae {

/// Says which constraint or force of `state` jumps within `moment` (s) after it, or what is no number then;
/// empty: nothing.
std::string find_jump(const ConstrainedSystem& system, const State& state, double moment,
                      const IntegratorOptions& options);

}  // namespace mfs::dae
