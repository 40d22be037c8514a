// Where the integrator's long vectors lie, and who makes the passes over them (loops.hpp): the threads of the
// host, or a CUDA device, in one stream.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "dae/vectors/device_queue.hpp"

namespace mfs::dae {

class Executor {
 public:
  enum class Place { host, device };

  /// `threads`: of the host, 0: all. Throws BackendError where there is no device, or this build has no CUDA,
  /// OutOfMemory and std::bad_alloc.
  Executor(Place place, int threads);
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  bool on_device() const { return queue_ != nullptr; }
  int threads() const { return threads_; }
  const DeviceQueue* queue() const { return queue_.get(); }  ///< null on the host
  /// The device's, a cudaStream_t; null on the host.
  void* stream() const { return on_device() ? queue_->stream() : nullptr; }

  /// Memory that lives as long as what is returned: that of the executor, and memory of the host for copies
  /// to it and back. Throws OutOfMemory (device), std::bad_alloc (host).
  std::shared_ptr<void> allocate(std::size_t bytes) const;
  std::shared_ptr<void> allocate_staging(std::size_t bytes) const;
  /// Copies between here and staging memory, behind what was begun before. On the host they are made at once.
  void begin_to_host(void* to, const void* from, std::size_t bytes) const;
  void begin_from_host(void* to, const void* from, std::size_t bytes) const;
  /// Waits for all that was begun.
  void synchronize() const;
  /// Marks what was begun so far; waits for what was marked last.
  void mark() const;
  void wait_for_mark() const;

  /// The same copies for any memory of the host; they are done when these return.
  void to_host(void* to, const void* from, std::size_t bytes) const {
    begin_to_host(to, from, bytes);
    synchronize();
  }
  void from_host(void* to, const void* from, std::size_t bytes) const {
    begin_from_host(to, from, bytes);
    synchronize();
  }

 private:
  std::unique_ptr<DeviceQueue> queue_;
  int threads_;
};

/// Numbers in an executor's memory.
template <class T>
class Array {
 public:
  Array() = default;
  Array(Array&&) noexcept = default;
  Array& operator=(Array&&) noexcept = default;

  /// What is in it is lost where the size changes, and nothing is set.
  void resize(const Executor& executor, std::size_t size) {
    if (size == size_) return;
    *this = Array();
    memory_ = executor.allocate(size * sizeof(T));
    size_ = size;
  }
  void assign(const Executor& executor, const std::vector<T>& values) {
    resize(executor, values.size());
    executor.from_host(data(), values.data(), size_ * sizeof(T));
  }
  std::vector<T> on_host(const Executor& executor) const {
    std::vector<T> values(size_);
    executor.to_host(values.data(), data(), size_ * sizeof(T));
    return values;
  }

  T* data() { return static_cast<T*>(memory_.get()); }
  const T* data() const { return static_cast<const T*>(memory_.get()); }
  std::size_t size() const { return size_; }

 private:
  std::shared_ptr<void> memory_;
  std::size_t size_ = 0;
};

/// An array whose numbers the host makes again and again, and whose copies it does not wait for.
template <class T>
class SentArray {
 public:
  /// Room of the host for so many numbers, once those that were sent before have arrived.
  T* room(const Executor& executor, std::size_t size) {
    executor.synchronize();
    if (size != array_.size()) {
      array_.resize(executor, size);
      staging_ = executor.allocate_staging(size * sizeof(T));
    }
    return static_cast<T*>(staging_.get());
  }
  /// What is in the room, for all that the executor begins from now on.
  void send(const Executor& executor) {
    executor.begin_from_host(array_.data(), staging_.get(), array_.size() * sizeof(T));
  }
  const Array<T>& array() const { return array_; }

 private:
  Array<T> array_;
  std::shared_ptr<void> staging_;
};

template <class T>
Array<T> make_array(const Executor& executor, const std::vector<T>& values) {
  Array<T> array;
  array.assign(executor, values);
  return array;
}

}  // namespace mfs::dae
