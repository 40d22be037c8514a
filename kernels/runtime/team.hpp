// A team: one thread of the engine's own and the OpenMP threads that it starts. Callers come from any thread,
// with any OpenMP settings of their own, which then stay as they are; a call hands its work over to a team
// that nobody else has at that time, and waits.
#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>

namespace mfs {

class Team {
 public:
  /// Called in the team's thread before work for `threads` threads.
  using Prepare = void (*)(Team& team, int threads);

  /// Starts its thread, which lives as long as the process, and so does the team. `beside_device`: who waits
  /// looks for up to 6 ms before it sleeps, once a device is in use. Throws std::system_error,
  /// std::bad_alloc.
  static Team* start(Prepare prepare, bool beside_device);

  /// As Engine::run, for one caller at a time; `released` is called in the team's thread when the work is
  /// done, before this returns, and throws nothing.
  void run(int threads, const std::function<void()>& work, const std::function<void()>& idle,
           const std::function<void()>& released);

  /// Of the last work.
  int threads() const { return threads_; }

  /// Asks the system for so many threads beside the team's own, unless the last work had them. OpenMP's
  /// library ends the process where it is refused one. Throws std::system_error, std::bad_alloc.
  void have_threads(int threads);

  static inline std::atomic<bool> has_device{false};

  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

 private:
  Team(Prepare prepare, bool beside_device) : prepare_(prepare), beside_device_(beside_device) {}
  void serve();
  template <class Ready>
  void look_for(const Ready& ready) const;

  const Prepare prepare_;
  const bool beside_device_;
  int granted_ = 0;   // threads that there are; only the team's thread looks
  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::atomic<const std::function<void()>*> work_{nullptr};
  const std::function<void()>* released_ = nullptr;
  int threads_ = 0;
  std::atomic<bool> done_{false};
  std::exception_ptr error_;
};

/// Threads of the loops that are started in this thread by kernels of the host: those of the team at work
/// here, else one.
int team_threads();

/// Sets team_threads() as long as it lives.
class TeamScope {
 public:
  explicit TeamScope(int threads);
  ~TeamScope();
  TeamScope(const TeamScope&) = delete;
  TeamScope& operator=(const TeamScope&) = delete;

 private:
  const int before_;
};

}  // namespace mfs
