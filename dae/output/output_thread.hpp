// A thread that writes beside the computation: jobs are done one after another, in the order in which they
// were given, while whoever gave them goes on. What a job throws is thrown again by the next call that gives
// a job or waits; the jobs behind it are not done.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace mfs::dae {

class OutputThread {
 public:
  /// `most_bytes`: of what waiting jobs hold; one of any size is taken where none waits.
  explicit OutputThread(std::size_t most_bytes);
  /// Does what is left, and keeps silent about what that throws.
  ~OutputThread();
  OutputThread(const OutputThread&) = delete;
  OutputThread& operator=(const OutputThread&) = delete;

  /// Waits until there is room for a job that holds so many bytes.
  void give(std::size_t bytes, std::function<void()> job);
  /// Waits until all jobs are done.
  void wait();

  double time_busy() const;                       ///< s that jobs took; after wait()
  double time_waited() const { return waited_; }  ///< s spent in give() and wait()

 private:
  struct Job {
    std::size_t bytes;
    std::function<void()> work;
  };

  void run();
  template <class Condition>
  void wait_until(std::unique_lock<std::mutex>& lock, const Condition& condition);

  const std::size_t most_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable given_, done_;
  std::deque<Job> jobs_;  // the first is the one that is being done
  std::size_t bytes_ = 0;
  bool end_ = false;
  std::exception_ptr failure_;
  double busy_ = 0, waited_ = 0;
  std::thread thread_;
};

}  // namespace mfs::dae
