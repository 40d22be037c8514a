// Keeps what an integrator tells.
#pragma once

#include <vector>

#include "dae/integrator/integrator.hpp"

namespace mfs::dae::test {

struct Recorder : Observer {
  std::vector<StepReport> steps;
  std::vector<State> states, outputs;
  void step(const StepReport& report, const std::function<const State&()>& state) override {
    steps.push_back(report);
    states.push_back(state());
  }
  void output(const State& state) override { outputs.push_back(state); }
};

}  // namespace mfs::dae::test
