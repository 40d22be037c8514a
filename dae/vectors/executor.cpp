#include "dae/vectors/executor.hpp"

#include <cstring>
#include <new>

#include "dae/vectors/host_loops.hpp"

namespace mfs::dae {

namespace {

std::shared_ptr<void> host_memory(std::size_t bytes) {
  return {::operator new(bytes), [](void* memory) { ::operator delete(memory); }};
}

}  // namespace

Executor::Executor(Place place, int threads)
    : queue_(place == Place::device ? make_device_queue() : nullptr), threads_(team_size(threads)) {}

std::shared_ptr<void> Executor::allocate(std::size_t bytes) const {
  return on_device() ? queue_->allocate(bytes) : host_memory(bytes);
}
std::shared_ptr<void> Executor::allocate_staging(std::size_t bytes) const {
  return on_device() ? queue_->allocate_staging(bytes) : host_memory(bytes);
}

void Executor::begin_to_host(void* to, const void* from, std::size_t bytes) const {
  if (on_device()) {
    queue_->begin_to_host(to, from, bytes);
  } else if (bytes > 0) {
    std::memcpy(to, from, bytes);
  }
}
void Executor::begin_from_host(void* to, const void* from, std::size_t bytes) const {
  if (on_device()) {
    queue_->begin_from_host(to, from, bytes);
  } else if (bytes > 0) {
    std::memcpy(to, from, bytes);
  }
}

void Executor::synchronize() const {
  if (on_device()) queue_->synchronize();
}
void Executor::mark() const {
  if (on_device()) queue_->mark();
}
void Executor::wait_for_mark() const {
  if (on_device()) queue_->wait_for_mark();
}

}  // namespace mfs::dae
