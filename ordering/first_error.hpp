// No exception may leave a parallel region or a task: the first one is kept, and thrown behind the region.
#pragma once

#include <atomic>
#include <exception>

namespace mfs {

class FirstError {
 public:
  /// Does `work`; after a failure, by any thread, nothing more.
  template <class Work>
  void attempt(const Work& work) noexcept {
    if (failed_) return;
    try {
      work();
    } catch (...) {
      if (!failed_.exchange(true)) error_ = std::current_exception();
    }
  }
  /// To be called when all threads are done.
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  std::atomic<bool> failed_{false};
  std::exception_ptr error_;
};

}  // namespace mfs
