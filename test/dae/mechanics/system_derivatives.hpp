// Checks that hold for every ConstrainedSystem at any state: its derivatives against central differences, its
// constraints' time derivatives against differences along a motion, the multipliers' forces against Phi_q.
#pragma once

#include "dae/mechanics/constrained_system.hpp"

namespace mfs::test {

/// A state with arrays of its own. Numbers of the order of 1 need no particular scaling.
struct State {
  double t = 0.0;
  std::vector<double> q, v, a, lambda;
  dae::StateView view() const { return {t, q.data(), v.data(), a.data(), lambda.data()}; }
};

/// Expects (GoogleTest) derivatives within `tolerance` times (1 + the largest entry of their block).
void expect_true_derivatives(const dae::ConstrainedSystem& system, const State& state,
                             double tolerance = 1e-7);

}  // namespace mfs::test
