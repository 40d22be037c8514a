// What Newton's method looks at after each correction, in one pass.
#pragma once

#include <array>

#include "dae/integrator/step_equations.hpp"
#include "dae/integrator/step_state.hpp"

namespace mfs::dae {

struct NewtonNorms {
  double residual = 0.0;              ///< largest |H_i|; infinite where one is not a number
  std::array<double, 3> violation{};  ///< the same of the constraints, by level
  double correction = 0.0;            ///< of [q, v], as weighted_rms
};

/// Of H = `h` at `state`. `y` is [q, v] before the last correction, or empty, and becomes that of now.
NewtonNorms newton_norms(const Executor& executor, const StepEquations& equations, const double* h,
                         const StepState& state, const Array<double>& weights, Array<double>& y);

}  // namespace mfs::dae
