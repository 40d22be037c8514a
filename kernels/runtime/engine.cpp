#include "kernels/runtime/engine.hpp"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <thread>

#include <mfs/error.hpp>

namespace mfs {

Engine& Engine::instance() {
  static Engine* engine = new Engine;  // never destroyed: its thread may outlive static destructors
  return *engine;
}

void Engine::check_process(pid_t process) {
  if (getpid() != process)
    throw StateError(
        "this process was forked from one that had used the solver before: use it in one of them");
}

int available_threads() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) != 0)
    return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, kMostThreads);
  return std::min(CPU_COUNT(&set), kMostThreads);
}

}  // namespace mfs
