#include "kernels/runtime/team.hpp"

#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <new>
#include <thread>
#include <utility>
#include <vector>

#include "kernels/runtime/engine.hpp"

namespace mfs {

namespace {

thread_local int threads_here = 0;  // 0: not at work

// Kokkos and OpenMP's library take some KiB for each thread when they start, and some hundred for all. LLVM's
// lets threads allocate while it still creates others, with stacks of sizes that none of those that were
// asked for has: so it needs the 64 MiB of address space that the C library may take for each of them once
// more.
#if defined(KMP_VERSION_MAJOR)
constexpr std::size_t kThreadMemory = std::size_t{65} << 20;
#else
constexpr std::size_t kThreadMemory = 1 << 20;
#endif

// OpenMP's library ends the process where the system refuses it a thread, and so does Kokkos where its
// threads find no memory. So threads and memory are asked for here first, all at once, and a refusal is
// thrown. The C library gives a thread that allocates 64 MiB of address space, which outlive it: so each
// allocates while the stacks of all are there, as else the last of them could take the place that the first
// ones' stacks have left.
void ask_for_threads(int count) {
  std::mutex mutex;
  std::condition_variable changed;
  int there = -1, settled = 0;  // -1: not all yet
  bool memory_refused = false;
  const auto settle = [&] {
    std::unique_lock<std::mutex> lock(mutex);
    changed.wait(lock, [&] { return there >= 0; });
    void* const volatile taken = std::malloc(kThreadMemory);
    if (!taken) memory_refused = true;
    if (++settled == there + 1) changed.notify_all();
    changed.wait(lock, [&] { return settled == there + 1; });  // with that of the caller
    std::free(taken);
  };
  std::vector<std::thread> granted;
  std::exception_ptr refusal;
  try {
    for (int k = 0; k < count; ++k) granted.emplace_back(settle);
  } catch (...) {
    refusal = std::current_exception();
  }
  {
    const std::lock_guard<std::mutex> lock(mutex);
    there = static_cast<int>(granted.size());
  }
  changed.notify_all();
  settle();
  for (std::thread& thread : granted) thread.join();
  if (refusal) std::rethrow_exception(refusal);
  if (memory_refused) throw std::bad_alloc();
}

}  // namespace

int team_threads() {
  return std::max(threads_here, 1);
}
bool Engine::at_work() {
  return threads_here > 0;
}
TeamScope::TeamScope(int threads) : before_(std::exchange(threads_here, threads)) {}
TeamScope::~TeamScope() {
  threads_here = before_;
}

Team* Team::start(Prepare prepare, bool beside_device) {
  std::unique_ptr<Team> team(new Team(prepare, beside_device));
  std::thread([team = team.get()] { team->serve(); }).detach();
  return team.release();
}

void Team::have_threads(int threads) {
  if (granted_ == threads) return;
  granted_ = 0;
  ask_for_threads(threads - 1);
  granted_ = threads;
}

// With a device, calls of a millisecond follow each other, and being woken up for each, on both sides, takes
// a tenth of that. So who waits looks for a while, leaving its processor to others, before it sleeps.
// It is longer than a caller takes to put a matrix together, 2 to 3 ms in flexible mechanisms.
template <class Ready>
void Team::look_for(const Ready& ready) const {
  if (!beside_device_ || !has_device) return;
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(6);
  while (!ready() && std::chrono::steady_clock::now() < end) std::this_thread::yield();
}

void Team::serve() {
  for (;;) {
    const auto asked = [this] { return work_ != nullptr; };
    look_for(asked);
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, asked);
    const std::function<void()>& task = *work_;
    lock.unlock();
    try {
      prepare_(*this, threads_);
      omp_set_num_threads(threads_);
      const TeamScope all(threads_);
      task();
    } catch (...) {
      error_ = std::current_exception();
    }
    (*released_)();
    lock.lock();
    work_ = nullptr;
    done_ = true;
    changed_.notify_all();
  }
}

void Team::run(int threads, const std::function<void()>& work, const std::function<void()>& idle,
               const std::function<void()>& released) {
  const auto done = [this] { return done_.load(); };
  std::unique_lock<std::mutex> lock(mutex_);
  threads_ = threads;
  released_ = &released;
  done_ = false;
  error_ = nullptr;
  work_ = &work;
  changed_.notify_all();
  lock.unlock();
  look_for(done);
  lock.lock();
  // Thrown only when the work is done: until then it uses what the caller lent.
  std::exception_ptr idle_error;
  while (!done()) {
    if (!idle || idle_error) {
      changed_.wait(lock, done);
    } else if (!changed_.wait_for(lock, std::chrono::milliseconds(100), done)) {
      lock.unlock();
      try {
        idle();
      } catch (...) {
        idle_error = std::current_exception();
      }
      lock.lock();
    }
  }
  const std::exception_ptr error = error_ ? std::move(error_) : idle_error;
  error_ = nullptr;
  lock.unlock();
  if (error) std::rethrow_exception(error);
}

}  // namespace mfs
