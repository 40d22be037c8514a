// The engine with the program's Kokkos (MFS_KOKKOS=shared): kernels are started by the thread that calls.
#include <omp.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <thread>

#include <Kokkos_Core.hpp>

#include <mfs/error.hpp>

#include "kernels/runtime/engine.hpp"
#include "kernels/runtime/team.hpp"

namespace mfs {

namespace {

void check_process(pid_t process) {
  if (getpid() != process)
    throw StateError(
        "this process was forked from one that had used the solver before: use it in one of them");
}

void check_kokkos() {
  if (!Kokkos::is_initialized())
    throw StateError(
        "Kokkos is not running: this libmfs uses the program's, so start it before and end it after "
        "(Kokkos::initialize, Tpetra::initialize)");
#if defined(KOKKOS_ENABLE_OPENMP) && KOKKOS_VERSION < 40000
  if (!Kokkos::OpenMP::impl_is_initialized())
    throw StateError("the OpenMP of this Kokkos takes calls only from the thread that initialized it");
#endif
#ifdef KOKKOS_ENABLE_OPENMP
  if (omp_in_parallel())
    throw StateError("called from inside a parallel region of OpenMP, where Kokkos has no threads");
#endif
}

// Parallel loops that are not Kokkos' have so many threads, in this thread, as long as this lives.
class LoopThreads {
 public:
  explicit LoopThreads(int count) { omp_set_num_threads(count); }
  ~LoopThreads() { omp_set_num_threads(before_); }
  LoopThreads(const LoopThreads&) = delete;
  LoopThreads& operator=(const LoopThreads&) = delete;

 private:
  const int before_ = omp_get_max_threads();
};

// Calls `idle` about ten times per second in a thread of its own, as the caller's is at work.
class Beside {
 public:
  explicit Beside(const std::function<void()>& idle) {
    if (idle) thread_ = std::thread([this, &idle] { call(idle); });
  }
  ~Beside() { stop(); }
  Beside(const Beside&) = delete;
  Beside& operator=(const Beside&) = delete;

  /// Throws what `idle` threw.
  void finish() {
    stop();
    if (error_) std::rethrow_exception(error_);
  }

 private:
  void call(const std::function<void()>& idle) {
    std::unique_lock<std::mutex> lock(mutex_);
    while (!changed_.wait_for(lock, std::chrono::milliseconds(100), [this] { return done_; }) && !error_) {
      try {
        idle();
      } catch (...) {
        error_ = std::current_exception();
      }
    }
  }
  void stop() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      done_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool done_ = false;
  std::exception_ptr error_;
  std::thread thread_;
};

}  // namespace

struct Engine::State {
  const pid_t process = getpid();
  std::mutex caller;  // one caller at a time
};

Engine::Engine() : state_(new State) {}

void Engine::run(int threads, const std::function<void()>& work, const std::function<void()>& idle, Needs) {
  check_process(state_->process);
  if (at_work()) return work();
  const std::lock_guard<std::mutex> one_caller(state_->caller);
  check_kokkos();
  const TeamScope all(threads);
  const LoopThreads loops(threads);
  Beside beside(idle);
  work();
  beside.finish();
}

void Engine::run_here(const std::function<void()>& work) {
  run(1, work);
}

#ifdef MFS_CUDA
void Engine::use_cuda() {
  check_device();
}

void Engine::check_device() {
  if (!Kokkos::is_initialized()) return;
  int device = 0;
  cudaGetDevice(&device);
  const int of_kokkos = Kokkos::Cuda().cuda_device();
  if (of_kokkos != device) refuse_device(of_kokkos, device);
}
#endif

}  // namespace mfs
