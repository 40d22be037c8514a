// In place of cuda/executor.cpp where MFS is built without CUDA.
#include <cstring>
#include <new>

#include <mfs/error.hpp>

#include "dae/vectors/executor.hpp"
#include "dae/vectors/host_loops.hpp"

namespace mfs::dae {

class DeviceQueue {};

Executor::Executor(Place place, int threads) : threads_(team_size(threads)) {
  if (place == Place::device) throw BackendError("CUDA", 0, "this build of MFS has no CUDA backend");
}
Executor::~Executor() = default;

void* Executor::stream() const {
  return nullptr;
}
std::shared_ptr<void> Executor::allocate(std::size_t bytes) const {
  return {::operator new(bytes), [](void* memory) { ::operator delete(memory); }};
}
std::shared_ptr<void> Executor::allocate_staging(std::size_t bytes) const {
  return allocate(bytes);
}
void Executor::begin_to_host(void* to, const void* from, std::size_t bytes) const {
  if (bytes > 0) std::memcpy(to, from, bytes);
}
void Executor::begin_from_host(void* to, const void* from, std::size_t bytes) const {
  if (bytes > 0) std::memcpy(to, from, bytes);
}
void Executor::synchronize() const {}
void Executor::mark() const {}
void Executor::wait_for_mark() const {}

}  // namespace mfs::dae
