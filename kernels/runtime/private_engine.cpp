// The engine with a Kokkos of its own (MFS_KOKKOS=private): calls have teams of threads from one pool.
#include <omp.h>
#include <pthread.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <string>
#include <vector>

#include <Kokkos_Core.hpp>

#include <mfs/error.hpp>

#include "kernels/runtime/callers_settings.hpp"
#include "kernels/runtime/engine.hpp"
#include "kernels/runtime/team.hpp"

namespace mfs {

namespace {

#if KOKKOS_VERSION >= 30700
using Settings = Kokkos::InitializationSettings;
#else
using Settings = Kokkos::InitArguments;
#endif

#ifdef MFS_CUDA
// Of the caller whom Kokkos' team serves: the device that is current in his thread.
int device_of_caller = 0;
// Kokkos' CUDA space has one, that of the first caller who needs it; -1 before.
std::atomic<int> device_of_kokkos{-1};

int current_device() {
  int device = 0;
  if (cudaGetDevice(&device) != cudaSuccess) cudaGetLastError();  // none: who needs one will see
  return device;
}

// In the team's thread, which would have the first device.
void follow_caller() {
  if (device_of_kokkos >= 0 || current_device() == device_of_caller) return;
  const cudaError_t code = cudaSetDevice(device_of_caller);
  if (code != cudaSuccess)
    throw BackendError("CUDA", code, std::string("cudaSetDevice: ") + cudaGetErrorString(code));
}
#endif

void start_kokkos(const Settings& settings) {
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

// In the one team that uses Kokkos. Another number of threads: only the OpenMP space starts anew.
// Kokkos::finalize would end all spaces, and Serial does not survive that in 3.4 (its scratch memory comes
// back too small, and is overrun).
void prepare_kokkos(Team& team, int wanted) {
  static bool started = false;
  static int kokkos_threads = 0;  // 0: OpenMP space not initialized
#ifdef MFS_CUDA
  follow_caller();
#endif
  if (kokkos_threads == wanted) return;
  team.have_threads(wanted);
  kokkos_threads = 0;
  omp_set_num_threads(wanted);  // Kokkos 3.4 counts threads by a region of as many as it may have
#if KOKKOS_VERSION >= 30700
  const auto settings = Settings().set_num_threads(wanted).set_disable_warnings(true);
#else
  Settings settings;
  settings.num_threads = wanted;
  settings.disable_warnings = true;
#endif
  if (!started) {
    start_kokkos(settings);
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

void prepare_threads(Team& team, int wanted) {
  team.have_threads(wanted);
}

}  // namespace

// Who may work at a time, and the teams that there are.
struct Engine::State {
  State(int processors, bool forked_at_work, bool kokkos_lost)
      : processors(processors), forked_at_work(forked_at_work), kokkos_lost(kokkos_lost) {}
  /// That of a process forked from this one.
  State* of_child() const {
    return new State(processors, forked_at_work || busy > 0 || callers_at_work > 0,
                     kokkos_lost || kokkos != nullptr);
  }

  const int processors;
  const bool forked_at_work, kokkos_lost;
  std::atomic<int> callers_at_work{0};  // in their own threads
  std::mutex mutex;                     // guards what follows
  std::condition_variable changed;
  std::uint64_t arrived = 0, admitted = 0;  // calls; they are admitted in the order in which they arrive
  int busy = 0;                             // threads at work
  bool kokkos_taken = false;
  Team* kokkos = nullptr;
  std::vector<Team*> idle;
  std::size_t teams = 0;  // without that of Kokkos

  void check_process(Needs needs) const {
    if (forked_at_work)
      throw StateError(
          "this process was forked while the solver was at work in the other: fork before or after");
    if (kokkos_lost && needs == Needs::kokkos)
      throw StateError(
          "this process was forked from one that had used Kokkos (backends cuda and kokkos): use them in one "
          "of the two");
  }

  // Waits until so many processors are left by others, or all of them.
  void admit(int threads, Needs needs) {
    std::unique_lock<std::mutex> lock(mutex);
    const std::uint64_t mine = arrived++;
    changed.wait(lock, [&] {
      const bool room = busy == 0 || busy + threads <= processors;
      return mine == admitted && room && !(needs == Needs::kokkos && kokkos_taken);
    });
    ++admitted;
    busy += threads;
    if (needs == Needs::kokkos) kokkos_taken = true;
    changed.notify_all();
  }

  void leave(int threads) {
    const std::lock_guard<std::mutex> lock(mutex);
    busy -= threads;
    changed.notify_all();
  }

  // The team that had so many threads last, if there is one. Where the system refuses a new one, that which
  // is free next.
  Team* take_team(int threads) {
    std::unique_lock<std::mutex> lock(mutex);
    if (idle.empty()) {
      try {
        idle.reserve(teams + 1);
        Team* const team = Team::start(prepare_threads, false);
        ++teams;
        return team;
      } catch (const std::exception&) {
        if (teams == 0) throw;
      }
      changed.wait(lock, [this] { return !idle.empty(); });
    }
    std::size_t k = idle.size() - 1;
    while (k > 0 && idle[k]->threads() != threads) --k;
    Team* const team = idle[k];
    idle[k] = idle.back();
    idle.pop_back();
    return team;
  }

  Team* take_kokkos() {
    const std::lock_guard<std::mutex> lock(mutex);
    if (!kokkos) kokkos = Team::start(prepare_kokkos, true);
    return kokkos;
  }

  // `team`: null where none was to be had.
  void give_back(Team* team, Needs needs) {
    const std::lock_guard<std::mutex> lock(mutex);
    if (needs == Needs::kokkos) {
      kokkos_taken = false;
    } else if (team) {
      idle.push_back(team);  // there is room
    }
    changed.notify_all();
  }
};

Engine::Engine() : state_(new State(available_threads(), false, false)) {
  // In the child, before fork returns there. What the parent had is left as it is, with locks that nobody
  // will open.
  pthread_atfork(nullptr, nullptr, [] {
    Engine& engine = instance();
    engine.state_ = engine.state_->of_child();
  });
}

#ifdef MFS_CUDA
void Engine::use_cuda() {
  if (device_of_kokkos >= 0) return;
#if KOKKOS_VERSION >= 30700
  Kokkos::Cuda::impl_initialize(
      Kokkos::InitializationSettings().set_device_id(device_of_caller).set_disable_warnings(true));
#else
  Kokkos::Cuda::impl_initialize(Kokkos::Cuda::SelectDevice(device_of_caller), 1);
#endif
  // Otherwise Kokkos would say at the end of the process that this was forgotten.
  std::atexit([] { Kokkos::Cuda::impl_finalize(); });
  Team::has_device = true;
  device_of_kokkos = device_of_caller;
}

void Engine::check_device() {
  const int used = device_of_kokkos;
  if (used >= 0 && current_device() != used) refuse_device(used, current_device());
}
#endif

void Engine::run(int threads, const std::function<void()>& work, const std::function<void()>& idle,
                 Needs needs) {
  if (needs == Needs::threads && at_work()) return run_here(work);
  state_->check_process(needs);
  state_->admit(threads, needs);
  // Processors are left when the work is done, the team when the caller has seen that.
  struct Lease {
    State& state;
    const int threads;
    const Needs needs;
    bool working = true;
    Team* team = nullptr;
    ~Lease() {
      if (working) state.leave(threads);
      state.give_back(team, needs);
    }
  } lease{*state_, threads, needs};
#ifdef MFS_CUDA
  if (needs == Needs::kokkos) device_of_caller = current_device();
#endif
  lease.team = needs == Needs::kokkos ? state_->take_kokkos() : state_->take_team(threads);
  lease.team->run(threads, work, idle, [&lease] {
    lease.state.leave(lease.threads);
    lease.working = false;
  });
}

void Engine::run_here(const std::function<void()>& work) {
  state_->check_process(Needs::threads);
  struct AtWork {
    std::atomic<int>& count;
    explicit AtWork(std::atomic<int>& counted) : count(counted) { ++count; }
    ~AtWork() { --count; }
  } const at_work(state_->callers_at_work);
  const CallersSettings kept;
  const TeamScope one(1);
  work();
}

}  // namespace mfs
