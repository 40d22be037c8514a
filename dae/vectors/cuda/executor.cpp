#include "dae/vectors/executor.hpp"

#include <algorithm>
#include <cstring>
#include <new>

#include "dae/vectors/cuda/device_queue.hpp"
#include "dae/vectors/host_loops.hpp"

namespace mfs::dae {

Executor::Executor(Place place, int threads) : threads_(team_size(threads)) {
  if (place == Place::host) return;
  int devices = 0;
  cuda::check(cudaGetDeviceCount(&devices), "cudaGetDeviceCount");
  queue_ = std::make_unique<DeviceQueue>();
}
Executor::~Executor() {
  if (on_device()) queue_->stream.drain();
}

void* Executor::stream() const {
  return on_device() ? queue_->stream.get() : nullptr;
}

std::shared_ptr<void> Executor::allocate(std::size_t bytes) const {
  if (!on_device()) return {::operator new(bytes), [](void* memory) { ::operator delete(memory); }};
  const auto arena = std::make_shared<cuda::DeviceArena>(std::max<Offset>(1, static_cast<Offset>(bytes)));
  return {arena, arena->at<char>(0)};
}

std::shared_ptr<void> Executor::allocate_staging(std::size_t bytes) const {
  if (!on_device()) return allocate(bytes);
  const auto arena = std::make_shared<cuda::PinnedArena>(std::max<Offset>(1, static_cast<Offset>(bytes)));
  return {arena, arena->at<char>(0)};
}

void Executor::begin_to_host(void* to, const void* from, std::size_t bytes) const {
  if (bytes == 0) return;
  if (on_device())
    queue_->stream.to_host(to, from, static_cast<Offset>(bytes));
  else
    std::memcpy(to, from, bytes);
}

void Executor::begin_from_host(void* to, const void* from, std::size_t bytes) const {
  if (bytes == 0) return;
  if (on_device())
    queue_->stream.to_device(to, from, static_cast<Offset>(bytes));
  else
    std::memcpy(to, from, bytes);
}

void Executor::synchronize() const {
  if (on_device()) queue_->stream.synchronize();
}
void Executor::mark() const {
  if (on_device()) queue_->marked.record(queue_->stream);
}
void Executor::wait_for_mark() const {
  if (on_device()) queue_->marked.synchronize();
}

}  // namespace mfs::dae
