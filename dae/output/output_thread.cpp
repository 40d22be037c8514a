#include "dae/output/output_thread.hpp"

#include <system_error>
#include <utility>

#include <mfs/error.hpp>

#include "ordering/stopwatch.hpp"

namespace mfs::dae {

OutputThread::OutputThread(std::size_t most_bytes) : most_bytes_(most_bytes) {
  try {
    thread_ = std::thread([this] { run(); });
  } catch (const std::system_error& e) {
    throw BackendError("std::thread", e.code().value(), e.what());
  }
}

OutputThread::~OutputThread() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    end_ = true;
  }
  given_.notify_all();
  thread_.join();
}

void OutputThread::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    given_.wait(lock, [this] { return end_ || !jobs_.empty(); });
    if (jobs_.empty()) return;
    const Stopwatch watch;
    if (!failure_) {
      const std::function<void()> work = std::move(jobs_.front().work);
      lock.unlock();
      std::exception_ptr thrown;
      try {
        work();
      } catch (...) {
        thrown = std::current_exception();
      }
      lock.lock();
      failure_ = thrown;
    }
    busy_ += watch.seconds();
    bytes_ -= jobs_.front().bytes;
    jobs_.pop_front();
    done_.notify_all();
  }
}

template <class Condition>
void OutputThread::wait_until(std::unique_lock<std::mutex>& lock, const Condition& condition) {
  const Stopwatch watch;
  done_.wait(lock, [&] { return failure_ || condition(); });
  waited_ += watch.seconds();
  if (failure_) std::rethrow_exception(failure_);
}

void OutputThread::give(std::size_t bytes, std::function<void()> job) {
  std::unique_lock<std::mutex> lock(mutex_);
  wait_until(lock, [&] { return jobs_.empty() || bytes_ + bytes <= most_bytes_; });
  jobs_.push_back({bytes, std::move(job)});
  bytes_ += bytes;
  lock.unlock();
  given_.notify_all();
}

void OutputThread::wait() {
  std::unique_lock<std::mutex> lock(mutex_);
  wait_until(lock, [this] { return jobs_.empty(); });
}

double OutputThread::time_busy() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return busy_;
}

}  // namespace mfs::dae
