// The state of a step, in an executor's memory.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "dae/integrator/integrator.hpp"
#include "dae/mechanics/constrained_system.hpp"
#include "dae/vectors/executor.hpp"
#include "dae/vectors/host_loops.hpp"

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

/// on_host() for one state after another: from a device by staging memory, into vectors that are used again.
/// New ones would take several times as long as the copies.
class HostStates {
 public:
  State take(const Executor& executor, const StepState& state, State used) {
    if (!executor.on_device()) return on_host(executor, state);
    const std::pair<const Array<double>*, std::vector<double>*> parts[] = {
        {&state.q, &used.q}, {&state.v, &used.v}, {&state.a, &used.a}, {&state.lambda, &used.lambda}};
    std::size_t size = 0;
    for (const auto& [from, to] : parts) size += from->size();
    if (size > size_) staging_ = executor.allocate_staging(size * sizeof(double));
    size_ = std::max(size, size_);
    auto* staged = static_cast<double*>(staging_.get());
    for (const auto& [from, to] : parts) {
      executor.begin_to_host(staged, from->data(), from->size() * sizeof(double));
      staged += from->size();
    }
    executor.synchronize();
    // One loop for all: each may have to wait for threads that others keep from their processors.
    for (const auto& [from, to] : parts) to->resize(from->size());
    const auto* const numbers = static_cast<const double*>(staging_.get());
    parallel_for_parts(size, executor.threads(), [&](std::size_t begin, std::size_t end) {
      std::size_t first = 0;
      for (const auto& [from, to] : parts) {
        const std::size_t here = std::clamp(begin, first, first + to->size());
        const std::size_t last = std::clamp(end, first, first + to->size());
        std::copy(numbers + here, numbers + last, to->begin() + static_cast<std::ptrdiff_t>(here - first));
        first += to->size();
      }
    });
    used.t = state.t;
    return used;
  }

 private:
  std::shared_ptr<void> staging_;
  std::size_t size_ = 0;  // numbers that it has room for
};

}  // namespace mfs::dae
