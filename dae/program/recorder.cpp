#include "dae/program/recorder.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "parts/interrupt.hpp"

namespace mfs::dae {
namespace {

/// Of states that wait to be written.
constexpr std::size_t kMostBytes = std::size_t{512} << 20;
/// That write pictures: more would take processors from the integration for what disks cannot take.
constexpr int kMostThreads = 4;
/// Steps are given together, as a thread that sleeps takes longer to wake than small systems to make a step.
constexpr std::size_t kBytesAtOnce = std::size_t{8} << 20;
constexpr double kSecondsAtOnce = 0.2;

std::size_t bytes_of(const State& state) {
  return sizeof(double) * (state.q.size() + state.v.size() + state.a.size() + state.lambda.size());
}

}  // namespace

Recorder::Recorder(ResultFiles& files, double end, program::ProgressDisplay& display)
    : files_(files),
      display_(display, end),
      end_(end),
      threads_(kMostBytes, std::min(kMostThreads, files.worth_threads())) {}

void Recorder::step(const StepReport& step, const std::function<const State&()>& state) {
  steps_.push_back({step, files_.along_steps() ? state() : State()});
  bytes_ += sizeof(Step) + bytes_of(steps_.back().state);
  if (bytes_ > kBytesAtOnce || since_given_.seconds() > kSecondsAtOnce) give_steps();
  steps_done_ = step.number;
  if (step.h < asked_) ++shorter_;
  display_.tell(steps_done_, step.t);
  program::throw_if_interrupted();
}

void Recorder::ask_for(double fixed_step) {
  constexpr double kMuchShorter = 0.9, kRounding = 1e-6;
  if (fixed_step > 0.0)
    asked_ = kMuchShorter * end_ / std::max(1.0, std::ceil(end_ / fixed_step * (1.0 - kRounding)));
}

std::string Recorder::short_steps_note() const {
  if (shorter_ == 0) return {};
  return fmt::format(
      "{} of {} steps are more than a tenth shorter than the fixed step, as Newton's method did not converge "
      "with longer ones",
      shorter_, steps_done_);
}

void Recorder::output(const State& state) {
  // Of one step there may be millions.
  display_.tell(steps_done_, state.t);
  program::throw_if_interrupted();
  give_steps();
  if (!std::exchange(has_looked_, true))
    files_.look_at(state, state);  // here, while nobody evaluates the system
  // Beside the state, what is drawn of it.
  const std::size_t bytes = 3 * bytes_of(state);
  const auto kept = std::make_shared<const State>(state);
  const auto pictures = std::make_shared<std::function<void()>>();
  threads_.give(
      bytes, [this, kept, pictures] { *pictures = files_.add_output(kept); }, [pictures] { (*pictures)(); });
}

void Recorder::give_steps() {
  since_given_ = Stopwatch();
  if (steps_.empty()) return;
  const auto steps = std::make_shared<const std::vector<Step>>(std::exchange(steps_, {}));
  threads_.give(std::exchange(bytes_, 0), [this, steps] {
    for (const Step& step : *steps) files_.add_step(step.report, step.state);
  });
}

void Recorder::finish() {
  give_steps();
  threads_.wait();
}

}  // namespace mfs::dae
