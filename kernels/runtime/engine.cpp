#include "kernels/runtime/engine.hpp"

#include <sched.h>

#include <algorithm>
#include <string>
#include <thread>

#include <mfs/error.hpp>

#include "kernels/runtime/control_groups.hpp"

namespace mfs {

Engine& Engine::instance() {
  static Engine* engine = new Engine;  // never destroyed: its thread may outlive static destructors
  return *engine;
}

#ifdef MFS_CUDA
void Engine::refuse_device(int of_kokkos, int current) {
  throw BackendError("Kokkos", 0,
                     "it was started on device " + std::to_string(of_kokkos) + ", the current one is " +
                         std::to_string(current));
}
#endif

int available_threads() {
  cpu_set_t set;
  CPU_ZERO(&set);
  const int offered = sched_getaffinity(0, sizeof set, &set) == 0
                          ? CPU_COUNT(&set)
                          : static_cast<int>(std::thread::hardware_concurrency());
  const int quota = processor_quota();
  return std::clamp(quota > 0 ? std::min(offered, quota) : offered, 1, kMostThreads);
}

}  // namespace mfs
