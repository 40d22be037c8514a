// Where Kokkos runs. With its private Kokkos (private_engine.cpp), MFS owns one thread that initializes
// Kokkos and starts all of its kernels: Kokkos 3.4's OpenMP accepts only the thread that initialized it,
// while callers come from any thread, with any OpenMP settings of their own, which then stay as they are. A
// call hands its work over and waits. With the program's Kokkos (shared_engine.cpp) the program starts and
// ends it, and the calling thread starts the kernels. What Kokkos and OpenMP leave a process made by fork is
// of no use: there the engine refuses to run.
#pragma once

#include <sys/types.h>

#include <functional>

namespace mfs {

class Engine {
 public:
  /// The engine of this process; started by the first call, alive until the process ends.
  static Engine& instance();

  /// Runs `work` with `threads` OpenMP threads (a shared Kokkos: with as many as it has) and returns when it
  /// is done; what it throws is thrown here. Calls from several threads wait for each other. Meanwhile `idle`
  /// (if any) is called about ten times per second, in the calling thread unless that is at work (a shared
  /// Kokkos); what it throws is thrown here once `work` is done. Throws StateError in a process that was
  /// forked from the engine's, or where a shared Kokkos takes no calls, std::system_error where the system
  /// refuses threads.
  void run(int threads, const std::function<void()>& work, const std::function<void()>& idle = {});

#ifdef MFS_CUDA
  /// Inside run: starts Kokkos' CUDA space on the current device, unless it has been. Throws BackendError
  /// where a shared one was started on another device.
  static void use_cuda();
#endif

  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

 private:
  Engine();
  ~Engine() = default;
  /// Throws StateError in a process other than `process`.
  static void check_process(pid_t process);
  struct State;
  State* state_;  // lives as long as the engine's thread: as long as the process
};

/// Kokkos' OpenMP space has room for no more.
constexpr int kMostThreads = 512;

/// Processors that this process may use, by its affinity mask and the quota of its control groups; at most
/// kMostThreads.
int available_threads();

}  // namespace mfs
