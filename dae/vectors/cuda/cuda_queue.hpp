// What a CUDA device needs to work for an executor.
#pragma once

#include "dae/vectors/executor.hpp"
#include "kernels/cuda/runtime/device.hpp"

namespace mfs::dae {

class CudaQueue final : public DeviceQueue {
 public:
  static constexpr int kFoldBlocks = 256;  ///< blocks of threads of a fold
  static constexpr int kFoldsAtOnce = 16;  ///< that are begun before the first is waited for

  ~CudaQueue() override { work.drain(); }
  void* stream() const override { return work.get(); }
  std::shared_ptr<void> allocate(std::size_t bytes) const override;
  std::shared_ptr<void> allocate_staging(std::size_t bytes) const override;
  void begin_to_host(void* to, const void* from, std::size_t bytes) const override {
    work.to_host(to, from, static_cast<Offset>(bytes));
  }
  void begin_from_host(void* to, const void* from, std::size_t bytes) const override {
    work.to_device(to, from, static_cast<Offset>(bytes));
  }
  void synchronize() const override { work.synchronize(); }
  void mark() override { marked.record(work); }
  void wait_for_mark() const override { marked.synchronize(); }

  cuda::Stream work;
  cuda::Event marked;
  cuda::PinnedArena folded{
      Offset{kFoldsAtOnce * kFoldBlocks * kMostFolded}};  ///< written by the device, read by the host
};

/// Of an executor on a device.
inline const CudaQueue& queue_of(const Executor& executor) {
  return static_cast<const CudaQueue&>(*executor.queue());
}

}  // namespace mfs::dae
