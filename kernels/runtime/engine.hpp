// Where work runs. With its private Kokkos (private_engine.cpp) MFS owns teams of threads, as many as calls
// have been at work at the same time: a call is admitted when as many processors as it has threads are left
// by the others, takes a team, hands its work over and waits (kernels/runtime/team.hpp). Work of one thread
// needs none of that and runs in the thread that calls. One team, started when it is first needed, is that of
// Kokkos: 3.4's OpenMP accepts only the thread that initialized it, so calls that start kernels of Kokkos are
// served one after another. With the program's Kokkos (shared_engine.cpp) the program starts and ends it, the
// calling thread starts the kernels, and all calls wait for each other.
//
// A process made by fork has the engine's memory, but none of its threads. With its private Kokkos it begins
// with new teams there, unless calls were at work at the time, which may have held locks of the BLAS or of
// OpenMP. Kokkos does not outlive a fork: once it has been started, and with the program's Kokkos, the engine
// refuses to run there.
#pragma once

#include <functional>

namespace mfs {

/// Whether work starts kernels of Kokkos.
enum class Needs { threads, kokkos };

class Engine {
 public:
  /// The engine of this process; started by the first call, alive until the process ends.
  static Engine& instance();

  /// Runs `work` with `threads` OpenMP threads (a shared Kokkos: with as many as it has) and returns when it
  /// is done; what it throws is thrown here. Meanwhile `idle` (if any) is called about ten times per second,
  /// in the calling thread unless that is at work (a shared Kokkos); what it throws is thrown here once
  /// `work` is done. Waits for calls of other threads that leave too few processors. Work that calls this for
  /// other work, which needs no Kokkos, has it done in its own thread. Throws StateError in a forked process
  /// where that is of no use, or where a shared Kokkos takes no calls, std::system_error where the system
  /// refuses threads.
  void run(int threads, const std::function<void()>& work, const std::function<void()>& idle = {},
           Needs needs = Needs::kokkos);

  /// Runs work of one thread that starts no kernels of Kokkos in the thread that calls, whose settings of
  /// OpenMP and of floating point are put back at its end. Waits for nobody (a shared Kokkos: as run). Throws
  /// StateError as run.
  void run_here(const std::function<void()>& work);

  /// Whether the calling thread is at work for some call.
  static bool at_work();

#ifdef MFS_CUDA
  /// Inside run: starts Kokkos' CUDA space, unless it has been, on the device that is current in the calling
  /// thread.
  static void use_cuda();
  /// Throws BackendError where that space was started on another device than is current in this thread.
  static void check_device();
#endif

  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

 private:
  Engine();
  ~Engine() = default;
#ifdef MFS_CUDA
  [[noreturn]] static void refuse_device(int of_kokkos, int current);
#endif
  struct State;
  State* state_;  // lives as long as the engine's threads: as long as the process
};

/// Whether several threads may have factors of one thread each at work at the same time.
#ifdef MFS_SHARED_KOKKOS
constexpr bool kManyAtWork = false;  // Kokkos' Serial has one scratch memory for a process
#else
constexpr bool kManyAtWork = true;
#endif

/// Kokkos' OpenMP space has room for no more.
constexpr int kMostThreads = 512;

/// Processors that this process may use, by its affinity mask and the quota of its control groups; at most
/// kMostThreads.
int available_threads();

}  // namespace mfs
