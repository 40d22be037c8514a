#include "dae/program/recorder.hpp"

#include <memory>
#include <utility>

#include <fmt/format.h>

#include "parts/interrupt.hpp"

namespace mfs::dae {
namespace {

/// Of states that wait to be written.
constexpr std::size_t kMostBytes = std::size_t{512} << 20;
/// Steps are given together, as a thread that sleeps takes longer to wake than small systems to make a step.
constexpr std::size_t kBytesAtOnce = std::size_t{8} << 20;
constexpr double kSecondsAtOnce = 0.2;

std::size_t bytes_of(const State& state) {
  return sizeof(double) * (state.q.size() + state.v.size() + state.a.size() + state.lambda.size());
}

}  // namespace

Recorder::Recorder(ResultFiles& files, double end, program::ProgressDisplay& display)
    : files_(files), end_(end), display_(display), thread_(kMostBytes) {}

void Recorder::step(const StepReport& step, const std::function<const State&()>& state) {
  steps_.push_back({step, files_.along_steps() ? state() : State()});
  bytes_ += sizeof(Step) + bytes_of(steps_.back().state);
  if (bytes_ > kBytesAtOnce || since_given_.seconds() > kSecondsAtOnce) give_steps();
  display_.show(fmt::format("step {:<5}", step.number), step.t / end_);
  program::throw_if_interrupted();
}

void Recorder::output(const State& state) {
  give_steps();
  thread_.give(bytes_of(state), [this, state] { files_.add_output(state); });
}

void Recorder::give_steps() {
  since_given_ = Stopwatch();
  if (steps_.empty()) return;
  const auto steps = std::make_shared<const std::vector<Step>>(std::exchange(steps_, {}));
  thread_.give(std::exchange(bytes_, 0), [this, steps] {
    for (const Step& step : *steps) files_.add_step(step.report, step.state);
  });
}

void Recorder::finish() {
  give_steps();
  thread_.wait();
}

}  // namespace mfs::dae
