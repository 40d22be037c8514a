// Copies from global to shared memory that run on while the thread goes on.
#pragma once

namespace mfs::cuda {

__device__ inline unsigned shared_address(const void* place) {
  return static_cast<unsigned>(__cvta_generic_to_shared(place));
}
/// To a place in shared memory; where it is not inside, zeros.
template <int Bytes>
__device__ void copy_async(unsigned to, const void* from, bool inside) {
  const int size = inside ? Bytes : 0;
  asm volatile("cp.async.ca.shared.global [%0], [%1], %2, %3;" ::"r"(to), "l"(from), "n"(Bytes), "r"(size));
}
template <int Bytes>
__device__ void copy_async(unsigned to, const void* from) {
  asm volatile("cp.async.ca.shared.global [%0], [%1], %2;" ::"r"(to), "l"(from), "n"(Bytes));
}
__device__ inline void commit_copies() {
  asm volatile("cp.async.commit_group;");
}
template <int Pending>
__device__ void wait_copies() {
  asm volatile("cp.async.wait_group %0;" ::"n"(Pending));
}

}  // namespace mfs::cuda
