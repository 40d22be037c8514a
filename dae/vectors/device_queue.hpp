// Memory of a device, and one stream of it in which everything is done.
#pragma once

#include <cstddef>
#include <memory>

namespace mfs::dae {

class DeviceQueue {
 public:
  /// The most bytes that each block of threads leaves of a fold (loops.hpp): 256 threads keep as many each.
  static constexpr std::size_t kMostFolded = 128;

  virtual ~DeviceQueue() = default;
  virtual void* stream() const = 0;
  /// Of the device, and of the host for copies to it and back. Throw OutOfMemory, std::bad_alloc.
  virtual std::shared_ptr<void> allocate(std::size_t bytes) const = 0;
  virtual std::shared_ptr<void> allocate_staging(std::size_t bytes) const = 0;
  virtual void begin_to_host(void* to, const void* from, std::size_t bytes) const = 0;
  virtual void begin_from_host(void* to, const void* from, std::size_t bytes) const = 0;
  virtual void synchronize() const = 0;
  virtual void mark() = 0;
  virtual void wait_for_mark() const = 0;
};

/// Throws BackendError where there is no device, or this build has no CUDA.
std::unique_ptr<DeviceQueue> make_device_queue();

}  // namespace mfs::dae
