// Phases of the solver: work that runs in the engine while the progress callback is told where the work is.
// Its errors come out as classes of mfs/error.hpp. The log goes through here, too.
#pragma once

#include <atomic>
#include <exception>
#include <functional>
#include <string>

#include <mfs/options.hpp>

namespace mfs {

class Phases {
 public:
  /// `options` must outlive this.
  Phases(const Options& options, int threads, int analysis_threads)
      : options_(options), threads_(threads), analysis_threads_(analysis_threads) {}

  int threads() const { return threads_; }
  int analysis_threads() const { return analysis_threads_; }

  /// Runs `work` with all threads. Throws what it throws, OutOfMemory for std::bad_alloc.
  template <class Work>
  void run(const char* phase, Work&& work) {
    run_in_engine(phase, threads_, std::ref(work));  // a reference: nothing is allocated
  }
  /// The same with the threads of the analysis.
  template <class Work>
  void run_analysis(const char* phase, Work&& work) {
    run_in_engine(phase, analysis_threads_, std::ref(work));
  }

  /// Where the running phase is; from any thread.
  void tell(const char* phase, double fraction);

  bool logs(int level) const { return options_.log && options_.verbosity >= level; }
  void log(int level, const std::string& line) {
    if (logs(level)) call_back([&] { options_.log(line); });
  }

 private:
  void run_in_engine(const char* phase, int threads, const std::function<void()>& work);
  void report_progress() {
    call_back([this] { options_.progress(Progress{phase_, fraction_}); });
  }
  /// What the caller's function throws is the caller's, whatever its type.
  template <class Call>
  void call_back(const Call& call) {
    try {
      call();
    } catch (...) {
      thrown_by_caller_ = std::current_exception();
      throw;
    }
  }

  const Options& options_;
  int threads_, analysis_threads_;
  // Written by the thread that works, told to the caller's callback by another.
  std::atomic<const char*> phase_{nullptr};
  std::atomic<double> fraction_{0};
  std::exception_ptr thrown_by_caller_;
};

}  // namespace mfs
