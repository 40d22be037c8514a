// The integrator's observer: gives steps and outputs to threads that write them beside the integration
// (result_files.hpp), shows how far the run is, and ends it where the user wants that.
#pragma once

#include <string>
#include <vector>

#include "dae/integrator/integrator.hpp"
#include "dae/output/output_threads.hpp"
#include "dae/program/result_files.hpp"
#include "dae/program/run_progress.hpp"
#include "ordering/stopwatch.hpp"

namespace mfs::dae {

class Recorder final : public Observer {
 public:
  /// `files` and `display` have to live as long. `end`: of the run, s.
  Recorder(ResultFiles& files, double end, program::ProgressDisplay& display);

  /// Both throw what writing an earlier one threw, and program::Interrupted.
  void step(const StepReport& step, const std::function<const State&()>& state) override;
  void output(const State& state) override;

  /// Waits until all is written. Throws what writing threw.
  void finish();
  /// A fixed step that is asked for; steps that are shorter are counted, less what makes them meet the end.
  void ask_for(double fixed_step);
  /// What to know of them; empty: nothing.
  std::string short_steps_note() const;
  double time_busy() const { return threads_.time_busy(); }      ///< s that writing took
  double time_waited() const { return threads_.time_waited(); }  ///< s that the integration waited for it

 private:
  struct Step {
    StepReport report;
    State state;
  };
  void give_steps();

  ResultFiles& files_;
  RunDisplay display_;
  const double end_;
  double asked_ = 0.0;  // s
  std::int64_t steps_done_ = 0, shorter_ = 0;
  bool has_looked_ = false;  // at the first output
  std::vector<Step> steps_;  // not yet given
  std::size_t bytes_ = 0;    // of their states
  Stopwatch since_given_;
  OutputThreads threads_;
};

}  // namespace mfs::dae
