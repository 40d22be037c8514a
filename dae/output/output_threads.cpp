#include "dae/output/output_threads.hpp"

#include <system_error>
#include <utility>

#include <mfs/error.hpp>

#include "ordering/stopwatch.hpp"

namespace mfs::dae {

OutputThreads::OutputThreads(std::size_t most_bytes, int threads) : most_bytes_(most_bytes) {
  try {
    for (int k = 0; k < threads; ++k) threads_.emplace_back([this] { run(); });
  } catch (const std::system_error& e) {
    if (threads_.empty()) throw BackendError("std::thread", e.code().value(), e.what());
  }
}

OutputThreads::~OutputThreads() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    end_ = true;
  }
  given_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void OutputThreads::run() {
  const auto take = [](std::deque<Job>& jobs) {
    Job job = std::move(jobs.front());
    jobs.pop_front();
    return job;
  };
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    // Who does the first part of a job goes on with the second, so nobody has to stay for that.
    const auto may_begin = [this] { return !busy_in_order_ && !in_order_.empty(); };
    given_.wait(lock, [&] { return !beside_.empty() || may_begin() || (end_ && in_order_.empty()); });
    if (!beside_.empty())
      work(take(beside_), false, lock);
    else if (may_begin())
      work(take(in_order_), true, lock);
    else
      return;
  }
}

void OutputThreads::work(Job job, bool in_order, std::unique_lock<std::mutex>& lock) {
  const Stopwatch watch;
  if (in_order) busy_in_order_ = true;
  if (!failure_) {
    lock.unlock();
    std::exception_ptr thrown;
    try {
      (in_order ? job.in_order : job.beside)();
    } catch (...) {
      thrown = std::current_exception();
    }
    lock.lock();
    if (thrown && (!failure_ || job.number < failed_)) {
      failure_ = thrown;
      failed_ = job.number;
    }
  }
  busy_ += watch.seconds();
  if (in_order) busy_in_order_ = false;
  if (in_order && job.beside) {
    beside_.push_back(std::move(job));
  } else {
    bytes_ -= job.bytes;
    --undone_;
  }
  given_.notify_all();
  done_.notify_all();
}

template <class Condition>
void OutputThreads::wait_until(std::unique_lock<std::mutex>& lock, const Condition& condition) {
  const Stopwatch watch;
  done_.wait(lock, [&] { return failure_ || condition(); });
  waited_ += watch.seconds();
  if (failure_) std::rethrow_exception(failure_);
}

void OutputThreads::give(std::size_t bytes, std::function<void()> in_order, std::function<void()> beside) {
  std::unique_lock<std::mutex> lock(mutex_);
  wait_until(lock, [&] { return undone_ == 0 || bytes_ + bytes <= most_bytes_; });
  in_order_.push_back({given_jobs_++, bytes, std::move(in_order), std::move(beside)});
  bytes_ += bytes;
  ++undone_;
  lock.unlock();
  given_.notify_all();
}

void OutputThreads::wait() {
  std::unique_lock<std::mutex> lock(mutex_);
  wait_until(lock, [this] { return undone_ == 0; });
}

double OutputThreads::time_busy() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return busy_;
}

}  // namespace mfs::dae
