#include <mfs/threads.hpp>

#include <atomic>
#include <cstdlib>
#include <new>
#include <string>

#include <mfs/error.hpp>

#include "kernels/runtime/engine.hpp"
#include "solver/memory_limit.hpp"
#include "solver/node_share.hpp"

namespace mfs {

namespace {

constexpr const char* kVariable = "MFS_NUM_THREADS";

std::atomic<int> chosen_threads{0};

// 0 where the environment says nothing.
int threads_by_environment() {
  const char* text = std::getenv(kVariable);
  if (text == nullptr || *text == '\0') return 0;
  char* end = nullptr;
  const long threads = std::strtol(text, &end, 10);
  if (end == text || *end != '\0' || threads < 0 || threads > kMostThreads)
    throw InvalidInput(kVariable, "must be a number from 1 to " + std::to_string(kMostThreads) +
                                      ", or 0 for what the machine offers, not \"" + text + "\"");
  return static_cast<int>(threads);
}

}  // namespace

void set_default_threads(int threads) {
  if (threads < 0 || threads > kMostThreads)
    throw InvalidInput("threads", "must be from 0 to " + std::to_string(kMostThreads));
  chosen_threads = threads;
}

int default_threads() try {
  if (const int threads = chosen_threads) return threads;
  if (const int threads = threads_by_environment()) return threads;
  return node_share(available_threads());
} catch (const std::bad_alloc&) {
  throw OutOfMemory(MemorySpace::host, 0, available_host_memory());
}

}  // namespace mfs
