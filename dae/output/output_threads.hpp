// Threads that write beside the computation, while whoever gave them jobs goes on. A job has a part that is
// done in the order in which jobs were given, one after another, and may have another, which is done after
// that beside those of other jobs. What a job throws is thrown again by the next call that gives a job or
// waits, that of the earliest job where there are several by then; jobs that were not begun are not done any
// more.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace mfs::dae {

class OutputThreads {
 public:
  /// `most_bytes`: of what jobs hold that are not done; one of any size is taken where there is no other. So
  /// many `threads`, or fewer where the system gives no more; throws BackendError where it gives none.
  OutputThreads(std::size_t most_bytes, int threads);
  /// Does what is left, and keeps silent about what that throws.
  ~OutputThreads();
  OutputThreads(const OutputThreads&) = delete;
  OutputThreads& operator=(const OutputThreads&) = delete;

  /// Waits until there is room for a job that holds so many bytes.
  void give(std::size_t bytes, std::function<void()> in_order, std::function<void()> beside = {});
  /// Waits until all jobs are done.
  void wait();

  double time_busy() const;                       ///< s that jobs took, of all threads; after wait()
  double time_waited() const { return waited_; }  ///< s spent in give() and wait()

 private:
  struct Job {
    std::int64_t number = 0;
    std::size_t bytes = 0;
    std::function<void()> in_order, beside;
  };

  void run();
  void work(Job job, bool in_order, std::unique_lock<std::mutex>& lock);
  template <class Condition>
  void wait_until(std::unique_lock<std::mutex>& lock, const Condition& condition);

  const std::size_t most_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable given_, done_;
  std::deque<Job> in_order_, beside_;  // not begun; of the second, the first part is done
  bool busy_in_order_ = false;
  std::int64_t given_jobs_ = 0, undone_ = 0;
  std::size_t bytes_ = 0;
  bool end_ = false;
  std::exception_ptr failure_;
  std::int64_t failed_ = 0;  // the job that threw it
  double busy_ = 0, waited_ = 0;
  std::vector<std::thread> threads_;
};

}  // namespace mfs::dae
