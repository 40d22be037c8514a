// The state of a step, in an executor's memory.
#pragma once

#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/constrained_system.hpp"
#include "dae/vectors/executor.hpp"

namespace mfs::dae {

struct StepState {
  double t = 0.0;
  Array<double> q, v, a, lambda;
};

inline StateView view(const StepState& state) {
  return {state.t, state.q.data(), state.v.data(), state.a.data(), state.lambda.data()};
}
inline void assign(const Executor& executor, const State& from, StepState& to) {
  to.t = from.t;
  to.q.assign(executor, from.q);
  to.v.assign(executor, from.v);
  to.a.assign(executor, from.a);
  to.lambda.assign(executor, from.lambda);
}
inline State on_host(const Executor& executor, const StepState& state) {
  return {state.t, state.q.on_host(executor), state.v.on_host(executor), state.a.on_host(executor),
          state.lambda.on_host(executor)};
}

}  // namespace mfs::dae
