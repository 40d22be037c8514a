#include "dae/vectors/cuda/cuda_queue.hpp"

#include <algorithm>

namespace mfs::dae {

namespace {

template <class Arena>
std::shared_ptr<void> memory_of(std::size_t bytes) {
  const auto arena = std::make_shared<Arena>(std::max<Offset>(1, static_cast<Offset>(bytes)));
  return {arena, arena->template at<char>(0)};
}

}  // namespace

std::shared_ptr<void> CudaQueue::allocate(std::size_t bytes) const {
  return memory_of<cuda::DeviceArena>(bytes);
}
std::shared_ptr<void> CudaQueue::allocate_staging(std::size_t bytes) const {
  return memory_of<cuda::PinnedArena>(bytes);
}

std::unique_ptr<DeviceQueue> make_device_queue() {
  int devices = 0;
  cuda::check(cudaGetDeviceCount(&devices), "cudaGetDeviceCount");
  return std::make_unique<CudaQueue>();
}

}  // namespace mfs::dae
