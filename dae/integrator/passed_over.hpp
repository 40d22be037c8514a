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
  ChangeWatch::Verdict look(const Executor& executor, const StepState& state) {
    if (!watch_) return {};
    return watch_->look(state.t, state.q.on_host(executor).data(), state.v.on_host(executor).data());
  }

 private:
  std::unique_ptr<ChangeWatch> watch_;
};

}  // namespace mfs::dae
