// ChangeWatch for states in an executor's memory.
#pragma once

#include <memory>

#include "dae/integrator/step_state.hpp"
#include "dae/mechanics/change_watch.hpp"

namespace mfs::dae {

class PassedOver {
 public:
  PassedOver() = default;
  explicit PassedOver(std::unique_ptr<ChangeWatch> watch) : watch_(std::move(watch)) {}

  void go_on(const Executor& executor, const StepState& state) {
    if (watch_) watch_->go_on(state.t, state.q.on_host(executor).data(), state.v.on_host(executor).data());
  }
  /// After a step of this order. Where a run begins with order 1 nothing is known yet of how far rates
  /// change, beside which what such a step leaves of them could be seen to be little.
  ChangeWatch::Verdict look(const Executor& executor, const StepState& state, int order) {
    if (!watch_) return {};
    tells_rates_ = tells_rates_ || order > 1;
    return watch_->look(state.t, state.q.on_host(executor).data(), state.v.on_host(executor).data(),
                        tells_rates_);
  }

 private:
  std::unique_ptr<ChangeWatch> watch_;
  bool tells_rates_ = false;  // a step was of an order whose positions do
};

}  // namespace mfs::dae
