// The one seam to the CUDA runtime: memory, copies, graphs, and what an error of any of them becomes. No
// other host code names one of its functions.
#pragma once

#include <cuda_runtime.h>

#include <algorithm>
#include <string>
#include <utility>

#include "kernels/runtime/arena.hpp"

namespace mfs::cuda {

/// Throws BackendError("CUDA", code, what).
void check(cudaError_t code, const char* what);
/// The same for the launch before it.
void check_launch(const char* what);

/// Bytes free on the current device.
Offset free_memory();
/// Bytes of the current device that are in use beside all DeviceArenas: this process's context with the code
/// of kernels. What else there is, arrays of a caller or other processes, does not count: it is the least
/// that this function has seen, and at most what a context takes.
Offset bytes_of_context();
/// Of the current device, as all that follows but the number of devices.
int multiprocessors();
/// Bytes that a kernel's block may ask for on the current device; MFS_CUDA_SHARED_MEMORY in the environment
/// (bytes) makes it a device that has less, for tests.
int shared_memory_per_block();
int device_count();
std::string device_name();
Offset device_memory();
/// 10 major + minor.
int compute_capability();
/// Speed of single precision in that of double.
int single_to_double();
int current_device();
/// Throws InvalidInput(name) for an array that kernels on the current device cannot reach: in memory of the
/// host that is not page-locked, or of another device.
void require_reachable(const void* array, const char* name);
/// Makes another the current device, as long as this lives.
class OnDevice {
 public:
  explicit OnDevice(int device);
  ~OnDevice();

 private:
  int before_;
};
/// Compute capability that a kernel was compiled for, of the code that the current device runs.
int code_of(const void* kernel);
/// Whether a kernel's code can wait for the one ahead of it in its stream (runtime/early_launch.hpp), and
/// graphs of this runtime and driver can tell so.
bool begins_early(const void* kernel);
void set_shared_memory(const void* kernel, std::size_t bytes);

/// Device memory of one arena. Throws OutOfMemory(device).
class DeviceArena : public RawArena {
 public:
  explicit DeviceArena(Offset bytes);
  ~DeviceArena();
};

/// Page-locked host memory, which the device copies from and to without a stop. Throws std::bad_alloc.
class PinnedArena : public RawArena {
 public:
  explicit PinnedArena(Offset bytes);
  ~PinnedArena();

 private:
  HostArena memory_;
};

class Event;

class Stream {
 public:
  /// Blocks of a stream of low priority begin when no others wait.
  enum class Priority { low, high };
  explicit Stream(Priority priority = Priority::high);
  ~Stream();
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  cudaStream_t get() const { return stream_; }
  void synchronize() const;
  /// Waits for what is in it, whatever comes of that.
  void drain() const noexcept;
  /// What is put into this stream from now on waits for the event.
  void wait_for(const Event& event) const;
  void to_device(void* to, const void* from, Offset bytes) const;
  void to_host(void* to, const void* from, Offset bytes) const;
  void clear(void* place, Offset bytes) const { fill(place, 0, bytes); }
  void fill(void* place, int byte, Offset bytes) const;
  /// `columns` columns of so many bytes, between any two memories.
  void copy_columns(void* to, Offset to_pitch, const void* from, Offset from_pitch, Offset bytes,
                    Vertex columns) const;

 private:
  cudaStream_t stream_ = nullptr;
};

/// A moment in a stream.
class Event {
 public:
  Event();
  ~Event();
  Event(const Event&) = delete;
  Event& operator=(const Event&) = delete;
  void record(const Stream& stream);
  /// In a stream that is not ours.
  void record_foreign(void* stream);
  /// Waits until it has passed.
  void synchronize() const;
  /// Milliseconds from `before` to this; both must have passed.
  float since(const Event& before) const;
  cudaEvent_t get() const { return event_; }

 private:
  cudaEvent_t event_ = nullptr;
};

/// Copies from any host memory by way of page-locked memory, which all threads fill: the runtime has one
/// thread for that. What is copied from may change at once.
class Upload {
 public:
  /// `most`: bytes of all that will be copied.
  Upload(const Stream& stream, Offset most)
      : stream_(stream),
        half_bytes_(std::clamp(most / 8, Offset(1) << 20, Offset(8) << 20)),
        memory_(std::min(most, 2 * half_bytes_)) {}
  /// Waits for the copies.
  ~Upload() { stream_.drain(); }
  void to_device(void* to, const void* from, Offset bytes);

 private:
  void turn();

  const Stream& stream_;
  const Offset half_bytes_;  // more takes longer to be locked than it saves
  PinnedArena memory_;       // one half is filled while the other is copied
  Event copied_[2];
  int half_ = 0;
  Offset used_ = 0;  // of the half
};

/// A stream for what may run beside another one, when that leaves room.
class SideStream {
 public:
  SideStream() : stream_(Stream::Priority::low) {}
  const Stream& stream() const { return stream_; }
  /// The stream, which from now on waits for what is in `main`.
  const Stream& begin_after(const Stream& main) {
    fork_.record(main);
    stream_.wait_for(fork_);
    busy_ = true;
    return stream_;
  }
  /// `main` waits for what has begun.
  void join(const Stream& main) {
    if (!busy_) return;
    joined_.record(stream_);
    main.wait_for(joined_);
    busy_ = false;
  }
  /// After a failure.
  void drain() noexcept {
    stream_.drain();
    busy_ = false;
  }

 private:
  Stream stream_;
  Event fork_, joined_;
  bool busy_ = false;
};

/// Launches recorded once and replayed.
class Graph {
 public:
  Graph() = default;
  ~Graph() { reset(); }
  Graph(const Graph&) = delete;
  Graph& operator=(const Graph&) = delete;

  bool recorded() const { return executable_ != nullptr; }
  template <class Work>
  void record(const Stream& stream, const Work& work) {
    reset();
    begin(stream);
    try {
      work();
      end(stream);
    } catch (...) {
      abandon(stream);
      throw;
    }
  }
  void launch(const Stream& stream) const;
  void reset();

 private:
  static void begin(const Stream& stream);
  static void abandon(const Stream& stream);
  void end(const Stream& stream);
  cudaGraphExec_t executable_ = nullptr;
};

}  // namespace mfs::cuda
