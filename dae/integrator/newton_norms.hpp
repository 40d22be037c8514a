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
  /// Of the work -F_i dq_i that the forces in H before the last correction did in it, as far as it rings
  /// (StepEquations::ringing): the velocity that all the mass gets from it, the same everywhere, as
  /// weighted_rms. Only newton_norms() tells it.
  double vibration = 0.0;
  double followed = 0.0;  ///< largest |F_i| of followed_forces()
};

/// Of H = `h` at `state`. `before` is [q, v, F] before the last correction, or empty, and becomes that of
/// now.
NewtonNorms newton_norms(const Executor& executor, const StepEquations& equations, const double* h,
                         const StepState& state, const Array<double>& weights, Array<double>& before);

}  // namespace mfs::dae
