// The engine with a Kokkos of its own (MFS_KOKKOS=private).
#include <omp.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

#include <Kokkos_Core.hpp>

#include "kernels/runtime/engine.hpp"

namespace mfs {

namespace {

// Kokkos and OpenMP's library take some KiB for each thread when they start, and some hundred for all.
constexpr std::size_t kThreadMemory = 1 << 20;

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

struct Engine::State {
  const pid_t process = getpid();
  std::mutex caller;  // one caller at a time
  std::mutex mutex;   // guards what follows
  std::condition_variable changed;
  std::atomic<const std::function<void()>*> work{nullptr};
  int threads = 0;
  std::atomic<bool> done{false};
  std::exception_ptr error;

  int kokkos_threads = 0;  // 0: OpenMP space not initialized; only the engine's thread looks

#if KOKKOS_VERSION >= 30700
  using Settings = Kokkos::InitializationSettings;
#else
  using Settings = Kokkos::InitArguments;
#endif
  bool started = false;

  static void start(const Settings& settings) {
#ifdef KOKKOS_ENABLE_CUDA
    // Kokkos::initialize would want a device now, also where none is asked for or there.
    Kokkos::Impl::pre_initialize(settings);
#if KOKKOS_VERSION >= 30700
    Kokkos::Serial::impl_initialize(settings);
    Kokkos::OpenMP::impl_initialize(settings);
#else
    Kokkos::Serial::impl_initialize();
    Kokkos::OpenMP::impl_initialize(settings.num_threads);
#endif
    Kokkos::Impl::post_initialize(settings);
#else
    Kokkos::initialize(settings);
#endif
  }

  // Another number of threads: only the OpenMP space starts anew. Kokkos::finalize would end all spaces, and
  // Serial does not survive that in 3.4 (its scratch memory comes back too small, and is overrun).
  void use_threads(int wanted) {
    if (kokkos_threads == wanted) return;
    ask_for_threads(wanted - 1);
    kokkos_threads = 0;
    omp_set_num_threads(wanted);  // Kokkos 3.4 counts threads by a region of as many as it may have
#if KOKKOS_VERSION >= 30700
    const auto settings = Kokkos::InitializationSettings().set_num_threads(wanted).set_disable_warnings(true);
#else
    Kokkos::InitArguments settings;
    settings.num_threads = wanted;
    settings.disable_warnings = true;
#endif
    if (!started) {
      start(settings);
      started = true;
    } else {
      Kokkos::OpenMP::impl_finalize();
#if KOKKOS_VERSION >= 30700
      Kokkos::OpenMP::impl_initialize(settings);
#else
      Kokkos::OpenMP::impl_initialize(wanted);
#endif
    }
    kokkos_threads = wanted;
  }

  // With a device, calls of a millisecond follow each other, and being woken up for each, on both sides,
  // takes a tenth of that. So who waits looks for a while, leaving its processor to others, before it sleeps.
  static inline std::atomic<bool> has_device{false};
  template <class Ready>
  static void look_for(const Ready& ready) {
    if (!has_device) return;
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(2);
    while (!ready() && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  }

  void serve() {
    for (;;) {
      const auto asked = [this] { return work != nullptr; };
      look_for(asked);
      std::unique_lock<std::mutex> lock(mutex);
      changed.wait(lock, asked);
      const std::function<void()>& task = *work;
      lock.unlock();
      try {
        use_threads(threads);
        task();
      } catch (...) {
        error = std::current_exception();
      }
      lock.lock();
      work = nullptr;
      done = true;
      changed.notify_all();
    }
  }
};

Engine::Engine() {
  auto state = std::make_unique<State>();
  std::thread([state = state.get()] { state->serve(); }).detach();
  state_ = state.release();
}

#ifdef MFS_CUDA
void Engine::use_cuda() {
  static bool started = false;
  if (started) return;
#if KOKKOS_VERSION >= 30700
  Kokkos::Cuda::impl_initialize(Kokkos::InitializationSettings().set_disable_warnings(true));
#else
  int device = 0;  // the caller's: Kokkos would take the first
  cudaGetDevice(&device);
  Kokkos::Cuda::impl_initialize(Kokkos::Cuda::SelectDevice(device), 1);
#endif
  // Otherwise Kokkos would say at the end of the process that this was forgotten.
  std::atexit([] { Kokkos::Cuda::impl_finalize(); });
  State::has_device = true;
  started = true;
}
#endif

void Engine::run(int threads, const std::function<void()>& work, const std::function<void()>& idle) {
  check_process(state_->process);
  const std::lock_guard<std::mutex> one_caller(state_->caller);
  const auto done = [this] { return state_->done.load(); };
  std::unique_lock<std::mutex> lock(state_->mutex);
  state_->threads = threads;
  state_->done = false;
  state_->error = nullptr;
  state_->work = &work;
  state_->changed.notify_all();
  lock.unlock();
  State::look_for(done);
  lock.lock();
  std::exception_ptr
      idle_error;  // thrown only when the work is done: until then it uses what the caller lent
  while (!done()) {
    if (!idle || idle_error) {
      state_->changed.wait(lock, done);
    } else if (!state_->changed.wait_for(lock, std::chrono::milliseconds(100), done)) {
      lock.unlock();
      try {
        idle();
      } catch (...) {
        idle_error = std::current_exception();
      }
      lock.lock();
    }
  }
  const std::exception_ptr error = state_->error ? std::move(state_->error) : idle_error;
  state_->error = nullptr;
  lock.unlock();
  if (error) std::rethrow_exception(error);
}

}  // namespace mfs
