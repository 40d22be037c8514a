// Phases of the solver: work that runs in the engine while the progress callback is told where the work is.
// Work of one thread runs in the thread that calls, unless there is such a callback. Its errors come out as
// classes of mfs/error.hpp. The log goes through here, too.
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
  Phases(const Options& options, int threads, int analysis_threads, bool uses_kokkos)
      : options_(options),
        threads_(threads),
        analysis_threads_(analysis_threads),
        uses_kokkos_(uses_kokkos),
        one_thread_(threads == 1 && !uses_kokkos) {}

  /// Of factors that are worth them.
  int threads() const { return threads_; }
  int analysis_threads() const { return analysis_threads_; }
  /// Of the work that run() is given.
  int threads_at_work() const { return one_thread_ ? 1 : threads_; }
  /// Says that the work of the factors is for one thread, or not any more.
  void work_with_one_thread(bool one) { one_thread_ = !uses_kokkos_ && (one || threads_ == 1); }

  /// Runs `work` with threads_at_work(). Throws what it throws, OutOfMemory for std::bad_alloc.
  template <class Work>
  void run(const char* phase, Work&& work) {
    run_threads(phase, threads_at_work(), work);
  }
  /// The same with the threads of the analysis. It has a stack of the usual size, as the caller may not.
  template <class Work>
  void run_analysis(const char* phase, Work&& work) {
    run_in_engine(phase, analysis_threads_, std::ref(work));
  }

  /// The same with so many threads, whatever the factors are worth.
  template <class Work>
  void run_threads(const char* phase, int threads, Work&& work) {
    // References: nothing is allocated.
    if (threads == 1 && !uses_kokkos_ && !options_.progress) {
      run_here(phase, std::ref(work));
    } else {
      run_in_engine(phase, threads, std::ref(work));
    }
  }

  /// Where the running phase is; from any thread.
  void tell(const char* phase, double fraction);

  bool logs(int level) const { return options_.log && options_.verbosity >= level; }
  void log(int level, const std::string& line) {
    if (logs(level)) call_back([&] { options_.log(line); });
  }

 private:
  void run_here(const char* phase, const std::function<void()>& work);
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
  const int threads_, analysis_threads_;
  const bool uses_kokkos_;
  bool one_thread_;
  // Written by the thread that works, told to the caller's callback by another.
  std::atomic<const char*> phase_{nullptr};
  std::atomic<double> fraction_{0};
  std::exception_ptr thrown_by_caller_;
};

}  // namespace mfs
